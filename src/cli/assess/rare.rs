//! `samara assess --rare`: how rare failures are by subset simulation, and the most likely one; and that one
//! flown again.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use anyhow::Context as _;

use super::args::{AssessArgs, BOUND};
use super::command::Command;
use super::hosted::{self, Asked, Hosted};
use super::only::AloneFlight;
use super::points::{mission, warn};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_to_fly;
use crate::cli::results::OutputFolder;
use samara::assess::Limits;
use samara::assess::coordinates::{DrawnTrial, TrialSpace};
use samara::assess::rare::RareSearch;
use samara::config::{Mission, load_rare_failure};
use samara::report::figure::{FigureError, rare_figure};
use samara::report::rare::RareReport;
use samara::study::own::{fly_points, trial_space};
use samara::trajectory::Trajectory;

/// Name of the files of the most likely failure.
const FAILURE: &str = "rare_failure";

/// Name of the study.
const NAME: &str = "rare";

/// Searches, writes and reports.
pub fn run(args: &AssessArgs, least: f64, stop: &AtomicBool) -> Result<Answer, Failure> {
    let narrator = Narrator::alone(args.mission.json);
    let mission = mission(args, "--rare", &narrator)?;
    let folder = hosted::folder(args, "assess_rare", NAME, &mission)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let plan = &timed.plan.trajectory;
    let space = trial_space(&mission, plan, args.unknowns).bad_input()?;
    let search = RareSearch { bound: args.bound, least, per_level: args.per_level(), seed: mission.seed };
    let spans = space.spans();
    let unknowns = args.unknowns || mission.uncertain.is_some();
    let settings = [
        ("rare", least.to_string()),
        ("bound", args.bound.to_string()),
        ("unknowns", unknowns.to_string()),
        ("per_level", args.per_level().to_string()),
    ];
    let whole = search.points_most(spans.len()) as u64;
    let asked = Asked { name: NAME, unit: "flights", whole, threads: args.threads, settings: &settings };
    let hosted = Hosted::new(args, (&mission, &folder), asked, stop)?;
    warn(&space, whole, &hosted);
    let found = hosted.run(|host| {
        search.run(space.dimensions(), &spans, |points| {
            Ok(fly_points(host, &space, points)?.iter().map(|outcome| outcome.j_tpf).collect())
        })
    })?;
    let Some(found) = found else { return hosted.stopped("probability", &narrator) };
    let nearest = found.nearest.as_ref().map(|nearest| space.drawn(&nearest.point));
    let command = Command::of(args, &mission).alone();
    let parts = space.parts().to_vec();
    let report = RareReport { mission: &mission, unknowns, found, parts, nearest };
    write(&report, &folder)?;
    if let Some(drawn) = &report.nearest {
        write_flight(&mission, plan, (&space, drawn), args.bound, &folder, args)?;
    }
    folder.write_manifest("assess_rare", &mission, &settings)?;
    let again = match report.nearest {
        Some(_) => {
            let file = folder.path().join(FAILURE).with_extension("json");
            format!("flown in {FAILURE}.svg; again: {command} --only {}\n", file.display())
        }
        None => String::new(),
    };
    folder.print_result(
        args.mission.json,
        || report.json(),
        || format!("\n{}\n{again}", report.document().text()),
    )?;
    Ok(Answer::from(report.found.is_below()))
}

fn write(report: &RareReport<'_>, folder: &OutputFolder) -> Result<(), Failure> {
    folder.write_text("rare.txt", &report.document().text())?;
    folder.write_text("rare.json", &report.json())?;
    folder.write_text("rare.csv", &report.csv())?;
    match rare_figure(report) {
        Ok(svg) => folder.write_text("rare.svg", &svg).map(|_| ())?,
        Err(FigureError::Empty) => {}
        Err(e) => Err(e).context("the figure of the probabilities")?,
    }
    if let Some(json) = report.failure_json() {
        folder.write_text(&format!("{FAILURE}.json"), &json)?;
    }
    if report.nearest.is_none() {
        let names = ["json", "csv", "svg", "html", "mcap"].map(|ending| format!("{FAILURE}.{ending}"));
        folder.remove_leftovers(&names.each_ref().map(String::as_str))?;
    }
    Ok(())
}

/// Flies the most likely failure of a file again: prints J_TPF, writes flight log, figure and pages.
pub fn fly_again(args: &AssessArgs, file: &Path) -> Result<Answer, Failure> {
    if args.paper {
        return Err(Failure::input(
            "--only FILE: a failure of --rare is expected without --paper".to_owned(),
        ));
    }
    let narrator = Narrator::alone(args.mission.json);
    let mission = mission(args, "--rare", &narrator)?;
    let failure = load_rare_failure(file, &mission).bad_input()?;
    if args.bound != BOUND && args.bound != failure.bound {
        return Err(Failure::input(format!(
            "--bound {}: that of the search, {}, is expected with --only {}",
            args.bound,
            failure.bound,
            file.display()
        )));
    }
    let folder = OutputFolder::create("assess_only", args.mission.out.as_deref(), &mission.name)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let plan = &timed.plan.trajectory;
    let space = trial_space(&mission, plan, failure.unknowns).bad_input()?;
    let (found, expected) = (failure.coordinates.len(), space.dimensions());
    if found != expected {
        return Err(Failure::input(format!(
            "{}: coordinates: {expected} numbers are expected, found {found}",
            file.display()
        )));
    }
    let outcome = space.fly(&[&failure.coordinates]).into_iter().next().unwrap_or_default();
    let drawn = space.drawn(&failure.coordinates);
    write_flight(&mission, plan, (&space, &drawn), failure.bound, &folder, args)?;
    folder.write_manifest("assess_only", &mission, &[("only", file.display().to_string())])?;
    let failed = !(outcome.j_tpf < failure.bound);
    let json = || {
        let object = serde_json::json!({
            "mission": mission.name,
            "j_tpf": outcome.j_tpf.is_finite().then_some(outcome.j_tpf),
            "bound": failure.bound,
            "failed": failed,
        });
        format!("{object:#}\n")
    };
    let said = if failed { "reaches" } else { "stays below" };
    let text =
        || format!("J_TPF {:.6}, which {said} {}; flight in {FAILURE}.*, ", outcome.j_tpf, failure.bound);
    folder.print_result(args.mission.json, json, text)?;
    Ok(Answer::from(!failed))
}

/// Writes the flight of the most likely failure, judged with this bound on J_TPF.
fn write_flight(
    mission: &Mission,
    plan: &Trajectory,
    (space, trial): (&TrialSpace, &DrawnTrial),
    bound: f64,
    folder: &OutputFolder,
    args: &AssessArgs,
) -> Result<(), Failure> {
    let flight = AloneFlight {
        mission,
        title: format!("{}, the most likely failure", mission.name),
        gains: &mission.control.gains_name,
        plan,
        samples: &space.samples(trial),
        limits: Limits { j_tpf_below: bound, ..mission.limits },
        way_to_t0_ned_m: space.way_to_t0(trial),
    };
    flight.write(folder, FAILURE, args)
}
