//! `samara study free-fall`: how well the release is found by the fall that the accelerometer shows.

use std::sync::atomic::AtomicBool;

use anyhow::Context as _;

use clap::Args;

use super::args::{StudyArgs, trials_of};
use super::hosted::{self, Asked, Hosted};
use crate::cli::answer::{Answer, Failure};
use crate::cli::args::whole;
use crate::cli::mission::{chosen_mission, origin};
use crate::cli::narrator::Narrator;
use samara::report::figure::free_fall_figure;
use samara::report::free_fall::FreeFallReport;
use samara::study::free_fall::free_fall_study;
use samara::study::jobs::{Jobs as _, Round};

/// Releases unless it is said otherwise.
const RELEASES: u64 = 10_000;

/// Name of the study.
const NAME: &str = "free_fall";
/// Name of the study in its manifest.
const VERB: &str = "free_fall";

/// Hours of descent unless it is said otherwise.
pub const HOURS: u64 = 20;

/// `samara study free-fall`.
#[derive(Args, Debug)]
pub struct FreeFallArgs {
    /// Releases that must be found [default: 10000].
    #[arg(long, value_name = "N", value_parser = whole::<u64>(2..=1_000_000_000))]
    pub trials: Option<u64>,
    /// Hours of descent in turbulence in which nothing may be found.
    #[arg(long, value_name = "HOURS", default_value_t = HOURS, value_parser = hours)]
    pub hours: u64,
    /// What every study has.
    #[command(flatten)]
    pub study: StudyArgs,
}

/// Hours of descent.
pub fn hours(text: &str) -> Result<u64, String> {
    whole::<u64>(1..=100_000)(text)
}

/// Flies releases and descents, writes and reports them.
pub fn run(args: &FreeFallArgs, stop: &AtomicBool) -> Result<Answer, Failure> {
    let (args, trials, hours) = (&args.study, args.trials, args.hours);
    let mission = chosen_mission(&args.mission.mission, &args.choice)?;
    let study = free_fall_study(&mission)
        .map_err(|e| Failure::input(format!("{}: free-fall: {e}", mission.file.display())))?;
    let trials = trials_of(trials, RELEASES, "free-fall")?;
    let narrator = Narrator::alone(args.mission.json);
    narrator.say(&origin(&args.mission.mission, &mission));
    let folder = hosted::folder(args, VERB, NAME, &mission)?;
    let settings = [("trials", trials.to_string()), ("free_fall_hours", hours.to_string())];
    let (unit, whole) = ("releases and hours", trials + hours);
    let asked = Asked { name: NAME, verb: VERB, unit, whole, threads: args.threads, settings: &settings };
    let hosted = Hosted::new(args, (&mission, &folder), asked, stop)?;
    let flown = hosted.run(|host| {
        let releases = host.fly("releases", Round::of(trials, 8), &|some, stop| {
            (!stop()).then(|| some.map(|trial| study.release(trial)).collect())
        })?;
        let descents = host.fly("descents", Round::of(hours, 1), &|some, stop| {
            (!stop()).then(|| some.map(|hour| study.descend(hour)).collect())
        })?;
        Ok((releases, descents))
    })?;
    let Some((releases, descents)) = flown else { return hosted.stopped("releases", &narrator) };
    let report = FreeFallReport { mission: &mission, study, releases, descents };
    folder.write_text("free_fall.txt", &report.document().text())?;
    folder.write_text("free_fall.json", &report.json())?;
    folder.write_text("free_fall_releases.csv", &report.releases_csv())?;
    folder.write_text("free_fall_descents.csv", &report.descents_csv())?;
    folder.write_text("free_fall_rules.csv", &report.rules_csv())?;
    folder.write_text("free_fall.svg", &free_fall_figure(&report).context("the figure of the rules")?)?;
    let every = folder.path().join("free_fall_releases.csv");
    let text = || format!("\n{}every release in {}\n", report.document().text(), every.display());
    hosted.finish(|| report.json(), text)?;
    Ok(Answer::from(report.holds()))
}
