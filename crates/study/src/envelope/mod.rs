//! The safe-release envelope: how far from the nominal release a drop may begin and be safe.
//!
//! | file | holds |
//! |---|---|
//! | this one | the study |
//! | [`releases`] | releases about a point of the envelope, and their flights |
//! | [`search`] | the edges, ray by ray |
//! | [`report`] | tables, JSON, rows |
//! | `figure` | the figure |

mod figure;
pub mod releases;
pub mod report;
pub mod search;

use std::fmt;

use samara_core::assess::envelope::{EdgeSearch, EnvelopeAxis};
use samara_core::plan::Plan;
use samara_mission::Mission;
use samara_report::document::Figure;

use crate::jobs::Jobs;
use crate::kind::{About, Flies, Given, Kind, Refused, Results, Slow, Study, Unfinished};
use crate::settings;
use crate::settings::Values;
use figure::envelope_figure;
pub use figure::{STRIP_PANELS, envelope_strip};
pub use releases::{ENVELOPE_LIMITS, MissionEnvelope};
use report::EnvelopeReport;
use search::EnvelopeSearch;

/// About how many flights a ray takes, of both limits.
const FLIGHTS_OF_A_RAY: u64 = 3000;

settings! {
    /// Which edges are searched.
    pub EnvelopeSettings {
        /// Two quantities at a time: `all` pairs, or some with commas between, such as pitch:wind.
        ///
        /// The quantities are pitch, pitch_rate, descent, delay, wind and turbulence.
        pairs("PAIRS"): Pairs = "all", pairs;
        /// Directions of each pair, a multiple of 4.
        rays("N"): usize = "16", rays;
    }
}

/// Pairs of quantities, in order, none twice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pairs(pub Vec<[EnvelopeAxis; 2]>);

impl fmt::Display for Pairs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pairs: Vec<String> = self.0.iter().map(|pair| pair.map(EnvelopeAxis::name).join(":")).collect();
        f.write_str(&pairs.join(","))
    }
}

fn pairs(text: &str) -> Result<Pairs, String> {
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

fn rays(text: &str) -> Result<usize, String> {
    let expected = "a multiple of 4 from 4 to 64 is expected";
    let fits = |n: &usize| (4..=64).contains(n) && n.is_multiple_of(4);
    text.parse().ok().filter(fits).ok_or_else(|| expected.to_owned())
}

/// How far from the nominal release a drop may begin and be safe, two quantities at a time.
pub struct Envelope;

impl Kind for Envelope {
    fn about(&self) -> About {
        About {
            name: "envelope",
            manifest: "assess_envelope",
            title: "How far from the nominal release a drop may begin and be safe",
            help: include_str!("help.txt"),
            unit: "rays",
            flies: Flies::FromT0,
            settings: EnvelopeSettings::TABLE,
            judges: Ok("the nominal release stays below J_state 1"),
            alone: Err("an edge is where a share of many flights stays safe, and no single one shows it"),
            refuses: &[],
        }
    }

    fn begin<'a>(&self, given: Given<'a>, values: &Values) -> Result<Box<dyn Study + 'a>, Refused> {
        let EnvelopeSettings { pairs: Pairs(pairs), rays } = EnvelopeSettings::of(values).map_err(Refused)?;
        let (mission, plan) = (given.mission, given.plan()?);
        let envelope = MissionEnvelope::new(mission, &plan.trajectory).map_err(Refused::by)?;
        Ok(Box::new(Edges { mission, plan, envelope, edges: EdgeSearch::default(), pairs, turns: rays }))
    }
}

struct Edges<'a> {
    mission: &'a Mission,
    plan: &'a Plan,
    envelope: MissionEnvelope,
    edges: EdgeSearch,
    pairs: Vec<[EnvelopeAxis; 2]>,
    turns: usize,
}

impl Edges<'_> {
    fn search(&self) -> EnvelopeSearch<'_> {
        let Self { envelope, edges, pairs, turns, .. } = self;
        EnvelopeSearch { envelope, search: edges, pairs, turns: *turns }
    }
}

impl Study for Edges<'_> {
    /// The rays, and the nominal release in the mission's own turbulence and in a point's.
    fn jobs(&self) -> u64 {
        let rays = self.search().rays();
        let nominal = [false, true].map(|sets| rays.iter().any(|ray| ray.from.sets_turbulence == sets));
        rays.len() as u64 + nominal.map(u64::from).iter().sum::<u64>()
    }

    fn slow(&self) -> Option<Slow<'_>> {
        let reason = self.envelope.one_at_a_time()?.to_string();
        let ray = self.search().rays().into_iter().next()?;
        let one = EdgeSearch { flights: 1, ..EdgeSearch::default() };
        let flights = self.search().rays().len() as u64 * FLIGHTS_OF_A_RAY / ENVELOPE_LIMITS.len() as u64;
        let try_some = move || {
            let _ = std::hint::black_box(self.envelope.nominal(&one, &ray, &|| false));
        };
        Some(Slow { reason, flights, tried: 1, try_some: Box::new(try_some) })
    }

    fn run(&self, jobs: &mut dyn Jobs) -> Result<Results, Unfinished> {
        let fans = self.search().run(jobs)?;
        let report = EnvelopeReport {
            mission: self.mission,
            fans,
            ranges: *self.envelope.ranges(),
            plan_j_tpf: self.mission.integrated(&self.plan.trajectory).j_tpf,
            search: self.edges.clone(),
        };
        let caption = "Where J_state 0.7 and 1 are reached, two quantities at a time".to_owned();
        Ok(Results {
            document: report.document(),
            json: report.json(),
            files: vec![("envelope.csv".to_owned(), report.csv())],
            figures: vec![Figure {
                file: "envelope.svg".to_owned(),
                caption,
                svg: envelope_figure(&report)?,
            }],
            holds: report.nominal_is_safe(),
            ..Results::default()
        })
    }
}
