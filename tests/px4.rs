//! Real PX4 under the program: run where SAMARA_PX4 names a build folder of PX4's simulation, skipped (and that said) elsewhere.
//!
//! What is true here is what PX4 does. Flights are bounded in time only so that a hang fails instead of hanging.
#![cfg(all(target_os = "linux", feature = "cli"))]
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "tests that drive programs, wait for them and read their files"
)]

#[path = "px4/cycles.rs"]
mod cycles;
#[path = "px4/drops.rs"]
mod drops;
#[path = "px4/harness.rs"]
mod harness;
#[path = "px4/restarts.rs"]
mod restarts;
#[path = "px4/traces.rs"]
mod traces;
