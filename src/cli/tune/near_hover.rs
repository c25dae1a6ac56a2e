//! `samara tune --method near-hover`: Ziegler and Nichols on the vehicle's own loops.

use super::args::TuneArgs;
use super::contest::contest;
use super::results::{report_nothing, write_gains, write_tune_manifest};
use super::settings::tuning;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::results::OutputFolder;
use crate::cli::system::{Stopwatch, interrupt_flag};
use crate::cli::terminal::print;
use samara::config::Mission;
use samara::host::Threads;
use samara::study::tuning::report::{Standing, near_hover as report};
use samara::trajectory::Trajectory;
use samara::tune::RangeEnds;
use samara::tune::near_hover::near_hover;

/// Tunes, tries, writes `gains.json`, `gains.params` and `near_hover.txt`.
pub fn run(
    args: &TuneArgs,
    mission: &Mission,
    plan: &Trajectory,
    threads: &Threads,
) -> Result<Answer, Failure> {
    let watch = Stopwatch::start();
    let found = near_hover(&tuning(args).setting(mission, plan)).bad_input()?;
    let folder = OutputFolder::create("tune", args.mission.out.as_deref(), &mission.name)?;
    folder.remove_leftovers(&["convergence.csv", "convergence.svg", "front.csv", "checkpoint.json"])?;
    write_gains(args, &folder, mission, &found.adjusted, &report::about(mission))?;
    let judge = tuning(args).judge(mission, plan).bad_input()?;
    let stop = interrupt_flag()?;
    let Some(contest) = contest(args, (mission, plan), &judge, &found.adjusted, (threads, &stop))? else {
        return report_nothing(args, &mission.name, "stopped; the gains are written, but were not tried");
    };
    let text = report::document(mission, &found, &contest).text();
    let verdict = contest.verdict() + "\n";
    folder.write_text("near_hover.txt", &format!("{text}{verdict}"))?;
    write_tune_manifest(args, &folder, mission, &RangeEnds::default())?;
    let object = || report::json(mission, &found, &contest, 1e-3 * watch.ms());
    folder.print_result(args.mission.json, object, || text)?;
    if !args.mission.json {
        print(&verdict)?;
    }
    Ok(Answer::from(contest.standing() != Standing::NotBetter))
}
