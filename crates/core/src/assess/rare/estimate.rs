//! What populations that climbed apart from each other say together.

use super::population::{Ascent, Level};
use crate::assess::statistics::{Share, Summary, student_t};
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
    /// The probability that a score is at least `x`. Where all populations know it from their first level its
    /// points are independent, and the interval is Clopper and Pearson's of all of them together.
    ///
    /// From higher levels it is that of the populations' scatter. What a population finds is a product of
    /// shares, whose logarithm is taken as normal: the interval is symmetric in the logarithm around the
    /// arithmetic mean, by Cox's variance of the mean of log-normal numbers, with Student's t for the few
    /// populations (Zhou and Gao 1997, Statistics in Medicine 16, 783-790, who centre it on Cox's own
    /// estimate of that mean); the plain scatter of so skewed numbers makes it too short. Where none met the
    /// event its upper end is that of a score which half of them passed and the others came close to: the
    /// middle of their highest thresholds.
    pub(super) fn of(ascents: &[Ascent], x: f64) -> Self {
        if let Some(share) = on_first_level(ascents, x) {
            return Self::of_share(&share);
        }
        let at = |x: f64| ascents.iter().map(|ascent| ascent.exceedance(x)).collect::<Vec<f64>>();
        let found = at(x);
        if found.iter().any(|p| *p > 0.0) {
            return Self::of_scatter(&found, least_variance(ascents, x));
        }
        let mut tops: Vec<f64> = ascents.iter().map(Ascent::top).collect();
        tops.sort_by(f64::total_cmp);
        let middle = tops.get(tops.len() / 2).copied().unwrap_or(f64::NEG_INFINITY).min(x);
        let passed = Self::of_scatter(&at(middle), least_variance(ascents, middle));
        Self { probability: 0.0, low: 0.0, high: passed.high, variation: f64::INFINITY }
    }

    fn of_share(share: &Share) -> Self {
        let (probability, (low, high)) = (share.probability(), share.interval());
        let variation = ((1.0 - probability) / share.hits() as f64).sqrt();
        Self { probability, low, high, variation: if share.hits() > 0 { variation } else { f64::INFINITY } }
    }

    /// Of what the populations found; `least` is the variance of the mean's logarithm that takes the place of
    /// the scatter where all found the same.
    fn of_scatter(found: &[f64], least: f64) -> Self {
        let summary = |values: &mut dyn Iterator<Item = f64>| {
            let mut summary = Summary::default();
            values.for_each(|value| summary.push(value));
            summary
        };
        let plain = summary(&mut found.iter().copied());
        let (mean, n) = (plain.mean(), found.len() as f64);
        if !(mean > 0.0) || found.len() < 2 {
            return Self { probability: mean, low: 0.0, high: 1.0, variation: f64::INFINITY };
        }
        let scattered = plain.max() > plain.min();
        let variation = if scattered { plain.std() / n.sqrt() / mean } else { least.sqrt() };
        // Of one that met no event there is no logarithm.
        let by_scatter = math::ln_1p(variation * variation);
        let variance = if plain.min() > 0.0 {
            let s2 = summary(&mut found.iter().map(|p| math::ln(*p))).std().powi(2);
            (s2 / n + s2 * s2 / (2.0 * (n - 1.0))).max(by_scatter)
        } else {
            by_scatter
        };
        let half = student_t(n - 1.0) * variance.sqrt();
        let (low, high) = (mean * math::exp(-half), (mean * math::exp(half)).min(1.0));
        Self { probability: mean, low, high, variation }
    }
}

/// How many of all points reach `x`, where every population knows that from its first level.
fn on_first_level(ascents: &[Ascent], x: f64) -> Option<Share> {
    let mut all = Share::default();
    for ascent in ascents {
        let (number, level) = ascent.level_at(x)?;
        if number > 0 {
            return None;
        }
        all.append(&Share::of(level.reached(x) as u64, level.scores.len() as u64));
    }
    (all.trials() > 0).then_some(all)
}

