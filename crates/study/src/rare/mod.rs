//! How rare failures are, and the most likely one.
//!
//! | file | holds |
//! |---|---|
//! | this one | the study, and the most likely failure flown again |
//! | [`report`] | tables, JSON, rows |
//! | `figure` | the figure |

mod figure;
pub mod report;

use std::path::Path;

use samara_core::assess::Limits;
use samara_core::assess::coordinates::{DrawnTrial, TrialSpace};
use samara_core::assess::rare::{PER_LEVEL_LEAST, PROBABILITY_LEAST, RareSearch};
use samara_core::trajectory::Trajectory;
use samara_mission::{Mission, load_rare_failure};
use samara_report::document::{Document, Figure, Passage};
use samara_report::figure::FigureError;

use crate::jobs::Jobs;
use crate::kind::{About, Flies, FlightFiles, Given, Kind, Refused, Results, Slow, Study, Unfinished};
use crate::own::{fly_points, slow_points, trial_space};
use crate::settings;
use crate::settings::{Values, bound, number, switch, whole};
use figure::rare_figure;
use report::RareReport;

/// Name of the files of the most likely failure.
const FAILURE: &str = "rare_failure";

/// J_TPF that is a failure, unless it is said otherwise.
const BOUND: f64 = 1.0;

settings! {
    /// How rare failures are sought.
    pub RareSettings {
        /// The probability down to which failures are sought.
        least("P"): f64 = "1e-4", least;
        /// J_TPF that is a failure.
        bound("B"): f64 = "1", bound;
        /// Draw what is uncertain too, where no file has the key `uncertain`.
        ///
        /// Mass, inertia, drag, density, thrust, latency, steady wind, delays: as `samara tune --robust`
        /// draws them. What the mission or its vehicle calls uncertain is always drawn.
        unknowns(""): bool = "false", switch;
        /// Flights of each level.
        per_level("N"): usize = "6800", whole(PER_LEVEL_LEAST as u64..=100_000);
    }
}

/// A probability that can be sought.
fn least(text: &str) -> Result<f64, String> {
    let fits = |p: f64| (PROBABILITY_LEAST..=0.1).contains(&p);
    number(text, fits, &format!("a probability from {PROBABILITY_LEAST:e} to 0.1 is expected, such as 1e-6"))
}

/// How probable it is that J_TPF reaches a bound, by subset simulation over everything that is drawn.
pub struct Rare;

impl Kind for Rare {
    fn about(&self) -> About {
        About {
            name: "rare",
            manifest: "assess_rare",
            title: "How rare failures are, and the most likely one",
            help: include_str!("help.txt"),
            unit: "flights",
            flies: Flies::FromT0,
            settings: RareSettings::TABLE,
            judges: Ok("failures are rarer than asked, with 95 % confidence"),
            alone: Ok("FILE"),
            refuses: &[],
        }
    }

