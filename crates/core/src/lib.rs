//! Flight dynamics of a multirotor that is dropped from a parachute: what flies, how it is planned and flown,
//! and how safe a flight was.
//!
//! It implements T. I. Opazo and J. W. Langelaan, "Longitudinal control of transition to powered flight for a
//! parachute-dropped multirotor" ("the paper"; its equations are cited as "(33)"). Nothing here reads a
//! file, a clock or a socket, or starts a thread. The modules stand on floors: each imports only what is
//! listed above it.
//!
//! | module | holds |
//! |---|---|
//! | [`math`], [`real`] | elementary functions, the same on every machine; the number of the dynamics |
//! | [`simd`], [`vector`] | wider registers; vectors of any number |
//! | [`checksum`], [`random`], [`units`] | CRC-32, random numbers, conversion factors |
//! | [`hints`] | what mostly causes a no, and the command for it |
//! | [`kalman`] | the covariance of a filter's errors |
//! | [`printable`] | texts of others made fit to be printed |
//! | [`ulog`] | PX4's flight logs, read |
//! | [`frames`], [`time`] | rotations; simulated time |
//! | [`logged_flight`] | a flight as a log has it |
//! | [`model`] | what flies: vehicle, air, parachute |
//! | [`identify`] | a vehicle out of flight logs, with standard errors |
//! | [`trajectory`] | a planned trajectory |
//! | [`control`], [`plan`] | how it is flown; how it should fly (neither knows the other) |
//! | [`sim`] | the drop in simulated time |
//! | [`manoeuvre`] | what to fly so that a log tells what a vehicle is |
//! | [`uncertain`] | what is not known exactly of it |
//! | [`assess`] | how safe it was |
//! | [`replan`] | plans that are renewed during a drop |
//! | [`verify`] | whether all this is right: NASA's check cases, closed forms |
//! | [`tune`] | gains by search |
//! | [`design`] | plan and gains by one search |
//! | [`params`] | PX4 parameter files, and gains in PX4's terms |
#![cfg_attr(
    not(target_arch = "x86_64"),
    allow(dead_code, reason = "what flies side by side is used where there are registers for it")
)]

pub mod assess;
pub mod checksum;
pub mod control;
pub mod design;
pub mod frames;
pub mod hints;
pub mod identify;
pub mod kalman;
pub mod logged_flight;
pub mod manoeuvre;
pub mod math;
pub mod model;
pub mod params;
pub mod plan;
pub mod printable;
pub mod random;
pub mod real;
pub mod replan;
pub mod sim;
pub mod simd;
pub mod time;
pub mod trajectory;
pub mod tune;
pub mod ulog;
pub mod uncertain;
pub mod units;
pub mod vector;
pub mod verify;
