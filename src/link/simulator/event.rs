//! What the simulator has to tell, with simulated times.

use core::time::Duration;
use std::fmt;

use super::super::{TimeUs, seconds};

/// Why the vehicle was cut loose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReleaseCause {
    /// A command to the parachute.
    Command,
    /// The mission's time.
    Time,
    /// The mission's altitude.
    Altitude,
    /// Armed and in OFFBOARD.
    ArmedOffboard,
    /// It came to the ground under its canopy.
    Ground,
}

impl ReleaseCause {
    /// A few words.
    pub fn text(self) -> &'static str {
        match self {
            Self::Command => "by command",
            Self::Time => "at the mission's time",
            Self::Altitude => "at the altitude",
            Self::ArmedOffboard => "armed in OFFBOARD",
            Self::Ground => "on the ground, which it reached under its canopy",
        }
    }
}

/// What a wait is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    /// The autopilot has connected and not sent a single frame.
    AnyFrame,
    /// The autopilot owes the answer to a HIL_SENSOR.
    ActuatorControls,
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::AnyFrame => "any message from the autopilot, which has connected but sent nothing",
            Self::ActuatorControls => "HIL_ACTUATOR_CONTROLS from the autopilot, the answer to HIL_SENSOR",
        })
    }
}

/// An event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SimulatorEvent {
    /// An autopilot has connected; `again`: the drop has started over for it.
    Connected {
        /// The drop had begun with an earlier one.
        again: bool,
    },
    /// The first answer has come; from here on, simulator and autopilot run in lockstep.
    Lockstep {
        /// Simulated time.
        at: TimeUs,
    },
    /// The autopilot has been armed or disarmed.
    Armed {
        /// Simulated time.
        at: TimeUs,
        /// Which of the two.
        armed: bool,
    },
    /// The autopilot is armed but does not tell its mode, which the release waits for.
    ModeUntold {
        /// Simulated time.
        at: TimeUs,
    },
    /// The autopilot, armed, has gone into a failsafe or left it.
    Failsafe {
        /// Simulated time.
        at: TimeUs,
        /// Which of the two.
        active: bool,
    },
    /// The vehicle has been cut loose.
    Released {
        /// Simulated time.
        at: TimeUs,
        /// Why.
        cause: ReleaseCause,
    },
    /// At that moment the autopilot was not armed: the vehicle falls.
    ReleasedUnarmed {
        /// Simulated time.
        at: TimeUs,
    },
    /// The delay is over, the rotors may turn.
    RotorsFree {
        /// Simulated time.
        at: TimeUs,
    },
    /// A limit of the mission has been passed, for the first time.
    LimitPassed {
        /// Simulated time.
        at: TimeUs,
        /// Which.
        name: &'static str,
    },
    /// The vehicle has come to the ground.
    TouchedGround {
        /// Simulated time.
        at: TimeUs,
        /// How fast it sank [m/s].
        speed_m_s: f64,
    },
    /// An answer is missing.
    Waiting {
        /// Simulated time, which stands still.
        at: TimeUs,
        /// What is missing.
        missing: Missing,
        /// For how long, as the caller measures.
        waited: Duration,
    },
    /// The step has been made without the answer.
    GoingOnWithout {
        /// Simulated time.
        at: TimeUs,
        /// What was missing.
        missing: Missing,
    },
    /// HIL_ACTUATOR_CONTROLS with a time that no HIL_SENSOR had; not used.
    Mistimed {
        /// Simulated time.
        at: TimeUs,
        /// The message's time.
        stamp: TimeUs,
    },
    /// The autopilot has gone.
    PeerLeft {
        /// Simulated time, which stands still.
        at: TimeUs,
    },
    /// The mission is over.
    Finished {
        /// Simulated time.
        at: TimeUs,
    },
}

fn touched(speed_m_s: f64) -> String {
    format!("on the ground at {speed_m_s:.2} m/s")
}

