//! Probabilities of rare failures: subset simulation over independent standard-normal coordinates.
//!
//! A score above a bound is a failure. Its probability is the product of probabilities of about a tenth: that
//! a point passes a first threshold, that one which has passed it passes the next, and so on to the bound (Au
//! and Beck 2001, <https://doi.org/10.1016/S0266-8920(01)00019-4>). Each threshold is what the best tenth of
//! the points before it reach, and those tenth begin the Markov chains that sample beyond it, by
//! preconditioned Crank-Nicolson steps whose acceptance does not fall with the number of coordinates; their
//! width follows the share that is accepted (Papaioannou et al. 2015,
//! <https://doi.org/10.1016/j.probengmech.2015.06.006>).
//!
//! How sure the product is comes from no formula for the correlation of chains: [`POPULATIONS`] populations
//! climb apart from each other, and the interval is that of their scatter; of failures so frequent that all
//! populations meet enough on their first level, whose points are independent, it is that of a share.
//!
//! | file | holds |
//! |---|---|
//! | `population` | a population on its way up |
//! | `estimate` | what populations say together: probability, interval, coefficient of variation |
//! | `nearest` | the most likely failure: the failing point nearest to the origin |

mod estimate;
mod nearest;
mod population;
#[cfg(test)]
mod tests;

use std::ops::Range;

pub use estimate::Estimate;
pub use nearest::Nearest;
pub use population::{Ascent, Level};

use crate::math;
use population::{Population, SHARE};

/// Populations that climb apart from each other.
pub const POPULATIONS: usize = 8;
/// Points of a level, of all populations, unless it is said otherwise.
pub const PER_LEVEL: usize = 6800;
/// Fewest points of a level: ten chains in each population.
pub const PER_LEVEL_LEAST: usize = 800;
/// Least probability that can be asked for.
pub const PROBABILITY_LEAST: f64 = 1e-12;

/// How a probability is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RareSearch {
    /// Score from which on a point is a failure.
    pub bound: f64,
    /// Smallest probability of interest; the search ends once failures are known to be rarer.
    pub least: f64,
    /// Points of a level, of all populations.
    pub per_level: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl RareSearch {
    /// Points of a population's level.
    fn points(&self) -> usize {
        (self.per_level.max(PER_LEVEL_LEAST) / POPULATIONS).max(1)
    }

    /// Thresholds that a population may pass: down to the least probability, and one more, so that what is
    /// rarer is known to be.
    fn thresholds(&self) -> usize {
        let needed = math::ln(self.least.clamp(PROBABILITY_LEAST, 1.0)) / math::ln(SHARE);
        (needed - 1e-9).ceil().max(0.0) as usize + 1
    }

    /// Most points that are scored on the way up.
    pub fn points_up_most(&self) -> usize {
        let points = self.points();
        let moved = points - (SHARE * points as f64).round() as usize;
        POPULATIONS * (points + self.thresholds() * moved)
    }

    /// Most points that are scored on the way up and, over so many spans, from there to the most likely
    /// failure.
    pub fn points_most(&self, spans: usize) -> usize {
        self.points_up_most() + nearest::points_most(POPULATIONS, spans)
    }

    /// Climbs to the bound over points of `dimensions` coordinates, and goes from the failures that were met
    /// to the most likely one. Along the way there a whole span of `spans` moves as one coordinate: a list
    /// of disjoint ranges that cover all. `score` gets points and gives a number for each; one that is no
    /// number is a failure.
    ///
    /// # Errors
    /// What `score` ends with.
    pub fn run<E>(
        &self,
        dimensions: usize,
        spans: &[Range<usize>],
        mut score: impl FnMut(&[Vec<f64>]) -> Result<Vec<f64>, E>,
    ) -> Result<RareFound, E> {
        let mut scored = 0u64;
        let mut score = |points: &[Vec<f64>]| {
            scored += points.len() as u64;
            let scores = score(points)?;
            Ok(scores.into_iter().map(|x| if x.is_nan() { f64::INFINITY } else { x }).collect())
        };
        let ascents = self.climb(dimensions, &mut score)?;
        let (ascents, failures): (Vec<Ascent>, Vec<Vec<Vec<f64>>>) = ascents.into_iter().unzip();
        let nearest = nearest::nearest(&failures, spans, self.bound, &mut score)?;
        Ok(RareFound { search: *self, ascents, nearest, scored })
    }

    /// All populations, level by level and step by step; each ascent with the failures that it met last.
    #[expect(clippy::type_complexity, reason = "an ascent and its points, once")]
    fn climb<E>(
        &self,
        dimensions: usize,
        score: &mut impl FnMut(&[Vec<f64>]) -> Result<Vec<f64>, E>,
    ) -> Result<Vec<(Ascent, Vec<Vec<f64>>)>, E> {
        let numbers = 0..POPULATIONS as u64;
        let mut populations: Vec<Population> =
            numbers.map(|number| Population::new(self.seed, number, self.points(), dimensions)).collect();
        loop {
            // The populations' points side by side, so that a step of all is scored at once.
            let proposed: Vec<Vec<Vec<f64>>> = populations.iter_mut().map(Population::propose).collect();
            let counts: Vec<usize> = proposed.iter().map(Vec::len).collect();
            let points: Vec<Vec<f64>> = proposed.into_iter().flatten().collect();
            if points.is_empty() {
                break;
            }
            let scores = score(&points)?;
            let (mut points, mut scores) = (points.into_iter(), scores.into_iter());
            for (population, count) in populations.iter_mut().zip(counts) {
                let taken = points.by_ref().take(count).zip(scores.by_ref().take(count)).collect();
                population.take(taken, self.bound, self.thresholds());
            }
        }
        Ok(populations.into_iter().map(|population| population.finish(self.bound)).collect())
    }
}

/// What a search found.
#[derive(Clone, Debug, PartialEq)]
pub struct RareFound {
    /// How it searched.
    pub search: RareSearch,
    /// How each population climbed.
    pub ascents: Vec<Ascent>,
    /// The most likely failure that was found; `None` without any failure.
    pub nearest: Option<Nearest>,
    /// Points that were scored, those on the way to the most likely failure included.
    pub scored: u64,
}

impl RareFound {
    /// The probability that a point fails.
    pub fn estimate(&self) -> Estimate {
        Estimate::of(&self.ascents, self.search.bound)
    }

    /// The probability that a score is at least `x`, for `x` up to the bound.
    pub fn exceedance(&self, x: f64) -> Estimate {
        Estimate::of(&self.ascents, x.min(self.search.bound))
    }

    /// Whether failures are rarer than the least probability of interest, with the interval's confidence.
    pub fn is_below(&self) -> bool {
        self.estimate().high < self.search.least
    }

    /// Points that were scored on the way up.
    pub fn climbed(&self) -> u64 {
        self.ascents.iter().map(|ascent| ascent.scored).sum()
    }
}
