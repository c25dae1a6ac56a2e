//! `samara assess --sobol`: what of all that is drawn decides J_TPF, the time to steady flight and the
//! altitude lost.

use std::sync::atomic::AtomicBool;

use anyhow::Context as _;

use super::args::AssessArgs;
use super::points::{Flights, Stopped, mission, stopped};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_to_fly;
use crate::cli::results::OutputFolder;
use samara::assess::sobol::SobolStudy;
use samara::report::figure::sobol_figure;
use samara::report::sobol::{Replaced, SobolReport, outputs_of};
use samara::study::own::trial_space;

/// Flies, writes and reports.
pub fn run(args: &AssessArgs, points: usize, stop: &AtomicBool) -> Result<Answer, Failure> {
    let narrator = Narrator::alone(args.mission.json);
    let mission = mission(args, "--sobol", &narrator)?;
    let folder = OutputFolder::create("assess_sobol", args.mission.out.as_deref(), &mission.name)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let plan = &timed.plan.trajectory;
    let space = trial_space(&mission, plan, true).bad_input()?;
    let groups = space.groups();
    let study = SobolStudy { points, seed: mission.seed };
    let ranges: Vec<_> = groups.iter().map(|group| group.ranges.clone()).collect();
    let flights = Flights::new(&space, args.threads, study.evaluations(groups.len()) as u64, stop)?;
    let end_s = space.duration_s();
    let mut replaced = Replaced::default();
    let found = study.run(space.dimensions(), &ranges, |points| {
        let flown = flights.fly(points)?;
        flown.iter().for_each(|outcome| replaced.push(outcome));
        Ok::<_, Stopped>(flown.iter().map(|outcome| outputs_of(outcome, end_s)).collect())
    });
    flights.finish();
    let Ok(found) = found else { return stopped(args, &mission, "outputs", &narrator) };
    let report = SobolReport { mission: &mission, study, groups, found, replaced, end_s };
    folder.write_text("sobol.txt", &report.document().text())?;
    folder.write_text("sobol.json", &report.json())?;
    folder.write_text("sobol.csv", &report.csv())?;
    folder.write_text("sobol.svg", &sobol_figure(&report).context("the figure of the indices")?)?;
    folder.write_manifest("assess_sobol", &mission, &[("sobol", points.to_string())])?;
    folder.print_result(
        args.mission.json,
        || report.json(),
        || format!("\n{}\n", report.document().text()),
    )?;
    Ok(Answer::Yes)
}
