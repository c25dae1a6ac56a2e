//! Sockets around the sessions: the only place of the wire with a clock, a socket and `async`.
//!
//! | file | holds |
//! |---|---|
//! | [`ports`] | which ports an instance has |
//! | [`clock`] | the wall clock: pacing by a speed factor |
//! | [`serial`] | a serial line to a board, and what it carries |
//! | [`url`] | endpoints as they are typed |
//! | `endpoint` | sockets for ground stations and companions, by kind |
//! | `connection` | the simulator's link: one TCP connection as frames |
//! | `links` | a party's endpoints and the hub between them and its session |
//! | [`stamp_store`] | where the time stamps of signed frames are kept between two starts |
//! | [`notice`] | notices to the caller; errors |
//! | [`simulator`] | [`run_simulator`]: TCP for the autopilot, UDP for the parachute; [`run_board`] |
//! | `busy_wait` | waiting for an answer without giving the processor up, while that pays |
//! | `companion` | a streamer beside the simulator, and the fence that holds simulated time back |
//! | [`autopilot`] | [`run_autopilot`]: TCP client of the simulator, UDP for ground stations and companions |
//! | [`streamer`] | [`run_streamer`]: UDP |
//! | `solver` | a thread that renews the streamer's plans |
//! | [`watched`] | [`run_watched_drop`]: the drop in memory at a speed to watch, ground stations on UDP |
//! | `event_texts` | the texts of PX4's events, from its metadata |
//! | `viewer` | the flight to be watched: HIL_STATE_QUATERNION on UDP |
//!
//! Loopback only, unless an endpoint is asked for by its URL; only a key keeps strangers out. Each `run_*`
//! returns when its session is over or `stop` completes, and gives its session back, so that what has been
//! flown can be written. A single-threaded runtime is enough.

pub mod autopilot;
mod busy_wait;
pub mod clock;
mod companion;
mod connection;
mod endpoint;
mod event_texts;
mod links;
pub mod notice;
pub mod ports;
pub mod serial;
pub mod simulator;
mod solver;
pub mod stamp_store;
pub mod streamer;
pub mod url;
mod viewer;
pub mod watched;

#[cfg(test)]
mod end_tests;
#[cfg(test)]
mod link_tests;
#[cfg(test)]
mod stall_tests;
#[cfg(test)]
mod tests;

pub use autopilot::{AfterSimulator, run_autopilot};
pub use clock::Speed;
pub use event_texts::event_texts;
pub use links::Wiring;
pub use notice::{LineNotice, Notice, Observer, ShellError};
pub use ports::{Ports, system_of_instance};
pub use serial::{SerialError, SerialUrl};
pub use simulator::{Attendance, Guest, HostedDrop, run_board, run_hosted_drop, run_simulator};
pub use stamp_store::{SignWith, StampStore};
pub use streamer::run_streamer;
pub use url::LinkUrl;
pub use watched::run_watched_drop;
