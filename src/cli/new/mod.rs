//! `samara new`: first drafts of a vehicle and of a mission for it.
//!
//! | file | holds |
//! |---|---|
//! | `files` | where drafts are written, and the paths between them |
//! | `ask` | what is not typed, asked for on a terminal |
//! | `vehicle` | `samara new vehicle` |
//! | `mission` | `samara new mission`: the file, and gains that fly it |

mod ask;
mod files;
mod mission;
mod vehicle;

use clap::{Args, Subcommand};

use super::answer::{Answer, Failure};

/// `samara new`.
#[derive(Args, Debug)]
pub struct NewArgs {
    /// What to draft.
    #[command(subcommand)]
    verb: NewVerb,
}

#[derive(Debug, Subcommand)]
enum NewVerb {
    /// Write a vehicle file from what a data sheet, an airframe or a Gazebo model says.
    #[command(after_long_help = include_str!("../help/new_vehicle.txt"))]
    Vehicle(vehicle::VehicleArgs),
    /// Write a mission for a vehicle, with gains that fly it.
    #[command(after_long_help = include_str!("../help/new_mission.txt"))]
    Mission(mission::MissionArgs),
}

/// Drafts a vehicle or a mission.
pub fn run(args: &NewArgs) -> Result<Answer, Failure> {
    match &args.verb {
        NewVerb::Vehicle(args) => vehicle::run(args),
        NewVerb::Mission(args) => mission::run(args),
    }
}
