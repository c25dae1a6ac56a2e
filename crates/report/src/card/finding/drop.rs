//! A drop, and drops of the release cases.

use serde::Deserialize;

use crate::outcome::OutcomeObject;
use samara_core::assess::Outcome;

/// `drop.json`.
#[derive(Clone, Debug, Deserialize)]
pub struct DropFound {
    /// Name of the autopilot.
    pub autopilot: Option<String>,
    /// Version of the autopilot.
    pub autopilot_version: Option<String>,
    safe: bool,
    objections: Vec<String>,
    #[serde(flatten)]
    outcome: OutcomeObject,
    /// The quantity that it is the share of.
    pub decided_by: Option<String>,
    /// J_TPF of the plan.
    pub plan_j_tpf: Option<f64>,
}

/// A drop of `cases.json`.
#[derive(Clone, Debug, Deserialize)]
pub struct CaseFound {
    /// Name of the release case.
    pub case: String,
    /// Name of the autopilot.
    pub autopilot: String,
    /// The drop.
    pub drop: DropFound,
}

#[derive(Deserialize)]
pub(super) struct CasesFile {
    pub(super) cases: Vec<CaseFound>,
}

impl DropFound {
    /// The drop's numbers; none where nothing was released.
    pub fn outcome(&self) -> &Outcome {
        &self.outcome.0
    }

    /// Why it was not safe, if it was not, in the judge's words: `samara drop` answers by the same.
    pub fn fault(&self) -> Option<String> {
        (!self.safe).then(|| self.objections.join("; "))
    }

    /// The pilot, in words.
    pub fn pilot(&self) -> String {
        pilot_words(
            self.autopilot.as_deref().unwrap_or("an unknown autopilot"),
            self.autopilot_version.as_deref(),
        )
    }
}

/// An autopilot of results, in words.
pub fn pilot_words(name: &str, version: Option<&str>) -> String {
    let version = version.map_or_else(String::new, |version| format!(" {version}"));
    match name {
        "reference" => "the reference autopilot on the true state".to_owned(),
        "reference_ekf" => "the reference autopilot on its own estimator".to_owned(),
        "px4" => format!("PX4{version}"),
        "px4-model" => format!("the model of PX4{version}'s control law"),
        other => other.to_owned(),
    }
}
