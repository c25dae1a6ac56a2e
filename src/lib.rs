//! samara plans, tunes, proves and flies the drop of a multirotor from a parachute.

pub mod autopilot;
pub mod frames;
pub mod model;
pub mod real;
pub mod trajectory;
pub mod units;
