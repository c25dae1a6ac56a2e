//! samara plans and flies the drop of a multirotor from a parachute: from the release, through free fall with
//! stopped rotors, to steady powered flight.
//!
//! It implements T. I. Opazo and J. W. Langelaan, "Longitudinal control of transition to powered flight for a
//! parachute-dropped multirotor" ("the paper"; its equations are cited as "(33)"). The modules stand on
//! floors: each imports only what is listed above it.
//!
//! | module | holds |
//! |---|---|
//! | [`math`] | elementary functions, the same on every machine |
//! | [`real`], [`simd`] | the scalar of the dynamics, wider registers |
//! | [`checksum`], [`random`], [`units`] | CRC-32, random numbers, conversion factors |
//! | [`printable`] | texts of others made fit to be printed |
//! | [`ulog`] | PX4's flight logs, read |
//! | [`identify`](mod@identify) | a vehicle out of flight logs, with standard errors |
//! | [`logged_flight`] | a flight as a log has it |
//! | [`frames`], [`time`] | rotations; simulated time |
//! | [`model`] | what flies: vehicle, air, parachute |
//! | [`trajectory`] | a planned trajectory |
//! | [`control`], [`plan`] | how it is flown; how it should fly (neither knows the other) |
//! | [`sim`] | the drop in simulated time |
//! | [`assess`] | how safe it was |
//! | [`replan`] | plans that are renewed during a drop |
//! | [`verify`] | whether all this is right: NASA's check cases, closed forms |
//! | [`tune`] | gains by search |
//! | [`design`] | plan and gains by one search |
//! | [`params`] | PX4 parameter files, and gains in PX4's terms |
#![cfg_attr(feature = "files", doc = "| [`config`] | files in: missions, vehicles, gains, trajectories |")]
#![cfg_attr(feature = "host", doc = "| [`host`] | studies on many threads, whose rows are kept |")]
#![cfg_attr(feature = "files", doc = "| [`report`] | results out: flight log, figures, tables, pages |")]
#![cfg_attr(
    feature = "view",
    doc = "| [`view`] | a mission in the browser, changed and flown anew at once |"
)]
//! | [`autopilot`] | modes, arming, OFFBOARD: PX4's manners around the control law |
#![cfg_attr(feature = "link", doc = "| [`link`] | MAVLink: the sessions on the wire |")]
//!
//! The command line (`src/cli`) is the program's, which the wheel for Python is too, and no part of what a
//! user of this library is promised.

#[cfg(feature = "cli")]
extern crate self as samara;

#[cfg(feature = "cli")]
#[doc(hidden)]
#[allow(rustdoc::invalid_html_tags, reason = "help as the program prints it")]
pub mod cli;
#[cfg(feature = "link")]
pub mod link;

pub use samara_core::{
    assess, checksum, control, design, frames, hints, identify, logged_flight, manoeuvre, math, model,
    params, plan, printable, random, real, replan, sim, simd, time, trajectory, tune, ulog, uncertain, units,
    vector, verify,
};
#[cfg(feature = "host")]
pub use samara_host as host;
pub use samara_link::autopilot;
#[cfg(feature = "files")]
pub use samara_mission as config;
#[cfg(feature = "files")]
pub use samara_report as report;
#[cfg(feature = "files")]
pub use samara_study as study;
#[cfg(feature = "view")]
pub use samara_view as view;
