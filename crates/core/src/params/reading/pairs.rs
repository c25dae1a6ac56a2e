//! Rows of a name and a value: MAVProxy's `.parm` (white space between them), comma-separated values. Types
//! are not said: they are PX4's own.

use super::format::pair;
use super::reader::{Reader, Repeated, is_name, refused};
use crate::params::ParamsError;

/// Titles of a first row, without which some are written.
const TITLES: [&str; 3] = ["name", "param", "parameter"];

pub(super) fn read(text: &str, reader: &mut Reader) -> Result<(), ParamsError> {
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    for (number, line) in lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
        let Some((name, value)) = pair(line) else {
            return Err(ParamsError::Pair { line: number });
        };
        if reader.rows == 0 && TITLES.iter().any(|title| name.eq_ignore_ascii_case(title)) {
            continue;
        }
        if !is_name(name) {
            return Err(refused(number, "name", "at most 16 letters, digits and `_`", name));
        }
        if let Some(value) = reader.number(number, name, value)? {
            reader.take(number, name, value, Repeated::Refused)?;
        }
    }
    Ok(())
}
