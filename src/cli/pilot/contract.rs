//! What a pilot is: a flight in, what was flown out, and the options that not every pilot has.

use std::sync::atomic::AtomicBool;

use crate::cli::answer::Failure;
use crate::cli::live::Live;
use crate::cli::narrator::Narrator;
use crate::cli::results::OutputFolder;
use samara::config::Mission;
use samara::control::Fall;
use samara::link::shell::{Speed, Wiring};
use samara::replan::{ReplanRecord, ReplanSetup};
use samara::report::FlownBy;
use samara::sim::{FlightRecord, Sample};
use samara::trajectory::Trajectory;

/// An autopilot, or a model of one, that flies drops. It is made once for a run and flies any number of them.
pub trait Pilot: Sync {
    /// The name in results: "reference", "reference_ekf", "px4" or "px4-model".
    fn name(&self) -> &'static str;

    /// The end of the first line on the terminal, after mission, vehicle and gains.
    fn introduction(&self) -> &'static str;

    /// Refuses a mission that cannot be flown, before anything is started: what is wrong is wrong for every
    /// flight, of which the first is by the vehicle of this number. Prints what there is to remark on the
    /// parameters that the pilot is given.
    fn check(&self, mission: &Mission, trajectory: &Trajectory, instance: u16) -> Result<(), Failure>;

    /// The parameter file of all that the autopilot is given for a flight; `None` where it flies the
    /// mission's own gains.
    fn parameters(&self, _mission: &Mission, _trajectory: &Trajectory) -> Result<Option<String>, Failure> {
        Ok(None)
    }

    /// Whether each flight takes the ports of an instance for itself.
    fn takes_ports(&self) -> bool {
        false
    }

    /// Refuses an instance whose number or ports are taken.
    fn check_instance(&self, _instance: u16) -> Result<(), Failure> {
        Ok(())
    }

    /// Flies the drop to its end, or until the autopilot leaves or refuses.
    fn fly(&self, flight: &PilotedDrop<'_>) -> Result<Flown, Failure>;
}

/// A drop to be flown.
pub struct PilotedDrop<'a> {
    pub mission: &'a Mission,
    pub trajectory: &'a Trajectory,
    /// Renewals of the plan, where they are asked for.
    pub replan: Option<&'a ReplanSetup>,
    /// Where the files that grow during the flight go.
    pub folder: &'a OutputFolder,
    pub narrator: &'a Narrator,
    /// The vehicle's number, which shifts its ports.
    pub instance: u16,
    /// How fast simulated time shall run.
    pub speed: Speed,
    /// Further endpoints and the key of what is signed.
    pub wiring: &'a Wiring,
    /// The page on which it is looked at while it flies.
    pub live: Option<&'a Live>,
    /// Raised to end a campaign's flight; a single flight listens for Ctrl-C itself.
    pub stop: Option<&'a AtomicBool>,
}

/// A flight that is over.
pub struct Flown {
    /// The flight log.
    pub log: Vec<Sample>,
    /// Events of the flight, and whether a failsafe flew part of it.
    pub record: FlightRecord,
    /// Simulated seconds per second of wall time, where that is of interest.
    pub real_time_factor: Option<f64>,
    /// The autopilot, where it is known.
    pub by: Option<FlownBy>,
    /// Why the autopilot did not fly to the end, if it left or refused.
    pub trouble: Option<String>,
    /// Attempts to renew the plan.
    pub replans: Vec<ReplanRecord>,
    /// The fall by which the release was found, where nothing else reported it.
    pub fall: Option<Fall>,
}

impl Flown {
    /// A flight of the simulator alone, by nobody known: its log and what happened in it.
    pub fn of_simulator(log: Vec<Sample>, record: FlightRecord) -> Self {
        let (real_time_factor, by, trouble, fall) = (None, None, None, None);
        Self { log, record, real_time_factor, by, trouble, replans: Vec::new(), fall }
    }
}

/// An option that not every pilot has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PilotOption {
    Estimator,
    Link,
    SignKey,
    /// `--speed`, where it is not `max`.
    Speed,
    /// `--cpu`, where it is not `auto`.
    Cpu,
    /// `--patience`, where it is not the default.
    Patience,
    Px4sOwnGains,
    Replan,
}

impl PilotOption {
    /// The option as it is typed, and why some pilots do not have it.
    pub fn text(self) -> (&'static str, &'static str) {
        match self {
            Self::Estimator => ("--estimator", "PX4 has an estimator of its own"),
            Self::Link => ("--link", "PX4's links are its own, and the model flies without a wire"),
            Self::SignKey => ("--sign-key", "PX4's frames go unsigned, and the model sends none"),
            Self::Speed => ("--speed", "the model flies without a wire, as fast as it goes"),
            Self::Cpu => ("--cpu", "no other runs in a process beside the simulator"),
            Self::Patience => ("--patience", "no other is waited for"),
            Self::Replan => ("--replan", "plans are renewed from telemetry, and the model sends none"),
            Self::Px4sOwnGains => ("--gains px4_default", "they are PX4's own"),
        }
    }

    /// Those options of a verb that are asked for.
    pub fn asked<const N: usize>(options: [(Self, bool); N]) -> Vec<Self> {
        options.into_iter().filter(|(_, asked)| *asked).map(|(option, _)| option).collect()
    }
}
