//! `samara study rare`: how rare failures are by subset simulation, and the most likely one; and that one
//! flown again.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::Context as _;

use clap::Args;

use super::args::StudyArgs;
use super::hosted::{self, Asked, Hosted};
use super::points::warn;
use crate::cli::alone_flight::AloneFlight;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::{PageArgs, number, whole};
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_to_fly;
use crate::cli::results::OutputFolder;
use samara::assess::Limits;
use samara::assess::coordinates::{DrawnTrial, TrialSpace};
use samara::assess::rare::{PER_LEVEL, PER_LEVEL_LEAST, PROBABILITY_LEAST, RareSearch};
use samara::config::{Mission, load_rare_failure};
use samara::report::figure::{FigureError, rare_figure};
use samara::report::rare::RareReport;
use samara::report::shell::command_line;
use samara::study::own::{fly_points, trial_space};
use samara::trajectory::Trajectory;

/// Name of the files of the most likely failure.
const FAILURE: &str = "rare_failure";

/// Name of the study.
const NAME: &str = "rare";
/// Name of the study in its manifest.
const VERB: &str = "assess_rare";

/// J_TPF that is a failure, unless it is said otherwise.
pub const BOUND: f64 = 1.0;

/// `samara study rare`.
#[derive(Args, Debug)]
pub struct RareArgs {
    /// The probability down to which failures are sought.
    #[arg(long, value_name = "P", default_value_t = 1e-4, value_parser = least)]
    pub least: f64,
    /// J_TPF that is a failure.
    #[arg(long, value_name = "B", default_value_t = BOUND, value_parser = bound)]
    pub bound: f64,
    /// Draw what is uncertain too, where no file has the key `uncertain`.
    ///
    /// Mass, inertia, drag, density, thrust, latency, steady wind, delays: as `samara tune --robust` draws
    /// them. What the mission or its vehicle calls uncertain is always drawn.
    #[arg(long)]
    pub unknowns: bool,
    /// Flights of each level.
    #[arg(long, value_name = "N", default_value_t = PER_LEVEL, value_parser = per_level)]
    pub per_level: usize,
    /// Fly the most likely failure again that a search wrote to this file, rare_failure.json.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["resume", "least", "unknowns", "per_level"])]
    pub only: Option<PathBuf>,
    /// The page of the most likely failure.
    #[command(flatten)]
    pub page: PageArgs,
    /// What every study has.
    #[command(flatten)]
    pub study: StudyArgs,
}

/// A probability that can be sought.
pub fn least(text: &str) -> Result<f64, String> {
    let fits = |p: f64| (PROBABILITY_LEAST..=0.1).contains(&p);
    number(text, fits, &format!("a probability from {PROBABILITY_LEAST:e} to 0.1 is expected, such as 1e-6"))
}

/// A bound on J_TPF.
pub fn bound(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0 && x <= 1e6, "a number above 0, up to 1e6, is expected")
}

/// Flights of a level.
pub fn per_level(text: &str) -> Result<usize, String> {
    whole::<usize>(PER_LEVEL_LEAST as u64..=100_000)(text)
}

/// Searches, writes and reports; or flies again what was found.
pub fn run(args: &RareArgs, stop: &AtomicBool) -> Result<Answer, Failure> {
    match &args.only {
        Some(file) => fly_again(args, file),
        None => search(args, stop),
    }
}

fn search(asked_for: &RareArgs, stop: &AtomicBool) -> Result<Answer, Failure> {
    let RareArgs { study: args, least, bound, unknowns, per_level, .. } = asked_for;
    let (least, bound, per_level) = (*least, *bound, *per_level);
    let narrator = Narrator::alone(args.mission.json);
    let mission = args.mission_with_a_drop_from_t0("rare", &narrator)?;
    let folder = hosted::folder(args, VERB, NAME, &mission)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let plan = &timed.plan.trajectory;
    let space = trial_space(&mission, plan, *unknowns).bad_input()?;
    let search = RareSearch { bound, least, per_level, seed: mission.seed };
    let spans = space.spans();
    let unknowns = *unknowns || mission.uncertain.is_some();
    let settings = [
        ("rare", least.to_string()),
        ("bound", bound.to_string()),
        ("unknowns", unknowns.to_string()),
        ("per_level", per_level.to_string()),
    ];
    let whole = search.points_most(spans.len()) as u64;
    let asked =
        Asked { name: NAME, verb: VERB, unit: "flights", whole, threads: args.threads, settings: &settings };
    let hosted = Hosted::new(args, (&mission, &folder), asked, stop)?;
    warn(&space, whole, &hosted);
    let found = hosted.run(|host| {
        search.run(space.dimensions(), &spans, |points| {
            Ok(fly_points(host, &space, points)?.iter().map(|outcome| outcome.j_tpf).collect())
        })
    })?;
    let Some(found) = found else { return hosted.stopped("probability", &narrator) };
    let nearest = found.nearest.as_ref().map(|nearest| space.drawn(&nearest.point));
    let parts = space.parts().to_vec();
    let report = RareReport { mission: &mission, unknowns, found, parts, nearest };
    write(&report, &folder)?;
    if let Some(drawn) = &report.nearest {
        write_flight(&mission, plan, (&space, drawn), bound, &folder, &asked_for.page)?;
    }
    let again = match report.nearest {
        Some(_) => {
            let file = folder.path().join(FAILURE).with_extension("json").display().to_string();
            let mut words = args.command(&["study", "rare"], &mission);
            words.extend(["--only".to_owned(), file]);
            format!("flown in {FAILURE}.svg; again: {}\n", command_line(words))
        }
        None => String::new(),
    };
    let place = folder.path().display();
    let text = || format!("\n{}\n{again}results in {place}\n", report.document().text());
    hosted.finish(|| report.json(), text)?;
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
fn fly_again(asked_for: &RareArgs, file: &Path) -> Result<Answer, Failure> {
    let RareArgs { study: args, bound, page, .. } = asked_for;
    let narrator = Narrator::alone(args.mission.json);
    let mission = args.mission_with_a_drop_from_t0("rare", &narrator)?;
    let failure = load_rare_failure(file, &mission).bad_input()?;
    if *bound != BOUND && *bound != failure.bound {
        return Err(Failure::input(format!(
            "--bound {}: that of the search, {}, is expected with --only {}",
            bound,
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
    write_flight(&mission, plan, (&space, &drawn), failure.bound, &folder, page)?;
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
    page: &PageArgs,
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
    flight.write(folder, FAILURE, page)
}
