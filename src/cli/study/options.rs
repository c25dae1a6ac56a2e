//! Settings as options of the command line, by their tables.

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches};

use samara::study::settings::{Setting, Values};

/// The options of a table.
pub fn options(table: &'static [Setting]) -> impl Iterator<Item = Arg> {
    table.iter().map(option)
}

/// A setting as an option.
fn option(setting: &'static Setting) -> Arg {
    let about: String = setting.about.lines().map(|line| line.trim_start().to_owned() + "\n").collect();
    let (first, more) = about.split_once("\n\n").unwrap_or((&about, ""));
    let flowed = |text: &str| text.trim().replace('\n', " ");
    let short = flowed(first).trim_end_matches('.').to_owned();
    let long = if more.is_empty() { short.clone() } else { format!("{short}\n\n{}", flowed(more)) };
    let arg = Arg::new(setting.name).long(setting.name.replace('_', "-")).help(short).long_help(long);
    match (setting.value, setting.usual) {
        ("", _) => arg.action(ArgAction::SetTrue),
        (value, "") => arg.value_name(value).value_parser(setting.read),
        (value, usual) => arg.value_name(value).default_value(usual).value_parser(setting.read),
    }
}

/// The values that were typed of a table's settings, the others as usual.
pub fn values(table: &'static [Setting], typed: &ArgMatches) -> Result<Values, clap::Error> {
    let mut values = Values::usual(table);
    for setting in table {
        let text = match setting.value {
            "" => Some(typed.get_flag(setting.name).to_string()),
            _ => typed.get_one::<String>(setting.name).cloned(),
        };
        if let Some(text) = text {
            let put = values.put(table, setting.name, &text);
            put.map_err(|e| clap::Error::raw(ErrorKind::ValueValidation, e))?;
        }
    }
    Ok(values)
}
