//! Results of a campaign with the mission's own gains: what a person who must decide needs to see of many
//! flights, whoever flew them.
//!
//! | file | holds |
//! |---|---|
//! | [`campaign_csv`] | every trial of a campaign, written and read again |
//! | [`only`] | one trial alone |
//! | [`tables`] | the tables, the verdict in a sentence |
//! | [`json`] | the object of `--json` and of `assess.json` |
//! | [`document`] | all that is said of them, for terminal, page and continuous integration |
//! | [`footprint`] | where the vehicles were when the plan ended, as GeoJSON and as KML |
//! | [`exact`] | exact quantiles, where every trial is kept |
//! | [`settings`] | what is asked of campaigns |

pub mod campaign_csv;
pub mod document;
pub mod exact;
pub mod footprint;
pub mod json;
pub mod only;
pub mod settings;
pub mod tables;

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::drops::DropTrial;
use samara_core::assess::judge::words;
use samara_core::assess::outcome::COUNTED;
use samara_core::assess::{
    BlockError, BlockSummary, Histogram, Limits, Outcome, Quantiles, Share, judge_trial,
};
use samara_core::tune::ReleaseCase;
use samara_mission::Mission;

/// Help of campaigns, which are one verb.
pub const HELP: &str = include_str!("help.txt");
/// Trials that a campaign keeps for its figures: the first ones.
pub const SHOWN: usize = 1000;
/// The worst trials that a campaign keeps.
const WORST: usize = 10;

/// A trial as a campaign's page shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialRecord {
    /// Number of the trial.
    pub trial: u64,
    /// What came of it.
    pub outcome: Outcome,
    /// Why the trial counts as failed, if it does.
    pub failure: Option<String>,
}

impl TrialRecord {
    /// The record of a study's flight.
    pub fn of_flight(trial: u64, outcome: &Outcome, limits: &Limits) -> Self {
        Self { trial, outcome: *outcome, failure: words(&judge_trial(outcome, limits)) }
    }

    /// The record of a whole drop; what was never released has no numbers.
    pub fn of_drop(drop: &DropTrial) -> Self {
        let outcome = drop.outcome.unwrap_or_else(Outcome::lost);
        Self { trial: drop.drawn.trial, outcome, failure: drop.failure.clone() }
    }
}

/// Which rows are kept of a campaign's trials.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Keep {
    /// Every trial's.
    All,
    /// Those of trials that failed.
    Failures,
    /// None: the statistics alone.
    Summary,
}

impl Keep {
    /// Most trials of which every row is kept unless it is said otherwise.
    pub const ALL_MOST: u64 = 1_000_000;

    /// What is kept of so many trials unless it is said otherwise.
    pub fn usual(trials: u64) -> Self {
        if trials > Self::ALL_MOST { Self::Summary } else { Self::All }
    }

    /// Whether the row of a trial that failed, or did not, is kept.
    pub fn keeps(self, failed: bool) -> bool {
        match self {
            Self::All => true,
            Self::Failures => failed,
            Self::Summary => false,
        }
    }
}

impl fmt::Display for Keep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::All => "all",
            Self::Failures => "failures",
            Self::Summary => "summary",
        })
    }
}

impl FromStr for Keep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let all = [Self::All, Self::Failures, Self::Summary];
        let named = all.into_iter().find(|keep| keep.to_string() == text);
        named.ok_or_else(|| "`all`, `failures` or `summary` is expected".to_owned())
    }
}

/// What a campaign, or a part of one, came to: statistics of all trials, the first of them and the worst.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CampaignSummary {
    /// Trials that did not fail, of all.
    pub passed: Share,
    /// Statistics of [`COUNTED`], in their order.
    pub measures: [BlockSummary; COUNTED.len()],
    /// Histograms of [`COUNTED`], in their order.
    pub histograms: [Histogram; COUNTED.len()],
    /// Exact quantiles of [`COUNTED`], where they are known.
    pub exact: Option<[Quantiles; COUNTED.len()]>,
    /// Those of the campaign's first [`SHOWN`] trials that are among these, in their order.
    pub shown: Vec<TrialRecord>,
    /// The worst ten: those that failed first, then by J_TPF; of equals the first flown.
    pub worst: Vec<TrialRecord>,
}

