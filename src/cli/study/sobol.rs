//! `samara study sobol`: what of all that is drawn decides J_TPF, the time to steady flight and the
//! altitude lost.

use std::sync::atomic::AtomicBool;

use anyhow::Context as _;

use clap::Args;

use super::args::StudyArgs;
use super::hosted::{self, Asked, Hosted};
use super::points::warn;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::whole;
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_to_fly;
use samara::assess::sobol::SobolStudy;
use samara::report::figure::sobol_figure;
use samara::report::sobol::{Replaced, SobolReport, outputs_of};
use samara::study::own::{fly_points, trial_space};

/// Name of the study.
const NAME: &str = "sobol";
/// Name of the study in its manifest.
const VERB: &str = "assess_sobol";

/// Points of each of the two samples, unless it is said otherwise.
pub const POINTS: usize = 2048;

/// `samara study sobol`.
#[derive(Args, Debug)]
pub struct SobolArgs {
    /// Trials of each of the two samples; as many more for each quantity.
    #[arg(long, value_name = "N", default_value_t = POINTS, value_parser = points)]
    pub points: usize,
    /// What every study has.
    #[command(flatten)]
    pub study: StudyArgs,
}

/// So many points.
pub fn points(text: &str) -> Result<usize, String> {
    whole::<usize>(64..=1_000_000)(text)
}

/// Flies, writes and reports.
pub fn run(args: &SobolArgs, stop: &AtomicBool) -> Result<Answer, Failure> {
    let (args, points) = (&args.study, args.points);
    let narrator = Narrator::alone(args.mission.json);
    let mission = args.mission_with_a_drop_from_t0("sobol", &narrator)?;
    let folder = hosted::folder(args, VERB, NAME, &mission)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let plan = &timed.plan.trajectory;
    let space = trial_space(&mission, plan, true).bad_input()?;
    let groups = space.groups();
    let study = SobolStudy { points, seed: mission.seed };
    let ranges: Vec<_> = groups.iter().map(|group| group.ranges.clone()).collect();
    let settings = [("sobol", points.to_string())];
    let whole = study.evaluations(groups.len()) as u64;
    let asked =
        Asked { name: NAME, verb: VERB, unit: "flights", whole, threads: args.threads, settings: &settings };
    let hosted = Hosted::new(args, (&mission, &folder), asked, stop)?;
    warn(&space, whole, &hosted);
    let end_s = space.duration_s();
    let mut replaced = Replaced::default();
    let found = hosted.run(|host| {
        study.run(space.dimensions(), &ranges, |points| {
            let flown = fly_points(host, &space, points)?;
            flown.iter().for_each(|outcome| replaced.push(outcome));
            Ok(flown.iter().map(|outcome| outputs_of(outcome, end_s)).collect())
        })
    })?;
    let Some(found) = found else { return hosted.stopped("outputs", &narrator) };
    let report = SobolReport { mission: &mission, study, groups, found, replaced, end_s };
    folder.write_text("sobol.txt", &report.document().text())?;
    folder.write_text("sobol.json", &report.json())?;
    folder.write_text("sobol.csv", &report.csv())?;
    folder.write_text("sobol.svg", &sobol_figure(&report).context("the figure of the indices")?)?;
    let place = folder.path().display();
    let text = || format!("\n{}\nresults in {place}\n", report.document().text());
    hosted.finish(|| report.json(), text)?;
    Ok(Answer::Yes)
}
