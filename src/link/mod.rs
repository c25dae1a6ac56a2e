//! The wire: MAVLink frames, and the sans-IO sessions that speak them.
//!
//! | file | holds |
//! |---|---|
//! | [`frame`] | a frame as received; what a strict message enum refuses stays readable |
//! | [`decoder`] | bytes to frames: stream and datagram, MAVLink 1 and 2 |
//! | [`encoder`] | messages to bytes |
//! | [`faults`] | what came and was not as it should be, by kind |
//! | [`signing`] | MAVLink 2 signatures |
//! | [`hub`] | many peers: who gets what, numbering, signing, forwarding, counts |
//! | [`peer`] | who is at the other end of a link |
//! | [`froude`] | PX4 under another gravity: the wire's scale |
//! | [`tlog`] | the record of what went over the wire |
//! | [`flight_log`] | what the autopilot knew and commanded, as ULog |
//! | [`parachute`] | the parachute component: release by command |
//! | [`simulator`] | the simulator: lockstep, release triggers, sensors, flight log |
//! | [`streamer`] | the offboard streamer: arms, releases, streams the plan |
//! | [`autopilot`] | the reference autopilot: HIL client, vehicle for ground stations and companions |
//! | [`lockstep`] | all of them on a wire in memory |
//! | `time`, `statustext` | seconds and microseconds; long texts in pieces |
//!
//! A session owns no socket and no clock. Simulated time comes as an argument, frames go in by `handle_input`, time
//! alone by `handle_time`, and what it wants sent is fetched by `poll_output` until that returns `None`. The sockets
//! and the only clock are in `shell`.

pub mod autopilot;
pub mod decoder;
pub mod encoder;
pub mod faults;
pub mod flight_log;
pub mod frame;
pub mod froude;
pub mod hub;
pub mod lockstep;
pub mod parachute;
pub mod peer;
#[cfg(feature = "cli")]
pub mod shell;
pub mod signing;
pub mod simulator;
mod statustext;
pub mod streamer;
mod time;
pub mod tlog;

#[cfg(test)]
mod codec_tests;
#[cfg(test)]
mod junk_tests;
#[cfg(test)]
mod parachute_tests;
#[cfg(test)]
mod test_site;

pub use autopilot::{AutopilotSession, AutopilotSetup};
pub use decoder::Decoder;
pub use encoder::{CommandAck, Encoder};
pub use faults::Faults;
pub use flight_log::{FlightLog, LogEntry};
pub use frame::{Command, Frame, Message, Payload, SetMode};
pub use froude::Froude;
pub use hub::{EndpointId, Hub, HubConfig, HubEvent};
pub use lockstep::{Lockstep, LockstepError, Party};
pub use parachute::ParachuteComponent;
pub use peer::{PeerId, Recipient};
pub use simulator::{
    FlightEvent, FlightRecord, Pace, Silence, SimulatorConfig, SimulatorEvent, SimulatorSession,
};
pub use streamer::{StreamerConfig, StreamerEvent, StreamerSession};
pub use time::{TimeUs, microseconds, seconds};
pub use tlog::Tlog;

/// Which of a session's connections a frame came by or goes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Link {
    /// Simulator and autopilot: HIL messages, TCP 4560 + instance.
    Simulator,
    /// Ground stations: UDP, the autopilot's 18570 + instance to 14550.
    GroundStation,
    /// Companions and scripts: UDP, the autopilot's 14580 + instance to 14540 + instance.
    Api,
    /// The parachute's own socket: UDP 14600 + instance to 14550 and 14540 + instance.
    Parachute,
}

/// An encoded frame that a session wants sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Transmit {
    /// By which connection.
    pub link: Link,
    /// To which of its peers.
    pub to: Recipient,
    /// The frame.
    pub bytes: Vec<u8>,
}

impl Transmit {
    /// To every peer of a link.
    pub fn to_all(link: Link, bytes: Vec<u8>) -> Self {
        Self { link, to: Recipient::All, bytes }
    }

    /// To one peer of a link.
    pub fn to_peer(link: Link, peer: PeerId, bytes: Vec<u8>) -> Self {
        Self { link, to: Recipient::Peer(peer), bytes }
    }
}

/// A party on the wire, without socket and clock.
pub trait Session {
    /// Takes a frame that came by `link` at simulated time `now`.
    fn handle_input(&mut self, now: TimeUs, link: Link, frame: &Frame);

    /// Does what falls due by `now` without a frame.
    fn handle_time(&mut self, now: TimeUs);

    /// The next frame to send; call until `None` after each of the two above.
    fn poll_output(&mut self) -> Option<Transmit>;
}