impl CampaignSummary {
    /// No trials yet, the first of which will be trial number `first`.
    pub fn from_trial(first: u64) -> Self {
        Self { measures: std::array::from_fn(|_| BlockSummary::from_trial(first)), ..Self::default() }
    }

    /// Takes the next trial.
    pub fn push(&mut self, trial: &TrialRecord) {
        self.passed.push(trial.failure.is_none());
        let sums = self.measures.iter_mut().zip(&mut self.histograms);
        for (quantity, (summary, histogram)) in COUNTED.iter().zip(sums) {
            let value = quantity.of(&trial.outcome);
            summary.push(value);
            value.into_iter().for_each(|x| histogram.push(x, quantity.bin_width));
        }
        if trial.trial < SHOWN as u64 {
            self.shown.push(trial.clone());
        }
        self.keep_worst(trial);
    }

    /// Takes the trials of a part that follows.
    ///
    /// # Errors
    /// [`BlockError`] where it does not follow.
    pub fn append(&mut self, part: &Self) -> Result<(), BlockError> {
        for (summary, follows) in self.measures.iter_mut().zip(&part.measures) {
            summary.append(follows)?;
        }
        self.passed.append(&part.passed);
        self.histograms.iter_mut().zip(&part.histograms).for_each(|(all, more)| all.append(more));
        self.exact = None;
        self.shown.extend_from_slice(&part.shown);
        part.worst.iter().for_each(|trial| self.keep_worst(trial));
        Ok(())
    }

    fn keep_worst(&mut self, trial: &TrialRecord) {
        let badness = |t: &TrialRecord| (t.failure.is_some(), t.outcome.j_tpf);
        let worse = |a: &TrialRecord, b: &TrialRecord| {
            let ((a_failed, a_cost), (b_failed, b_cost)) = (badness(a), badness(b));
            b_failed.cmp(&a_failed).then(b_cost.total_cmp(&a_cost)).is_lt()
        };
        let place = self.worst.iter().position(|kept| worse(trial, kept)).unwrap_or(self.worst.len());
        if place < WORST {
            self.worst.insert(place, trial.clone());
            self.worst.truncate(WORST);
        }
    }

    /// Number of the trial after the last.
    pub fn end(&self) -> u64 {
        self.measures[0].end()
    }

    /// Quantiles of the quantity at a place of [`COUNTED`] among all trials; `None` where that trial has no
    /// value.
    pub fn quantiles(&self, place: usize) -> Quantiles {
        match &self.exact {
            Some(exact) => exact[place],
            None => self.histograms[place].quantiles(COUNTED[place].bin_width, self.flown()),
        }
    }

    /// The greatest value of the quantity at a place of [`COUNTED`]; `None` where a trial has none, and
    /// without trials.
    pub fn greatest(&self, place: usize) -> Option<f64> {
        let sums = self.measures[place].summary();
        Some(sums.max()).filter(|max| max.is_finite() && sums.count() == self.flown())
    }

    /// Trials.
    pub fn flown(&self) -> u64 {
        self.passed.trials()
    }

    /// Trials that failed.
    pub fn failed(&self) -> u64 {
        self.passed.misses()
    }
}

/// A campaign with its name.
#[derive(Clone, Debug)]
pub struct NamedCampaign {
    /// Name in files: `optimal`, `step`, an autopilot's.
    pub name: String,
    /// Name for people.
    pub label: String,
    /// The trials.
    pub summary: CampaignSummary,
    /// The file with a line for each trial that is kept, if any is.
    pub file: Option<String>,
}

/// A release case, flown.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseRecord {
    /// Name of the case.
    pub case: String,
    /// The flight.
    pub flight: TrialRecord,
    /// Distance of the flight from the plan, (45).
    pub tracking_rms: f64,
}

