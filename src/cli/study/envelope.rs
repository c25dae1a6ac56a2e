//! `samara study envelope`: how far from the nominal release a drop may begin and be safe, two quantities
//! at a time.

use std::sync::atomic::AtomicBool;

use anyhow::Context as _;

use clap::Args;

use super::args::StudyArgs;
use super::hosted::{self, Asked, Hosted};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::estimate::warn_in_space;
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_to_fly;
use samara::assess::envelope::{EdgeSearch, EnvelopeAxis, Ray};
use samara::report::envelope::{EnvelopeReport, FanEdges};
use samara::report::figure::envelope_figure;
use samara::study::envelope::{ENVELOPE_LIMITS, MissionEnvelope};
use samara::study::envelope_search::EnvelopeSearch;

/// About how many flights a ray takes, of both limits.
const FLIGHTS_OF_A_RAY: u64 = 3000;

/// Name of the study.
const NAME: &str = "envelope";
/// Name of the study in its manifest.
const VERB: &str = "assess_envelope";

/// Directions of each pair, unless it is said otherwise.
pub const RAYS: usize = 16;

/// `samara study envelope`.
#[derive(Args, Debug)]
pub struct EnvelopeArgs {
    /// Two quantities at a time: `all` pairs, or some with commas between, such as pitch:wind.
    ///
    /// The quantities are pitch, pitch_rate, descent, delay, wind and turbulence.
    #[arg(long, value_name = "PAIRS", default_value = "all", value_parser = pairs)]
    pub pairs: Pairs,
    /// Directions of each pair, a multiple of 4.
    #[arg(long, value_name = "N", default_value_t = RAYS, value_parser = rays)]
    pub rays: usize,
    /// What every study has.
    #[command(flatten)]
    pub study: StudyArgs,
}

/// The pairs of quantities, in order, none twice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pairs(pub Vec<[EnvelopeAxis; 2]>);

/// The value of --pairs.
pub fn pairs(text: &str) -> Result<Pairs, String> {
    if text == "all" {
        return Ok(Pairs(EnvelopeAxis::pairs()));
    }
    let names = EnvelopeAxis::ALL.map(EnvelopeAxis::name).join(", ");
    let mut pairs: Vec<[EnvelopeAxis; 2]> = Vec::new();
    for pair in text.split(',') {
        let axes = pair.split_once(':').map(|(x, y)| [x, y].map(|name| EnvelopeAxis::named(name.trim())));
        let Some([Some(x), Some(y)]) = axes.filter(|[x, y]| x != y) else {
            return Err(format!(
                "`all`, or pairs of different quantities such as pitch:wind are expected, found `{pair}`; \
                 quantities: {names}"
            ));
        };
        if !pairs.iter().any(|known| known.contains(&x) && known.contains(&y)) {
            pairs.push([x, y]);
        }
    }
    Ok(Pairs(pairs))
}

/// Directions of a pair.
pub fn rays(text: &str) -> Result<usize, String> {
    let expected = "a multiple of 4 from 4 to 64 is expected";
    text.parse()
        .ok()
        .filter(|n: &usize| (4..=64).contains(n) && n.is_multiple_of(4))
        .ok_or_else(|| expected.to_owned())
}

/// Searches the edges, writes and reports them.
pub fn run(args: &EnvelopeArgs, stop: &AtomicBool) -> Result<Answer, Failure> {
    let (args, Pairs(pairs), turns) = (&args.study, &args.pairs, args.rays);
    let narrator = Narrator::alone(args.mission.json);
    let mission = args.mission_with_a_drop_from_t0("envelope", &narrator)?;
    let folder = hosted::folder(args, VERB, NAME, &mission)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let asked: Vec<String> = pairs.iter().map(|pair| pair.map(EnvelopeAxis::name).join(":")).collect();
    let settings = [("envelope", asked.join(",")), ("rays", turns.to_string())];
    let envelope = MissionEnvelope::new(&mission, &timed.plan.trajectory).bad_input()?;
    let edges = EdgeSearch::default();
    let search = EnvelopeSearch { envelope: &envelope, search: &edges, pairs, turns };
    let rays = search.rays();
    let whole = rays.len() as u64;
    let asked =
        Asked { name: NAME, verb: VERB, unit: "rays", whole, threads: args.threads, settings: &settings };
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
    let every = folder.path().join("envelope.csv");
    let text = || format!("\n{}every edge in {}\n", report.document().text(), every.display());
    hosted.finish(|| report.json(), text)?;
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
