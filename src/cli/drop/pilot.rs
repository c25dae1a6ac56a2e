//! Who flies a drop: samara's own autopilot, PX4, or the model of PX4's control law.

use std::path::Path;

use super::{DropArgs, Wires, flight};
use crate::cli::args::{AutopilotArg, ChoiceArgs, EstimatorChoice, StateArgs};
use crate::cli::mission::{mission_for_px4, mission_with_a_drop, note_estimator};
use crate::cli::narrative::Narrator;
use crate::cli::net::speed_of;
use crate::cli::outcome::{BadInput, Failure};
use crate::cli::output::OutputFolder;
use crate::cli::px4::flight::Px4Drop;
use crate::cli::px4::{self, BuildFolder, Patience};
use samara::config::Mission;
use samara::link::FlightRecord;
use samara::params::ParameterFile;
use samara::report::FlownBy;
use samara::sim::Sample;
use samara::trajectory::Trajectory;

/// What a flight without a wire does not leave.
const OF_THE_WIRE: [&str; 4] = ["hil.tlog", "vehicle.tlog", "companion.tlog", "flight.ulg"];

/// Who flies.
pub enum Pilot {
    /// samara's own autopilot, with what is chosen of it.
    Reference(ChoiceArgs),
    /// PX4, and the parameters it is given in place of the mission's gains.
    Px4(BuildFolder, Option<ParameterFile>),
    /// The model of PX4's control law, and its parameters likewise.
    Px4Model(Option<ParameterFile>),
}

impl Pilot {
    /// The pilot of `--autopilot` and the mission for it, which notes what decides the flight beside the files.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when there is no PX4 where it should be, or a file is missing or wrong.
    pub fn of(
        argument: &AutopilotArg,
        path: &Path,
        choice: &ChoiceArgs,
        state: &StateArgs,
        feed_forward: bool,
    ) -> Result<(Self, Mission), Failure> {
        let (pilot, mut mission) = match argument {
            AutopilotArg::Reference => {
                let mut mission = mission_with_a_drop(path, choice)?;
                note_estimator(&mut mission, state);
                (Self::Reference(choice.clone()), mission)
            }
            AutopilotArg::Px4(build) => {
                let build = BuildFolder::open(build).bad_input()?;
                let (mut mission, parameters) = mission_for_px4(path, choice)?;
                mission.note_choice("autopilot", "px4");
                (Self::Px4(build, parameters), mission)
            }
            AutopilotArg::Px4Model => {
                let (mut mission, parameters) = mission_for_px4(path, choice)?;
                mission.note_choice("autopilot", "px4-model");
                (Self::Px4Model(parameters), mission)
            }
        };
        if feed_forward {
            mission.note_choice("feed forward", "yes");
        }
        Ok((pilot, mission))
    }

    /// What is said of it at the start.
    pub fn words(&self, state: &StateArgs) -> &'static str {
        match self {
            Self::Reference(_) if state.estimator == EstimatorChoice::Ekf => ", on its own estimator",
            Self::Reference(_) => "",
            Self::Px4(..) => ", flown by PX4",
            Self::Px4Model(_) => ", flown by the model of PX4's control law",
        }
    }

    /// The name in results.
    pub fn name(&self, state: &StateArgs) -> &'static str {
        match self {
            Self::Reference(_) if state.estimator == EstimatorChoice::Ekf => "reference_ekf",
            Self::Reference(_) => "reference",
            Self::Px4(..) => "px4",
            Self::Px4Model(_) => "px4-model",
        }
    }

    /// Looks whether the mission can be flown, before anything is started: what is wrong is wrong for every flight. Gives what is to
    /// say of the parameters.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when PX4 does not suit the mission, its vehicle or its gains.
    pub fn check(&self, mission: &Mission, trajectory: &Trajectory) -> Result<Vec<String>, Failure> {
        match self {
            Self::Reference(_) => Ok(Vec::new()),
            Self::Px4(build, parameters) => {
                let (_, preparation) = px4::flight::prepare(build, mission, trajectory, parameters.as_ref())?;
                Ok(preparation.upload.remarks)
            }
            Self::Px4Model(parameters) => {
                Ok(px4::model::parameters_for(mission, trajectory, parameters.as_ref())?.1)
            }
        }
    }

    /// Flies the mission.
    ///
    /// # Errors
    /// [`Failure`] when a port or file cannot be had, or PX4 not started.
    pub fn fly(
        &self,
        args: &DropArgs,
        mission: &Mission,
        trajectory: &Trajectory,
        folder: &OutputFolder,
        narrator: &Narrator,
    ) -> Result<Flown, Failure> {
        match self {
            Self::Reference(choice) => {
                let DropArgs { state, net, link, speed, .. } = args;
                let wires = Wires { choice, state, net, link, speed: *speed, stop: None };
                let flown = flight::fly(&wires, mission, trajectory, folder, narrator)?;
                // Verdict and events tell all that there is.
                Ok(Flown { trouble: None, ..flown })
            }
            Self::Px4(build, parameters) => {
                let drop = Px4Drop {
                    build,
                    instance: args.net.instance,
                    cpu: args.cpu,
                    speed: speed_of(args.speed),
                    parameters: parameters.as_ref(),
                    feed_forward: args.feed_forward,
                    patience: Patience { limit: args.patience.limit(), answers: args.cases },
                };
                px4::fly(&drop, mission, trajectory, folder, narrator)
            }
            Self::Px4Model(parameters) => {
                folder.remove(&OF_THE_WIRE)?;
                px4::model::fly(mission, trajectory, parameters.as_ref(), args.feed_forward)
            }
        }
    }
}

/// A flown drop.
pub struct Flown {
    /// The flight log.
    pub log: Vec<Sample>,
    /// What happened.
    pub record: FlightRecord,
    /// Simulated seconds per second.
    pub real_time_factor: f64,
    /// Who flew.
    pub by: FlownBy,
    /// Why the autopilot did not fly to the end, if it left or refused.
    pub trouble: Option<String>,
}
