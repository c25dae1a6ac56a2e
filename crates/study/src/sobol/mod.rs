//! What decides a drop, of all that is uncertain: Sobol's indices.
//!
//! | file | holds |
//! |---|---|
//! | this one | the study |
//! | [`report`] | tables, JSON, rows |
//! | `figure` | the figure |

mod figure;
pub mod report;

use samara_core::assess::coordinates::{CoordinateGroup, TrialSpace};
use samara_core::assess::sobol::SobolStudy;
use samara_mission::Mission;
use samara_report::document::Figure;

use crate::feature::Feature;
use crate::jobs::Jobs;
use crate::kind::{About, Flies, Given, Kind, Refused, Results, Slow, Study, Unfinished};
use crate::own::{fly_points, slow_points, trial_space};
use crate::settings;
use crate::settings::{Values, whole};
use figure::sobol_figure;
use report::{Replaced, SobolReport, outputs_of};

settings! {
    /// How what decides is estimated.
    pub SobolSettings {
        /// Trials of each of the two samples; as many more for each quantity.
        points("N"): usize = "2048", whole(64..=1_000_000);
    }
}

/// Why it is no test, and nothing for a card.
const SHARES_OUT: &str = "it shares out a variance, and judges nothing";

/// What of all that is drawn decides J_TPF, the time to steady flight and the altitude lost.
pub struct Sobol;

impl Kind for Sobol {
    fn about(&self) -> About {
        About {
            name: "sobol",
            manifest: "assess_sobol",
            title: "What decides a drop, of all that is uncertain",
            help: include_str!("help.txt"),
            unit: "flights",
            flies: Flies::FromT0,
            settings: SobolSettings::TABLE,
            judges: Err(SHARES_OUT),
            alone: Err("an index is of all flights together, and no single one shows it"),
            refuses: &[(Feature::Card, SHARES_OUT)],
        }
    }

    fn begin<'a>(&self, given: Given<'a>, values: &Values) -> Result<Box<dyn Study + 'a>, Refused> {
        let SobolSettings { points } = SobolSettings::of(values).map_err(Refused)?;
        let mission = given.mission;
        let space = trial_space(mission, &given.plan()?.trajectory, true).map_err(Refused::by)?;
        let groups = space.groups();
        Ok(Box::new(Estimate { mission, space, groups, study: SobolStudy { points, seed: mission.seed } }))
    }
}

struct Estimate<'a> {
    mission: &'a Mission,
    space: TrialSpace,
    groups: Vec<CoordinateGroup>,
    study: SobolStudy,
}

impl Study for Estimate<'_> {
    fn jobs(&self) -> u64 {
        self.study.evaluations(self.groups.len()) as u64
    }

    fn slow(&self) -> Option<Slow<'_>> {
        slow_points(&self.space, self.jobs())
    }

    fn run(&self, jobs: &mut dyn Jobs) -> Result<Results, Unfinished> {
        let Self { mission, space, groups, study } = self;
        let ranges: Vec<_> = groups.iter().map(|group| group.ranges.clone()).collect();
        let (mut replaced, end_s) = (Replaced::default(), space.duration_s());
        let found = study.run(space.dimensions(), &ranges, |points| {
            let flown = fly_points(jobs, space, points)?;
            flown.iter().for_each(|outcome| replaced.push(outcome));
            Ok::<_, Unfinished>(flown.iter().map(|outcome| outputs_of(outcome, end_s)).collect())
        })?;
        let report = SobolReport { mission, study: *study, groups: groups.clone(), found, replaced, end_s };
        let caption = "What decides a drop: shares of the variance".to_owned();
        Ok(Results {
            document: report.document(),
            json: report.json(),
            files: vec![("sobol.csv".to_owned(), report.csv())],
            figures: vec![Figure { file: "sobol.svg".to_owned(), caption, svg: sobol_figure(&report)? }],
            holds: true,
            ..Results::default()
        })
    }
}
