//! Settings as options of the command line, by their tables.

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches};

use samara::study::settings::{LEFT, Setting, Values};

/// The options of a table.
pub fn options(table: &'static [Setting]) -> impl Iterator<Item = Arg> {
    table.iter().map(option)
}

/// What a setting's value is called, and whether it may be given more than once.
fn value_of(setting: &Setting) -> (&'static str, bool) {
    setting.value.strip_suffix("...").map_or((setting.value, false), |value| (value, true))
}

/// A setting as an option.
pub fn option(setting: &'static Setting) -> Arg {
    let about: String = setting.about.lines().map(|line| line.trim_start().to_owned() + "\n").collect();
    let (first, more) = about.split_once("\n\n").unwrap_or((&about, ""));
    let flowed = |text: &str| text.trim().replace('\n', " ");
    let short = flowed(first).trim_end_matches('.').to_owned();
    let long = if more.is_empty() { short.clone() } else { format!("{short}\n\n{}", flowed(more)) };
    let arg = Arg::new(setting.name)
        .long(setting.name.replace('_', "-"))
        .help(short)
        .long_help(long)
        .hide_short_help(setting.rare);
    let (value, repeats) = value_of(setting);
    if value.is_empty() {
        return arg.action(ArgAction::SetTrue);
    }
    let arg = arg.value_name(value).value_parser(setting.read);
    let arg = if repeats { arg.action(ArgAction::Append) } else { arg };
    // What is left to be usual says in words what that is.
    if [LEFT, ""].contains(&setting.usual) { arg } else { arg.default_value(setting.usual) }
}

/// The values that were typed of a table's settings, the others as usual.
pub fn values(table: &'static [Setting], typed: &ArgMatches) -> Result<Values, clap::Error> {
    let mut values = Values::usual(table);
    for setting in table {
        let text = match value_of(setting) {
            ("", _) => typed.get_flag(setting.name).to_string(),
            _ => match typed.get_many::<String>(setting.name) {
                Some(texts) => texts.cloned().collect::<Vec<_>>().join(" "),
                None => continue,
            },
        };
        let put = values.put(table, setting.name, &text);
        put.map_err(|e| clap::Error::raw(ErrorKind::ValueValidation, e))?;
    }
    Ok(values)
}
