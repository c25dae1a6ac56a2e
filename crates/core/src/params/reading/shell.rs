//! PX4's shell: what `param show` prints, and scripts that set parameters - airframes of PX4's own,
//! `px4-rc.params`, variables `PX4_PARAM_NAME`. Such a file is PX4's.

use super::reader::{Reader, Repeated, is_name};
use crate::control::px4::versions::ToldBy;
use crate::params::ParamsError;

const PROMPTS: [&str; 2] = ["pxh>", "nsh>"];

/// The name and the value of a line of `param show`: `x + MC_PITCH_P [406,683] : 6.5000`. In place of a value
/// there may be an error in `<>`.
pub(super) fn shown(line: &str) -> Option<(&str, &str)> {
    let (before, value) = line.rsplit_once(" : ")?;
    let (before, places) = before.trim_end().strip_suffix(']')?.rsplit_once('[')?;
    let in_use = places.split(',').all(|place| place.trim().parse::<i32>().is_ok());
    let name = before.split_whitespace().next_back().filter(|name| is_name(name))?;
    (in_use && !value.trim().starts_with('<')).then_some((name, value.trim()))
}

pub(super) fn read_shown(text: &str, reader: &mut Reader) -> Result<(), ParamsError> {
    reader.file.say("Stack", "PX4");
    let mut first = None;
    for (i, line) in text.lines().enumerate() {
        let Some((name, value)) = shown(line.trim()) else { continue };
        first.get_or_insert(i + 1);
        if let Some(value) = reader.number(i + 1, name, value)? {
            reader.take(i + 1, name, value, Repeated::LastStands)?;
        }
    }
    first.into_iter().for_each(|line| reader.remarks.note(line, "`param show` prints four decimals only"));
    Ok(())
}

/// The name and the value of a line that sets a parameter.
pub(super) fn set(line: &str) -> Option<(&str, &str)> {
    let mut words = line.split_whitespace().skip_while(|word| PROMPTS.contains(word) || *word == "export");
    let first = words.next()?;
    if let Some(variable) = first.strip_prefix(ToldBy::VARIABLE) {
        return variable.split_once('=');
    }
    let sets = matches!(first, "param" | "px4-param") && matches!(words.next()?, "set" | "set-default");
    let mut rest = words.filter(|word| !matches!(*word, "-s" | "fail"));
    let (name, value) = (rest.next()?, rest.next()?);
    sets.then_some((name, value))
}

/// The script that a line runs.
pub(super) fn run(line: &str) -> Option<&str> {
    let mut words = line.split_whitespace();
    matches!(words.next()?, "." | "source").then(|| words.next())?
}

pub(super) fn read_script(text: &str, reader: &mut Reader) -> Result<(), ParamsError> {
    reader.file.say("Stack", "PX4");
    let mut depth = 0_usize;
    for (i, line) in text.lines().enumerate() {
        let (number, line) = (i + 1, line.trim());
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        match line.split([' ', ';']).next() {
            Some("if") => depth += 1,
            Some("fi") => depth = depth.saturating_sub(1),
            _ => {}
        }
        let Some((name, text)) = set(line) else {
            run(line).into_iter().for_each(|script| reader.file.run(number, script));
            reader.remarks.note(number, "sets no parameter: passed over");
            continue;
        };
        let text = text.trim_matches(['"', '\'']);
        if !is_name(name) || text.contains('$') {
            reader.remarks.note(number, "a variable, or no name of a parameter: passed over");
            continue;
        }
        if depth > 0 {
            reader.remarks.note(number, "under an `if`: taken as if that held");
        }
        if let Some(value) = reader.number(number, name, text)? {
            reader.take(number, name, value, Repeated::LastStands)?;
        }
    }
    Ok(())
}
