//! Statistics of a campaign, one trial at a time: mean, standard deviation, extremes, and how sure they are.
//!
//! Nothing is kept of the trials, so a campaign may be of any length. Within a block of trials the mean and
//! the sum of squares follow Welford's recurrence, in order of the trials, the mean with what rounding takes
//! from it kept beside it; blocks are joined as a tree ([`super::blocks`]): the result depends on the trials
//! alone, and its error does not grow with their number. Intervals hold with [`CONFIDENCE`]: Student's t for
//! a mean, Clopper and Pearson's exact one for a probability.

use super::beta::beta_quantile;
use crate::math;

/// Confidence of every interval.
pub const CONFIDENCE: f64 = 0.95;

/// Mean, standard deviation and extremes of a quantity. A value that is not finite (a flight that diverged)
/// makes mean and deviation no number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    count: u64,
    mean: f64,
    /// Rounding error of `mean`, to be added.
    mean_rest: f64,
    sum_of_squares: f64,
    min: f64,
    max: f64,
}

impl Default for Summary {
    fn default() -> Self {
        let (min, max) = (f64::INFINITY, f64::NEG_INFINITY);
        Self { count: 0, mean: 0.0, mean_rest: 0.0, sum_of_squares: 0.0, min, max }
    }
}

impl Summary {
    /// Takes the next value.
    pub fn push(&mut self, x: f64) {
        self.count += 1;
        let before = (x - self.mean) - self.mean_rest;
        let change = before / self.count as f64 + self.mean_rest;
        let mean = self.mean + change;
        // Exact when the change is the smaller one, as it is but for the first few values.
        self.mean_rest = change - (mean - self.mean);
        self.mean = mean;
        self.sum_of_squares += before * ((x - self.mean) - self.mean_rest);
        self.min = self.min.min(x);
        self.max = self.max.max(x);
    }

    /// This summary with the values of another after its own (Chan, Golub and LeVeque 1979, (2.1)).
    #[must_use]
    pub fn joined(&self, other: &Self) -> Self {
        if self.count == 0 || other.count == 0 {
            return if self.count == 0 { *other } else { *self };
        }
        let count = self.count + other.count;
        let (here, there, all) = (self.count as f64, other.count as f64, count as f64);
        let apart = (other.mean - self.mean) + (other.mean_rest - self.mean_rest);
        let change = apart * (there / all) + self.mean_rest;
        let mean = self.mean + change;
        // What the sum rounds away, whichever of the two is larger (Knuth, TAOCP 2, 4.2.2, theorem B).
        let taken = mean - self.mean;
        let mean_rest = (self.mean - (mean - taken)) + (change - taken);
        let sum_of_squares =
            self.sum_of_squares + other.sum_of_squares + apart * apart * (here * (there / all));
        Self {
            count,
            mean,
            mean_rest,
            sum_of_squares,
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The numbers that make up the summary: count; mean, what rounding has taken from it, sum of squares of
    /// the differences from the mean, least and greatest value.
    pub fn parts(&self) -> (u64, [f64; 5]) {
        (self.count, [self.mean, self.mean_rest, self.sum_of_squares, self.min, self.max])
    }

    /// The summary of such numbers, as [`Summary::parts`] gives them.
    pub fn from_parts(count: u64, [mean, mean_rest, sum_of_squares, min, max]: [f64; 5]) -> Self {
        Self { count, mean, mean_rest, sum_of_squares, min, max }
    }

    /// Number of values.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean; NaN without values.
    pub fn mean(&self) -> f64 {
        if self.count == 0 { f64::NAN } else { self.mean + self.mean_rest }
    }

    /// Standard deviation, with n - 1; NaN with fewer than two values.
    pub fn std(&self) -> f64 {
        if self.count < 2 { f64::NAN } else { (self.sum_of_squares / (self.count - 1) as f64).sqrt() }
    }

    /// Least value.
    pub fn min(&self) -> f64 {
        self.min
    }

    /// Greatest value.
    pub fn max(&self) -> f64 {
        self.max
    }

    /// Student's interval of the mean: `mean +- t s/sqrt(n)`; NaN with fewer than two values.
    pub fn mean_interval(&self) -> (f64, f64) {
        if self.count < 2 {
            return (f64::NAN, f64::NAN);
        }
        let n = self.count as f64;
        let half = student_t(n - 1.0) * self.std() / n.sqrt();
        (self.mean() - half, self.mean() + half)
    }
}

/// The t with `P(|T| < t) = `[`CONFIDENCE`] for Student's distribution.
pub(super) fn student_t(nu: f64) -> f64 {
    student_t_at(CONFIDENCE, nu)
}

/// The t with `P(|T| < t) = confidence` for Student's distribution: `T^2/(nu + T^2)` is a beta variable.
pub(super) fn student_t_at(confidence: f64, nu: f64) -> f64 {
    let y = beta_quantile(confidence, 0.5, 0.5 * nu);
    (nu * y / (1.0 - y)).sqrt()
}

/// How often something holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    hits: u64,
    trials: u64,
}

impl Share {
    /// Takes the next trial.
    pub fn push(&mut self, hit: bool) {
        self.trials += 1;
        self.hits += u64::from(hit);
    }

