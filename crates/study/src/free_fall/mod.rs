//! How well the release is found by the fall that the accelerometer alone shows.
//!
//! | file | holds |
//! |---|---|
//! | this one | the study |
//! | `circumstances` | the releases and descents that show it |
//! | [`report`] | tables, JSON, rows |
//! | `figure` | the figure |

mod circumstances;
mod figure;
pub mod report;

use samara_core::assess::free_fall::FreeFallStudy;
use samara_mission::Mission;
use samara_report::document::Figure;

use crate::feature::Feature;
use crate::jobs::{Jobs, Round};
use crate::kind::{About, Flies, Given, Kind, Refused, Results, Study, Unfinished};
use crate::settings;
use crate::settings::{Values, whole};
pub use circumstances::{NoFreeFall, free_fall_study};
pub use figure::free_fall_figure;
use report::FreeFallReport;

settings! {
    /// How much is fallen and descended.
    pub FreeFallSettings {
        /// Releases that must be found.
        trials("N"): u64 = "10000", whole(2..=100_000);
        /// Hours of descent in turbulence in which nothing may be found.
        hours("HOURS"): u64 = "20", whole(1..=100_000);
    }
}

/// Releases that must be found, and descents in which nothing may be.
pub struct FreeFall;

impl Kind for FreeFall {
    fn about(&self) -> About {
        About {
            name: "free_fall",
            manifest: "free_fall",
            title: "How well the release is found without a wire",
            help: include_str!("help.txt"),
            unit: "releases and hours",
            flies: Flies::WithoutAPlan,
            settings: FreeFallSettings::TABLE,
            judges: Ok("every release is found, and nothing else under a taut riser"),
            alone: Err(
                "a rate of alarms is of all hours together; one release with the detector is `samara drop`",
            ),
            refuses: &[(
                Feature::Card,
                "it judges what finds the release, and a card what comes of the drop",
            )],
        }
    }

    fn begin<'a>(&self, given: Given<'a>, values: &Values) -> Result<Box<dyn Study + 'a>, Refused> {
        let FreeFallSettings { trials, hours } = FreeFallSettings::of(values).map_err(Refused)?;
        let study = free_fall_study(given.mission).map_err(|e| Refused(format!("free-fall: {e}")))?;
        Ok(Box::new(Falls { mission: given.mission, study, trials, hours }))
    }
}

struct Falls<'a> {
    mission: &'a Mission,
    study: FreeFallStudy,
    trials: u64,
    hours: u64,
}

impl Study for Falls<'_> {
    fn jobs(&self) -> u64 {
        self.trials + self.hours
    }

    fn run(&self, jobs: &mut dyn Jobs) -> Result<Results, Unfinished> {
        let Self { mission, study, trials, hours } = self;
        let releases = jobs.fly("releases", Round::of(*trials, 8), &|some, stop| {
            (!stop()).then(|| some.map(|trial| study.release(trial)).collect())
        })?;
        let descents = jobs.fly("descents", Round::of(*hours, 1), &|some, stop| {
            (!stop()).then(|| some.map(|hour| study.descend(hour)).collect())
        })?;
        let report = FreeFallReport { mission, study: study.clone(), releases, descents };
        let caption = "False alarms of each rule, and how long it takes".to_owned();
        let named = |name: &str, csv: String| (format!("free_fall_{name}.csv"), csv);
        Ok(Results {
            document: report.document(),
            json: report.json(),
            files: vec![
                named("releases", report.releases_csv()),
                named("descents", report.descents_csv()),
                named("rules", report.rules_csv()),
            ],
            figures: vec![Figure {
                file: "free_fall.svg".to_owned(),
                caption,
                svg: free_fall_figure(&report)?,
            }],
            holds: report.holds(),
            ..Results::default()
        })
    }
}
