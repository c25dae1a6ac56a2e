//! samara plans, tunes, proves and flies the drop of a multirotor from a parachute.

pub mod assess;
pub mod autopilot;
#[cfg(feature = "files")]
pub mod config;
pub mod control;
pub mod frames;
#[cfg(feature = "link")]
pub mod link;
pub mod model;
pub mod real;
pub mod sim;
pub mod trajectory;
pub mod tune;
pub mod units;
