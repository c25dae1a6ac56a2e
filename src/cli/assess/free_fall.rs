//! `samara assess --free-fall`: how well the release is found by the fall that the accelerometer shows.

use std::sync::atomic::AtomicBool;

use anyhow::Context as _;

use super::args::AssessArgs;
use super::rows::{fly_row, trials_of};
use crate::cli::answer::{Answer, Failure};
use crate::cli::mission::{chosen_mission, origin};
use crate::cli::narrator::Narrator;
use crate::cli::progress::ProgressLine;
use crate::cli::results::OutputFolder;
use crate::cli::system::thread_pool;
use crate::cli::terminal::print;
use samara::report::figure::free_fall_figure;
use samara::report::free_fall::FreeFallReport;
use samara::study::free_fall::free_fall_study;

/// Releases unless it is said otherwise.
const RELEASES: u64 = 10_000;
/// Releases between two looks at Ctrl-C, and hours of descent.
const BLOCKS: (u64, u64) = (256, 8);

/// Flies releases and descents, writes and reports them.
pub fn run(args: &AssessArgs, hours: u64, stop: &AtomicBool) -> Result<Answer, Failure> {
    let mission = chosen_mission(&args.mission.mission, &args.choice)?;
    let study = free_fall_study(&mission)
        .map_err(|e| Failure::input(format!("{}: --free-fall: {e}", mission.file.display())))?;
    let trials = trials_of(args.trials, RELEASES, "--free-fall")?;
    let narrator = Narrator::alone(args.mission.json);
    narrator.say(&origin(&args.mission.mission, &mission));
    let folder = OutputFolder::create("free_fall", args.mission.out.as_deref(), &mission.name)?;
    let pool = thread_pool(args.threads)?;
    let progress = ProgressLine::new("assess", "releases and hours", trials + hours);
    progress.set_message("releases");
    let releases = fly_row(&pool, &progress, (trials, BLOCKS.0), stop, |trial| study.release(trial));
    progress.set_message("descents");
    let descents = releases
        .as_ref()
        .and_then(|_| fly_row(&pool, &progress, (hours, BLOCKS.1), stop, |k| study.descend(k)));
    let (Some(releases), Some(descents)) = (releases, descents) else {
        narrator.say("stopped: nothing is kept of campaigns that are not complete\n");
        narrator.check()?;
        return Ok(Answer::No);
    };
    progress.finish();
    let report = FreeFallReport { mission: &mission, study, releases, descents };
    folder.write_text("free_fall.txt", &report.document().text())?;
    folder.write_text("free_fall.json", &report.json())?;
    folder.write_text("free_fall_releases.csv", &report.releases_csv())?;
    folder.write_text("free_fall_descents.csv", &report.descents_csv())?;
    folder.write_text("free_fall_rules.csv", &report.rules_csv())?;
    folder.write_text("free_fall.svg", &free_fall_figure(&report).context("the figure of the rules")?)?;
    let asked = [("trials", trials.to_string()), ("free_fall_hours", hours.to_string())];
    folder.write_manifest("free_fall", &mission, &asked)?;
    print(&if args.mission.json {
        report.json()
    } else {
        format!(
            "\n{}every release in {}\n",
            report.document().text(),
            folder.path().join("free_fall_releases.csv").display()
        )
    })?;
    Ok(Answer::from(report.holds()))
}