/// The variance that the logarithm of the populations' mean had if the points of each level were independent:
/// `(1 - p)/(p n)` for a level of n points of which a share p reaches what is above.
fn least_variance(ascents: &[Ascent], x: f64) -> f64 {
    let of_level = |level: &Level, reached: usize| {
        let (reached, points) = (reached as f64, level.scores.len() as f64);
        // Of all it is said as if one more had not.
        if reached > 0.0 { (points - reached).max(1.0) / (reached * points) } else { 0.0 }
    };
    let of_ascent = |ascent: &Ascent| {
        let Some((number, level)) = ascent.level_at(x) else { return 0.0 };
        let below = ascent.levels.windows(2).take(number);
        let below = below.map(|two| of_level(&two[0], two[0].reached(two[1].threshold)));
        below.sum::<f64>() + of_level(level, level.reached(x))
    };
    let count = ascents.len().max(1) as f64;
    ascents.iter().map(of_ascent).sum::<f64>() / (count * count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, Stream};

    /// Of eight log-normal numbers with a mean of 1, as scattered as those of the flights that
    /// docs/rare_events.md tells of (0.63) and with more than twice that, so many of the intervals hold 1,
    /// within three deviations of 20 000 tries: 94.6 and 91.3 %, by 200 000 tries in numpy.
    #[test]
    fn reference_intervals_of_skewed_numbers_cover() {
        const TRIES: u64 = 20_000;
        for (sigma, expected) in [(0.63, 0.946), (1.5, 0.913)] {
            let covers = |k: u64| {
                let mut stream = Stream::new(11, Purpose::Dice, k);
                let found: Vec<f64> =
                    (0..8).map(|_| math::exp(sigma * stream.normal() - 0.5 * sigma * sigma)).collect();
                let estimate = Estimate::of_scatter(&found, 0.0);
                estimate.low <= 1.0 && 1.0 <= estimate.high
            };
            let share = (0..TRIES).filter(|k| covers(*k)).count() as f64 / TRIES as f64;
            assert!((share - expected).abs() < 0.006, "{sigma}: {share}");
        }
    }

    /// One number that is zero has no logarithm: the scatter alone decides.
    #[test]
    fn a_population_without_the_event_widens_the_interval() {
        let some = Estimate::of_scatter(&[1e-4, 1.1e-4, 1e-4, 1e-4], 0.0);
        let fewer = Estimate::of_scatter(&[1e-4, 1.1e-4, 1e-4, 0.0], 0.0);
        assert!(fewer.low < 0.75e-4 && fewer.high > 1e-4, "{fewer:?}");
        assert!(some.low < some.high && fewer.high - fewer.low > some.high - some.low, "{some:?} {fewer:?}");
    }

    /// An ascent whose levels have so many points at the next threshold, of so many: level k at k + 1, the
    /// others at k + 1/2.
    fn ascent(reached: &[(usize, usize)]) -> Ascent {
        let mut probability = 1.0;
        let level = |(k, (above, points)): (usize, &(usize, usize))| {
            let scores: Vec<f64> =
                (0..*points).map(|i| k as f64 + if i < *above { 1.0 } else { 0.5 }).collect();
            let level = Level {
                threshold: if k == 0 { f64::NEG_INFINITY } else { k as f64 },
                probability,
                scores,
                accepted: 1.0,
            };
            probability *= *above as f64 / *points as f64;
            level
        };
        Ascent { levels: reached.iter().enumerate().map(level).collect(), scored: 0, stalled: false }
    }

    /// Populations that found the same have an interval that is that of independent points: by hand
    /// `(0.9/10 + 0.8/20)/8` for eight of a hundred points, of which a tenth and then a fifth go on.
    #[test]
    fn closed_form_equal_populations_have_an_interval() {
        let ascents = vec![ascent(&[(10, 100), (20, 100)]); 8];
        let Estimate { probability, low, high, variation } = Estimate::of(&ascents, 2.0);
        let by_hand = ((0.9 / 10.0 + 0.8 / 20.0) / 8.0f64).sqrt();
        assert!((probability - 0.02).abs() < 1e-12 && (variation - by_hand).abs() < 1e-12, "{variation}");
        let half = student_t(7.0) * math::ln_1p(by_hand * by_hand).sqrt();
        assert!((math::ln(high / probability) - half).abs() < 1e-12, "{high}");
        assert!((math::ln(probability / low) - half).abs() < 1e-12, "{low}");
    }

    /// Points of first levels are pooled, whatever each population found: 0.025^(1/800) for all of 800, and
    /// as printed in tables 0.4439 to 0.9748 for 8 of 10.
    #[test]
    fn closed_form_first_levels_are_pooled() {
        let all = Estimate::of(&vec![ascent(&[(100, 100)]); 8], 1.0);
        assert!((all.low - math::powf(0.025, 1.0 / 800.0)).abs() < 1e-12 && all.high == 1.0, "{all:?}");
        let some = Estimate::of(&[ascent(&[(5, 5)]), ascent(&[(3, 5), (1, 5)])], 0.9);
        assert_eq!(some.variation, Estimate::of_share(&Share::of(8, 10)).variation);
        assert!((some.low - 0.443_904_5).abs() < 1e-6 && (some.high - 0.974_789_3).abs() < 1e-6, "{some:?}");
        let none = Estimate::of(&vec![ascent(&[(0, 100)]); 8], 5.0);
        assert!((none.high - (1.0 - math::powf(0.025, 1.0 / 800.0))).abs() < 1e-12 && none.low == 0.0);
    }
}
