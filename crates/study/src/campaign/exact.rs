//! Exact quantiles of a campaign's quantities, where every trial is kept: sorted in memory, or found in
//! passes over the rows where there are too many.

use super::TrialRecord;
use samara_core::assess::outcome::COUNTED;
use samara_core::assess::{QUANTILES, Quantiles, Selection};

/// The values of [`COUNTED`], in their order; what has none lies beyond all others.
#[derive(Clone, Debug, Default)]
pub struct MeasureValues([Vec<f64>; COUNTED.len()]);

impl MeasureValues {
    /// Takes a trial.
    pub fn push(&mut self, trial: &TrialRecord) {
        for (quantity, values) in COUNTED.iter().zip(&mut self.0) {
            values.push(quantity.of(&trial.outcome).unwrap_or(f64::INFINITY));
        }
    }

    /// The quantiles of each measure among all trials; `None` where that trial has no value.
    pub fn quantiles(self) -> [Quantiles; COUNTED.len()] {
        self.0.map(|mut values| {
            values.sort_unstable_by(f64::total_cmp);
            known(QUANTILES.map(|quantile| quantile.of_ascending(&values)))
        })
    }
}

/// The search for the quantiles of more trials than memory holds, in [`Selection::PASSES`] passes.
#[derive(Clone, Debug)]
pub struct MeasurePasses([Selection; COUNTED.len()]);

impl MeasurePasses {
    /// The search among so many trials.
    pub fn new(trials: u64) -> Self {
        Self(std::array::from_fn(|_| Selection::new(trials)))
    }

    /// Takes the next trial of a pass.
    pub fn push(&mut self, trial: &TrialRecord) {
        for (quantity, selection) in COUNTED.iter().zip(&mut self.0) {
            selection.push(quantity.of(&trial.outcome).unwrap_or(f64::INFINITY));
        }
    }

    /// Ends a pass over all trials.
    pub fn end_pass(&mut self) {
        self.0.iter_mut().for_each(Selection::end_pass);
    }

    /// The quantiles of each measure among all trials, after all passes; `None` where that trial has no
    /// value.
    pub fn quantiles(&self) -> [Quantiles; COUNTED.len()] {
        self.0.each_ref().map(|selection| known(selection.quantiles()))
    }
}

fn known(quantiles: Quantiles) -> Quantiles {
    quantiles.map(|x| x.filter(|x| x.is_finite()))
}
