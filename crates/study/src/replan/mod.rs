//! What renewing the plan during a drop does.
//!
//! | file | holds |
//! |---|---|
//! | this one | the study, without a wire or by what another flies |
//! | [`flights`] | drops along one plan and along renewed ones |
//! | [`report`] | tables, JSON, rows |

pub mod flights;
pub mod report;

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use samara_core::replan::Cadence;
use samara_mission::Mission;

use crate::feature::{COMPARES, Feature};
use crate::jobs::{Jobs, Stop};
use crate::kind::{About, Flies, Given, Kind, Refused, Results, Study, Unfinished, trial_alone};
use crate::settings;
use crate::settings::{Values, whole};
pub use flights::{ReplanDrop, ReplanFlights, ReplanRow};
use report::{ReplanCampaign, ReplanReport};

settings! {
    /// When plans are renewed, and how often drops are flown.
    pub ReplanSettings {
        /// When plans are renewed: at the `release`, or at a rate [Hz] from it on; several with commas
        /// between.
        when("WHEN"): Cadences = "release,1", cadences;
        /// Trials of each campaign.
        trials("N"): u64 = "300", whole(2..=100_000);
    }
}

/// Cadences, in order, none twice.
#[derive(Clone, Debug, PartialEq)]
pub struct Cadences(pub Vec<Cadence>);

impl fmt::Display for Cadences {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cadences: Vec<String> = self.0.iter().map(Cadence::to_string).collect();
        f.write_str(&cadences.join(","))
    }
}

fn cadences(text: &str) -> Result<Cadences, String> {
    let mut cadences = Vec::new();
    for cadence in text.split(',') {
        let cadence = cadence.trim().parse()?;
        if !cadences.contains(&cadence) {
            cadences.push(cadence);
        }
    }
    Ok(Cadences(cadences))
}

/// Drops along one plan and along plans that are renewed, from the same random numbers.
pub struct Replan;

impl Kind for Replan {
    fn about(&self) -> About {
        About {
            name: "replan",
            manifest: "replan",
            title: "What renewing the plan during the drop does",
            help: include_str!("help.txt"),
            unit: "drops",
            flies: Flies::WholeDrops,
            settings: ReplanSettings::TABLE,
            judges: Err(COMPARES),
            alone: Ok("K"),
            refuses: &[(Feature::Card, COMPARES)],
        }
    }

    fn begin<'a>(&self, given: Given<'a>, values: &Values) -> Result<Box<dyn Study + 'a>, Refused> {
        Ok(Box::new(Renewals::without_a_wire(given, values)?))
    }

    fn alone(&self, given: Given<'_>, values: &Values, name: &str) -> Result<Results, Refused> {
        let trials = trial_alone(name)?;
        let renewals = Renewals::without_a_wire(given, values)?;
        let drops = renewals.fly.iter().map(|fly| fly(trials.start, &|| false).into_iter().collect());
        let report = renewals.report(trials.clone(), drops.collect());
        Ok(Results {
            document: report.document(),
            json: report.json(),
            files: vec![("replan_only.csv".to_owned(), report.csv())],
            holds: true,
            ..Results::default()
        })
    }
}

/// Flies a trial; `None` where it was stopped.
pub type FlyRenewed<'a> = dyn Fn(u64, Stop<'_>) -> Option<ReplanDrop> + Sync + 'a;

/// Campaigns along one plan and along renewed ones, each flown in its own way.
pub struct Renewals<'a> {
    /// The mission.
    pub mission: &'a Mission,
    /// Name of the autopilot that flies over a wire; `None`: the cascade without one.
    pub autopilot: Option<&'static str>,
    /// How the drops of each campaign are flown.
    pub rows: Vec<ReplanRow>,
    /// What flies those of each row.
    pub fly: Vec<Box<FlyRenewed<'a>>>,
    /// Trials of each campaign.
    pub trials: u64,
}

impl<'a> Renewals<'a> {
    fn without_a_wire(given: Given<'a>, values: &Values) -> Result<Self, Refused> {
        let (rows, trials) = Renewals::rows(given, values)?;
        let (shared, plan) = (Arc::new(given.mission.clone()), given.plan()?);
        let fly_row = |row: &ReplanRow| -> Result<Box<FlyRenewed<'a>>, Refused> {
            let flights = ReplanFlights::new(&shared, plan, row).map_err(Refused::by)?;
            Ok(Box::new(move |trial, _| Some(flights.fly(trial))))
        };
        let fly = rows.iter().map(fly_row).collect::<Result<_, _>>()?;
        Ok(Self { mission: given.mission, autopilot: None, rows, fly, trials })
    }

    fn report(&self, trials: Range<u64>, drops: Vec<Vec<ReplanDrop>>) -> ReplanReport<'_> {
        let of = |(row, drops): (&ReplanRow, _)| ReplanCampaign { row: row.clone(), drops };
        let campaigns = self.rows.iter().zip(drops).map(of).collect();
        ReplanReport { mission: self.mission, autopilot: self.autopilot, trials, campaigns }
    }

    /// The campaigns of a mission, and the trials of each: the first by the mission's own gains, the others
    /// by those that were chosen, or that the mission has for renewed plans.
    ///
    /// # Errors
    /// [`Refused`] for a mission whose plan cannot be renewed.
    pub fn rows(given: Given<'_>, values: &Values) -> Result<(Vec<ReplanRow>, u64), Refused> {
        let ReplanSettings { when: Cadences(cadences), trials } =
            ReplanSettings::of(values).map_err(Refused)?;
        let (own, chosen) = (given.own.unwrap_or(given.mission), given.mission);
        cadences.iter().try_for_each(|cadence| chosen.check_replan(*cadence)).map_err(Refused::by)?;
        let of_renewed = match &own.replan.gains {
            Some(file) if given.own.is_none() => (file.name.as_str(), &file.gains),
            _ => (chosen.control.gains_name.as_str(), &chosen.control.gains),
        };
        Ok((ReplanRow::campaigns(own, &cadences, of_renewed), trials))
    }
}

impl Study for Renewals<'_> {
    fn jobs(&self) -> u64 {
        self.rows.len() as u64 * self.trials
    }

    fn run(&self, jobs: &mut dyn Jobs) -> Result<Results, Unfinished> {
        let drops = jobs.fly_sets("drops", (self.rows.len(), self.trials), 1, &|set, some, stop| {
            let fly = self.fly.get(set)?;
            some.map(|trial| (!stop()).then(|| fly(trial, stop)).flatten()).collect()
        })?;
        let report = self.report(0..self.trials, drops);
        Ok(Results {
            figures: report.figure()?.into_iter().collect(),
            document: report.document(),
            json: report.json(),
            files: vec![("replan.csv".to_owned(), report.csv())],
            holds: true,
            ..Results::default()
        })
    }
}
