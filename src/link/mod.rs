//! The wire: MAVLink frames, and the sans-IO sessions that speak them.
//!
//! | file | holds |
//! |---|---|
//! | [`frame`] | a frame as received; what a strict message enum refuses stays readable |
//! | [`codec`] | bytes to frames (stream and datagram, MAVLink 1 and 2) and messages to bytes |
//! | [`autopilot`] | the reference autopilot: HIL client, vehicle for ground stations and companions |
//!
//! A session owns no socket and no clock. Simulated time comes as an argument, frames go in by `handle_input`, time
//! alone by `handle_time`, and what it wants sent is fetched by `poll_output` until that returns `None`. The sockets
//! and the only clock are in `shell`.

pub mod autopilot;
pub mod codec;
pub mod frame;

pub use codec::{CommandAck, Decoder, Encoder, Faults};
pub use frame::{Command, Frame, Message, Payload, SetMode};

/// Simulated time since the simulation began [us].
pub type TimeUs = u64;

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
    /// The frame.
    pub bytes: Vec<u8>,
}
