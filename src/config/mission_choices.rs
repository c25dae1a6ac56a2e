//! What is chosen in place of a mission's own: gains, seed, trajectory; and the hash of the inputs, which follows each choice.

use std::path::{Path, PathBuf};

use super::gains_file::{gains_path, load_named_gains};
use super::source::{InputHash, Source};
use super::trajectory_csv::{TrajectoryFile, load_trajectory};
use super::{ConfigError, GainsFile, Mission};

/// Where gains come from, and the hash of every other input.
#[derive(Clone)]
pub(super) struct GainsShelf {
    directory: PathBuf,
    hash_without_gains: InputHash,
}

impl std::fmt::Debug for GainsShelf {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        self.directory.fmt(f)
    }
}

impl GainsShelf {
    /// The shelf beside a mission's own gains file.
    pub(super) fn beside(gains_file: &Path, hash_without_gains: InputHash) -> Self {
        Self { directory: gains_file.parent().map(Path::to_owned).unwrap_or_default(), hash_without_gains }
    }

    /// Reads a gains file; with it, the hash of all inputs.
    pub(super) fn take(
        &self,
        path: &Path,
        named_in: Option<&Path>,
    ) -> Result<(GainsFile, String), ConfigError> {
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
        let path = gains_path(name_or_path, &self.gains_shelf.directory);
        let (gains, input_hash) = self.gains_shelf.take(&path, None)?;
        self.gains = gains.gains;
        self.gains_name = gains.name;
        self.input_hash = input_hash;
        for (name, value) in self.choices.clone() {
            self.absorb(&name, &value);
        }
        Ok(())
    }

    /// Hash of mission, vehicle and tables without the gains: the inputs of a search for gains.
    pub fn hash_without_gains(&self) -> String {
        self.gains_shelf.hash_without_gains.hex()
    }

    /// Notes what was chosen beside the files and decides what results hold (an option of the command line, the hash of a
    /// trajectory). The input hash follows.
    pub fn note_choice(&mut self, name: &str, value: &str) {
        self.choices.push((name.to_owned(), value.to_owned()));
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
        hash.follow(&self.input_hash);
        hash.absorb_text(name, value);
        self.input_hash = hash.hex();
    }

    /// The input hash with one more file in it.
    pub(super) fn hash_with(&self, role: &str, source: &Source) -> String {
        let mut hash = self.gains_shelf.hash_without_gains.clone();
        hash.follow(&self.input_hash);
        hash.absorb(role, source);
        hash.hex()
    }
}
