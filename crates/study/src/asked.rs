//! What was asked: all that decides the results of a study or a campaign, as it was typed. Shards hold it, so
//! that whoever puts them together needs no options.

use std::path::PathBuf;

use samara_mission::Mission;
use samara_report::json::VERSION;
use samara_report::shell::command_line;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::settings::{Setting, Values};

/// A study, or a campaign, as it was asked for.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Asked {
    /// Name of the kind.
    pub study: String,
    /// Version of samara that flies it.
    pub version: String,
    /// The mission, as it was typed.
    pub mission: PathBuf,
    /// SHA-256 of all inputs, hexadecimal.
    pub input_hash: String,
    /// Gains in place of the mission's own, a name or a file.
    pub gains: Option<String>,
    /// PX4 parameters in place of the mission's own.
    pub params: Option<PathBuf>,
    /// Seed of everything random.
    pub seed: u64,
    /// Name of the release case.
    pub case: Option<String>,
    /// Other values of keys, as `--set` takes them.
    pub set: Vec<String>,
    /// Names and texts of the settings.
    pub settings: Vec<(String, String)>,
    /// What flies whole drops over a wire, or by the model of one.
    pub wire: Option<AskedWire>,
    /// First line of the rows of a study; a campaign has none.
    pub head: String,
}

/// What flies whole drops.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct AskedWire {
    /// The autopilot, as `--autopilot` takes it.
    pub autopilot: String,
    /// Whether the reference autopilot flies by its own filter.
    pub ekf: bool,
    /// Whether the plan's acceleration is sent with its velocity.
    pub feed_forward: bool,
}

impl Asked {
    /// What is asked of a mission as it is, by a study of this name: nothing in place of the mission's own.
    pub fn of(study: &str, table: &[Setting], values: &Values, mission: &Mission) -> Self {
        let settings = values.in_order(table).into_iter();
        Self {
            study: study.to_owned(),
            version: VERSION.to_owned(),
            mission: mission.file.clone(),
            input_hash: mission.inputs.hash.clone(),
            gains: None,
            params: None,
            seed: mission.seed,
            case: None,
            set: Vec::new(),
            settings: settings.map(|(name, text)| (name.to_owned(), text)).collect(),
            wire: None,
            head: String::new(),
        }
    }

    /// Values of the settings.
    ///
    /// # Errors
    /// Where one is none of this table: its name, and what is expected.
    pub fn values(&self, table: &[Setting]) -> Result<Values, String> {
        let mut values = Values::usual(table);
        for (name, text) in &self.settings {
            values.put(table, name, text).map_err(|e| format!("settings.{name}: {e}"))?;
        }
        Ok(values)
    }

    /// The command of this verb that asks for it, quoted for a shell, with more words behind it.
    pub fn command(&self, verb: &[&str], more: impl IntoIterator<Item = String>) -> String {
        let words = ["samara"].iter().chain(verb).map(|word| (*word).to_owned());
        let words = words.chain([self.mission.display().to_string()]).chain(self.choices());
        command_line(words.chain(more))
    }

    /// The words that choose what flies, behind the mission in a command: all but the settings.
    pub fn choices(&self) -> Vec<String> {
        let option = |name: &str, value: Option<String>| {
            value.into_iter().flat_map(move |value| [name.to_owned(), value]).collect::<Vec<_>>()
        };
        let path = |path: &PathBuf| path.display().to_string();
        let wire = self.wire.as_ref();
        let mut words: Vec<String> =
            self.set.iter().flat_map(|text| ["--set".to_owned(), text.clone()]).collect();
        words.extend(option("--gains", self.gains.clone()));
        words.extend(option("--params", self.params.as_ref().map(path)));
        words.extend(option("--case", self.case.clone()));
        words.extend(option("--seed", Some(self.seed.to_string())));
        words.extend(option("--estimator", wire.filter(|wire| wire.ekf).map(|_| "ekf".to_owned())));
        words.extend(wire.filter(|wire| wire.feed_forward).map(|_| "--feed-forward".to_owned()));
        words.extend(option("--autopilot", wire.map(|wire| wire.autopilot.clone())));
        words
    }
}

/// SHA-256 of a text, hexadecimal.
pub fn sha256_hex(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}
