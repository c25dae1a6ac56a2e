//! The wire: MAVLink frames, the sans-IO sessions that speak them (`samara_link::link`), and the parties of a
//! drop, built from a mission ([`parties`], feature `files`).
//!
//! A session owns no socket and no clock: [`session`] has the contract. This is a whole host, with an
//! autopilot that answers and leaves the motors at rest:
//!
//! ```
//! # #[cfg(feature = "files")]
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use mavlink::dialects::common::{HIL_ACTUATOR_CONTROLS_DATA, MavMessage};
//! use samara::link::{Decoder, Encoder, Frame, HilConfig, HilSession, Link, Session, TimeUs, Transmit};
//!
//! struct Idle {
//!     encoder: Encoder,
//!     answer: Option<Transmit>,
//! }
//!
//! impl Session for Idle {
//!     fn handle_input(&mut self, link: Link, frame: &Frame) {
//!         if let Some(MavMessage::HIL_SENSOR(m)) = frame.known() {
//!             let controls = HIL_ACTUATOR_CONTROLS_DATA { time_usec: m.time_usec, ..Default::default() };
//!             let bytes = self.encoder.encode(&MavMessage::HIL_ACTUATOR_CONTROLS(controls));
//!             self.answer = Some(Transmit::to_all(link, bytes));
//!         }
//!     }
//!     fn handle_time(&mut self, _now: TimeUs) {}
//!     fn next_wake(&self) -> Option<TimeUs> {
//!         None
//!     }
//!     fn poll_output(&mut self) -> Option<Transmit> {
//!         self.answer.take()
//!     }
//! }
//!
//! let mission = samara::config::load_mission("mission/titan_drop.json".as_ref())?;
//! let mut simulator = HilSession::new(mission.simulation(), HilConfig::default());
//! let mut autopilot = Idle { encoder: Encoder::new(1, 1), answer: None };
//! let mut wire = Decoder::new();
//! simulator.peer_connected();
//! while let Some(at) = simulator.next_wake().filter(|at| *at <= 1_000_000) {
//!     simulator.handle_time(at);
//!     autopilot.handle_time(at);
//!     while let Some(sent) = simulator.poll_output() {
//!         wire.datagram(&sent.bytes, |frame| autopilot.handle_input(sent.link, &frame));
//!     }
//!     while let Some(sent) = autopilot.poll_output() {
//!         wire.datagram(&sent.bytes, |frame| simulator.handle_input(sent.link, &frame));
//!     }
//!     while let Some(event) = simulator.poll_event() {
//!         println!("{event}");
//!     }
//! }
//! assert_eq!(simulator.run().log().len(), 250);
//! # Ok(())
//! # }
//! # #[cfg(not(feature = "files"))]
//! # fn main() {}
//! ```

#[cfg(feature = "files")]
pub mod parties;

pub use samara_link::link::*;
