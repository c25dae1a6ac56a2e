//! Which format a file has: each has a look of its own.

use std::str;

use super::reader::{is_name, shortened};
use super::shell::{run, set, shown};
use crate::params::ParamsError;
use crate::params::file::ParameterFile;
use crate::params::metadata::Metadata;

/// A format that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// QGroundControl's: rows of five columns.
    Table,
    /// Rows of a name and a value.
    Pairs,
    /// What PX4's `param show` prints.
    Shown,
    /// A script with `param set` or `param set-default`, or one that runs others.
    Script,
}

impl Format {
    /// The format of a text; QGroundControl's where it looks like none.
    pub fn of(text: &str) -> Self {
        let lines = || text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
        let any = |fits: fn(&str) -> bool| lines().any(fits);
        match () {
            () if any(is_row) => Self::Table,
            () if any(|line| shown(line).is_some()) => Self::Shown,
            () if any(|line| set(line).is_some() || run(line).is_some()) => Self::Script,
            () if any(|line| pair(line).is_some_and(looks_like_a_pair)) => Self::Pairs,
            () => Self::Table,
        }
    }
}

fn is_row(line: &str) -> bool {
    let mut columns = line.split_whitespace();
    let ids = [columns.next(), columns.next()];
    ids.iter().all(|id| id.is_some_and(|id| id.parse::<u32>().is_ok())) && columns.next().is_some_and(is_name)
}

/// The name and the value of a row that has nothing else: separated by white space, or by a comma.
pub(super) fn pair(line: &str) -> Option<(&str, &str)> {
    let line = line.split_once('#').map_or(line, |(before, _)| before).trim();
    let (name, value) = line.split_once(char::is_whitespace).or_else(|| line.split_once(','))?;
    let (name, value) = (name.trim_end_matches(',').trim(), value.trim());
    (!value.contains(char::is_whitespace)).then_some((name, value))
}

fn looks_like_a_pair((name, value): (&str, &str)) -> bool {
    is_name(name) && value.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.'))
}

/// A file's text, where it is one.
///
/// # Errors
/// [`ParamsError::Format`] that names a binary format, as far as it is known.
pub fn text(bytes: &[u8]) -> Result<&str, ParamsError> {
    let refuse = |what: &str| Err(ParamsError::Format(what.to_owned()));
    match bytes {
        [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => {
            return refuse("text in UTF-16, as PowerShell's `>` writes it; UTF-8 is expected");
        }
        // A document of BSON begins with its length and an element: a type, here a number's, and a name.
        [_, _, _, 0 | 0xFF, 0x01 | 0x10, name, ..] if name.is_ascii_uppercase() => {
            return refuse(
                "PX4's own file of parameters (BSON); what `param show` prints is read, or what QGroundControl saves",
            );
        }
        _ => {}
    }
    str::from_utf8(bytes)
        .map_err(|e| ParamsError::Format(format!("not text: byte {} is not UTF-8", e.valid_up_to() + 1)))
}

/// How ArduPilot's names begin, and PX4's do not.
const ARDUPILOTS: [&str; 14] = [
    "AHRS_",
    "ARMING_",
    "ATC_",
    "BATT_",
    "EK2_",
    "EK3_",
    "FRAME_CLASS",
    "FS_",
    "INS_",
    "PSC_",
    "SCHED_",
    "SERVO1_",
    "SYSID_",
    "WPNAV_",
];

/// Refuses parameters that are not PX4's, by what the file says of itself, or, where it says nothing, by
/// their names.
///
/// # Errors
/// [`ParamsError::Format`].
pub(super) fn refuse_another_stack(file: &ParameterFile) -> Result<(), ParamsError> {
    let refuse =
        |why: String| Err(ParamsError::Format(format!("ArduPilot's parameters, {why}; PX4's are expected")));
    if let Some(stack) = file.header("Stack").filter(|stack| stack.starts_with("ArduPilot")) {
        return refuse(format!("by the line `# Stack: {}`", shortened(stack)));
    }
    if file.is_of_px4() {
        return Ok(());
    }
    let is_ardupilots = |name: &str| ARDUPILOTS.iter().any(|begin| name.starts_with(begin));
    let (px4s, others): (Vec<&str>, Vec<&str>) =
        file.entries().map(|(_, name, _)| name).partition(|name| Metadata::newest().nearest(name).is_some());
    let ardupilots: Vec<&str> = others.into_iter().filter(|name| is_ardupilots(name)).collect();
    if ardupilots.len() > px4s.len() {
        return refuse(format!("by their names ({}, ..)", ardupilots[..ardupilots.len().min(3)].join(", ")));
    }
    Ok(())
}
