//! `samara assess --sobol`: what of all that is drawn decides J_TPF, the time to steady flight and the
//! altitude lost.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context as _;
use rayon::prelude::*;

use super::args::AssessArgs;
use super::rare::{Stopped, mission};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::estimate::warn_one_at_a_time;
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_to_fly;
use crate::cli::progress::Progress;
use crate::cli::results::OutputFolder;
use crate::cli::system::thread_pool;
use crate::cli::terminal::print;
use samara::assess::sobol::SobolStudy;
use samara::report::campaign::own::trial_space;
use samara::report::figure::sobol_figure;
use samara::report::sobol::{SobolReport, outputs_of};
use samara::sim::planar::LANES;

/// Flies, writes and reports.
pub fn run(args: &AssessArgs, points: usize, stop: &AtomicBool) -> Result<Answer, Failure> {
    let narrator = Narrator::alone(args.mission.json);
    let mission = mission(args, "--sobol", &narrator)?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let plan = &timed.plan.trajectory;
    let space = trial_space(&mission, plan, true).bad_input()?;
    let groups = space.groups();
    let study = SobolStudy { points, seed: mission.seed };
    let flights = study.evaluations(groups.len()) as u64;
    let pool = thread_pool(args.threads)?;
    if let Some(reason) = space.one_at_a_time() {
        let nominal = [vec![0.0; space.dimensions()]];
        warn_one_at_a_time(reason, flights, pool.current_num_threads(), || space.fly(&nominal));
    }
    let progress = Progress::new("assess", "flights", flights);
    let ranges: Vec<_> = groups.iter().map(|group| group.ranges.clone()).collect();
    let end_s = space.duration_s();
    let found = study.run(space.dimensions(), &ranges, |points| {
        if stop.load(Ordering::Relaxed) {
            return Err(Stopped);
        }
        let flown = pool.install(|| points.par_chunks(LANES).map(|some| space.fly(some)).collect::<Vec<_>>());
        progress.inc(points.len() as u64);
        Ok(flown.iter().flatten().map(|outcome| outputs_of(outcome, end_s)).collect())
    });
    progress.finish();
    let Ok(found) = found else {
        narrator.say("stopped: nothing is kept of a study that is not complete\n");
        narrator.check()?;
        if args.mission.json {
            let object = serde_json::json!({ "mission": mission.name, "outputs": null, "reason": "stopped" });
            print(&format!("{object:#}\n"))?;
        }
        return Ok(Answer::No);
    };
    let report = SobolReport { mission: &mission, study, groups, found };
    folder.write_text("sobol.txt", &report.text())?;
    folder.write_text("sobol.json", &report.json())?;
    folder.write_text("sobol.csv", &report.csv())?;
    folder.write_text("sobol.svg", &sobol_figure(&report).context("the figure of the indices")?)?;
    folder.write_manifest("assess_sobol", &mission, &[("sobol", points.to_string())])?;
    folder.print_result(args.mission.json, || report.json(), || format!("\n{}\n", report.text()))?;
    Ok(Answer::Yes)
}
