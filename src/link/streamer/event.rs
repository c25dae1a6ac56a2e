//! What the streamer has to tell, with simulated times (the vehicle's `time_boot_ms`).

use core::time::Duration;
use std::fmt;

use super::super::{TimeUs, seconds};

/// An event.
#[derive(Clone, Debug, PartialEq)]
pub enum StreamerEvent {
    /// Heartbeat and clock of the vehicle have been heard; zero-thrust setpoints start.
    VehicleHeard {
        /// Simulated time.
        at: TimeUs,
        /// The vehicle's system.
        system_id: u8,
    },
    /// The parameters are with the vehicle.
    Uploaded {
        /// Simulated time.
        at: TimeUs,
        /// How many.
        set: usize,
        /// Those that it does not have.
        absent: Vec<String>,
    },
    /// A parameter of the vehicle is not fit for a drop.
    Trap {
        /// Simulated time.
        at: TimeUs,
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What comes of it.
        otherwise: &'static str,
    },
    /// The estimator has attitude and velocity.
    Aligned {
        /// Simulated time.
        at: TimeUs,
        /// Whether it has said so.
        told: bool,
    },
    /// The estimator is not ready.
    NotAligned {
        /// Simulated time.
        at: TimeUs,
        /// What it lacks.
        lacking: String,
        /// What the vehicle said meanwhile.
        said: Vec<String>,
    },
    /// The estimator has lost what it had.
    EstimateLost {
        /// Simulated time.
        at: TimeUs,
        /// What it lacks.
        lacking: String,
        /// What the vehicle said meanwhile.
        said: Vec<String>,
    },
    /// The vehicle is in a mode in which its tilt limit comes up.
    Holds {
        /// Simulated time.
        at: TimeUs,
        /// For how long it is left in it.
        for_us: TimeUs,
    },
    /// The vehicle was not for long enough in such a mode.
    NotHeld {
        /// Simulated time.
        at: TimeUs,
    },
    /// The release is asked for later than it was to be.
    Late {
        /// Simulated time.
        at: TimeUs,
        /// By how much.
        late: TimeUs,
    },
    /// Velocity setpoints wait: the vehicle believes to be on the ground.
    HeldBack {
        /// Simulated time.
        at: TimeUs,
    },
    /// Arming has waited in vain for the vehicle's own checks.
    ChecksNotPassed {
        /// Simulated time.
        at: TimeUs,
        /// Whether the vehicle has told of them.
        told: bool,
    },
    /// OFFBOARD has been accepted.
    Offboard {
        /// Simulated time.
        at: TimeUs,
    },
    /// Arming has been accepted.
    Armed {
        /// Simulated time.
        at: TimeUs,
    },
    /// The parachute has been told to cut.
    ReleaseAsked {
        /// Simulated time.
        at: TimeUs,
    },
    /// The release and its instant are known.
    Released {
        /// Simulated time.
        at: TimeUs,
        /// The release.
        released_at: TimeUs,
        /// Whether the parachute said so; otherwise it is the time of its acknowledgement.
        told: bool,
    },
    /// The first setpoint of the plan has been sent.
    Tracking {
        /// Simulated time.
        at: TimeUs,
    },
    /// The plan is over, the target velocity follows.
    Target {
        /// Simulated time.
        at: TimeUs,
    },
    /// A command has been refused.
    Refused {
        /// Simulated time.
        at: TimeUs,
        /// What was asked.
        what: &'static str,
        /// The answer.
        result: String,
        /// What the vehicle said meanwhile.
        said: Vec<String>,
    },
    /// A command has not been answered.
    Unanswered {
        /// Simulated time.
        at: TimeUs,
        /// What was asked.
        what: &'static str,
        /// Component that should have answered.
        by: &'static str,
    },
    /// The vehicle is no longer armed in OFFBOARD while it should be.
    Lost {
        /// Simulated time.
        at: TimeUs,
        /// "armed" or "in OFFBOARD".
        what: &'static str,
        /// What the vehicle said meanwhile.
        said: Vec<String>,
    },
    /// Vehicle or parachute said something.
    Text {
        /// Simulated time.
        at: TimeUs,
        /// `MAV_SEVERITY`, 0 the worst, 7 debug.
        severity: u8,
        /// The text.
        text: String,
    },
    /// The vehicle's clock has jumped back: it has been started anew, and so is the streamer.
    VehicleRestarted {
        /// The vehicle's new time.
        at: TimeUs,
    },
    /// Nothing comes.
    Waiting {
        /// Simulated time last heard.
        at: TimeUs,
        /// What is missing.
        missing: &'static str,
        /// From which system.
        system_id: u8,
        /// For how long, as the caller measures.
        waited: Duration,
    },
    /// The streamer has given up.
    Failed {
        /// Simulated time.
        at: TimeUs,
        /// Why.
        reason: String,
    },
    /// The stream is at its end.
    Done {
        /// Simulated time.
        at: TimeUs,
    },
}