    fn begin<'a>(&self, given: Given<'a>, values: &Values) -> Result<Box<dyn Study + 'a>, Refused> {
        let RareSettings { least, bound, unknowns, per_level } = RareSettings::of(values).map_err(Refused)?;
        let (mission, plan) = (given.mission, &given.plan()?.trajectory);
        let space = trial_space(mission, plan, unknowns).map_err(Refused::by)?;
        let search = RareSearch { bound, least, per_level, seed: mission.seed };
        let unknowns = unknowns || mission.uncertain.is_some();
        Ok(Box::new(Sought { mission, plan, space, search, unknowns }))
    }

    fn alone(&self, given: Given<'_>, values: &Values, name: &str) -> Result<Results, Refused> {
        let RareSettings { bound, .. } = RareSettings::of(values).map_err(Refused)?;
        let (mission, plan) = (given.mission, &given.plan()?.trajectory);
        let failure = load_rare_failure(Path::new(name), mission).map_err(Refused::by)?;
        if bound != BOUND && bound != failure.bound {
            let expected = failure.bound;
            let text =
                format!("--bound {bound}: that of the search, {expected}, is expected with --only {name}");
            return Err(Refused(text));
        }
        let space = trial_space(mission, plan, failure.unknowns).map_err(Refused::by)?;
        let (found, expected) = (failure.coordinates.len(), space.dimensions());
        if found != expected {
            return Err(Refused(format!(
                "{name}: coordinates: {expected} numbers are expected, found {found}"
            )));
        }
        let outcome = space.fly(&[&failure.coordinates]).into_iter().next().unwrap_or_default();
        let drawn = space.drawn(&failure.coordinates);
        let failed = !(outcome.j_tpf < failure.bound);
        let object = serde_json::json!({
            "mission": mission.name,
            "j_tpf": outcome.j_tpf.is_finite().then_some(outcome.j_tpf),
            "bound": failure.bound,
            "failed": failed,
        });
        let said = if failed { "reaches" } else { "stays below" };
        let said =
            format!("J_TPF {:.6}, which {said} {}; flight in {FAILURE}.*", outcome.j_tpf, failure.bound);
        Ok(Results {
            document: Document { lead: vec![Passage::Said(said)], ..Document::default() },
            json: format!("{object:#}\n"),
            flights: vec![flight(mission, plan, (&space, &drawn), failure.bound)],
            holds: !failed,
            ..Results::default()
        })
    }
}

struct Sought<'a> {
    mission: &'a Mission,
    plan: &'a Trajectory,
    space: TrialSpace,
    search: RareSearch,
    unknowns: bool,
}

impl Study for Sought<'_> {
    fn jobs(&self) -> u64 {
        self.search.points_most(self.space.spans().len()) as u64
    }

    fn slow(&self) -> Option<Slow<'_>> {
        slow_points(&self.space, self.jobs())
    }

    fn run(&self, jobs: &mut dyn Jobs) -> Result<Results, Unfinished> {
        let Self { mission, plan, space, search, unknowns } = self;
        let found = search.run(space.dimensions(), &space.spans(), |points| {
            let flown = fly_points(jobs, space, points)?;
            Ok::<_, Unfinished>(flown.iter().map(|outcome| outcome.j_tpf).collect())
        })?;
        let nearest = found.nearest.as_ref().map(|nearest| space.drawn(&nearest.point));
        let report =
            RareReport { mission, unknowns: *unknowns, found, parts: space.parts().to_vec(), nearest };
        let caption = "Probability that J_TPF exceeds a value".to_owned();
        let figure = match rare_figure(&report) {
            Ok(svg) => Some(Figure { file: "rare.svg".to_owned(), caption, svg }),
            Err(FigureError::Empty) => None,
            Err(e) => Err(e)?,
        };
        let mut files = vec![("rare.csv".to_owned(), report.csv())];
        let again = report.failure_json().map(|json| (format!("{FAILURE}.json"), json));
        let drawn = report.nearest.as_ref();
        Ok(Results {
            document: report.document(),
            json: report.json(),
            figures: figure.into_iter().collect(),
            flights: drawn
                .map(|drawn| flight(mission, plan, (space, drawn), search.bound))
                .into_iter()
                .collect(),
            absent: match drawn {
                Some(_) => Vec::new(),
                None => ["json", "csv", "svg", "html", "mcap"].map(|kind| format!("{FAILURE}.{kind}")).into(),
            },
            holds: report.found.is_below(),
            again: again.as_ref().map(|(name, _)| name.clone()),
            files: {
                files.extend(again);
                files
            },
            ..Results::default()
        })
    }
}

/// The flight of the most likely failure, judged with this bound on J_TPF.
fn flight(
    mission: &Mission,
    plan: &Trajectory,
    (space, trial): (&TrialSpace, &DrawnTrial),
    bound: f64,
) -> FlightFiles {
    FlightFiles {
        name: FAILURE.to_owned(),
        title: format!("{}, the most likely failure", mission.name),
        gains: mission.control.gains_name.clone(),
        plan: plan.clone(),
        samples: space.samples(trial),
        limits: Limits { j_tpf_below: bound, ..mission.limits },
        way_to_t0_ned_m: space.way_to_t0(trial),
    }
}
