//! Real PX4 under the program: run where SAMARA_PX4 names a build folder of PX4's simulation, skipped (and
//! that said) elsewhere.
//!
//! What is true here is what PX4 does. Flights are bounded in time only so that a hang fails instead of
//! hanging.
#![cfg(all(target_os = "linux", feature = "cli"))]

mod cycles;
mod drops;
mod harness;
mod restarts;
mod traces;
