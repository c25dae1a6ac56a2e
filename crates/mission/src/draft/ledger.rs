//! Where each number of a draft is from, as its file says it.

use super::text;
use crate::estimated::OriginKind;
use crate::foreign::{Key, Known, KnownVehicle};

/// Where numbers of a draft are from.
struct Told {
    keys: Vec<&'static str>,
    kind: OriginKind,
    file: Option<String>,
    formula: String,
}

impl Told {
    /// The line of the file.
    fn line(&self) -> String {
        let keys = serde_json::Value::from(self.keys.clone()).to_string().replace("\",", "\", ");
        let (kind, formula) = (self.kind.word(), text(&self.formula));
        let file = self.file.as_ref().map_or_else(String::new, |file| format!("\"file\": {}, ", text(file)));
        format!("    {{ \"keys\": {keys}, \"kind\": \"{kind}\", {file}\"formula\": {formula} }}")
    }
}

/// Where each number of a draft is from: told, a file's, or estimated.
pub(super) struct Ledger<'a> {
    pub(super) files: &'a KnownVehicle,
    /// Keys of what was told.
    pub(super) told: Vec<&'static str>,
    given: Vec<Told>,
    estimated: Vec<Told>,
}

impl<'a> Ledger<'a> {
    /// Nothing is noted yet of a draft from these files.
    pub(super) fn new(files: &'a KnownVehicle) -> Self {
        Self { files, told: Vec::new(), given: Vec::new(), estimated: Vec::new() }
    }

    /// Notes the formula that keys are estimated by.
    pub(super) fn estimate(&mut self, keys: &[&'static str], formula: String) {
        self.estimated.push(Told { keys: keys.to_vec(), kind: OriginKind::Estimated, file: None, formula });
    }

    /// Notes the place in a file that a key's value is from.
    pub(super) fn of_file<T>(&mut self, key: &'static str, known: &Known<T>) {
        let (file, formula) = (Some(known.file.clone()), known.words.clone());
        match self.given.iter_mut().find(|told| told.file == file && told.formula == formula) {
            Some(told) => told.keys.push(key),
            None => self.given.push(Told { keys: vec![key], kind: OriginKind::Given, file, formula }),
        }
    }

    /// Notes that a number is a file's, or else was told.
    pub(super) fn known(&mut self, key: Key) {
        match self.files.numbers.get(&key) {
            Some(known) => self.of_file(key.path(), known),
            None => self.told.push(key.path()),
        }
    }

    /// The number that was told, else a file's, else the estimate with its formula.
    pub(super) fn number(
        &mut self,
        key: Key,
        told: Option<f64>,
        estimate: impl FnOnce() -> (f64, String),
    ) -> f64 {
        if let Some(number) = told {
            self.told.push(key.path());
            return number;
        }
        if let Some(known) = self.files.numbers.get(&key) {
            self.of_file(key.path(), known);
            return known.value;
        }
        let (number, formula) = estimate();
        self.estimate(&[key.path()], formula);
        number
    }

    /// The lines of the file: what was told, what files give, what is estimated.
    pub(super) fn lines(mut self) -> Vec<String> {
        let formula = "told to samara new vehicle".to_owned();
        let told =
            Told { keys: std::mem::take(&mut self.told), kind: OriginKind::Given, file: None, formula };
        let told = Some(told).filter(|told| !told.keys.is_empty());
        told.iter().chain(&self.given).chain(&self.estimated).map(Told::line).collect()
    }
}
