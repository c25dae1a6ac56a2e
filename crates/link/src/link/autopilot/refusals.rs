//! What ground stations offer for every PX4 multirotor and is not there: refused in the protocol's own way
//! where it has one, and in words, once each.
//!
//! | asked for | answer |
//! |---|---|
//! | DO_ORBIT, DO_SET_ROI_* and its elder kin | UNSUPPORTED |
//! | LOG_REQUEST_LIST | LOG_ENTRY: no logs |
//! | LOG_REQUEST_DATA, LOG_ERASE | words alone |
//! | SERIAL_CONTROL | the words, as the shell's output |
//! | REQUEST_EVENT | RESPONSE_EVENT_ERROR |

use std::collections::BTreeSet;

use mavlink::dialects::common::*;

use super::outbox::{Outbox, Peer};
use crate::autopilot::{Autopilot, Severity};

/// Something that is not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Missing {
    Orbit,
    RegionOfInterest,
    Logs,
    Console,
    Events,
}

impl Missing {
    fn words(self) -> &'static str {
        match self {
            Self::Orbit => "orbits are not flown here",
            Self::RegionOfInterest => "there is no region of interest here: the heading stays",
            Self::Logs => "no logs over MAVLink: flight.ulg is in the folder of results",
            Self::Console => "there is no console here",
            Self::Events => "there are no events here: what matters is said in words",
        }
    }

    /// What a command asks for that is not there.
    #[expect(deprecated, reason = "some are deprecated in MAVLink, still sent by ground stations")]
    pub(super) fn of_command(command: MavCmd) -> Option<Self> {
        match command {
            MavCmd::MAV_CMD_DO_ORBIT => Some(Self::Orbit),
            MavCmd::MAV_CMD_NAV_ROI
            | MavCmd::MAV_CMD_DO_SET_ROI
            | MavCmd::MAV_CMD_DO_SET_ROI_LOCATION
            | MavCmd::MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET
            | MavCmd::MAV_CMD_DO_SET_ROI_SYSID
            | MavCmd::MAV_CMD_DO_SET_ROI_NONE => Some(Self::RegionOfInterest),
            _ => None,
        }
    }
}

/// What has been refused in words.
#[derive(Clone, Debug, Default)]
pub(super) struct Refusals {
    said: BTreeSet<Missing>,
}

impl Refusals {
    /// Says that something is not there, unless that has been said.
    pub(super) fn say(&mut self, missing: Missing, autopilot: &mut Autopilot) {
        if self.said.insert(missing) {
            autopilot.say(Severity::Warning, missing.words());
        }
    }

    /// Answers a message that asks for something that is not there; whether it was that.
    pub(super) fn answer(
        &mut self,
        peer: Peer,
        message: &MavMessage,
        autopilot: &mut Autopilot,
        outbox: &mut Outbox,
    ) -> bool {
        let (missing, answer) = match message {
            MavMessage::LOG_REQUEST_LIST(_) => {
                (Missing::Logs, Some(MavMessage::LOG_ENTRY(LOG_ENTRY_DATA::DEFAULT)))
            }
            MavMessage::LOG_REQUEST_DATA(_) | MavMessage::LOG_ERASE(_) => (Missing::Logs, None),
            MavMessage::SERIAL_CONTROL(m) => (Missing::Console, shell_output(m)),
            MavMessage::REQUEST_EVENT(m) => {
                let error = RESPONSE_EVENT_ERROR_DATA {
                    sequence: m.first_sequence,
                    target_system: peer.system,
                    target_component: peer.component,
                    ..RESPONSE_EVENT_ERROR_DATA::DEFAULT
                };
                (Missing::Events, Some(MavMessage::RESPONSE_EVENT_ERROR(error)))
            }
            _ => return false,
        };
        self.say(missing, autopilot);
        if let Some(answer) = answer {
            outbox.reply(peer, &answer);
        }
        true
    }
}

/// The refusal as what a shell prints, to whom an answer is wanted by; a reply gets none.
fn shell_output(asked: &SERIAL_CONTROL_DATA) -> Option<MavMessage> {
    let wants_answer = asked.flags.contains(SerialControlFlag::SERIAL_CONTROL_FLAG_RESPOND)
        && !asked.flags.contains(SerialControlFlag::SERIAL_CONTROL_FLAG_REPLY);
    if !wants_answer || asked.device != SerialControlDev::SERIAL_CONTROL_DEV_SHELL {
        return None;
    }
    let mut answer = SERIAL_CONTROL_DATA {
        device: asked.device,
        flags: SerialControlFlag::SERIAL_CONTROL_FLAG_REPLY,
        ..SERIAL_CONTROL_DATA::DEFAULT
    };
    let text = Missing::Console.words().bytes().chain(*b"\r\n");
    for (place, byte) in answer.data.iter_mut().zip(text) {
        *place = byte;
        answer.count += 1;
    }
    Some(MavMessage::SERIAL_CONTROL(answer))
}
