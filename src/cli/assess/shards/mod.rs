//! `samara assess --shard`: a part of a campaign in a file of its own, flown anywhere, any number of times;
//! and `samara merge`, which makes of the parts what the campaign in one go makes.
//!
//! | file | holds |
//! |---|---|
//! | `part` | what a part belongs to, and how it is reported |
//! | `place` | where a part's file is: there and whole, or written aside and renamed |
//! | `study` | parts of flights from t = 0 |
//! | `drops` | parts of whole drops |
//! | `parts` | the parts that are there, each trial in one of them |
//! | `merge` | the parts put together |
//! | `merge_study`, `merge_drops` | flights from t = 0, whole drops |

mod drops;
pub mod merge;
mod merge_drops;
mod merge_study;
mod part;
mod parts;
mod place;
mod study;

use std::sync::atomic::AtomicBool;

use super::args::AssessArgs;
use crate::cli::answer::{Answer, Failure};
use crate::cli::mission::mission_from_t0;
use crate::cli::narrator::Narrator;
use crate::cli::pilot::pilot_and_mission;
use samara::study::cut::Cut;

/// Reports which campaign the arguments make, and flies nothing.
pub fn describe(args: &AssessArgs) -> Result<Answer, Failure> {
    let whole = Cut::WHOLE;
    let head = match &args.autopilot {
        Some(autopilot) => {
            let (pilot, mission) = pilot_and_mission(&args.pilot(autopilot))?;
            part::head_of(args, &mission, Some(pilot.name()), whole)
        }
        None => part::head_of(
            args,
            &mission_from_t0(&args.mission, &args.choice, &Narrator::alone(true))?,
            None,
            whole,
        ),
    };
    part::describe(&head)
}

/// Flies a part of the campaign, unless it is there.
pub fn run(args: &AssessArgs, shard: Cut, stop: &AtomicBool) -> Result<Answer, Failure> {
    match &args.autopilot {
        Some(autopilot) => drops::run(args, autopilot, shard, stop),
        None => study::run(args, shard, stop),
    }
}
