//! A flight's table in CSV: `flight.csv`, or columns of the same names from elsewhere. Comment lines (`#`) at
//! the top, a header, and rows; what is empty or no number is not a number.

use std::path::Path;

use super::error::ConfigError;
use super::source::Source;
use super::table;
use samara_core::logged_flight::LoggedFlight;
use samara_core::logged_flight::columns::{KNOWN, flight};

/// Columns of a table, at most.
const MOST_COLUMNS: usize = 1000;

/// The flight of a table; `path` is for messages.
///
/// # Errors
/// [`ConfigError`] with the line, where it is no such table.
pub fn read_flight_table(text: &str, path: &Path) -> Result<LoggedFlight, ConfigError> {
    let source = Source::of_text(text, path);
    let mut lines = table::lines(&source);
    let (at, header) = lines.next().unwrap_or((1, ""));
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    if names.len() > MOST_COLUMNS || !names.contains(&"t_s") {
        let message = format!("expected a header with the column `t_s` and others of: {KNOWN}");
        return Err(table::refuse(&source, at, 1, message));
    }
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    for (line, text) in lines {
        let found = text.split(',').count();
        if found != names.len() {
            let message = format!("expected {} fields separated by commas, found {found}", names.len());
            return Err(table::refuse(&source, line, 1, message));
        }
        for (column, field) in columns.iter_mut().zip(text.split(',')) {
            column.push(field.trim().parse().unwrap_or(f64::NAN));
        }
    }
    let column = |name: &str| {
        let i = names.iter().position(|one| *one == name)?;
        columns.get(i).map(Vec::as_slice)
    };
    flight(column).ok_or_else(|| table::refuse(&source, at, 1, "expected times in `t_s`".to_owned()))
}