impl SimulatorEvent {
    /// What is wrong in [`Self::ModeUntold`].
    pub(super) const MODE_UNTOLD: &'static str = "armed, but the release trigger armed_offboard waits for OFFBOARD in a HEARTBEAT, and no HEARTBEAT of the autopilot has \
         named a mode (PX4 sends none on the simulator link: choose another trigger, or bring its HEARTBEAT to the parachute's \
         UDP port 14600 + instance)";

    /// What is said at [`Self::ReleasedUnarmed`].
    pub(super) const NOT_ARMED: &'static str = "released while the autopilot is not armed";

    /// Time and words of an event that belongs to the flight: not of what depends on waits and connections.
    pub(super) fn of_flight(&self) -> Option<(TimeUs, String)> {
        let (at, text) = match *self {
            Self::Armed { at, armed: true } => (at, "armed".to_owned()),
            Self::Armed { at, armed: false } => (at, "disarmed".to_owned()),
            Self::ModeUntold { at } => (at, Self::MODE_UNTOLD.to_owned()),
            Self::Failsafe { at, active: true } => (at, "failsafe: the autopilot has taken over".to_owned()),
            Self::Failsafe { at, active: false } => (at, "failsafe over".to_owned()),
            Self::Released { at, cause } => (at, format!("released {}", cause.text())),
            Self::ReleasedUnarmed { at } => (at, Self::NOT_ARMED.to_owned()),
            Self::RotorsFree { at } => (at, "rotors free".to_owned()),
            Self::LimitPassed { at, name } => (at, format!("limit passed: {name}")),
            Self::TouchedGround { at, speed_m_s } => (at, touched(speed_m_s)),
            Self::Connected { .. }
            | Self::Lockstep { .. }
            | Self::Waiting { .. }
            | Self::GoingOnWithout { .. }
            | Self::Mistimed { .. }
            | Self::PeerLeft { .. }
            | Self::Finished { .. } => return None,
        };
        Some((at, text))
    }
}

impl fmt::Display for SimulatorEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let s = |at: &TimeUs| seconds(*at);
        match self {
            Self::Connected { again: false } => f.write_str("autopilot connected"),
            Self::Connected { again: true } => f.write_str("autopilot connected; the drop starts over"),
            Self::Lockstep { at } => {
                write!(f, "{:8.3} s  first answer from the autopilot, lockstep from here", s(at))
            }
            Self::Armed { at, armed: true } => write!(f, "{:8.3} s  autopilot armed", s(at)),
            Self::Armed { at, armed: false } => write!(f, "{:8.3} s  autopilot disarmed", s(at)),
            Self::ModeUntold { at } => write!(f, "{:8.3} s  {}", s(at), Self::MODE_UNTOLD),
            Self::Failsafe { at, active: true } => {
                write!(f, "{:8.3} s  failsafe: the autopilot has taken over", s(at))
            }
            Self::Failsafe { at, active: false } => write!(f, "{:8.3} s  failsafe over", s(at)),
            Self::Released { at, cause } => write!(f, "{:8.3} s  released {}", s(at), cause.text()),
            Self::ReleasedUnarmed { at } => write!(f, "{:8.3} s  {}", s(at), Self::NOT_ARMED),
            Self::RotorsFree { at } => write!(f, "{:8.3} s  rotors free", s(at)),
            Self::LimitPassed { at, name } => write!(f, "{:8.3} s  limit passed: {name}", s(at)),
            Self::TouchedGround { at, speed_m_s } => write!(f, "{:8.3} s  {}", s(at), touched(*speed_m_s)),
            Self::Waiting { at, missing, waited } => {
                write!(f, "{:8.3} s  waiting since {:.1} s for {missing}", s(at), waited.as_secs_f64())
            }
            Self::GoingOnWithout { at, missing } => write!(f, "{:8.3} s  going on without {missing}", s(at)),
            Self::Mistimed { at, stamp } => write!(
                f,
                "{:8.3} s  ignored HIL_ACTUATOR_CONTROLS stamped {stamp} us: no HIL_SENSOR had that time",
                s(at)
            ),
            Self::PeerLeft { at } => {
                write!(f, "{:8.3} s  autopilot disconnected; waiting for a new one", s(at))
            }
            Self::Finished { at } => write!(f, "{:8.3} s  end of the mission", s(at)),
        }
    }
}
