//! The files of a design: mission, gains, plan, the search step by step, the manifest.

use anyhow::Context as _;

use super::args::DesignArgs;
use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::new::relative;
use crate::cli::planning::write_plan;
use crate::cli::results::OutputFolder;
use samara::config::{Mission, designed_mission_json, gains_json, load_mission};
use samara::design::{DesignJudge, DesignSearch};
use samara::report::bode_figure;
use samara::study::designing::report::{self as design, DesignRun};

const MISSION: &str = "design_mission.json";
const GAINS: &str = "design_gains.json";

/// Writes the chosen design: `design_mission.json`, `design_gains.json`, its plan, `design.csv` and
/// `design_front.csv`.
pub fn write_design(
    folder: &OutputFolder,
    mission: &Mission,
    judge: &DesignJudge<'_>,
    search: &DesignSearch,
    run: &DesignRun,
) -> Result<(), Failure> {
    let chosen = &run.chosen.design;
    let about = design::about(mission, search, run);
    folder.write_text(GAINS, &gains_json(&run.name, &about, &run.gains(mission)))?;
    let beside = |path: &std::path::Path| relative(folder.path(), path);
    let text = designed_mission_json(mission, chosen, GAINS, beside).bad_input()?;
    let path = folder.write_text(MISSION, &text)?;
    let designed = load_mission(&path).context("the mission that was written")?;
    if let Some(plan) = judge.plan(&chosen.plan) {
        write_plan(folder, &designed, &plan)?;
    }
    folder.write_text("design.csv", &design::convergence_csv(mission, search))?;
    folder.write_text("design_front.csv", &design::front_csv(mission, search)).map(|_| ())
}

/// Writes `design_bode.svg`, the responses of the chosen design's loops.
pub fn write_bode(folder: &OutputFolder, mission: &Mission, run: &DesignRun) -> Result<(), Failure> {
    if run.loops.is_empty() {
        return Ok(());
    }
    let figure = bode_figure(mission, &run.name, &run.loops).context("the figure of the loops")?;
    folder.write_text("design_bode.svg", &figure).map(|_| ())
}

/// Writes `design.svg`, the distributions of J_TPF of the fresh flights.
pub fn write_distributions(folder: &OutputFolder, mission: &Mission, run: &DesignRun) -> Result<(), Failure> {
    if run.judged.is_empty() {
        return Ok(());
    }
    let figure = design::figure(mission, run).context("the figure of the fresh flights")?;
    folder.write_text("design.svg", &figure).map(|_| ())
}

/// Writes the manifest of a design, with the options that made it and the hash of the inputs of the mission
/// that it wrote.
pub fn write_manifest(args: &DesignArgs, folder: &OutputFolder, mission: &Mission) -> Result<(), Failure> {
    let designed = load_mission(&folder.path().join(MISSION)).context("the mission that was written")?;
    let options = [
        ("designed_input_hash", designed.inputs.hash),
        ("budget", args.budget.to_string()),
        ("time_limit", args.time_limit.map_or_else(|| "none".to_owned(), |s| s.to_string())),
        ("start", args.start.clone().unwrap_or_else(|| mission.control.gains_name.clone())),
        ("finalists", args.finalists.to_string()),
        ("unseen", args.unseen.to_string()),
        ("against", args.against.join(" ")),
    ];
    folder.write_manifest("design", mission, &options)
}