impl CaseRecord {
    /// The record of a release case's flight and of its distance from the plan.
    pub fn of(
        number: u64,
        case: &ReleaseCase,
        (outcome, tracking_rms): (Outcome, f64),
        limits: &Limits,
    ) -> Self {
        let flight = TrialRecord::of_flight(number, &outcome, limits);
        Self { case: case.name.clone(), flight, tracking_rms }
    }
}

/// Everything that a page shows of a mission's campaigns.
#[derive(Clone, Debug)]
pub struct CampaignReport<'a> {
    /// The mission, with the chosen gains and seed.
    pub mission: &'a Mission,
    /// The pilot, in words for the page.
    pub flown_by: String,
    /// The command that makes the campaigns again.
    pub command: String,
    /// The command that, with `--only K`, flies trial K alone; `None`: no command does.
    pub alone: Option<String>,
    /// What makes a trial fail.
    pub limits: Limits,
    /// J_TPF of the plan.
    pub plan_j_tpf: f64,
    /// The campaigns; the first is judged, the others stand beside it.
    pub campaigns: Vec<NamedCampaign>,
    /// The release cases of the judged campaign; none where they were not flown.
    pub cases: Vec<CaseRecord>,
    /// Control period of the flights whose tracking RMS is reported [s].
    pub tracking_period_s: f64,
}

