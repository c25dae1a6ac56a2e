//! The integration tests: one program, so that it is linked once. A file's tests are chosen by its name:
//! `cargo test --test integration swap::`.
#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "tests fail by panicking; they drive the program, wait for it and read its files"
)]

// What a test takes of the core's tests names its modules so.
use samara::{control, logged_flight, manoeuvre, model, sim};

mod architecture;
mod assess;
mod card;
mod cli;
#[cfg(all(feature = "files", feature = "link"))]
mod command_long;
mod design;
mod drop_campaigns;
mod examples;
mod features;
mod fidelity;
mod free_fall;
mod fuzz;
mod identify;
mod kept_files;
#[cfg(feature = "files")]
mod lanes;
mod lockstep;
mod log;
mod own_study;
mod own_vehicle;
mod params;
mod plan_grid;
mod planner;
mod px4;
mod px4_model;
mod px4_stand_in;
mod rare;
mod reference_autopilot;
mod reference_flight;
mod replan;
mod replay;
mod report_drop;
mod results;
mod rotors;
mod shards;
mod snapshots;
mod studies;
mod swap;
mod toolchain;
mod tune;
mod verify;
