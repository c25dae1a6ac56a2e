//! Who flies a drop: samara's own autopilot, PX4, or the model of PX4's control law.

use std::path::Path;

use super::{DropArgs, flight};
use crate::cli::args::{AutopilotArg, ChoiceArgs, EstimatorChoice, StateArgs};
use crate::cli::mission::{mission_for_px4, mission_with_a_drop, note_estimator};
use crate::cli::narrative::Narrator;
use crate::cli::net::speed_of;
use crate::cli::outcome::{BadInput, Failure};
use crate::cli::output::OutputFolder;
use crate::cli::px4::flight::Px4Drop;
use crate::cli::px4::{self, BuildFolder};
use crate::config::Mission;
use crate::link::FlightRecord;
use crate::params::ParameterFile;
use crate::sim::Sample;
use crate::trajectory::Trajectory;

/// What a flight without a wire does not leave.
const OF_THE_WIRE: [&str; 3] = ["hil.tlog", "vehicle.tlog", "flight.ulg"];

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
    /// The pilot of `--autopilot`, which may have an estimator of its own, and the mission for it.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when there is no PX4 where it should be, it is told what to fly by, or a file is missing or wrong.
    pub fn of(
        argument: &AutopilotArg,
        path: &Path,
        choice: &ChoiceArgs,
        state: &StateArgs,
    ) -> Result<(Self, Mission), Failure> {
        if *argument != AutopilotArg::Reference && state.estimator == EstimatorChoice::Ekf {
            let text =
                "--estimator: --autopilot reference is expected with it; PX4 has an estimator of its own";
            return Err(anyhow::anyhow!(text)).bad_input();
        }
        Ok(match argument {
            AutopilotArg::Reference => {
                let mut mission = mission_with_a_drop(path, choice)?;
                note_estimator(&mut mission, state);
                (Self::Reference(choice.clone()), mission)
            }
            AutopilotArg::Px4(build) => {
                let build = BuildFolder::open(build).bad_input()?;
                let (mission, parameters) = mission_for_px4(path, choice)?;
                (Self::Px4(build, parameters), mission)
            }
            AutopilotArg::Px4Model => {
                let (mission, parameters) = mission_for_px4(path, choice)?;
                (Self::Px4Model(parameters), mission)
            }
        })
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
            Self::Reference(choice) => flight::fly(args, choice, mission, trajectory, folder, narrator),
            Self::Px4(build, parameters) => {
                let drop = Px4Drop {
                    build,
                    instance: args.net.instance,
                    cpu: args.cpu,
                    speed: speed_of(args.speed),
                    parameters: parameters.as_ref(),
                    feed_forward: args.feed_forward,
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
    /// Why the autopilot did not fly to the end, if it left or refused.
    pub trouble: Option<String>,
}