fn join(said: &[String]) -> String {
    if said.is_empty() { String::new() } else { format!("; the vehicle says: {}", said.join("; ")) }
}

impl fmt::Display for StreamerEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let s = |at: &TimeUs| seconds(*at);
        match self {
            Self::VehicleHeard { at, system_id } => {
                write!(f, "{:8.3} s  vehicle {system_id} heard, streaming level attitude, no thrust", s(at))
            }
            Self::Uploaded { at, set, absent } => {
                write!(f, "{:8.3} s  {set} parameters set, each echoed", s(at))?;
                if absent.is_empty() {
                    return Ok(());
                }
                write!(f, "; unknown to this autopilot: {}", absent.join(" "))
            }
            Self::Trap { at, name, value, otherwise } => {
                write!(f, "{:8.3} s  {name} = {value}: {otherwise}", s(at))
            }
            Self::Aligned { at, told: true } => {
                write!(f, "{:8.3} s  the estimator has attitude and velocity", s(at))
            }
            Self::Aligned { at, told: false } => {
                write!(f, "{:8.3} s  the estimator tells nothing (ESTIMATOR_STATUS); going on", s(at))
            }
            Self::NotAligned { at, lacking, said } => {
                write!(f, "{:8.3} s  waiting for the estimator: no {lacking} yet{}", s(at), join(said))
            }
            Self::EstimateLost { at, lacking, said } => {
                write!(f, "{:8.3} s  the estimator has lost {lacking}: waiting for it{}", s(at), join(said))
            }
            Self::Holds { at, for_us } => write!(
                f,
                "{:8.3} s  left in HOLD for {:.2} s: PX4's tilt limit comes up there",
                s(at),
                s(for_us)
            ),
            Self::NotHeld { at } => write!(
                f,
                "{:8.3} s  not long enough in HOLD: PX4's tilt limit is not up, and comes with 0.2 rad/s only",
                s(at)
            ),
            Self::Late { at, late } => {
                write!(f, "{:8.3} s  the release comes {:.1} s after hang_s", s(at), s(late))
            }
            Self::HeldBack { at } => write!(
                f,
                "{:8.3} s  the vehicle believes to be on the ground (EXTENDED_SYS_STATE): velocity setpoints wait, it would keep its \
                 rotors at zero thrust",
                s(at)
            ),
            Self::ChecksNotPassed { at, told: true } => {
                write!(
                    f,
                    "{:8.3} s  the vehicle's checks before arming do not pass (SYS_STATUS); asking why",
                    s(at)
                )
            }
            Self::ChecksNotPassed { at, told: false } => {
                write!(
                    f,
                    "{:8.3} s  the vehicle tells nothing of its checks before arming (SYS_STATUS); going on",
                    s(at)
                )
            }
            Self::Offboard { at } => write!(f, "{:8.3} s  OFFBOARD accepted", s(at)),
            Self::Armed { at } => write!(f, "{:8.3} s  armed", s(at)),
            Self::ReleaseAsked { at } => write!(f, "{:8.3} s  release commanded", s(at)),
            Self::Released { at, released_at, told: true } => {
                write!(f, "{:8.3} s  released at {:.3} s", s(at), s(released_at))
            }
            Self::Released { at, released_at, told: false } => write!(
                f,
                "{:8.3} s  release acknowledged but its time not told (NAMED_VALUE_INT t_release); taking {:.3} s",
                s(at),
                s(released_at)
            ),
            Self::Tracking { at } => write!(f, "{:8.3} s  streaming the plan", s(at)),
            Self::Target { at } => {
                write!(f, "{:8.3} s  plan at its end, streaming the target velocity", s(at))
            }
            Self::Refused { at, what, result, said } => {
                write!(f, "{:8.3} s  {what} refused ({result}){}", s(at), join(said))
            }
            Self::Unanswered { at, what, by } => {
                write!(f, "{:8.3} s  {what}: no COMMAND_ACK from the {by}, asking again", s(at))
            }
            Self::Lost { at, what, said } => {
                write!(f, "{:8.3} s  the vehicle is no longer {what}{}", s(at), join(said))
            }
            Self::Text { at, text, .. } => write!(f, "{:8.3} s  > {text}", s(at)),
            Self::VehicleRestarted { at } => {
                write!(f, "{:8.3} s  the vehicle's clock went back: starting over", s(at))
            }
            Self::Waiting { at, missing, system_id, waited } => write!(
                f,
                "{:8.3} s  waiting since {:.1} s for {missing} from the autopilot of system {system_id}",
                s(at),
                waited.as_secs_f64()
            ),
            Self::Failed { at, reason } => write!(f, "{:8.3} s  gave up: {reason}", s(at)),
            Self::Done { at } => write!(f, "{:8.3} s  stream ended", s(at)),
        }
    }
}
