//! Two campaigns of one seed: means, paired differences, trials that fail in one alone.

use std::collections::BTreeSet;

use super::sides::sides;
use crate::fidelity::lines::CampaignLines;
use samara_core::assess::outcome::COUNTED;
use samara_core::assess::{Quantity, Summary};
use samara_report::columns::fixed;
use samara_report::document::{Grid, Passage};
use samara_report::json::{finite, result_objects};

/// Most trials that are named in a line.
const NAMED: usize = 10;

/// Two campaigns of one seed.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignPair {
    /// Name of the pair: that of the files.
    pub name: String,
    /// The campaigns.
    pub lines: [CampaignLines; 2],
    /// How many trials of each failed, where results beside the lines say so.
    pub told_failed: [Option<u64>; 2],
    /// Trials that both have flown.
    pub shared: BTreeSet<u64>,
    /// The quantities.
    pub quantities: Vec<QuantityPair>,
}

/// A quantity of the trials that have it in both campaigns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuantityPair {
    /// The quantity.
    pub quantity: Quantity,
    /// The values of A and of B.
    pub values: [Summary; 2],
    /// The differences, B less A, trial by trial.
    pub difference: Summary,
    /// Trials of both that have a value in one of them alone.
    pub in_one_alone: u64,
}

/// Trials of both campaigns that failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failures {
    /// How many failed in A, and in B.
    pub failed: [usize; 2],
    /// Those that failed in A alone, and in B alone.
    pub alone: [Vec<u64>; 2],
}

/// Why trials of two campaigns are no pairs.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unpaired {
    /// The seeds differ.
    #[error(
        "{name}: A is of seed {}, B of seed {}: a trial of one is another draw than that of the same number of the other, so \
         that there are no pairs; fly one of them with the other's --seed",
        seeds[0],
        seeds[1]
    )]
    Seeds {
        /// Name of the pair.
        name: String,
        /// The seeds of A and of B.
        seeds: [u64; 2],
    },
    /// No trial was flown in both.
    #[error("{0}: no trial was flown in both campaigns")]
    NoTrial(String),
}

impl CampaignPair {
    /// The pair of two campaigns; `told_failed` has how many trials of each failed by the results beside
    /// them.
    ///
    /// # Errors
    /// [`Unpaired`] where the seeds differ, or no trial was flown in both.
    pub fn new(
        name: String,
        lines: [CampaignLines; 2],
        told_failed: [Option<u64>; 2],
    ) -> Result<Self, Unpaired> {
        let [a, b] = &lines;
        if a.seed != b.seed {
            return Err(Unpaired::Seeds { name, seeds: [a.seed, b.seed] });
        }
        let shared: BTreeSet<u64> = a.trials.intersection(&b.trials).copied().collect();
        if shared.is_empty() {
            return Err(Unpaired::NoTrial(name));
        }
        let quantities = COUNTED.iter().map(|quantity| QuantityPair::of(quantity, &lines, &shared)).collect();
        Ok(Self { name, lines, told_failed, shared, quantities })
    }

    /// Which of the trials of both failed; `None` where not both campaigns' lines say so.
    pub fn failures(&self) -> Option<Failures> {
        let of_both = |lines: &CampaignLines| lines.failed.as_ref().map(|failed| failed & &self.shared);
        let [a, b] = &self.lines;
        let (a, b) = (of_both(a)?, of_both(b)?);
        let alone = [&a - &b, &b - &a].map(|alone| alone.into_iter().collect());
        Some(Failures { failed: [a.len(), b.len()], alone })
    }

    /// How many of all its trials failed, of each campaign that says so.
    fn failed(&self) -> [Option<u64>; 2] {
        let by_lines = self.lines.each_ref().map(|lines| lines.failed.as_ref().map(|f| f.len() as u64));
        [0, 1].map(|i| by_lines[i].or(self.told_failed[i]))
    }

    /// What is said of it.
    pub fn passages(&self) -> Vec<Passage> {
        let flown = |lines: &CampaignLines| {
            format!("{}: {} trials, samara {}", lines.flown, lines.trials.len(), lines.version)
        };
        let mut passages = Vec::from(sides(self.lines.each_ref().map(flown)));
        passages.push(Passage::Table(self.grid()));
        let left_out = self.quantities.iter().filter(|pair| pair.in_one_alone > 0).map(|pair| {
            let (words, n) = (pair.quantity.words, pair.in_one_alone);
            format!("{words}: {n} trials of both have it in one alone, and are left out")
        });
        passages.extend(left_out.chain(self.failure_words()).map(Passage::Remark));
        passages
    }

