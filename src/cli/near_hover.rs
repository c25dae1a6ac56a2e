//! `samara tune --method near-hover`: Ziegler and Nichols on the vehicle's own loops.

use std::io::Write as _;

use super::clock::Stopwatch;
use super::outcome::{Answer, BadInput, Failure};
use super::output::{OutputFolder, print};
use super::tune::{TuneArgs, bench, contenders, setting};
use crate::config::{Mission, gains_json};
use crate::control::Gains;
use crate::report::tune as report;
use crate::trajectory::Trajectory;
use crate::tune::near_hover::near_hover;

/// Tunes, tries, writes `gains.json`.
pub fn run(args: &TuneArgs, mission: &Mission, plan: &Trajectory) -> Result<Answer, Failure> {
    let watch = Stopwatch::start();
    let found = near_hover(&setting(args, mission, plan)).bad_input()?;
    let contenders = contenders(args, mission, plan, &bench(args, mission, plan)?, &found.adjusted)?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let yaw = &mission.gains;
    let gains = Gains { k_ppsi: yaw.k_ppsi, k_pr: yaw.k_pr, ..Gains::longitudinal(found.adjusted) };
    let text = gains_json(&args.name, &report::near_hover_about(mission), &gains);
    folder.write("gains.json", |out| out.write_all(text.as_bytes()))?;
    if args.mission.json {
        print(&report::near_hover_json(mission, &found, &contenders, 1e-3 * watch.ms()))?;
    } else {
        print(&report::near_hover_text(mission, &found, &contenders))?;
        print(&format!("results in {}\n", folder.path().display()))?;
    }
    Ok(Answer::Yes)
}
