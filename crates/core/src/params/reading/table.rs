//! QGroundControl's `.params`: a `#` header, then rows `vehicle id <tab> component id <tab> name <tab> value
//! <tab> type`, sorted by name; type 6 is a 32-bit integer, 9 single precision. QGroundControl writes a float
//! as the double that equals it, with 18 decimals. The reader takes any origin: LF or CRLF, any vehicle id,
//! `%g` values, no header. Header lines `# Key: value` are kept: [`crate::params::purpose`] says which ones
//! samara writes.

use std::collections::BTreeSet;

use super::reader::{Reader, Repeated, integer, is_name, refused};
use crate::params::ParamsError;
use crate::params::file::{AUTOPILOT_COMPONENT, Value};
use crate::params::purpose::Purpose;

/// MAVLink's numbers of the types that PX4 does not have.
const OTHER_TYPES: [&str; 8] = ["1", "2", "3", "4", "5", "7", "8", "10"];

pub(super) fn read(text: &str, reader: &mut Reader) -> Result<(), ParamsError> {
    let (mut vehicle, mut others) = (None, BTreeSet::new());
    let mut is_header = true;
    for (i, line) in text.lines().enumerate() {
        let (number, line) = (i + 1, line.trim());
        if let Some(comment) = line.strip_prefix('#') {
            if is_header {
                take_comment(number, comment.trim(), reader);
            }
        } else if !line.is_empty() {
            is_header = false;
            let Some(row) = Row::of(number, line, reader)? else { continue };
            let own = *vehicle.get_or_insert_with(|| {
                if row.vehicle != 1 {
                    let words =
                        format!("vehicle id {}; QGroundControl loads it into any vehicle", row.vehicle);
                    reader.remarks.note(number, words);
                }
                row.vehicle
            });
            if row.vehicle != own {
                let words = format!("of vehicle {}, the file is vehicle {own}'s: passed over", row.vehicle);
                reader.remarks.note(number, words);
                continue;
            }
            let Some(value) = row.value(reader)? else { continue };
            if row.component != AUTOPILOT_COMPONENT {
                others.insert(row.component);
            }
            reader.take_of(row.component, number, row.name, value, Repeated::Refused)?;
        }
    }
    if !others.is_empty() {
        let others: Vec<String> = others.iter().map(u8::to_string).collect();
        reader
            .file
            .remark([format!("parameters of component {} are not the autopilot's", others.join(", "))]);
    }
    Ok(())
}

fn take_comment(line: usize, comment: &str, reader: &mut Reader) {
    let Some((key, value)) = comment.split_once(':') else { return };
    let (key, value) = (key.trim(), value.trim());
    if key == Purpose::KEY {
        match Purpose::from_name(value) {
            Some(purpose) => reader.file.say_purpose(purpose),
            None => {
                let words = "`# For:` names none of samara, px4, px4-froude: taken for a comment";
                return reader.remarks.note(line, words);
            }
        }
    }
    reader.file.say(key, value);
}

struct Row<'a> {
    line: usize,
    vehicle: u8,
    component: u8,
    name: &'a str,
    value: &'a str,
    kind: &'a str,
}

impl<'a> Row<'a> {
    /// A row's columns; `None`: passed over.
    fn of(line: usize, text: &'a str, reader: &mut Reader) -> Result<Option<Self>, ParamsError> {
        let columns: Vec<&str> = text.split_whitespace().collect();
        let &[vehicle, component, name, value, kind] = columns.as_slice() else {
            if columns.get(5).is_some_and(|sixth| sixth.starts_with('#')) {
                reader
                    .remarks
                    .note(line, "a comment behind a row: QGroundControl skips it, and so it is passed over");
                return Ok(None);
            }
            return Err(ParamsError::Columns { line, found: columns.len() });
        };
        if text.matches('\t').count() != 4 {
            let words = "columns are not separated by single tabs; QGroundControl skips such a row";
            reader.remarks.note(line, words);
        }
        if !is_name(name) {
            return Err(refused(line, "name", "at most 16 letters, digits and `_`", name));
        }
        let id = |column, text: &str| {
            text.parse::<u8>().map_err(|_| refused(line, column, "a whole number from 0 to 255", text))
        };
        let (vehicle, component) = (id("vehicle id", vehicle)?, id("component id", component)?);
        Ok(Some(Self { line, vehicle, component, name, value, kind }))
    }

    /// A row's value; `None`: passed over.
    fn value(&self, reader: &mut Reader) -> Result<Option<Value>, ParamsError> {
        let Self { line, component, name, value, kind, .. } = *self;
        if OTHER_TYPES.contains(&kind) {
            let whose = match component {
                AUTOPILOT_COMPONENT => "a type that PX4 does not have".to_owned(),
                other => format!("of component {other}"),
            };
            reader.remarks.note(line, format!("type {kind}, {whose}: passed over"));
            return Ok(None);
        }
        let value = match kind {
            "6" => integer(line, value).map(Some),
            "9" => reader.real(line, name, value),
            _ => return Err(refused(line, "type", "6 (32-bit integer) or 9 (single precision)", kind)),
        };
        if component != AUTOPILOT_COMPONENT && value.is_err() {
            reader.remarks.note(line, format!("no value, of component {component}: passed over"));
            return Ok(None);
        }
        value
    }
}
