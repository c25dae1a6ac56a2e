//! The faults that there are, as `samara faults` lists them: a table for the terminal, an object for
//! `--json`.

use super::json::{VERSION, object, text};
use samara_core::sim::faults::{CATALOGUE, Entry};

/// The numbers and words of the command that injects a fault.
fn command(entry: &Entry) -> String {
    entry.command.map_or("-".to_owned(), |(unit, kind)| {
        format!("{} {} ({}, {})", unit.name(), kind.name(), unit as u16, kind as u16)
    })
}

/// The faults as a table: name, keys of the mission, unit and type of the command, and below each what it
/// does. Ends with a line's end.
pub fn faults_text() -> String {
    let keys = |entry: &Entry| if entry.keys.is_empty() { "-".to_owned() } else { entry.keys.join(", ") };
    let width = |of: &dyn Fn(&Entry) -> usize| CATALOGUE.iter().map(of).max().unwrap_or(0);
    let (names, all_keys) = (width(&|entry| entry.name.len()), width(&|entry| keys(entry).len()));
    let mut table = format!("{:names$}  {:all_keys$}  {}\n", "fault", "keys", "command (unit, type)");
    for entry in CATALOGUE {
        table += &format!("{:names$}  {:all_keys$}  {}\n", entry.name, keys(entry), command(entry));
        table += &format!("    {}\n", entry.does);
    }
    table
}

/// The object of `samara faults --json`.
pub fn faults_json() -> String {
    let fault = |entry: &Entry| {
        object! {
            name: entry.name,
            does: entry.does,
            keys: entry.keys,
            command: entry.command.map(|(unit, kind)| object! {
                unit: unit as u16,
                unit_name: unit.name(),
                failure_type: kind as u16,
                type_name: kind.name(),
            }),
        }
    };
    let faults: Vec<_> = CATALOGUE.iter().map(fault).collect();
    text(&object! { version: VERSION, faults: faults })
}
