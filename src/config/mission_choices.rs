//! What is chosen in place of a mission's own: gains, seed, trajectory; and the hash of the inputs, which follows each choice.

use std::path::{Path, PathBuf};

use super::gains_file::{gains_path, load_named_gains};
use super::source::{InputHash, Source};
use super::trajectory_csv::{TrajectoryFile, load_trajectory};
use super::{ConfigError, GainsFile, Mission};

/// What the results of a mission depend on.
#[derive(Clone)]
pub struct Inputs {
    /// SHA-256 of mission, vehicle, tables and gains, and of what was chosen beside them, hexadecimal.
    pub hash: String,
    /// What was chosen beside the files: name and value, in the order of choosing.
    pub choices: Vec<(String, String)>,
    /// Where the mission's own gains are.
    gains_directory: PathBuf,
    hash_without_gains: InputHash,
}

impl std::fmt::Debug for Inputs {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Inputs")
            .field("hash", &self.hash)
            .field("choices", &self.choices)
            .finish_non_exhaustive()
    }
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
        let (gains, hash) = inputs.read_gains(gains_file, Some(named_in))?;
        inputs.hash = hash;
        Ok((inputs, gains))
    }

    /// Adds to a file that is not on the shelf the names of those that are.
    fn with_known(&self, error: ConfigError) -> ConfigError {
        let ConfigError::Read { role, path, named_in, reason } = error else { return error };
        let known = self.names().filter(|_| path.parent() == Some(&self.gains_directory));
        let reason =
            known.map_or(reason.clone(), |names| format!("{reason}; expected one of {names}, or a file"));
        ConfigError::Read { role, path, named_in, reason }
    }

    /// The names on the shelf, in order, if there are any.
    fn names(&self) -> Option<String> {
        let files =
            std::fs::read_dir(&self.gains_directory).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
        let gains = files.filter(|path| path.extension().is_some_and(|e| e == "json"));
        let mut names: Vec<String> =
            gains.filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned())).collect();
        names.sort();
        (!names.is_empty()).then(|| names.join(", "))
    }

    /// Reads a gains file; with it, the hash of all inputs.
    fn read_gains(&self, path: &Path, named_in: Option<&Path>) -> Result<(GainsFile, String), ConfigError> {
        let mut hash = self.hash_without_gains.clone();
        let gains = load_named_gains(path, named_in, &mut hash)?;
        Ok((gains, hash.hex()))
    }
}

impl Mission {
    /// Puts other gains in: those of the file `name_or_path`, or of that name beside the mission's own gains file. The input
    /// hash follows.
    ///
    /// # Errors
    /// [`ConfigError`] when the file cannot be read or does not hold gains; the mission is unchanged then.
    pub fn use_gains(&mut self, name_or_path: &str) -> Result<(), ConfigError> {
        let path = gains_path(name_or_path, &self.inputs.gains_directory);
        let (gains, input_hash) =
            self.inputs.read_gains(&path, None).map_err(|e| self.inputs.with_known(e))?;
        self.control.gains = gains.gains;
        self.control.gains_name = gains.name;
        self.inputs.hash = input_hash;
        for (name, value) in self.inputs.choices.clone() {
            self.absorb(&name, &value);
        }
        Ok(())
    }

    /// Hash of mission, vehicle and tables without the gains: the inputs of a search for gains.
    pub fn hash_without_gains(&self) -> String {
        self.inputs.hash_without_gains.hex()
    }

    /// Notes what was chosen beside the files and decides what results hold (an option of the command line, the hash of a
    /// trajectory). The input hash follows.
    pub fn note_choice(&mut self, name: &str, value: &str) {
        self.inputs.choices.push((name.to_owned(), value.to_owned()));
        self.absorb(name, value);
    }

    /// Puts another seed in. The input hash follows.
    pub fn use_seed(&mut self, seed: u64) {
        if seed != self.seed {
            self.seed = seed;
            self.note_choice("seed", &seed.to_string());
        }
    }

    /// Reads a trajectory for the mission's vehicle, to be flown instead of a plan. The input hash follows.
    ///
    /// # Errors
    /// [`ConfigError`] when the file is wrong or for another number of rotors; the mission is unchanged then.
    pub fn use_trajectory(&mut self, path: &Path) -> Result<TrajectoryFile, ConfigError> {
        let file = load_trajectory(path, self.vehicle.rotors.len())?;
        self.note_choice("trajectory sha256", &file.sha256);
        Ok(file)
    }

    fn absorb(&mut self, name: &str, value: &str) {
        let mut hash = InputHash::default();
        hash.follow(&self.inputs.hash);
        hash.absorb_text(name, value);
        self.inputs.hash = hash.hex();
    }

    /// The input hash with one more file in it.
    pub(super) fn hash_with(&self, role: &str, source: &Source) -> String {
        let mut hash = self.inputs.hash_without_gains.clone();
        hash.follow(&self.inputs.hash);
        hash.absorb(role, source);
        hash.hex()
    }
}
