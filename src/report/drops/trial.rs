//! A drop of a campaign that is over: what is kept of it, and the file in which it waits for the others.
//!
//! Each drop has a file of its own as soon as it is over, so that a campaign that is stopped, or whose
//! machine fails, goes on where it was. The file holds exactly what lines, tables and page are made of: a
//! campaign of drops that were read gives the bytes of one that was flown in one go.

use serde::{Deserialize, Serialize};

use crate::assess::{DropOutcome, RandomDrop};
use crate::config::Mission;
use crate::report::json::{VERSION, text};
use crate::units::DEG_PER_RAD;

/// A trial that is over.
#[derive(Clone, Debug, PartialEq)]
pub struct DropTrial {
    /// What was drawn.
    pub drawn: RandomDrop,
    /// What came of it, if it was released.
    pub outcome: Option<DropNumbers>,
    /// Why it counts as failed, if it does.
    pub failure: Option<String>,
}

/// Numbers of a drop that was released, in the units of files. What is not finite, as after a state that was
/// none, would hide the other trials' means: it is `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DropNumbers {
    /// Pitch at the release [deg].
    pub release_pitch_deg: Option<f64>,
    /// Pitch rate at the release [deg/s].
    pub release_pitch_rate_deg_s: Option<f64>,
    /// J_TPF, (51).
    pub j_tpf: Option<f64>,
    /// Largest speed [m/s].
    pub peak_speed_m_s: Option<f64>,
    /// Largest pitch, either way, without its sign [deg].
    pub peak_pitch_deg: Option<f64>,
    /// Largest pitch rate, either way, without its sign [deg/s].
    pub peak_pitch_rate_deg_s: Option<f64>,
    /// Largest roll, either way, without its sign [deg].
    pub peak_roll_deg: Option<f64>,
    /// Largest angle between the body's up axis and the vertical [deg].
    pub peak_tilt_deg: Option<f64>,
    /// Way down from the release to the end of the plan [m].
    pub altitude_lost_m: Option<f64>,
    /// Time after t = 0 from which the flight is steady, to the end [s].
    pub steady_after_s: Option<f64>,
    /// Root of the mean square of `|v - v_plan|` over the plan [m/s].
    pub tracking_rms_m_s: Option<f64>,
    /// Way from the release to the end of the plan, NED [m].
    pub way_ned_m: [Option<f64>; 3],
    /// Least distance from the canopy after the release [m], where the canopy is a body of its own.
    pub canopy_distance_m: Option<f64>,
    /// Names of the limits that were passed.
    pub limits_passed: Vec<String>,
}

impl From<&DropOutcome> for DropNumbers {
    fn from(outcome: &DropOutcome) -> Self {
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let degrees = |x: f64| finite(x * DEG_PER_RAD);
        let v = &outcome.verdict;
        Self {
            release_pitch_deg: degrees(outcome.release_pitch_rad),
            release_pitch_rate_deg_s: degrees(outcome.release_pitch_rate_rad_s),
            j_tpf: finite(v.j_tpf),
            peak_speed_m_s: finite(v.peak_speed_m_s),
            peak_pitch_deg: degrees(v.peak_pitch_rad.abs()),
            peak_pitch_rate_deg_s: degrees(v.peak_pitch_rate_rad_s.abs()),
            peak_roll_deg: degrees(v.peak_roll_rad.abs()),
            peak_tilt_deg: degrees(v.peak_tilt_rad),
            altitude_lost_m: finite(v.altitude_lost_m),
            steady_after_s: v.steady_after_s.and_then(finite),
            tracking_rms_m_s: finite(outcome.tracking_rms_m_s),
            way_ned_m: [v.way_ned_m.x, v.way_ned_m.y, v.way_ned_m.z].map(finite),
            canopy_distance_m: v.canopy_distance_m.and_then(finite),
            limits_passed: v.limits_passed.iter().map(|name| (*name).to_owned()).collect(),
        }
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
    outcome: Option<DropNumbers>,
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
            outcome: trial.outcome.clone(),
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
        DropTrial { drawn: mission.draw_drop(self.trial), outcome: self.outcome, failure: self.failure }
    }
}
