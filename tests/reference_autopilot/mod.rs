//! The reference autopilot behind its wire: frames in, frames out, no sockets. Source of truth: PX4's and the
//! MAVLink services' behaviour (`regress_*`), the same flight without frames (`closed_form_*`), random frames
//! (`prop_*`).
#![cfg(all(feature = "files", feature = "link"))]

mod bench;
mod closed_loop;
mod commands;
mod estimator;
mod junk;
mod missions;
mod parameters;
mod peers;
mod qgroundcontrol;
mod services;
mod setpoints;
mod telemetry;
