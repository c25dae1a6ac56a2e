//! Statistics of a part as JSON, to the last bit: what is not finite stands as text.

use serde::{Deserialize, Serialize};

use super::ShardError;
use crate::campaign::{CampaignSummary, TrialRecord};
use crate::drops::DropTally;
use samara_core::assess::{BlockNode, BlockSummary, Histogram, Share, Summary};
use samara_report::outcome::OutcomeRecord;

/// Statistics of one campaign's part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyPart {
    /// Name of the campaign.
    pub name: String,
    /// The statistics.
    pub summary: SummaryRecord,
    /// Lines of the first trials, as in the campaign's CSV file, where they are of this part.
    pub shown: Vec<String>,
}

/// Statistics of a part of a campaign of whole drops.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DropsPart {
    /// What the page is made of.
    pub summary: SummaryRecord,
    /// What the table is made of.
    pub tally: DropTallyRecord,
}

/// A number of any kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
enum Number {
    Finite(f64),
    Other(String),
}

impl From<f64> for Number {
    fn from(x: f64) -> Self {
        if x.is_finite() { Self::Finite(x) } else { Self::Other(x.to_string()) }
    }
}

impl From<&Number> for f64 {
    fn from(number: &Number) -> Self {
        match number {
            Number::Finite(x) => *x,
            Number::Other(text) => text.parse().unwrap_or(Self::NAN),
        }
    }
}

/// The sums of a quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BlocksRecord {
    head: Vec<Option<f64>>,
    /// Level, count, and the numbers of the summary.
    nodes: Vec<(u32, u64, [Number; 5])>,
    tail: Vec<Option<f64>>,
}

impl BlocksRecord {
    fn of(sums: &BlockSummary) -> Self {
        let (head, nodes, tail) = sums.parts();
        let node = |node: &BlockNode| {
            let (count, numbers) = node.summary.parts();
            (node.level, count, numbers.map(Number::from))
        };
        Self { head: head.to_vec(), nodes: nodes.iter().map(node).collect(), tail: tail.to_vec() }
    }

    fn sums(&self, first: u64) -> Result<BlockSummary, ShardError> {
        let node = |(level, count, numbers): &(u32, u64, [Number; 5])| BlockNode {
            level: *level,
            summary: Summary::from_parts(*count, numbers.each_ref().map(f64::from)),
        };
        let nodes: Vec<BlockNode> = self.nodes.iter().map(node).collect();
        Ok(BlockSummary::from_parts(first, &self.head, &nodes, &self.tail)?)
    }
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TrialRow {
    trial: u64,
    outcome: OutcomeRecord,
    failure: Option<String>,
}

impl From<&TrialRecord> for TrialRow {
    fn from(t: &TrialRecord) -> Self {
        Self { trial: t.trial, outcome: OutcomeRecord(t.outcome), failure: t.failure.clone() }
    }
}

impl From<&TrialRow> for TrialRecord {
    fn from(t: &TrialRow) -> Self {
        Self { trial: t.trial, outcome: t.outcome.0, failure: t.failure.clone() }
    }
}

/// [`CampaignSummary`] of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SummaryRecord {
    first: u64,
    passed: u64,
    trials: u64,
    measures: Vec<BlocksRecord>,
    /// Bins that hold a value, with how many.
    histograms: Vec<Vec<(i32, u64)>>,
    shown: Vec<TrialRow>,
    worst: Vec<TrialRow>,
}

impl SummaryRecord {
    /// The record of a part.
    pub fn of(summary: &CampaignSummary) -> Self {
        Self {
            first: summary.measures[0].first(),
            passed: summary.passed.hits(),
            trials: summary.passed.trials(),
            measures: summary.measures.iter().map(BlocksRecord::of).collect(),
            histograms: summary.histograms.iter().map(|histogram| histogram.bins().collect()).collect(),
            shown: summary.shown.iter().map(TrialRow::from).collect(),
            worst: summary.worst.iter().map(TrialRow::from).collect(),
        }
    }

    /// Trials that failed.
    pub fn failed(&self) -> u64 {
        self.trials.saturating_sub(self.passed)
    }

    /// The part, which must be that of these trials.
    ///
    /// # Errors
    /// [`ShardError`] where it is not.
    pub fn summary(&self, trials: &std::ops::Range<u64>) -> Result<CampaignSummary, ShardError> {
        let sums = self.measures.iter().map(|sums| sums.sums(self.first)).collect::<Result<Vec<_>, _>>()?;
        let of = |sums: &BlockSummary| sums.first() == trials.start && sums.end() == trials.end;
        if !sums.iter().all(of) || self.trials != trials.end - trials.start || self.passed > self.trials {
            return Err(ShardError::NotAShard("statistics of its trials".into()));
        }
        let measures = sums.try_into().map_err(|_| ShardError::NotAShard("as many quantities".into()))?;
        let histograms: Vec<Histogram> =
            self.histograms.iter().map(|bins| Histogram::of(bins.iter().copied())).collect();
        Ok(CampaignSummary {
            passed: Share::of(self.passed, self.trials),
            measures,
            histograms: histograms
                .try_into()
                .map_err(|_| ShardError::NotAShard("as many histograms".into()))?,
            exact: None,
            shown: self.shown.iter().map(TrialRecord::from).collect(),
            worst: self.worst.iter().map(TrialRecord::from).collect(),
        })
    }
}

/// [`DropTally`] of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DropTallyRecord {
    measures: Vec<BlocksRecord>,
    failures: Vec<(u64, String)>,
}

impl DropTallyRecord {
    /// The record of a part.
    pub fn of(tally: &DropTally) -> Self {
        let (measures, failures) = tally.parts();
        Self { measures: measures.iter().map(BlocksRecord::of).collect(), failures: failures.to_vec() }
    }

    /// Trials that failed.
    pub fn failed(&self) -> u64 {
        self.failures.len() as u64
    }

    /// The part, which must be that of these trials.
    ///
    /// # Errors
    /// [`ShardError`] where it is not.
    pub fn tally(self, trials: &std::ops::Range<u64>) -> Result<DropTally, ShardError> {
        let sums = self.measures.iter().map(|sums| sums.sums(trials.start)).collect::<Result<Vec<_>, _>>()?;
        if sums.iter().any(|sums| sums.end() != trials.end) {
            return Err(ShardError::NotAShard("statistics of its trials".into()));
        }
        let sums = sums.try_into().map_err(|_| ShardError::NotAShard("as many quantities".into()))?;
        Ok(DropTally::from_parts(trials.end - trials.start, sums, self.failures))
    }
}