    /// The share of so many hits among so many trials; more hits than trials are as many.
    pub fn of(hits: u64, trials: u64) -> Self {
        Self { hits: hits.min(trials), trials }
    }

    /// Takes the trials of another share.
    pub fn append(&mut self, other: &Self) {
        self.trials += other.trials;
        self.hits += other.hits;
    }

    /// Trials.
    pub fn trials(&self) -> u64 {
        self.trials
    }

    /// Trials in which it held.
    pub fn hits(&self) -> u64 {
        self.hits
    }

    /// Trials in which it did not hold.
    pub fn misses(&self) -> u64 {
        self.trials - self.hits
    }

    /// Estimated probability; NaN without trials.
    pub fn probability(&self) -> f64 {
        self.hits as f64 / self.trials as f64
    }

    /// Clopper and Pearson's interval: the probabilities under which so few, or so many, hits are no rarer
    /// than half of what [`CONFIDENCE`] leaves. It is exact: it covers the true probability at least that
    /// often.
    pub fn interval(&self) -> (f64, f64) {
        self.interval_at(CONFIDENCE)
    }

    /// [`Share::interval`] at another confidence.
    pub fn interval_at(&self, confidence: f64) -> (f64, f64) {
        let tail = 0.5 * (1.0 - confidence);
        let (k, n) = (self.hits as f64, self.trials as f64);
        let low = if self.hits == 0 { 0.0 } else { beta_quantile(tail, k, n - k + 1.0) };
        let high = if self.hits == self.trials { 1.0 } else { beta_quantile(1.0 - tail, k + 1.0, n - k) };
        (low, high)
    }
}

/// Upper bound of the rate of events that come by themselves, of which `events` were seen in `time`, in
/// events per unit of that time: the rate under which so few are as rare as what [`CONFIDENCE`] leaves
/// (Garwood 1936, one-sided). Without any it is `-ln(0.05)/time`.
pub fn rate_bound(events: u64, time: f64) -> f64 {
    let left = 1.0 - CONFIDENCE;
    // P(N <= events) of Poisson's distribution.
    let so_few = |mean: f64| {
        let (mut term, mut sum) = (math::exp(-mean), 0.0);
        for k in 0..=events {
            sum += term;
            term *= mean / (k + 1) as f64;
        }
        sum
    };
    let (mut low, mut high) = (events as f64, events as f64 + 10.0 * (events as f64 + 1.0).sqrt());
    // From some 700 on the terms are below the least number; Wilson and Hilferty's cube is close there.
    if events > 500 {
        let n = events as f64 + 1.0;
        let z = 1.644_853_626_951_472_2;
        let root = 1.0 - 1.0 / (9.0 * n) + z / (3.0 * n.sqrt());
        return n * root * root * root / time;
    }
    while high - low > 1e-12 * high {
        let middle = 0.5 * (low + high);
        if !(low < middle && middle < high) {
            break;
        }
        if so_few(middle) > left { low = middle } else { high = middle }
    }
    high / time
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(values: impl IntoIterator<Item = f64>) -> Summary {
        let mut s = Summary::default();
        values.into_iter().for_each(|x| s.push(x));
        s
    }

    /// n equal steps of h from a: mean a + h (n-1)/2, variance h^2 n (n+1)/12; far from zero, where sums of
    /// squares fail.
    #[test]
    fn closed_form_evenly_spaced_values() {
        let (n, h, a) = (100_000, 1e-3, 1e6);
        let s = summary((0..n).map(|i| a + h * f64::from(i)));
        let (mean, n) = (a + h * f64::from(n - 1) / 2.0, f64::from(n));
        assert!((s.mean() / mean - 1.0).abs() < 1e-14);
        assert!((s.std() / (h * h * n * (n + 1.0) / 12.0).sqrt() - 1.0).abs() < 1e-9);
        assert_eq!((s.min(), s.count()), (a, 100_000));
    }

    /// With one degree of freedom T is Cauchy's: t = tan(0.95 pi/2). With two: t = sqrt(2 c^2/(1 - c^2)), c =
    /// 0.95.
    #[test]
    fn closed_form_student() {
        assert!((student_t(1.0) - math::tan(0.95 * std::f64::consts::FRAC_PI_2)).abs() < 1e-9);
        assert!((student_t(2.0) - (2.0 * 0.9025f64 / 0.0975).sqrt()).abs() < 1e-10);
        // Printed tables.
        assert!((student_t(99.0) - 1.984_216_951).abs() < 1e-8);
        assert!((student_t(99_999.0) - 1.959_987_7).abs() < 1e-6);
        let (low, high) = summary([1.0, 3.0]).mean_interval();
        assert!((high - 2.0 - student_t(1.0)).abs() < 1e-12 && (low + high - 4.0).abs() < 1e-12);
    }

    /// All of n: from 0.025^(1/n) to 1.
    #[test]
    fn closed_form_all_safe() {
        for n in [1u64, 100, 100_000] {
            let share = Share { hits: n, trials: n };
            let (low, high) = share.interval();
            assert!((low - math::powf(0.025f64, 1.0 / n as f64)).abs() < 1e-12, "{n}: {low}");
            assert_eq!((high, share.misses()), (1.0, 0));
            assert_eq!(Share { hits: 0, trials: n }.interval().0, 0.0);
        }
        // 8 of 10, as printed in tables of the interval.
        let (low, high) = Share { hits: 8, trials: 10 }.interval();
        assert!((low - 0.443_904_5).abs() < 1e-6 && (high - 0.974_789_3).abs() < 1e-6, "{low} {high}");
    }

    /// None in 3000 h: -ln(0.05)/3000; one and ten: half the quantiles of chi^2 with 4 and 22 degrees of
    /// freedom, 9.487729 and 33.924438, as printed in tables. Where the sum gives way to the cube one event
    /// more is `1 + z/(2 sqrt(n)) = 1.037` more.
    #[test]
    fn closed_form_rates_of_rare_events() {
        assert!((rate_bound(0, 3000.0) + math::ln(0.05) / 3000.0).abs() < 1e-15);
        assert!((rate_bound(1, 1.0) - 0.5 * 9.487_729).abs() < 1e-6);
        assert!((rate_bound(10, 2.0) - 0.25 * 33.924_438).abs() < 1e-6);
        let by_sum = rate_bound(500, 1.0);
        let beyond = rate_bound(501, 1.0);
        assert!((beyond - by_sum - 1.037).abs() < 0.003, "{by_sum} {beyond}");
    }

    /// Joined parts are the whole: count and extremes exactly, mean and deviation as evenly spaced values far
    /// from zero have them; nothing joined is nothing.
    #[test]
    fn closed_form_joined_parts() {
        let (n, h, a) = (100_000, 1e-3, 1e6);
        let part = |from: i32, to: i32| summary((from..to).map(|i| a + h * f64::from(i)));
        let s = part(0, 7).joined(&part(7, 60_000)).joined(&part(60_000, n));
        let (mean, n) = (a + h * f64::from(n - 1) / 2.0, f64::from(n));
        assert!((s.mean() / mean - 1.0).abs() < 1e-15, "{}", s.mean() - mean);
        assert!((s.std() / (h * h * n * (n + 1.0) / 12.0).sqrt() - 1.0).abs() < 1e-9);
        assert_eq!((s.count(), s.min(), s.max()), (100_000, a, a + h * 99_999.0));
        let none = Summary::default();
        assert_eq!((none.joined(&s), s.joined(&none), none.joined(&none)), (s, s, none));
        let (count, parts) = s.parts();
        assert_eq!(Summary::from_parts(count, parts), s);
        let lost = summary([0.5, f64::INFINITY]).joined(&summary([0.25]));
        assert!(!lost.mean().is_finite() && lost.max() == f64::INFINITY && lost.min() == 0.25);
    }

    #[test]
    fn what_diverges_is_not_averaged_away() {
        let s = summary([0.5, f64::INFINITY, 0.5]);
        assert!(!s.mean().is_finite() && s.max() == f64::INFINITY && s.min() == 0.5);
        assert!(summary([]).mean().is_nan() && summary([1.0]).std().is_nan());
    }
}
