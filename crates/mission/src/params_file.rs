//! PX4 parameter files, read from disk.

use std::path::Path;

use super::error::ConfigError;
use super::source::Source;
use samara_core::params::file::write;
use samara_core::params::{ParameterFile, ParamsError};
use samara_core::ulog::Ulog;

/// Reads a parameter file of any origin.
///
/// # Errors
/// [`ConfigError`] with the line in the file, when it cannot be read or does not hold parameters.
pub fn load_parameters(path: &Path) -> Result<ParameterFile, ConfigError> {
    Ok(read(path)?.1)
}

/// A parameter file and the text that it was read from.
pub(super) fn read(path: &Path) -> Result<(Source, ParameterFile), ConfigError> {
    let bytes = Source::bytes(path, "parameter file", None)?;
    let file = ParameterFile::read(&bytes).map_err(|error| refuse(path, error))?;
    if Ulog::is_one(&bytes) {
        // A log's parameters as text, from which shards and manifests read them again.
        let parameters = file.own().map(|(name, entry)| (name.to_owned(), entry.value)).collect();
        let text = write(file.header("Version").unwrap_or("none"), &[], &parameters);
        return Ok((Source::of_text(&text, path), file));
    }
    let text = String::from_utf8_lossy(&bytes);
    Ok((Source::of_text(text.trim_start_matches('\u{feff}'), path), file))
}

/// An error about a parameter file, with its path.
pub(super) fn refuse(path: &Path, error: ParamsError) -> ConfigError {
    ConfigError::Parameters { file: path.to_owned(), error }
}
