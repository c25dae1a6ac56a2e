//! Files that hold PX4's parameters, read strictly: what is odd and does not matter is passed over with a
//! remark that has its line, what matters and cannot be read is refused with its line.
//!
//! | file | holds |
//! |---|---|
//! | [`mod@format`] | which format a file has, and what is named in a refusal |
//! | `table` | QGroundControl's `.params`: five columns under a header |
//! | `pairs` | a name and a value in a row: MAVProxy's `.parm`, comma-separated values |
//! | `flight_log` | a ULog's parameters, as they were at its start |
//! | `shell` | PX4's shell: what `param show` prints, scripts of `param set` and `param set-default` |
//! | `reader` | what has been read, and values of texts |
//! | `remarks` | remarks, by what there is to say, with their lines |

mod flight_log;
pub mod format;
mod pairs;
mod reader;
mod remarks;
mod shell;
mod table;

#[cfg(test)]
mod tests;

use super::ParamsError;
use super::file::ParameterFile;
use crate::ulog::Ulog;
use format::Format;
use reader::Reader;

impl ParameterFile {
    /// Reads a file's bytes.
    ///
    /// # Errors
    /// [`ParamsError`] with the line that is wrong, or with the format where that is none of those read.
    pub fn read(bytes: &[u8]) -> Result<Self, ParamsError> {
        if Ulog::is_one(bytes) {
            let mut reader = Reader::default();
            flight_log::read(bytes, &mut reader)?;
            return finished(reader);
        }
        Self::parse(format::text(bytes)?)
    }

    /// Parses a file's text.
    ///
    /// # Errors
    /// As [`ParameterFile::read`].
    pub fn parse(text: &str) -> Result<Self, ParamsError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut reader = Reader::default();
        match Format::of(text) {
            Format::Table => table::read(text, &mut reader)?,
            Format::Pairs => pairs::read(text, &mut reader)?,
            Format::Shown => shell::read_shown(text, &mut reader)?,
            Format::Script => shell::read_script(text, &mut reader)?,
        }
        finished(reader)
    }
}

/// What was read, with all remarks on it.
fn finished(reader: Reader) -> Result<ParameterFile, ParamsError> {
    let Reader { mut file, remarks, .. } = reader;
    format::refuse_another_stack(&file)?;
    file.remark(remarks.said());
    Ok(file)
}
