//! An axis of a table: its knots, and the interval between two of them that a value lies in.

use crate::real::Real;

/// Increasing knots, at least two.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    pub(crate) knots: Vec<f64>,
    /// Left knot and `1/width` of each interval.
    pub(crate) intervals: Vec<[f64; 2]>,
    /// 1/spacing if the knots are equidistant: finds the interval without a search.
    pub(crate) inverse_spacing: Option<f64>,
}

impl Axis {
    pub(crate) fn new(knots: &[f64]) -> Self {
        let n = knots.len() - 1;
        let spacing = (knots[n] - knots[0]) / n as f64;
        let even = knots.windows(2).all(|w| (w[1] - w[0] - spacing).abs() < 1e-9 * spacing);
        let intervals = knots.windows(2).map(|w| [w[0], 1.0 / (w[1] - w[0])]).collect();
        Self { knots: knots.to_vec(), intervals, inverse_spacing: even.then(|| 1.0 / spacing) }
    }

    /// Left knot of the interval that `x` lies in, from 0; the outermost one beyond the ends.
    #[inline(always)]
    pub(crate) fn interval<S: Real>(&self, x: S) -> S::Cell {
        match self.inverse_spacing {
            Some(inv) => ((x - self.knots[0]) * inv).cell(self.knots.len() - 2),
            None => x.interval(&self.knots),
        }
    }

    /// Distance from the left knot of an interval.
    #[inline(always)]
    pub(crate) fn beyond_knot<S: Real>(&self, x: S, interval: S::Cell) -> S {
        let [knot, _] = x.gather(&self.intervals, interval);
        x - knot
    }
}
