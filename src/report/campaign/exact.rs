//! Exact quantiles of a campaign's quantities, where every trial is kept: sorted in memory, or found in
//! passes over the rows where there are too many.

use super::{MEASURES, TrialRecord};
use crate::assess::{QUANTILES, Quantiles, Selection};

/// The values of [`MEASURES`], in their order.
#[derive(Clone, Debug, Default)]
pub struct MeasureValues([Vec<f64>; MEASURES.len()]);

impl MeasureValues {
    /// Takes a trial.
    pub fn push(&mut self, trial: &TrialRecord) {
        for (measure, values) in MEASURES.iter().zip(&mut self.0) {
            values.extend((measure.of)(trial));
        }
    }

    /// The quantiles of each measure.
    pub fn quantiles(self) -> [Quantiles; MEASURES.len()] {
        self.0.map(|mut values| {
            values.sort_unstable_by(f64::total_cmp);
            QUANTILES.map(|quantile| quantile.of_ascending(&values))
        })
    }
}

/// The search for the quantiles of more trials than memory holds, in [`Selection::PASSES`] passes.
#[derive(Clone, Debug)]
pub struct MeasurePasses([Selection; MEASURES.len()]);

impl MeasurePasses {
    /// The search, with the number of trials that have a value of each of [`MEASURES`].
    pub fn new(counts: [u64; MEASURES.len()]) -> Self {
        Self(counts.map(Selection::new))
    }

    /// Takes the next trial of a pass.
    pub fn push(&mut self, trial: &TrialRecord) {
        for (measure, selection) in MEASURES.iter().zip(&mut self.0) {
            (measure.of)(trial).into_iter().for_each(|x| selection.push(x));
        }
    }

    /// Ends a pass over all trials.
    pub fn end_pass(&mut self) {
        self.0.iter_mut().for_each(Selection::end_pass);
    }

    /// The quantiles of each measure, after all passes.
    pub fn quantiles(&self) -> [Quantiles; MEASURES.len()] {
        self.0.each_ref().map(Selection::quantiles)
    }
}
