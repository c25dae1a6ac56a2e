//! samara plans, tunes, proves and flies the drop of a multirotor from a parachute.

#[cfg(feature = "files")]
pub mod config;
pub mod frames;
pub mod model;
pub mod plan;
pub mod real;
pub mod trajectory;
pub mod units;
