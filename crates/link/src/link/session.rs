//! The contract between a party on the wire and its host.
//!
//! A [`Session`] owns no socket and no clock. Its host brings it frames and simulated time, and sends what it
//! wants sent. **Time** is simulated time in microseconds, and it passes only by [`Session::handle_time`] and
//! by the time stamps of frames; the host's `now` never runs backwards while the session's peer stays the
//! same.
//!
//! One of the parties makes the time of the others: [`HilSession`](super::hil::HilSession), whose `next_wake`
//! is its next step as soon as that may be made, and `None` as long as it waits for its autopilot. A host in
//! simulated time calls `handle_time` at once; one in wall time waits until that time has come. (The head of
//! `samara::link` is a whole host.)
//!
//! [`Lockstep`](super::lockstep::Lockstep) is a host in simulated time for simulator, autopilot and streamer;
//! `shell` has those with sockets.
//!
//! **Wall time** reaches a session as a length only: a session whose peer may fall silent while simulated
//! time stands still has a `handle_silence(waited)`, which its host calls every now and then with the time
//! since the last frame or step. What begins and ends outside the wire has methods of its own:
//! `peer_connected`, `peer_left`, `stop`.

use super::frame::Frame;
use super::peer::Recipient;
use crate::time::TimeUs;

/// A party on the wire, without socket and clock; the head of this module has the whole contract.
pub trait Session {
    /// Takes a frame that came by `link`.
    fn handle_input(&mut self, link: Link, frame: &Frame);

    /// Takes the time and does all that falls due by `now`. To be called at [`Self::next_wake`]; earlier and
    /// more often is allowed.
    fn handle_time(&mut self, now: TimeUs);

    /// The next frame to send; to be called until `None` after each of the two above.
    fn poll_output(&mut self) -> Option<Transmit>;

    /// The simulated time at which [`Self::handle_time`] has something to do next, which may have passed;
    /// `None`: not before a frame has come.
    fn next_wake(&self) -> Option<TimeUs>;
}

/// One of the connections of a session, by which frames come and go.
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
    /// Connection to send it by.
    pub link: Link,
    /// Peers of that connection that it is for.
    pub to: Recipient,
    /// The frame.
    pub bytes: Vec<u8>,
}

impl Transmit {
    /// To every peer of a link.
    pub fn to_all(link: Link, bytes: Vec<u8>) -> Self {
        Self { link, to: Recipient::All, bytes }
    }
}
