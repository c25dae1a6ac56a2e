//! `samara tune --method near-hover`: Ziegler and Nichols on the vehicle's own loops.

use std::io::Write as _;

use super::args::TuneArgs;
use super::contest::contest;
use super::files::{write_gains, write_tune_manifest};
use super::{bench, nothing, setting};
use crate::cli::clock::Stopwatch;
use crate::cli::interrupt;
use crate::cli::outcome::{Answer, BadInput, Failure};
use crate::cli::output::{OutputFolder, print};
use samara::config::Mission;
use samara::report::tune::near_hover as report;
use samara::trajectory::Trajectory;
use samara::tune::near_hover::near_hover;

/// Tunes, tries, writes `gains.json`, `gains.params` and `near_hover.txt`.
pub fn run(args: &TuneArgs, mission: &Mission, plan: &Trajectory) -> Result<Answer, Failure> {
    let watch = Stopwatch::start();
    let found = near_hover(&setting(args, mission, plan)).bad_input()?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    folder.remove(&["convergence.csv", "convergence.svg", "front.csv", "checkpoint.json"])?;
    write_gains(args, &folder, mission, &found.adjusted, &report::about(mission))?;
    let tuning = bench(args, mission, plan)?;
    let stop = interrupt::flag()?;
    let Some(contest) = contest(args, mission, plan, &tuning, &found.adjusted, &stop)? else {
        return nothing(args, &mission.name, "stopped; the gains are written, but were not tried");
    };
    let text = report::text(mission, &found, &contest);
    folder.write("near_hover.txt", |out| out.write_all(text.as_bytes()))?;
    write_tune_manifest(args, &folder, mission)?;
    if args.mission.json {
        print(&report::json(mission, &found, &contest, 1e-3 * watch.ms()))?;
    } else {
        print(&text)?;
        print(&format!("results in {}\n", folder.path().display()))?;
    }
    Ok(Answer::Yes)
}
