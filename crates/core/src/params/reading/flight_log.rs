//! A ULog's parameters, as they were at its start.

use super::reader::{MOST_ROWS, Reader, Repeated, is_name};
use crate::params::ParamsError;
use crate::params::file::Value;
use crate::ulog::{Parameter, Ulog};

/// Most names that a remark lists.
const NAMED: usize = 6;

/// Takes the parameters of a log, and what it says of the autopilot.
pub(super) fn read(bytes: &[u8], reader: &mut Reader) -> Result<(), ParamsError> {
    let log = Ulog::read(bytes).map_err(|error| ParamsError::Format(error.to_string()))?;
    if log.parameters.is_empty() {
        return Err(ParamsError::Format("a ULog without parameters".to_owned()));
    }
    reader.file.say("Stack", log.text("sys_name").unwrap_or_default());
    if let Some([major, minor, patch, _]) = log.release() {
        reader.file.say("Version", &format!("{major}.{minor}.{patch}"));
    }
    let named = log.parameters.iter().filter(|(name, _)| is_name(name)).take(MOST_ROWS);
    for (number, (name, value)) in (1..).zip(named) {
        let value = match value {
            Parameter::Int(value) => Some(Value::Int(*value)),
            Parameter::Real(value) => reader.finite(number, name, *value)?,
        };
        if let Some(value) = value {
            reader.take(number, name, value, Repeated::LastStands)?;
        }
    }
    if !log.lost.is_empty() {
        let lost = log.lost_bytes();
        reader.file.remark([format!("{lost} bytes of the log are damaged and were passed over")]);
    }
    let mut changed: Vec<&str> = log.changed.iter().map(|(_, name, _)| name.as_str()).collect();
    changed.sort_unstable();
    changed.dedup();
    if !changed.is_empty() {
        let more = changed.len().saturating_sub(NAMED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let listed = changed.get(..changed.len().min(NAMED)).unwrap_or_default().join(", ");
        reader
            .file
            .remark([format!("changed during the log, the values at its start stand: {listed}{more}")]);
    }
    Ok(())
}
