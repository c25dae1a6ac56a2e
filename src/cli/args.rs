//! The options that several verbs share; those of one verb stand beside it.

use std::path::PathBuf;

use clap::Args;

use crate::link::shell::LinkUrl;

/// Options that every verb with a mission has.
#[derive(Args, Debug)]
pub struct MissionArgs {
    /// The mission file.
    #[arg(default_value = "mission/titan_drop.json")]
    pub mission: PathBuf,
    /// Folder for the results [default: out/<mission name>].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
}

/// What every verb that plans has.
#[derive(Args, Debug)]
pub struct PlanningArgs {
    /// Show each iteration of the planner on stderr.
    #[arg(short, long)]
    pub verbose: bool,
}

/// Which of several vehicles side by side.
#[derive(Args, Debug)]
pub struct NetArgs {
    /// Number of the vehicle: shifts its ports as PX4 does, and its MAVLink system id.
    #[arg(long, value_name = "0..9", default_value_t = 0, value_parser = super::net::instance)]
    pub instance: u16,
    /// Sign what is sent to ground stations, companions and parachute, and let in only what is signed: a file with 64 hexadecimal
    /// digits or a passphrase, as QGroundControl and MAVProxy take it.
    #[arg(long, value_name = "FILE")]
    pub sign_key: Option<PathBuf>,
}

/// Endpoints besides an instance's own.
#[derive(Args, Debug)]
pub struct LinkArgs {
    /// A further endpoint for ground stations: udpin, udpout, tcpin or tcpout, then :HOST:PORT (`in` binds and serves whoever
    /// comes, `out` goes there). May be repeated.
    #[arg(long = "link", value_name = "URL")]
    pub links: Vec<LinkUrl>,
}

/// How fast simulated time shall run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpeedArg {
    /// Simulated seconds per second.
    Factor(f64),
    /// As fast as it goes.
    Max,
}

/// Who flies a drop.
#[derive(Clone, Debug, PartialEq)]
pub enum AutopilotArg {
    /// samara's own.
    Reference,
    /// PX4, from a build folder.
    Px4(PathBuf),
    /// The model of PX4's control law.
    Px4Model,
}

/// What can be chosen in place of the mission's own.
#[derive(Args, Clone, Debug)]
pub struct ChoiceArgs {
    /// Gains: a name beside the mission's own gains (ours, safety, near_hover, paper_pso), or a file; `px4_default`: PX4's own, where
    /// it flies.
    #[arg(long, value_name = "NAME|FILE")]
    pub gains: Option<String>,
    /// Gains and limits of samara's autopilot from a PX4 parameter file that is for it, or for any autopilot under standard gravity.
    #[arg(long, value_name = "FILE", conflicts_with = "gains")]
    pub params: Option<PathBuf>,
    /// Seed of everything random, instead of the mission's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Let the vehicle swing under its canopy so that it comes to t = 0 with the pitch and pitch rate of this release case of the
    /// mission (Table 3: case_0 to case_6).
    #[arg(long, value_name = "NAME")]
    pub case: Option<String>,
}

/// What the reference autopilot flies by.
#[derive(Args, Debug)]
pub struct StateArgs {
    /// What the autopilot takes its state from.
    #[arg(long, value_enum, default_value_t = EstimatorChoice::Truth)]
    pub estimator: EstimatorChoice,
}

/// Where the autopilot's state comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum EstimatorChoice {
    /// The simulator's truth (ODOMETRY, HIL_STATE_QUATERNION), as in the paper's study.
    Truth,
    /// Its own Kalman filter on the sensors (HIL_SENSOR, HIL_GPS).
    Ekf,
}

/// Simulated seconds per second.
///
/// # Errors
/// What was expected, in words.
pub fn speed(text: &str) -> Result<SpeedArg, String> {
    if text == "max" {
        return Ok(SpeedArg::Max);
    }
    match text.parse::<f64>() {
        Ok(x) if (0.001..=10_000.0).contains(&x) => Ok(SpeedArg::Factor(x)),
        _ => Err("a factor from 0.001 to 10000, or `max`, is expected".to_owned()),
    }
}

/// Who flies.
///
/// # Errors
/// What was expected, in words.
pub fn autopilot(text: &str) -> Result<AutopilotArg, String> {
    match text.split_once('=') {
        None if text == "reference" => Ok(AutopilotArg::Reference),
        None if text == "px4-model" => Ok(AutopilotArg::Px4Model),
        Some(("px4", folder)) if !folder.is_empty() => Ok(AutopilotArg::Px4(folder.into())),
        _ => Err("`reference`, `px4-model`, or `px4=` and a build folder of PX4's simulation is expected"
            .to_owned()),
    }
}

/// A positive number.
///
/// # Errors
/// What was expected, in words.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x > 0.0 => Ok(x),
        _ => Err("a positive number is expected".to_owned()),
    }
}
