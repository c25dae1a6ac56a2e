//! What each effect that a mission names does to its drops.
//!
//! | file | holds |
//! |---|---|
//! | this one | the study |
//! | [`flights`] | drops with and without each effect |
//! | [`report`] | tables, JSON, rows |

pub mod flights;
pub mod report;

use std::ops::Range;

use samara_core::sim::ABREAST;
use samara_mission::{Effect, Mission};

use crate::feature::{COMPARES, Feature};
use crate::jobs::Jobs;
use crate::kind::{About, Flies, Given, Kind, Refused, Results, Study, Unfinished, trial_alone};
use crate::settings;
use crate::settings::{Values, whole};
pub use flights::{EffectFlights, EffectsOn, JudgedDrop};
use report::{EffectCampaign, EffectReport};

settings! {
    /// How effects are compared.
    pub EffectsSettings {
        /// Trials of each campaign.
        trials("N"): u64 = "1000", whole(2..=100_000);
    }
}

/// Drops with none of a mission's effects, each alone, all, and all but each, from the same random numbers.
pub struct Effects;

impl Kind for Effects {
    fn about(&self) -> About {
        About {
            name: "effects",
            manifest: "effects",
            title: "What each effect that the mission names does to its drops",
            help: include_str!("help.txt"),
            unit: "drops",
            flies: Flies::WholeDrops,
            settings: EffectsSettings::TABLE,
            judges: Err(COMPARES),
            alone: Ok("K"),
            refuses: &[(Feature::Card, COMPARES)],
        }
    }

    fn begin<'a>(&self, given: Given<'a>, values: &Values) -> Result<Box<dyn Study + 'a>, Refused> {
        let EffectsSettings { trials } = EffectsSettings::of(values).map_err(Refused)?;
        Ok(Box::new(Comparison::new(given, 0..trials)?))
    }

    fn alone(&self, given: Given<'_>, _: &Values, name: &str) -> Result<Results, Refused> {
        let comparison = Comparison::new(given, trial_alone(name)?)?;
        let drops = comparison.flights.iter().map(|(_, flights)| flights.fly_all(comparison.trials.clone()));
        let report = comparison.report(drops.collect());
        Ok(Results {
            document: report.document(),
            json: report.json(),
            files: vec![("effects_only.csv".to_owned(), report.csv())],
            holds: true,
            ..Results::default()
        })
    }
}

struct Comparison<'a> {
    mission: &'a Mission,
    effects: Vec<Effect>,
    flights: Vec<(EffectsOn, EffectFlights<'a>)>,
    trials: Range<u64>,
}

impl<'a> Comparison<'a> {
    fn new(given: Given<'a>, trials: Range<u64>) -> Result<Self, Refused> {
        let (mission, plan) = (given.mission, &given.plan()?.trajectory);
        let effects = mission.effects();
        if effects.is_empty() {
            let keys: Vec<&str> = Effect::ALL.into_iter().map(Effect::key).collect();
            return Err(Refused(format!(
                "a study of effects has nothing to leave out: at least one of these keys is expected: {}",
                keys.join("; ")
            )));
        }
        let flights = EffectsOn::campaigns(&effects)
            .into_iter()
            .map(|on| Ok((on, EffectFlights::new(mission, &on.kept(&effects), plan).map_err(Refused::by)?)));
        let flights = flights.collect::<Result<_, Refused>>()?;
        Ok(Self { mission, effects, flights, trials })
    }

    fn report(&self, drops: Vec<Vec<JudgedDrop>>) -> EffectReport<'_> {
        let of = |((on, _), drops): (&(EffectsOn, _), _)| EffectCampaign { on: *on, drops };
        let campaigns = self.flights.iter().zip(drops).map(of).collect();
        let (effects, trials) = (self.effects.clone(), self.trials.clone());
        EffectReport { mission: self.mission, effects, trials, campaigns }
    }
}

impl Study for Comparison<'_> {
    fn jobs(&self) -> u64 {
        self.flights.len() as u64 * self.trials.end
    }

    fn run(&self, jobs: &mut dyn Jobs) -> Result<Results, Unfinished> {
        let drops = jobs.fly_sets(
            "drops",
            (self.flights.len(), self.trials.end),
            ABREAST as u64,
            &|set, some, stop| {
                let (_, flights) = self.flights.get(set)?;
                (!stop()).then(|| flights.fly_all(some))
            },
        )?;
        let report = self.report(drops);
        Ok(Results {
            figures: report.figure()?.into_iter().collect(),
            document: report.document(),
            json: report.json(),
            files: vec![("effects.csv".to_owned(), report.csv())],
            holds: true,
            ..Results::default()
        })
    }
}
