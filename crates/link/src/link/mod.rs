//! The wire: MAVLink frames, and the sans-IO sessions that speak them.
//!
//! | file | holds |
//! |---|---|
//! | [`session`] | the contract between a session and its host; links |
//! | [`frame`] | a frame as received; what a strict message enum refuses stays readable |
//! | [`decoder`] | bytes to frames: stream and datagram, MAVLink 1 and 2 |
//! | [`encoder`] | messages to bytes |
//! | [`faults`] | what came and was not as it should be, by kind |
//! | [`signing`] | MAVLink 2 signatures |
//! | [`stamps`] | their time stamps, as they survive a restart |
//! | [`hub`] | many peers: who gets what, numbering, signing, forwarding, counts |
//! | [`peer`] | who is at the other end of a link |
//! | [`froude`] | PX4 under another gravity: the wire's scale |
//! | [`tlog`] | the record of what went over the wire, written and read |
//! | [`mod@replay`] | a drop flown again from its recorded actuators |
//! | [`parachute`] | the parachute component: release by command |
//! | [`hil`] | the simulator's side of PX4's HIL link: lockstep, sensors as messages |
//! | [`streamer`] | the offboard streamer: arms, releases, streams the plan |
//! | [`autopilot`] | the reference autopilot: HIL client, vehicle for ground stations and companions |
//! | [`lockstep`] | all of them on a wire in memory |
//! | [`seen`] | what the frames tell whoever looks on: mode, motion, what was sent last |
//! | `injection` | MAV_CMD_INJECT_FAILURE as orders about faults |
//! | `statustext` | long texts in pieces |
//! | `wire` | the wire's units; messages of more than one sender |
//!
//! A session owns no socket and no clock: [`session`] has the contract. The sockets and the only clock are in
//! `shell`.

pub mod autopilot;
pub mod decoder;
pub mod encoder;
pub mod faults;
pub mod frame;
pub mod froude;
pub mod hil;
pub mod hub;
mod injection;
pub mod lockstep;
pub mod parachute;
pub mod peer;
pub mod px4_events;
pub mod replay;
pub mod seen;
pub mod session;
#[cfg(feature = "shell")]
pub mod shell;
pub mod signing;
pub mod stamps;
mod statustext;
pub mod streamer;
pub mod tlog;
mod wire;

#[cfg(test)]
mod codec_tests;
#[cfg(test)]
mod junk_tests;
#[cfg(test)]
mod parachute_tests;

pub use autopilot::{AutopilotSession, AutopilotSetup};
pub use decoder::Decoder;
pub use encoder::Encoder;
pub use faults::Faults;
pub use frame::{Command, CommandAck, Frame, Payload, SetMode};
pub use froude::Froude;
pub use hil::{HilConfig, HilEvent, HilSession, Pace};
pub use hub::{EndpointId, Hub, HubConfig, HubEvent};
pub use lockstep::{Lockstep, LockstepError, Party};
pub use parachute::ParachuteComponent;
pub use peer::{PeerId, Recipient};
pub use replay::{Difference, ReplayError, Replayed, replay};
pub use session::{Link, Session, Transmit};
pub use streamer::{StreamerConfig, StreamerEvent, StreamerSession};
pub use tlog::{Tlog, TlogError, TlogFault, TlogReader, TlogRecord};

pub use crate::autopilot::flight_log::{FlightLog, LogEntry};
pub use crate::time::{TimeUs, Timed, microseconds, seconds};