impl CampaignReport<'_> {
    /// The campaign that is judged.
    pub fn judged(&self) -> Option<&NamedCampaign> {
        self.campaigns.first()
    }

    /// Whether no trial of it failed, and no release case.
    pub fn safe(&self) -> bool {
        let trials =
            |campaign: &NamedCampaign| campaign.summary.flown() > 0 && campaign.summary.failed() == 0;
        self.judged().is_some_and(trials) && self.failed_case().is_none()
    }

    /// The first release case that failed, and why.
    pub fn failed_case(&self) -> Option<(&CaseRecord, &str)> {
        self.cases.iter().find_map(|case| Some((case, case.flight.failure.as_deref()?)))
    }

    /// Places of the quantities in [`COUNTED`], the one that tells the trials apart best first: by standard
    /// deviation as a share of the mean.
    pub fn telling(&self) -> Vec<usize> {
        let spread = |place: usize| {
            let of = |campaign: &NamedCampaign| {
                let s = &campaign.summary.measures[place];
                let spread = if s.count() < 2 { 0.0 } else { s.std() / s.mean().abs() };
                if spread.is_finite() { spread } else { 0.0 }
            };
            self.judged().map_or(0.0, of)
        };
        let mut places: Vec<usize> = (0..COUNTED.len()).collect();
        places.sort_by(|a, b| spread(*b).total_cmp(&spread(*a)));
        places
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(trial: u64, j_tpf: f64, failure: Option<&str>) -> TrialRecord {
        TrialRecord {
            trial,
            outcome: Outcome {
                j_tpf,
                peak_speed_m_s: 1.0,
                peak_tilt_deg: 6.0,
                steady_after_s: failure.is_none().then_some(2.0),
                altitude_lost_m: 3.0,
                ..Outcome::default()
            },
            failure: failure.map(str::to_owned),
        }
    }

    /// By hand: failures come first whatever they cost, then the dearest; of equals the first flown.
    #[test]
    fn the_worst_trials_are_kept_in_order() {
        let mut summary = CampaignSummary::default();
        for trial in 0..30u32 {
            let failure = (trial == 7).then_some("never steady");
            summary.push(&record(trial.into(), f64::from(trial % 15) / 15.0, failure));
        }
        let worst: Vec<u64> = summary.worst.iter().map(|t| t.trial).collect();
        assert_eq!(worst, [7, 14, 29, 13, 28, 12, 27, 11, 26, 10]);
        assert_eq!((summary.flown(), summary.failed()), (30, 1));
        // A trial that was never steady has no time.
        assert_eq!(summary.measures.each_ref().map(BlockSummary::count), [30, 29, 30, 30, 30]);
    }

    /// Parts in order come to the whole, with cuts inside blocks and within the trials that are shown.
    #[test]
    fn prop_parts_come_to_the_whole() {
        let flown = |from: u64, to: u64| {
            let mut summary = CampaignSummary::from_trial(from);
            for trial in from..to {
                let failure = trial.is_multiple_of(91).then_some("never steady");
                summary.push(&record(trial, (trial % 37) as f64 / 37.0, failure));
            }
            summary
        };
        let whole = flown(0, 3000);
        for cuts in [&[0, 3000][..], &[0, 1000, 3000], &[0, 1, 300, 512, 999, 1001, 2999, 3000]] {
            let mut joined = CampaignSummary::default();
            for cut in cuts.windows(2) {
                joined.append(&flown(cut[0], cut[1])).unwrap();
            }
            assert_eq!(joined, whole);
        }
        assert!(flown(0, 10).append(&flown(11, 12)).is_err());
        assert_eq!(whole.shown.len(), SHOWN);
    }

    /// By hand: without failures J_TPF is 0, 0.1 .. 0.9 in equal shares: the median is 0.4, 99 % are 0.9 or
    /// less. The exact ones take the histogram's place.
    #[test]
    fn closed_form_quantiles() {
        let mut summary = CampaignSummary::default();
        let mut values = exact::MeasureValues::default();
        for trial in 0..1000 {
            let trial = record(trial, (trial % 10) as f64 / 10.0 + 3e-6, None);
            summary.push(&trial);
            values.push(&trial);
        }
        let near =
            |[p50, p99]: Quantiles| (p50.unwrap() - 0.4).abs() < 1e-12 && (p99.unwrap() - 0.9).abs() < 1e-12;
        assert!(near(summary.quantiles(0)), "{:?}", summary.quantiles(0));
        summary.exact = Some(values.quantiles());
        assert_eq!(summary.quantiles(0), [Some(0.4 + 3e-6), Some(0.9 + 3e-6)]);
    }

    /// By hand: of 200 trials three have no time to steady flight and one of those no J_TPF. 99 % of all is
    /// the 198th, one of those without a time; of the 197 that have one it would be 2.98 s. Exact, in passes
    /// and by histogram alike.
    #[test]
    fn closed_form_trials_without_a_value_lie_beyond_all_others() {
        let mut summary = CampaignSummary::default();
        let mut values = exact::MeasureValues::default();
        let trials: Vec<TrialRecord> = (0..200)
            .map(|k| {
                let lost = k == 7;
                let j_tpf = if lost { f64::INFINITY } else { 0.5 + 1e-3 * k as f64 };
                let steady_after_s = (k % 70 != 7).then_some(1.0 + 0.01 * k as f64);
                let mut trial = record(k, j_tpf, lost.then_some("lost"));
                trial.outcome.steady_after_s = steady_after_s;
                trial
            })
            .collect();
        let mut passes = exact::MeasurePasses::new(200);
        for _ in 0..samara_core::assess::Selection::PASSES {
            trials.iter().for_each(|trial| passes.push(trial));
            passes.end_pass();
        }
        for trial in &trials {
            summary.push(trial);
            values.push(trial);
        }
        let exact = values.quantiles();
        assert_eq!(passes.quantiles(), exact);
        assert_eq!(exact[1], [Some(1.0 + 0.01 * 101.0), None]);
        // The second greatest of the 199 that have a J_TPF: the lost one is beyond.
        assert_eq!(exact[0][1], Some(0.5 + 1e-3 * 198.0));
        for (place, exact) in exact.iter().enumerate() {
            for (binned, exact) in summary.quantiles(place).iter().zip(exact) {
                assert_eq!(binned.is_some(), exact.is_some(), "{place}");
                assert!(
                    binned.zip(*exact).is_none_or(|(a, b)| (a - b).abs() <= 0.51 * COUNTED[place].bin_width)
                );
            }
        }
        assert_eq!([0, 1, 2].map(|place| summary.greatest(place)), [None, None, Some(3.0)]);
        assert_eq!(CampaignSummary::default().greatest(0), None);
    }
}
