//! The inputs of a mission: the hash of its files and of what was chosen beside them, and where its gains
//! come from.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::error::ConfigError;
use crate::gains_file::{GainsFile, gains_of, load_gains};
use crate::names::{gains_path, names_of};
use crate::overrides::{Override, put_all};
use crate::shipped::is_built_in;
use crate::source::{InputHash, NamedFile, Source};
use samara_core::hints::Typed;

/// Everything that the results of a mission depend on.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// SHA-256 of mission, vehicle, tables and gains, and of what was chosen beside them, hexadecimal.
    pub hash: String,
    /// How a command names the mission, with values that were set and gains that were chosen.
    pub typed: Typed,
    /// Choices beside the files: name and value, in the order of choosing.
    pub choices: Vec<(String, String)>,
    /// File of the gains; of built-in ones the path begins with `built-in:`.
    pub gains_file: PathBuf,
    /// The directory of the mission's own gains file.
    gains_directory: PathBuf,
    /// Keys of the gains' file with other values, whichever file that is.
    gains_set: Vec<(String, Override)>,
    /// The texts of mission and vehicle.
    texts: [Arc<str>; 2],
    hash_without_gains: InputHash,
}

impl Inputs {
    /// The inputs of a mission as its files give them, and its gains, in whose file these keys are set;
    /// `texts` are those of mission and vehicle.
    pub(super) fn of_files(
        source: &Source,
        gains_set: &[(String, Override)],
        texts: [String; 2],
        hash_without_gains: InputHash,
    ) -> Result<(Self, GainsFile), ConfigError> {
        let gains_directory = source.file.parent().map(Path::to_owned).unwrap_or_default();
        let mut inputs = Self {
            hash: String::new(),
            typed: Typed::default(),
            choices: Vec::new(),
            gains_file: PathBuf::new(),
            gains_directory,
            gains_set: gains_set.to_vec(),
            texts: texts.map(Arc::from),
            hash_without_gains,
        };
        let gains = inputs.take_gains(source)?;
        Ok((inputs, gains))
    }

    /// Reads gains: those of the file `name_or_path`, or of that name beside the mission's own gains file, or
    /// the built-in ones of that name. The hash follows.
    pub(super) fn other_gains(&mut self, name_or_path: &str) -> Result<GainsFile, ConfigError> {
        let path = gains_path(name_or_path, &self.gains_directory)?;
        let mut source = Source::read(&path, "gains file", None)?;
        put_all(&mut source, &self.gains_set)?;
        self.given_gains(&source)
    }

    /// Takes gains in place of those that there are. The hash follows.
    pub(super) fn given_gains(&mut self, source: &Source) -> Result<GainsFile, ConfigError> {
        let gains = self.take_gains(source)?;
        for (name, value) in self.choices.clone() {
            self.absorb(&name, &value);
        }
        Ok(gains)
    }

    fn take_gains(&mut self, source: &Source) -> Result<GainsFile, ConfigError> {
        let mut hash = self.hash_without_gains.clone();
        let gains = gains_of(source, &mut hash)?;
        (self.hash, self.gains_file) = (hash.hex(), source.file.clone());
        Ok(gains)
    }

    /// Takes over how the mission is named: by its file, or by the name of a built-in one, and these values.
    pub(super) fn type_mission(&mut self, file: &Path, set: &[Override]) {
        let word = match file.file_stem() {
            Some(stem) if is_built_in(file) => stem.to_string_lossy().into_owned(),
            _ => file.display().to_string(),
        };
        let set = set.iter().flat_map(|given| ["--set".to_owned(), given.to_string()]);
        self.typed.mission = [word].into_iter().chain(set).collect();
    }

    /// Takes over how its gains were chosen.
    pub(super) fn type_gains(&mut self, option: &str, value: impl Into<String>) {
        self.typed.gains = vec![option.to_owned(), value.into()];
    }

    /// Names of the gains beside the mission's own, in order.
    pub(super) fn gains_beside(&self) -> Vec<String> {
        names_of(&self.gains_directory)
    }

    /// The files that mission and vehicle name beside those of vehicle and gains: tables, and gains of
    /// renewed plans.
    pub fn named(&self) -> &[NamedFile] {
        self.hash_without_gains.named()
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

    /// The text of the mission's file, with what was set in it.
    pub fn mission_text(&self) -> &str {
        &self.texts[0]
    }

    /// The texts of mission and vehicle as they were read and, if they are named `gains_name`, those of the
    /// gains as their file is now, each with its name among results.
    pub(super) fn texts(&self, gains_name: &str) -> Result<Vec<(String, String)>, ConfigError> {
        let [mission, vehicle] = &self.texts;
        let mut files = vec![("mission.json", mission.to_string()), ("vehicle.json", vehicle.to_string())];
        // Others may have flown: of a parameter file, of a study.
        if load_gains(&self.gains_file)?.name == gains_name {
            let mut source = Source::read(&self.gains_file, "file", None)?;
            put_all(&mut source, &self.gains_set)?;
            files.push(("gains.json", source.text));
        }
        Ok(files.into_iter().map(|(name, text)| (name.to_owned(), text)).collect())
    }
}
