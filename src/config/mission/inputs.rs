//! The inputs of a mission: the hash of its files and of what was chosen beside them, and where its gains
//! come from.

use std::path::{Path, PathBuf};

use crate::config::error::ConfigError;
use crate::config::gains_file::{GainsFile, gains_path, load_named_gains};
use crate::config::source::{InputHash, Source};

/// Everything that the results of a mission depend on.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// SHA-256 of mission, vehicle, tables and gains, and of what was chosen beside them, hexadecimal.
    pub hash: String,
    /// Choices beside the files: name and value, in the order of choosing.
    pub choices: Vec<(String, String)>,
    /// The directory of the mission's own gains file.
    gains_directory: PathBuf,
    hash_without_gains: InputHash,
}

impl Inputs {
    /// The inputs of a mission as its files give them, and its gains.
    pub(super) fn of_files(
        gains_file: &Path,
        named_in: &Path,
        hash_without_gains: InputHash,
    ) -> Result<(Self, GainsFile), ConfigError> {
        let gains_directory = gains_file.parent().map(Path::to_owned).unwrap_or_default();
        let mut inputs =
            Self { hash: String::new(), choices: Vec::new(), gains_directory, hash_without_gains };
        let gains = inputs.read_gains(gains_file, Some(named_in))?;
        Ok((inputs, gains))
    }

    /// Reads gains: those of the file `name_or_path`, or of that name beside the mission's own gains file.
    /// The hash follows.
    pub(super) fn other_gains(&mut self, name_or_path: &str) -> Result<GainsFile, ConfigError> {
        let path = gains_path(name_or_path, &self.gains_directory);
        let gains = self.read_gains(&path, None).map_err(|error| self.with_known_names(error))?;
        for (name, value) in self.choices.clone() {
            self.absorb(&name, &value);
        }
        Ok(gains)
    }

    fn read_gains(&mut self, path: &Path, named_in: Option<&Path>) -> Result<GainsFile, ConfigError> {
        let mut hash = self.hash_without_gains.clone();
        let gains = load_named_gains(path, named_in, &mut hash)?;
        self.hash = hash.hex();
        Ok(gains)
    }

    /// An error about a missing file of gains, with the names of those that there are beside it.
    fn with_known_names(&self, error: ConfigError) -> ConfigError {
        let ConfigError::Read { role, path, named_in, reason } = error else { return error };
        let known = self.known_names().filter(|_| path.parent() == Some(&self.gains_directory));
        let reason =
            known.map_or(reason.clone(), |names| format!("{reason}; expected one of {names}, or a file"));
        ConfigError::Read { role, path, named_in, reason }
    }

    /// The names of the gains beside the mission's own, in order, if there are any.
    fn known_names(&self) -> Option<String> {
        let files =
            std::fs::read_dir(&self.gains_directory).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
        let gains = files.filter(|path| path.extension().is_some_and(|e| e == "json"));
        let mut names: Vec<String> =
            gains.filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned())).collect();
        names.sort();
        (!names.is_empty()).then(|| names.join(", "))
    }

    /// Hash of mission, vehicle and tables alone, hexadecimal.
    pub(super) fn hash_without_gains(&self) -> String {
        self.hash_without_gains.hex()
    }

    /// Notes a choice; the hash follows.
    pub(super) fn note(&mut self, name: &str, value: &str) {
        self.choices.push((name.to_owned(), value.to_owned()));
        self.absorb(name, value);
    }

    fn absorb(&mut self, name: &str, value: &str) {
        let mut hash = InputHash::default();
        hash.follow(&self.hash);
        hash.absorb(name, value);
        self.hash = hash.hex();
    }

    /// Takes another file into the hash.
    pub(super) fn absorb_file(&mut self, role: &str, source: &Source) {
        let mut hash = self.hash_without_gains.clone();
        hash.follow(&self.hash);
        hash.absorb(role, &source.text);
        self.hash = hash.hex();
    }
}
