//! samara against an independent implementation of the same model, on the Titan vehicle.
//!
//! `tests/data/reference_flights.json` holds that implementation's numbers: a planar program, so what is
//! compared here is samara's quaternion code, in the vertical plane, with formulas written for that plane
//! alone.
#![cfg(feature = "files")]

mod data;
mod dynamics;
mod flights;
mod monte_carlo;
mod motors;
mod planar;
mod tracking;
mod tuning;
mod variations;
