//! `samara assess --envelope`: how far from the nominal release a drop may begin and be safe, two quantities
//! at a time.

use std::sync::atomic::AtomicBool;

use anyhow::Context as _;

use super::args::AssessArgs;
use super::hosted::{self, Asked, Hosted};
use super::points::mission;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::estimate::warn_in_space;
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_to_fly;
use crate::cli::terminal::print;
use samara::assess::envelope::{EdgeSearch, EnvelopeAxis, Ray};
use samara::report::envelope::{EnvelopeReport, FanEdges};
use samara::report::figure::envelope_figure;
use samara::study::envelope::{ENVELOPE_LIMITS, MissionEnvelope};
use samara::study::envelope_search::EnvelopeSearch;

/// About how many flights a ray takes, of both limits.
const FLIGHTS_OF_A_RAY: u64 = 3000;

/// Name of the study.
const NAME: &str = "envelope";

/// Searches the edges, writes and reports them.
pub fn run(args: &AssessArgs, pairs: &[[EnvelopeAxis; 2]], stop: &AtomicBool) -> Result<Answer, Failure> {
    let narrator = Narrator::alone(args.mission.json);
    let mission = mission(args, "--envelope", &narrator)?;
    let folder = hosted::folder(args, "assess_envelope", NAME, &mission)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let asked: Vec<String> = pairs.iter().map(|pair| pair.map(EnvelopeAxis::name).join(":")).collect();
    let settings = [("envelope", asked.join(",")), ("rays", args.rays().to_string())];
    let envelope = MissionEnvelope::new(&mission, &timed.plan.trajectory).bad_input()?;
    let edges = EdgeSearch::default();
    let search = EnvelopeSearch { envelope: &envelope, search: &edges, pairs, turns: args.rays() };
    let rays = search.rays();
    let whole = rays.len() as u64;
    let asked = Asked { name: NAME, unit: "rays", whole, threads: args.threads, settings: &settings };
    let hosted = Hosted::new(args, (&mission, &folder), asked, stop)?;
    warn(&search, &rays, hosted.threads());
    let Some(fans) = hosted.run(|host| search.run(host))? else {
        return hosted.stopped("pairs", &narrator);
    };
    let report = EnvelopeReport {
        mission: &mission,
        fans: fans.into_iter().map(FanEdges::from).collect(),
        ranges: *envelope.ranges(),
        plan_j_tpf: mission.integrated(&timed.plan.trajectory).j_tpf,
        search: edges,
    };
    folder.write_text("envelope.txt", &report.document().text())?;
    folder.write_text("envelope.csv", &report.csv())?;
    folder.write_text("envelope.json", &report.json())?;
    folder.write_text("envelope.svg", &envelope_figure(&report).context("the figure of the envelope")?)?;
    folder.write_manifest("assess_envelope", &mission, &settings)?;
    print(&if args.mission.json {
        report.json()
    } else {
        format!(
            "\n{}every edge in {}\n",
            report.document().text(),
            folder.path().join("envelope.csv").display()
        )
    })?;
    Ok(Answer::from(report.nominal_is_safe()))
}

/// Says how long a search takes where flights are flown in six degrees of freedom.
fn warn(search: &EnvelopeSearch<'_>, rays: &[Ray], threads: usize) {
    if let (Some(reason), Some(ray)) = (search.envelope.one_at_a_time(), rays.first()) {
        let one = EdgeSearch { flights: 1, ..EdgeSearch::default() };
        let count = rays.len() as u64 * FLIGHTS_OF_A_RAY / ENVELOPE_LIMITS.len() as u64;
        warn_in_space(reason, (count, 1), threads, || search.envelope.nominal(&one, ray, &|| false));
    }
}