    /// Words on the failures, a line each.
    fn failure_words(&self) -> Vec<String> {
        if let Some(Failures { failed: [a, b], alone }) = self.failures() {
            let alone = ["A", "B"].into_iter().zip(&alone).filter(|(_, alone)| !alone.is_empty());
            let alone =
                alone.map(|(side, of)| format!("failed in {side} alone ({}): {}", of.len(), named(of)));
            return std::iter::once(format!("of the trials of both {a} failed in A, {b} in B"))
                .chain(alone)
                .collect();
        }
        let failed = self.failed();
        if failed == [Some(0); 2] {
            return vec!["no trial failed in A or B".to_owned()];
        }
        let [a, b] = failed.map(|failed| failed.map_or("an unknown number".to_owned(), |n| n.to_string()));
        vec![format!("of all trials {a} failed in A, {b} in B; not both files say which")]
    }

    fn grid(&self) -> Grid {
        let title = format!(
            "{}, seed {}: means of the {} trials of both, and of their differences, 95 %",
            self.name,
            self.lines[0].seed,
            self.shared.len()
        );
        let mut grid = Grid::new(&title, ["", "A", "B", "B - A", "from", "to", "trials"]);
        for QuantityPair { quantity, values: [a, b], difference, .. } in &self.quantities {
            let decimals = quantity.decimals_of_mean();
            let number = |x: f64| if x.is_finite() { fixed(x, decimals) } else { "-".to_owned() };
            let (low, high) = difference.mean_interval();
            let numbers = [a.mean(), b.mean(), difference.mean(), low, high].map(number);
            grid.row(&quantity.head(), numbers.into_iter().chain([difference.count().to_string()]));
        }
        grid
    }
}

impl QuantityPair {
    fn of(quantity: &Quantity, lines: &[CampaignLines; 2], shared: &BTreeSet<u64>) -> Self {
        let [a, b] = lines.each_ref().map(|lines| lines.values(quantity));
        let mut pair = Self {
            quantity: *quantity,
            values: <[Summary; 2]>::default(),
            difference: Summary::default(),
            in_one_alone: 0,
        };
        for trial in shared {
            match [a, b].map(|values| values.and_then(|values| *values.get(trial)?)) {
                [Some(a), Some(b)] => {
                    pair.values[0].push(a);
                    pair.values[1].push(b);
                    pair.difference.push(b - a);
                }
                [None, None] => {}
                _ => pair.in_one_alone += 1,
            }
        }
        pair
    }
}

/// The first of some trials.
fn named(trials: &[u64]) -> String {
    let numbers: Vec<String> = trials.iter().take(NAMED).map(u64::to_string).collect();
    let more = if trials.len() > NAMED { ", .." } else { "" };
    format!("{}{more}", numbers.join(", "))
}

result_objects! {
    /// Two campaigns of one seed, trial by trial.
    CampaignPairObject(pair: &CampaignPair) [
        let [a, b] = &pair.lines;
        let failures = pair.failures();
        let [failed_a, failed_b] = pair.failed();
        let alone = |i: usize| failures.as_ref().map(|failures| failures.alone[i].clone());
    ] {
        /// Name of the pair: that of the files.
        name: String = pair.name.clone(),
        /// Seed of everything random.
        seed: u64 = a.seed,
        /// What flew A, in words.
        flown_a: String = a.flown.clone(),
        /// What flew B, in words.
        flown_b: String = b.flown.clone(),
        /// Number of trials of A.
        trials_a: usize = a.trials.len(),
        /// Number of trials of B.
        trials_b: usize = b.trials.len(),
        /// Number of trials that both have flown.
        shared: usize = pair.shared.len(),
        /// Number of all trials of A that failed; null where nothing says.
        failed_a: Option<u64> = failed_a,
        /// Number of all trials of B that failed; null where nothing says.
        failed_b: Option<u64> = failed_b,
        /// Trials of both that failed in A alone; null where not both files say which failed.
        failed_in_a_alone: Option<Vec<u64>> = alone(0),
        /// Trials of both that failed in B alone; null likewise.
        failed_in_b_alone: Option<Vec<u64>> = alone(1),
        /// The quantities.
        quantities: Vec<QuantityPairObject> = pair.quantities.iter().map(QuantityPairObject::of).collect(),
    }

    /// A quantity of the trials that have it in both campaigns.
    QuantityPairObject(pair: &QuantityPair) [
        let [a, b] = &pair.values;
        let (low, high) = pair.difference.mean_interval();
    ] {
        /// Name of the quantity; it ends in its unit.
        name: String = pair.quantity.key.to_owned(),
        /// Number of trials that have it in both.
        count: u64 = pair.difference.count(),
        /// Number of trials of both that have it in one alone.
        in_one_alone: u64 = pair.in_one_alone,
        /// Mean of A.
        mean_a: Option<f64> = finite(a.mean()),
        /// Mean of B.
        mean_b: Option<f64> = finite(b.mean()),
        /// Mean difference, B less A.
        difference: Option<f64> = finite(pair.difference.mean()),
        /// Lower end of the interval of the mean difference.
        difference_low: Option<f64> = finite(low),
        /// Upper end of that interval.
        difference_high: Option<f64> = finite(high),
    }
}
