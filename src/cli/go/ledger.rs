//! What has been done of a way to the card: `go.json`, written before and after each step, so that one that
//! was stopped or killed anywhere goes on there.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::cli::answer::Failure;
use crate::cli::results::OutputFolder;
use samara::config::bounded::text_at_most;
use samara::report::json::VERSION;

/// Name of the file.
const FILE: &str = "go.json";
/// The most that is read of it [bytes].
const LARGEST: u64 = 1 << 20;

/// A step that was begun.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// The command, as it is typed.
    pub command: String,
    /// Hash of the inputs.
    pub inputs: String,
    /// The answer, once it is there.
    pub answer: Option<Said>,
}

/// The answer of a step.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Said {
    /// Whether it is a yes.
    pub yes: bool,
    /// The conclusion, one line or more.
    pub conclusion: Vec<String>,
    /// Commands that look closer.
    pub closer: Vec<String>,
}

/// Steps by their names, of one version of samara.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Ledger {
    version: String,
    steps: BTreeMap<String, Entry>,
}

impl Ledger {
    /// The ledger of a folder; one that is not there, is damaged or of another version is empty: all is done
    /// anew.
    pub fn read(folder: &Path) -> Self {
        let text = text_at_most(&folder.join(FILE), LARGEST).unwrap_or_default();
        let ledger: Option<Self> = serde_json::from_str(&text).ok();
        let of_this = ledger.filter(|ledger| ledger.version == VERSION);
        of_this.unwrap_or_else(|| Self { version: VERSION.to_owned(), steps: BTreeMap::new() })
    }

    /// What is known of a step, if its command and inputs are these.
    pub fn of(&self, step: &str, command: &str, inputs: &str) -> Option<&Entry> {
        self.steps.get(step).filter(|entry| entry.command == command && entry.inputs == inputs)
    }

    /// Notes a step and writes the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn note(&mut self, step: &str, entry: Entry, folder: &OutputFolder) -> Result<(), Failure> {
        self.steps.insert(step.to_owned(), entry);
        let text = serde_json::to_string_pretty(self).map_err(anyhow::Error::from)?;
        folder.write_text(FILE, &(text + "\n")).map(|_| ())
    }
}
