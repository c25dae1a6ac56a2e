//! What flies a drop: samara's own autopilot, PX4, or the model of PX4's control law. Each is one room and
//! says there which options it has; another pilot is another room and its lines here.
//!
//! | file | holds |
//! |---|---|
//! | `contract` | what a pilot is: the trait, its flight, what was flown |
//! | `reference` | samara's own autopilot, over the wire in memory or at a speed to watch |
//! | `px4` | PX4 in a process of its own |
//! | `board` | PX4 on a board on a serial line |
//! | `places` | how many drops fly side by side, and under which number |
//! | `px4_model` | the model of PX4's control law, without a wire |

pub mod board;
mod contract;
mod places;
pub mod px4;
pub mod px4_model;
mod reference;

use std::path::Path;

use super::answer::Failure;
use super::args::{AutopilotArg, ChoiceArgs, StateArgs};
pub use contract::{Flown, Pilot, PilotOption, PilotedDrop};
pub use places::Places;
pub use px4::Px4Settings;
pub use reference::Reference;
use samara::config::Mission;
use samara::link::shell::SerialUrl;

/// The autopilots as they are typed, with the options that each has.
const PILOTS: [(&str, &[PilotOption]); 3] =
    [("reference", reference::OPTIONS), ("px4=DIR", px4::OPTIONS), ("px4-model", px4_model::OPTIONS)];

/// What a verb asks of a pilot.
pub struct PilotRequest<'a> {
    pub autopilot: &'a AutopilotArg,
    /// The line of a board that flies instead.
    pub board: Option<&'a SerialUrl>,
    /// The mission's file.
    pub mission: &'a Path,
    pub choice: &'a ChoiceArgs,
    pub state: &'a StateArgs,
    pub settings: Px4Settings,
    /// Whether the plan's acceleration is sent with its velocity, whatever the mission says.
    pub feed_forward: bool,
    /// The options asked for that not every pilot has.
    pub options: Vec<PilotOption>,
}

/// The pilot that is asked for and the mission for it, which notes what decides the flight beside the files.
/// An option that the pilot does not have is refused, never passed over: who asks for signed frames and gets
/// unsigned ones should know.
pub fn pilot_and_mission(request: &PilotRequest<'_>) -> Result<(Box<dyn Pilot>, Mission), Failure> {
    let PilotRequest { autopilot, board, mission, choice, state, settings, feed_forward, ref options } =
        *request;
    let [of_reference, of_px4, of_px4_model] = PILOTS;
    let (_, own) = match autopilot {
        AutopilotArg::Reference => of_reference,
        AutopilotArg::Px4(_) => of_px4,
        AutopilotArg::Px4Model(_) => of_px4_model,
    };
    if let Some(line) = board {
        if let Some(foreign) = options.iter().find(|option| !board::OPTIONS.contains(option)) {
            let (option, _) = foreign.text();
            return Err(Failure::input(format!(
                "{option}: not with --serial, whose board flies in real time"
            )));
        }
        let (pilot, mut mission) = board::Board::new(line, mission, choice)?;
        feed_forward_where_asked(&mut mission, feed_forward);
        return Ok((Box::new(pilot), mission));
    }
    if let Some(foreign) = options.iter().find(|option| !own.contains(option)) {
        let (option, why) = foreign.text();
        let owners = PILOTS.iter().filter(|(_, own)| own.contains(foreign)).map(|(name, _)| *name);
        let owners = owners.collect::<Vec<_>>().join(" or ");
        return Err(Failure::input(format!("{option}: --autopilot {owners} is expected with it; {why}")));
    }
    let (pilot, mut mission): (Box<dyn Pilot>, Mission) = match autopilot {
        AutopilotArg::Reference => {
            let (pilot, mission) = Reference::new(mission, choice, state)?;
            (Box::new(pilot), mission)
        }
        AutopilotArg::Px4(build) => {
            let (pilot, mission) = px4::Px4::new(build, mission, choice, settings)?;
            (Box::new(pilot), mission)
        }
        AutopilotArg::Px4Model(law) => {
            let (pilot, mission) = px4_model::Px4Model::new(*law, mission, choice)?;
            (Box::new(pilot), mission)
        }
    };
    feed_forward_where_asked(&mut mission, feed_forward);
    Ok((pilot, mission))
}

fn feed_forward_where_asked(mission: &mut Mission, asked: bool) {
    if asked {
        mission.control.feed_forward = true;
        mission.note_choice("feed forward", "yes");
    }
}
