//! What the streamer reports; the simulated time of a report is the vehicle's `time_boot_ms`.

use core::time::Duration;
use std::fmt;

use super::vehicle::AutopilotVersion;
use crate::control::Fall;
use crate::control::px4::Version;
use crate::replan::ReplanRecord;
use crate::time::{TimeUs, seconds};

/// A report of the streamer.
#[derive(Clone, Debug, PartialEq)]
pub enum StreamerEvent {
    /// Heartbeat and clock of the vehicle, which is this system, have been heard; zero-thrust setpoints
    /// start.
    VehicleHeard(u8),
    /// The parameters are with the vehicle.
    Uploaded {
        /// How many.
        set: usize,
        /// Those that it does not have.
        absent: Vec<String>,
        /// Those of which no value has come.
        silent: Vec<String>,
    },
    /// The software that the vehicle flies.
    FlownBy {
        /// Version, if the vehicle has told one.
        version: Option<AutopilotVersion>,
        /// The version of PX4 that it is taken for.
        taken_for: &'static Version,
    },
    /// The texts of the vehicle's events are not known.
    NoEventTexts {
        /// Reason.
        why: String,
    },
    /// A parameter of the vehicle is not fit for a drop.
    Trap {
        /// The parameter.
        name: &'static str,
        /// Value of the parameter.
        value: f64,
        /// What comes of it.
        otherwise: &'static str,
    },
    /// The estimator has attitude and velocity.
    Aligned {
        /// Whether it has said so.
        reported: bool,
    },
    /// The estimator is not ready.
    NotAligned {
        /// Quantities that the estimator lacks.
        lacking: String,
        /// What the vehicle said meanwhile.
        said: Vec<String>,
    },
    /// The estimator has lost what it had.
    EstimateLost {
        /// Quantities that the estimator lacks.
        lacking: String,
        /// What the vehicle said meanwhile.
        said: Vec<String>,
    },
    /// The vehicle is in a mode in which its tilt limit comes up, and is left in it for this long.
    Holds(TimeUs),
    /// The vehicle was not for long enough in such a mode.
    NotHeld,
    /// The release is asked for later by this than it was to be.
    Late(TimeUs),
    /// Velocity setpoints wait: the vehicle believes to be on the ground.
    HeldBack,
    /// Arming has waited in vain for the vehicle's own checks.
    ChecksNotPassed {
        /// Whether the vehicle has reported them.
        reported: bool,
    },
    /// OFFBOARD has been accepted.
    Offboard,
    /// Arming has been accepted.
    Armed,
    /// The release has been commanded to the parachute.
    ReleaseAsked,
    /// The release and its instant are known.
    Released {
        /// Simulated time of the release.
        released_at: TimeUs,
        /// Whether the parachute said so; otherwise it is the time of its acknowledgement.
        reported: bool,
    },
    /// The vehicle falls, by its accelerometer: the release and its instant are known.
    Falls(Fall),
    /// The first setpoint of the plan has been sent.
    Tracking,
    /// The plan is over, the target velocity follows.
    Target,
    /// An attempt to renew the plan; its times are since t = 0.
    Replanned(ReplanRecord),
    /// A command has been refused.
    Refused {
        /// What was asked.
        what: &'static str,
        /// The answer.
        result: String,
        /// What the vehicle said meanwhile.
        said: Vec<String>,
    },
    /// A command has not been answered.
    Unanswered {
        /// What was asked.
        what: &'static str,
        /// Component that should have answered.
        by: &'static str,
    },
    /// The vehicle is no longer armed in OFFBOARD while it should be.
    Lost {
        /// "armed" or "in OFFBOARD".
        what: &'static str,
        /// What the vehicle said meanwhile.
        said: Vec<String>,
    },
    /// Vehicle or parachute said something.
    Text {
        /// `MAV_SEVERITY`, 0 the worst, 7 debug.
        severity: u8,
        /// The text.
        text: String,
    },
    /// Vehicle and parachute say more than anybody can read: what follows is not reported for a while.
    TooManyTexts,
    /// The vehicle's clock has jumped back to the time of this report: it has been started anew, and so is
    /// the streamer.
    VehicleRestarted,
    /// Nothing comes; the time is the last that was heard.
    Waiting {
        /// What is missing.
        missing: &'static str,
        /// From which system.
        system_id: u8,
        /// For how long, as the caller measures.
        waited: Duration,
    },
    /// The streamer has given up, for this reason.
    Failed(String),
    /// The stream is at its end.
    Done,
}

fn join(said: &[String]) -> String {
    if said.is_empty() { String::new() } else { format!("; the vehicle says: {}", said.join("; ")) }
}

