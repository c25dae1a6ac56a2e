//! What a HIL session reports.

use core::time::Duration;
use std::fmt;

use super::board::Checked;
use crate::sim::DropEvent;
use crate::time::TimeUs;

/// What a wait is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    /// No autopilot has connected.
    Autopilot,
    /// The line to a board is gone.
    Board,
    /// The autopilot has connected and not sent a single frame.
    AnyFrame,
    /// The autopilot owes the answer to a HIL_SENSOR.
    ActuatorControls,
    /// No companion has been heard yet.
    Companion,
    /// The companion owes its next setpoint.
    Setpoint,
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Autopilot => "an autopilot, which connects to TCP 4560 + instance",
            Self::Board => "the line to the board, which is looked for",
            Self::AnyFrame => "any message from the autopilot, which has connected but sent nothing",
            Self::ActuatorControls => "HIL_ACTUATOR_CONTROLS from the autopilot, the answer to HIL_SENSOR",
            Self::Companion => {
                "a companion: any message from a script to the parachute, which sends to UDP 14540 + instance"
            }
            Self::Setpoint => "the companion's next setpoint",
        })
    }
}

/// A report of a HIL session: what happened in the drop, and what happened on the link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HilEvent {
    /// Something has happened in the drop.
    Drop(DropEvent),
    /// An autopilot has connected; `again`: the drop has started over for it.
    Connected {
        /// The drop had begun with an earlier one.
        again: bool,
    },
    /// The first answer has come; from here on, simulator and autopilot run in lockstep.
    Lockstep,
    /// The first answer has come from an autopilot with a clock of its own; from here on, time goes on.
    RealTime,
    /// How a parameter that hardware in the loop depends on is set on the board.
    Board(Checked),
    /// An answer is missing; simulated time stands still.
    Waiting {
        /// What is missing.
        missing: Missing,
        /// For how long, as the host measures.
        waited: Duration,
    },
    /// A companion is heard; simulated time goes no faster than the clock until its setpoints come.
    CompanionHeard,
    /// Setpoints are heard; simulated time waits for them from here on.
    CompanionStreams,
    /// No setpoint has come for so long; simulated time goes on without until one is heard.
    CompanionSilent(Duration),
    /// HIL_ACTUATOR_CONTROLS with this time, which no HIL_SENSOR had; not used.
    Mistimed(TimeUs),
    /// The autopilot has gone; simulated time stands still.
    PeerLeft,
    /// The mission is over.
    Finished,
}

impl fmt::Display for HilEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drop(event @ DropEvent::Armed { .. }) => write!(f, "autopilot {event}"),
            Self::Drop(event @ DropEvent::ModeUnknown) => write!(
                f,
                "{event} (a HEARTBEAT would name it, and PX4 sends none on the simulator link: choose another trigger, or bring its \
                 HEARTBEAT to the parachute's UDP port 14600 + instance)"
            ),
            Self::Drop(event) => event.fmt(f),
            Self::Connected { again: false } => f.write_str("autopilot connected"),
            Self::Connected { again: true } => f.write_str("autopilot connected; the drop starts over"),
            Self::Lockstep => f.write_str("first answer from the autopilot, lockstep from here"),
            Self::RealTime => f.write_str("first answer from the autopilot, in real time from here"),
            Self::Board(checked) => checked.fmt(f),
            Self::Waiting { missing, waited } => {
                write!(f, "waiting since {:.1} s for {missing}", waited.as_secs_f64())
            }
            Self::CompanionHeard => {
                f.write_str("a companion is heard; in real time until it streams setpoints")
            }
            Self::CompanionStreams => f.write_str("setpoints are heard, in step with them from here"),
            Self::CompanionSilent(waited) => write!(
                f,
                "no setpoint for {:.1} s: going on without the companion until one is heard",
                waited.as_secs_f64()
            ),
            Self::Mistimed(stamp) => {
                write!(f, "ignored HIL_ACTUATOR_CONTROLS stamped {stamp} us: no HIL_SENSOR had that time")
            }
            Self::PeerLeft => f.write_str("autopilot disconnected; waiting for a new one"),
            Self::Finished => f.write_str("end of the mission"),
        }
    }
}
