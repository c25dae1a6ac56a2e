//! What populations that climbed apart from each other say together.

use super::population::Ascent;
use crate::assess::statistics::{Summary, student_t};
use crate::math;

/// A probability, and how sure it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean of what the populations found.
    pub probability: f64,
    /// Lower end of the interval that holds the probability with 95 % confidence.
    pub low: f64,
    /// Upper end of that interval.
    pub high: f64,
    /// Coefficient of variation of the mean, by the scatter of the populations; infinite where none met the
    /// event.
    pub variation: f64,
}

impl Estimate {
    /// The probability that a score is at least `x`. The interval takes the logarithm of the mean as normal,
    /// with Student's t for the few populations. Where none met the event its upper end is that of a score
    /// which half of them passed and the others came close to: the middle of their highest thresholds.
    pub(super) fn of(ascents: &[Ascent], x: f64) -> Self {
        let at = |x: f64| {
            let mut found = Summary::default();
            ascents.iter().for_each(|ascent| found.push(ascent.exceedance(x)));
            found
        };
        let found = at(x);
        if found.max() > 0.0 {
            return Self::of_scatter(&found);
        }
        let mut tops: Vec<f64> = ascents.iter().map(Ascent::top).collect();
        tops.sort_by(f64::total_cmp);
        let middle = tops.get(tops.len() / 2).copied().unwrap_or(f64::NEG_INFINITY);
        let passed = Self::of_scatter(&at(middle.min(x)));
        Self { probability: 0.0, low: 0.0, high: passed.high, variation: f64::INFINITY }
    }

    fn of_scatter(found: &Summary) -> Self {
        let (mean, n) = (found.mean(), found.count() as f64);
        if !(mean > 0.0) || found.count() < 2 {
            return Self { probability: mean, low: 0.0, high: 1.0, variation: f64::INFINITY };
        }
        let variation = found.std() / n.sqrt() / mean;
        let half = student_t(n - 1.0) * math::ln_1p(variation * variation).sqrt();
        let (low, high) = (mean * math::exp(-half), (mean * math::exp(half)).min(1.0));
        Self { probability: mean, low, high, variation }
    }
}
