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

use super::asked::CampaignOf;
use crate::cli::answer::{Answer, Failure};
use crate::cli::mission::mission_from_t0;
use crate::cli::narrator::Narrator;
use crate::cli::pilot::pilot_and_mission;
use samara::study::cut::Cut;

/// Flies a part of the campaign, unless it is there, or reports which campaign it would be of.
pub fn run(of: &CampaignOf, stop: &AtomicBool) -> Result<Answer, Failure> {
    match (&of.wire.autopilot, of.args.part.shard) {
        (Some(autopilot), Some(shard)) => drops::run(of, autopilot, shard, stop),
        (None, Some(shard)) => study::run(of, shard, stop),
        (Some(autopilot), None) => {
            let (pilot, mission) = pilot_and_mission(&of.pilot(autopilot))?;
            part::describe(of, &part::head_of(of, &mission, Some(pilot.name()), Cut::WHOLE)?)
        }
        (None, None) => {
            let (mission, choice) = (&of.args.mission, &of.args.choice);
            let mission = mission_from_t0(mission, choice, &Narrator::alone(true))?;
            part::describe(of, &part::head_of(of, &mission, None, Cut::WHOLE)?)
        }
    }
}
