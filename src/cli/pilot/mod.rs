//! What flies a drop: samara's own autopilot, PX4, or the model of PX4's control law. Each is one room and
//! says there which options it has; another pilot is another room and its lines here.
//!
//! | file | holds |
//! |---|---|
//! | `contract` | what a pilot is: the trait, its flight, what was flown |
//! | `reference` | samara's own autopilot, over the wire in memory or at a speed to watch |
//! | `px4` | PX4 in a process of its own |
//! | `px4_model` | the model of PX4's control law, without a wire |

mod contract;
pub mod px4;
mod px4_model;
mod reference;

use std::path::Path;

use super::answer::Failure;
use super::args::{AutopilotArg, ChoiceArgs, StateArgs};
use super::terminal::print_err;
pub use contract::{Flight, Flown, Pilot, PilotOption};
pub use px4::Px4Settings;
pub use reference::Reference;
use samara::config::Mission;
use samara::trajectory::Trajectory;

/// The autopilots as they are typed, with the options that each has.
const PILOTS: [(&str, &[PilotOption]); 3] =
    [("reference", reference::OPTIONS), ("px4=DIR", px4::OPTIONS), ("px4-model", px4_model::OPTIONS)];

/// Refuses the first option that is asked for and that the autopilot does not have, never passes it over: who
/// asks for signed frames and gets unsigned ones should know.
pub fn refuse_foreign_options(autopilot: &AutopilotArg, asked: &[PilotOption]) -> Result<(), Failure> {
    let own = match autopilot {
        AutopilotArg::Reference => reference::OPTIONS,
        AutopilotArg::Px4(_) => px4::OPTIONS,
        AutopilotArg::Px4Model => px4_model::OPTIONS,
    };
    let Some(foreign) = asked.iter().find(|option| !own.contains(option)) else { return Ok(()) };
    let (option, why) = foreign.words();
    let owners: Vec<&str> =
        PILOTS.iter().filter(|(_, own)| own.contains(foreign)).map(|(name, _)| *name).collect();
    let owners = owners.join(" or ");
    Err(Failure::input(format!("{option}: --autopilot {owners} is expected with it; {why}")))
}

/// The pilot of `--autopilot` and the mission for it, which notes what decides the flight beside the files.
pub fn pilot_and_mission(
    autopilot: &AutopilotArg,
    mission: &Path,
    choice: &ChoiceArgs,
    state: &StateArgs,
    settings: Px4Settings,
) -> Result<(Box<dyn Pilot>, Mission), Failure> {
    let feed_forward = settings.feed_forward;
    let (pilot, mut mission): (Box<dyn Pilot>, Mission) = match autopilot {
        AutopilotArg::Reference => {
            let (pilot, mission) = Reference::new(mission, choice, state)?;
            (Box::new(pilot), mission)
        }
        AutopilotArg::Px4(build) => {
            let (pilot, mission) = px4::Px4::new(build, mission, choice, settings)?;
            (Box::new(pilot), mission)
        }
        AutopilotArg::Px4Model => {
            let (pilot, mission) = px4_model::Px4Model::new(mission, choice, feed_forward)?;
            (Box::new(pilot), mission)
        }
    };
    if feed_forward {
        mission.note_choice("feed forward", "yes");
    }
    Ok((pilot, mission))
}

/// Refuses a mission that the pilot cannot fly: what is wrong is wrong for every flight. Prints, once, what
/// there is to remark on the parameters that PX4 is given.
pub fn check_mission(pilot: &dyn Pilot, mission: &Mission, trajectory: &Trajectory) -> Result<(), Failure> {
    for remark in pilot.check(mission, trajectory)? {
        print_err(&format!("samara: {}: {remark}\n", mission.control.gains_name));
    }
    Ok(())
}
