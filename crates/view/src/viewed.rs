//! The mission that is open, and its keys with other values.

use std::path::PathBuf;

use serde_json::{Map, Value};

use samara_mission::{ConfigError, Mission, Override, load_mission_with};

/// Keys with other values, in the order in which they were given.
pub type Changes = Vec<Override>;

/// Why a changed mission is none.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// The files do not take a value.
    #[error(transparent)]
    File(#[from] ConfigError),
    /// There is nothing to fly, or it cannot be flown.
    #[error("{0}")]
    Unflown(String),
    /// Something newer is wanted.
    #[error("overtaken")]
    Overtaken,
}

/// What is wrong, with the causes behind it.
pub(crate) fn with_causes(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(error.source(), |cause| cause.source());
    causes.fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}

/// A mission that is looked at.
#[derive(Clone, Debug)]
pub struct Viewed {
    /// The mission's file, or the path of a built-in one.
    pub path: PathBuf,
    /// The mission as a command names it.
    pub typed: String,
    /// Values that were given when it was opened; those of the page come after them.
    pub set: Changes,
}

impl Viewed {
    /// The mission with other values of its keys.
    ///
    /// # Errors
    /// [`Refused::File`] of a value that its file does not take, with its place; [`Refused::Unflown`] of a
    /// mission without a drop.
    pub fn with(&self, changes: &[Override]) -> Result<Mission, Refused> {
        let mission = load_mission_with(&self.path, &self.all(changes))?;
        if mission.release.standing {
            return Err(Refused::Unflown("the vehicle starts on the ground, there is no drop".to_owned()));
        }
        Ok(mission)
    }

    /// The command that flies the mission with these values, quoted for a shell.
    pub fn command(&self, changes: &[Override]) -> String {
        let set = self.all(changes).into_iter().flat_map(|set| ["--set".to_owned(), set.to_string()]);
        let words = ["samara".to_owned(), "drop".to_owned(), self.typed.clone()].into_iter().chain(set);
        samara_report::shell::command_line(words)
    }

    /// All values, those that were given at the opening first; of a key that has two, the later.
    pub(crate) fn all(&self, changes: &[Override]) -> Changes {
        let mut all: Changes = Vec::new();
        for given in self.set.iter().chain(changes) {
            all.retain(|earlier| earlier.key() != given.key());
            all.push(given.clone());
        }
        all
    }
}

/// The changes of an object `{"KEY": "VALUE", ..}`, or which key is no such thing and why.
pub fn changes_of(object: &Map<String, Value>) -> Result<Changes, (String, String)> {
    let change = |(key, value): (&String, &Value)| {
        let refused = |why: &str| (key.clone(), format!("{key}: {why}"));
        let value = value.as_str().ok_or_else(|| refused("a text is expected"))?;
        format!("{key}={value}").parse::<Override>().map_err(|why| refused(&why))
    };
    object.iter().map(change).collect()
}

/// The change whose value a message is about, where it says so.
pub(crate) fn key_of(message: &str, changes: &[Override]) -> Option<String> {
    let named = |change: &&Override| message.contains(&format!("--set {change}"));
    changes.iter().rev().find(named).map(|change| change.key().to_owned())
}