impl fmt::Display for StreamerEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::VehicleHeard(system_id) => {
                write!(f, "vehicle {system_id} heard, streaming level attitude, no thrust")
            }
            Self::Uploaded { set, absent, silent } => {
                write!(f, "{set} parameters set, each echoed")?;
                for (what, names) in [("unknown to this autopilot", absent), ("not answered", silent)] {
                    if !names.is_empty() {
                        write!(f, "; {what}: {}", names.join(" "))?;
                    }
                }
                Ok(())
            }
            Self::FlownBy { version: Some(version), taken_for } => {
                write!(f, "the vehicle flies PX4 {version}")?;
                match version.known() == Some(taken_for) && version.number() == taken_for.number {
                    true => Ok(()),
                    false => write!(f, ", taken for {}", taken_for.number),
                }
            }
            Self::FlownBy { version: None, taken_for } => {
                write!(f, "the vehicle does not tell its version: by its parameters PX4 {}", taken_for.number)
            }
            Self::NoEventTexts { why } => {
                write!(f, "what the vehicle says by EVENT is not understood: its metadata, {why}")
            }
            Self::Trap { name, value, otherwise } => write!(f, "{name} = {value}: {otherwise}"),
            Self::NotAligned { lacking, said } => {
                write!(f, "waiting for the estimator: no {lacking} yet{}", join(said))
            }
            Self::EstimateLost { lacking, said } => {
                write!(f, "the estimator has lost {lacking}: waiting for it{}", join(said))
            }
            Self::Holds(for_us) => {
                write!(f, "left in HOLD for {:.2} s: PX4's tilt limit comes up there", seconds(*for_us))
            }
            Self::Late(late) => write!(f, "the release comes {:.1} s after hang_s", seconds(*late)),
            Self::Released { released_at, reported: true } => {
                write!(f, "released at {:.3} s", seconds(*released_at))
            }
            Self::Released { released_at, reported: false } => write!(
                f,
                "release acknowledged but its time not told (NAMED_VALUE_INT t_release); taking {:.3} s",
                seconds(*released_at)
            ),
            Self::Falls(Fall { began_at, found_at }) => write!(
                f,
                "falls since {:.3} s by its accelerometer, found at {:.3} s",
                seconds(*began_at),
                seconds(*found_at)
            ),
            Self::Refused { what, result, said } => write!(f, "{what} refused ({result}){}", join(said)),
            Self::Unanswered { what, by } => {
                write!(f, "{what}: no COMMAND_ACK from the {by}, asking again")
            }
            Self::Lost { what, said } => write!(f, "the vehicle is no longer {what}{}", join(said)),
            Self::Replanned(record) => write!(f, "{record}"),
            Self::Text { text, .. } => write!(f, "> {text}"),
            Self::Waiting { missing, system_id, waited } => {
                let waited_s = waited.as_secs_f64();
                write!(
                    f,
                    "waiting since {waited_s:.1} s for {missing} from the autopilot of system {system_id}"
                )
            }
            Self::Failed(reason) => write!(f, "gave up: {reason}"),
            plain => f.write_str(plain.fixed_text()),
        }
    }
}

impl StreamerEvent {
    /// The text of a report that has no values in it.
    fn fixed_text(&self) -> &'static str {
        match self {
            Self::Aligned { reported: true } => "the estimator has attitude and velocity",
            Self::Aligned { reported: false } => "the estimator tells nothing (ESTIMATOR_STATUS); going on",
            Self::NotHeld => {
                "not long enough in HOLD: PX4's tilt limit is not up, and comes with 0.2 rad/s only"
            }
            Self::HeldBack => {
                "the vehicle believes to be on the ground (EXTENDED_SYS_STATE): velocity setpoints wait, it would keep its \
                 rotors at zero thrust"
            }
            Self::ChecksNotPassed { reported: true } => {
                "the vehicle's checks before arming do not pass (SYS_STATUS); asking why"
            }
            Self::ChecksNotPassed { reported: false } => {
                "the vehicle tells nothing of its checks before arming (SYS_STATUS); going on"
            }
            Self::Offboard => "OFFBOARD accepted",
            Self::Armed => "armed",
            Self::ReleaseAsked => "release commanded",
            Self::Tracking => "streaming the plan",
            Self::Target => "plan at its end, streaming the target velocity",
            Self::TooManyTexts => "the vehicle says more than can be read: what it says now is left out",
            Self::VehicleRestarted => "the vehicle's clock went back: starting over",
            Self::Done => "stream ended",
            _ => "",
        }
    }
}
