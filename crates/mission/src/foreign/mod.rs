//! What files of other programs say of a vehicle, for drafts: PX4's airframes and parameters, Gazebo's
//! models.
//!
//! | file | holds |
//! |---|---|
//! | `known` | numbers with the place that they are from, and what several files come to together |
//! | `rotors` | what rotors must keep to make a multirotor |
//! | `airframe` | PX4's parameters of an airframe script, a parameter file or a log |
//! | `sdf` | Gazebo's SDF |

mod airframe;
mod known;
mod rotors;
mod sdf;

use std::path::{Path, PathBuf};

use crate::error::ConfigError;
use crate::source::Source;
use known::ROLE;
pub use known::{Key, Known, KnownRotors, KnownVehicle};

/// What files say of a vehicle together: where two disagree the later one stands, but metres stand before
/// directions; and it is told.
///
/// # Errors
/// [`ConfigError`] with the file and the place in it, when one cannot be read or is not a multirotor's.
pub fn known_vehicle(files: &[PathBuf]) -> Result<KnownVehicle, ConfigError> {
    let mut all = KnownVehicle::default();
    for file in files {
        all.add(read(file)?);
    }
    Ok(all)
}

fn read(file: &Path) -> Result<KnownVehicle, ConfigError> {
    let refuse = |reason: &str| {
        let reason = reason.to_owned();
        Err(ConfigError::Read { role: ROLE, path: file.to_owned(), named_in: None, reason })
    };
    let is = |extension: &str| file.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension));
    if is("jinja") {
        return refuse(sdf::TEMPLATE);
    }
    let bytes = Source::bytes(file, ROLE, None)?;
    let mut begin = bytes.trim_ascii_start();
    begin = begin.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(begin).trim_ascii_start();
    match begin.first() {
        Some(b'<') => sdf::read(file),
        Some(b'{') => refuse("JSON; a vehicle file of samara is flown as it is, by `--vehicle` of a mission"),
        _ => airframe::read(file),
    }
}
