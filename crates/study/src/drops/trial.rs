//! A drop of a campaign that is over: what is kept of it, and the file in which it waits for the others.
//!
//! Each drop has a file of its own as soon as it is over, so that a campaign that is stopped, or whose
//! machine fails, goes on where it was. The file holds exactly what lines, tables and page are made of: a
//! campaign of drops that were read gives the bytes of one that was flown in one go.

use serde::{Deserialize, Serialize};

use samara_core::assess::{Outcome, RandomDrop};
use samara_mission::Mission;
use samara_report::json::{VERSION, text};
use samara_report::outcome::OutcomeRecord;

/// A trial that is over.
#[derive(Clone, Debug, PartialEq)]
pub struct DropTrial {
    /// What was drawn.
    pub drawn: RandomDrop,
    /// What came of it, if it was released.
    pub outcome: Option<Outcome>,
    /// Names of the limits that were passed.
    pub limits_passed: Vec<String>,
    /// Why it counts as failed, if it does.
    pub failure: Option<String>,
}

impl DropTrial {
    /// A drop of which nothing is known but what was drawn.
    pub fn drawn(drawn: RandomDrop) -> Self {
        Self { drawn, outcome: None, limits_passed: Vec::new(), failure: None }
    }
}

/// A drop's file cannot be a part of the campaign.
#[derive(Debug, thiserror::Error)]
pub enum TrialFileError {
    /// The file is not what a campaign writes of a drop.
    #[error("a drop of a campaign, as `samara assess --autopilot` writes it, is expected")]
    Unreadable(#[from] serde_json::Error),
    /// The drop is of another campaign.
    #[error("this drop is of another campaign: {what} {found}, expected {expected}")]
    OtherCampaign {
        /// What differs.
        what: &'static str,
        /// The value in the file.
        found: String,
        /// The campaign's own.
        expected: String,
    },
}

/// A drop's file: a JSON object.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialFile {
    mission: String,
    version: String,
    seed: u64,
    input_hash: String,
    autopilot: String,
    /// The version of the autopilot that flew, where it reports one.
    pub autopilot_version: Option<String>,
    trial: u64,
    outcome: Option<OutcomeRecord>,
    limits_passed: Vec<String>,
    failure: Option<String>,
}

impl TrialFile {
    /// The file of a mission's drop by an autopilot of this name and version.
    pub fn new(mission: &Mission, autopilot: &str, version: Option<&str>, trial: &DropTrial) -> Self {
        Self {
            mission: mission.name.clone(),
            version: VERSION.to_owned(),
            seed: mission.seed,
            input_hash: mission.inputs.hash.clone(),
            autopilot: autopilot.to_owned(),
            autopilot_version: version.map(str::to_owned),
            trial: trial.drawn.trial,
            outcome: trial.outcome.map(OutcomeRecord),
            limits_passed: trial.limits_passed.clone(),
            failure: trial.failure.clone(),
        }
    }

    /// The object as text.
    pub fn to_json(&self) -> String {
        text(self)
    }

    /// The file of trial number `trial` of a mission's campaign by an autopilot of this name.
    ///
    /// # Errors
    /// [`TrialFileError`]: it is no such file, or of other inputs, another version of samara, another
    /// autopilot or another trial.
    pub fn parse(json: &str, mission: &Mission, autopilot: &str, trial: u64) -> Result<Self, TrialFileError> {
        let file: Self = serde_json::from_str(json)?;
        let pairs = [
            ("mission", file.mission.clone(), mission.name.clone()),
            ("version of samara", file.version.clone(), VERSION.to_owned()),
            ("seed", file.seed.to_string(), mission.seed.to_string()),
            ("hash of the inputs", file.input_hash.clone(), mission.inputs.hash.clone()),
            ("autopilot", file.autopilot.clone(), autopilot.to_owned()),
            ("trial", file.trial.to_string(), trial.to_string()),
        ];
        match pairs.into_iter().find(|(_, found, expected)| found != expected) {
            None => Ok(file),
            Some((what, found, expected)) => Err(TrialFileError::OtherCampaign { what, found, expected }),
        }
    }

    /// The trial, with what a mission draws for it.
    pub fn into_trial(self, mission: &Mission) -> DropTrial {
        DropTrial {
            drawn: mission.draw_drop(self.trial),
            outcome: self.outcome.map(|object| object.0),
            limits_passed: self.limits_passed,
            failure: self.failure,
        }
    }
}
