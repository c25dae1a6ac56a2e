//! MAVLink software in the loop: the sessions on the wire (simulator, autopilot, streamer, parachute), and
//! the reference autopilot that one of them speaks for.
//!
//! | module | holds |
//! |---|---|
//! | [`autopilot`] | modes, arming, OFFBOARD: PX4's manners around the control law |
#![cfg_attr(feature = "wire", doc = "| [`link`] | MAVLink: the sessions on the wire |")]
//!
//! The autopilot names nothing of the wire. Neither reads missions: who builds them from one stands above.

pub mod autopilot;
#[cfg(feature = "wire")]
pub mod link;

// The core's modules by their own names.
#[allow(unused_imports, reason = "each is named by some feature")]
use samara_core::{
    checksum, control, frames, kalman, math, model, params, plan, printable, random, real, replan, sim, time,
    trajectory, units,
};

#[cfg(test)]
#[path = "../../core/src/sim/test_site.rs"]
#[allow(dead_code, reason = "what the core's tests use")]
mod test_site;
#[cfg(test)]
#[path = "../../core/src/control/test_vehicles.rs"]
#[allow(dead_code, reason = "what the core's tests use")]
mod test_vehicles;
