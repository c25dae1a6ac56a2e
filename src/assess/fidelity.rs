//! What a costly way to fly a campaign says of its trials, with the help of cheaper ways that have flown the
//! same trials and many more: control variates over rungs of fidelity, and the bound from the value of a
//! cheaper rung to that of the costly one.
//!
//! With C a quantity in the costly rung and B in the next cheaper one, both on n trials,
//!
//! ```text
//! C^ = mean_n(C) + beta (M_B - mean_n(B)),   beta = S_BC / S_BB,
//! var C^ = s_e^2 (1/n + (M_B - mean_n(B))^2 / S_BB) + beta^2 var M_B
//! ```
//!
//! where `s_e^2` is the variance of what the line leaves, with n - 2, and M_B the mean of B over all its
//! trials, or estimated in turn with the help of a rung that is cheaper still (Glasserman 2003, section 4.1;
//! Peherstorfer, Willcox and Gunzburger 2016, doi:10.1137/15M1046472). B's trials contain the n as a part:
//! with `C = a + beta B + e` the mean of e and that of B are uncorrelated, so the two variances add.

use std::collections::BTreeMap;

use super::chosen::quantile_rank;
use super::statistics::{Summary, student_t};

/// Fewest trials that two rungs must share.
pub const FEWEST_SHARED: u64 = 8;

/// A quantity by the number of the trial; a trial in which it has no value is left out.
pub type ByTrial = BTreeMap<u64, f64>;

/// A mean with the variance of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanEstimate {
    /// The mean.
    pub mean: f64,
    /// Variance of its error.
    pub variance: f64,
    /// Degrees of freedom of that variance.
    pub degrees: f64,
    /// Trials of the rung that it is the mean of.
    pub trials: u64,
}

impl MeanEstimate {
    /// The mean of values that are drawn alike, without help; its variance is NaN with fewer than two.
    fn plain(values: &ByTrial) -> Self {
        let mut summary = Summary::default();
        values.values().for_each(|x| summary.push(*x));
        let (trials, std) = (summary.count(), summary.std());
        let n = trials as f64;
        Self { mean: summary.mean(), variance: std * std / n, degrees: n - 1.0, trials }
    }

    /// Half of the interval that covers the mean with [`CONFIDENCE`](super::CONFIDENCE), by Student's t.
    pub fn half_width(&self) -> f64 {
        student_t(self.degrees) * self.variance.sqrt()
    }

    /// That interval.
    pub fn interval(&self) -> (f64, f64) {
        (self.mean - self.half_width(), self.mean + self.half_width())
    }
}

/// How a rung goes with the next cheaper one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Trials that both have flown, with a value in both.
    pub shared: u64,
    /// Correlation of their values.
    pub correlation: f64,
    /// The line's slope beta; 0 where the cheaper rung has one value only.
    pub slope: f64,
}

impl Agreement {
    /// The share of its width that an interval keeps at the least, however many trials the cheaper rung
    /// flies: `sqrt(1 - rho^2)`.
    pub fn least_width(&self) -> f64 {
        (1.0 - self.correlation * self.correlation).max(0.0).sqrt()
    }
}

/// A mean in the costliest of several rungs, without and with the help of the others.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanByRungs {
    /// Without.
    pub plain: MeanEstimate,
    /// With.
    pub helped: MeanEstimate,
    /// Each rung and the next cheaper one, the costliest first.
    pub agreements: Vec<Agreement>,
}

impl MeanByRungs {
    /// The mean of `costly`, by rungs that are each cheaper than the one before; a rung's own where the help
    /// of those makes its interval no narrower. `None` where two neighbours share fewer than
    /// [`FEWEST_SHARED`] trials.
    pub fn of(costly: &ByTrial, cheaper: &[&ByTrial]) -> Option<Self> {
        let rungs: Vec<&ByTrial> = std::iter::once(costly).chain(cheaper.iter().copied()).collect();
        let mut helped = MeanEstimate::plain(rungs.last()?);
        let mut agreements = Vec::new();
        for pair in rungs.windows(2).rev() {
            let (estimate, agreement) = help(pair[0], pair[1], &helped)?;
            let own = MeanEstimate::plain(pair[0]);
            helped = if estimate.half_width() < own.half_width() { estimate } else { own };
            agreements.insert(0, agreement);
        }
        Some(Self { plain: MeanEstimate::plain(costly), helped, agreements })
    }

    /// By how much the helped interval is narrower than the plain one; 1 where nothing helps.
    pub fn narrower(&self) -> f64 {
        self.plain.half_width() / self.helped.half_width()
    }
}

/// The mean of `costly` by the mean of `cheap`, which is known from more trials.
fn help(costly: &ByTrial, cheap: &ByTrial, known: &MeanEstimate) -> Option<(MeanEstimate, Agreement)> {
    let shared: Vec<(f64, f64)> =
        costly.iter().filter_map(|(trial, c)| Some((*cheap.get(trial)?, *c))).collect();
    let (mut b, mut c) = (Summary::default(), Summary::default());
    for (of_cheap, of_costly) in &shared {
        b.push(*of_cheap);
        c.push(*of_costly);
    }
    if b.count() < FEWEST_SHARED {
        return None;
    }
    let n = b.count() as f64;
    let (mut bb, mut bc, mut cc) = (0.0, 0.0, 0.0);
    for (of_cheap, of_costly) in &shared {
        let (db, dc) = (of_cheap - b.mean(), of_costly - c.mean());
        bb += db * db;
        bc += db * dc;
        cc += dc * dc;
    }
    let slope = if bb > 0.0 { bc / bb } else { 0.0 };
    let left = (cc - slope * bc).max(0.0) / (n - 2.0);
    let away = known.mean - b.mean();
    let leverage = if bb > 0.0 { away * away / bb } else { 0.0 };
    let estimate = MeanEstimate {
        mean: c.mean() + slope * away,
        variance: left * (1.0 / n + leverage) + slope * slope * known.variance,
        degrees: n - 2.0,
        trials: b.count(),
    };
    let correlation = if bb > 0.0 && cc > 0.0 { bc / (bb * cc).sqrt() } else { 0.0 };
    Some((estimate, Agreement { shared: b.count(), correlation, slope }))
}

/// How far above the cheaper rung's value that of the costly one stays in the next trial, with a probability
/// of at least `confidence`, over the draw of the trials that it was calibrated on and of the next: the value
/// of rank `ceil((n + 1) confidence)` of n excesses `C - B`, whatever their distribution (split conformal
/// prediction; Lei et al. 2018, doi:10.1080/01621459.2017.1307116, theorem 2.2). An excess may be infinite,
/// where C has no value and B has. `None` where n is too small for the rank.
pub fn conformal_margin(excesses: &[f64], confidence: f64) -> Option<f64> {
    let mut ascending = excesses.to_vec();
    ascending.sort_by(f64::total_cmp);
    let rank = quantile_rank(ascending.len() + 1, confidence);
    ascending.get(rank - 1).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    fn by_trial(values: impl IntoIterator<Item = f64>) -> ByTrial {
        (0..).zip(values).collect()
    }

    /// Where the costly rung is a line of the cheap one, its mean is that line of the known mean, exactly,
    /// and the interval is the cheap one's by the slope.
    #[test]
    fn closed_form_a_line_needs_no_more_trials() {
        let cheap = by_trial((0..1000).map(|k| f64::from(k * 7919 % 1000)));
        let costly: ByTrial = cheap.iter().take(20).map(|(k, b)| (*k, 3.0 - 2.0 * b)).collect();
        let found = MeanByRungs::of(&costly, &[&cheap]).unwrap();
        assert!((found.helped.mean - (3.0 - 2.0 * 499.5)).abs() < 1e-9, "{found:?}");
        let alone = MeanEstimate::plain(&cheap);
        assert!((found.helped.variance / (4.0 * alone.variance) - 1.0).abs() < 1e-9);
        assert!((found.agreements[0].correlation + 1.0).abs() < 1e-12);
        assert!(found.agreements[0].least_width() < 1e-6 && (found.agreements[0].slope + 2.0).abs() < 1e-12);
    }

    /// A cheap rung that has flown the same trials and no more adds nothing.
    #[test]
    fn closed_form_no_more_trials_no_help() {
        let mut dice = Stream::new(1, 1);
        let cheap = by_trial((0..50).map(|_| dice.normal()));
        let costly: ByTrial = cheap.iter().map(|(k, b)| (*k, b + dice.normal())).collect();
        let found = MeanByRungs::of(&costly, &[&cheap]).unwrap();
        assert!((found.helped.mean - found.plain.mean).abs() < 1e-12);
        // n - 2 for what the line leaves in place of n - 1.
        assert!((0.98..1.04).contains(&(found.helped.variance / found.plain.variance)), "{found:?}");
    }

    /// A cheap rung that says little, with a mean that lies far from that of the shared trials, is left out;
    /// the choice leaves the interval's coverage: 95 of 100 seeds, within three deviations of that count.
    #[test]
    fn prop_help_that_widens_is_left_out() {
        const SEEDS: u64 = 400;
        let (mut covered, mut left_out) = (0, 0);
        for seed in 0..SEEDS {
            let mut dice = Stream::new(seed, 9);
            let cheap = by_trial((0..2000).map(|_| dice.normal()));
            let costly: ByTrial = cheap.iter().take(40).map(|(k, b)| (*k, 0.2 * b + dice.normal())).collect();
            let found = MeanByRungs::of(&costly, &[&cheap]).unwrap();
            assert!(found.narrower() >= 1.0);
            let (low, high) = found.helped.interval();
            covered += u64::from(low <= 0.0 && 0.0 <= high);
            left_out += u64::from(found.helped == found.plain);
        }
        assert!((367..=393).contains(&covered), "{covered}");
        assert!((100..300).contains(&left_out), "{left_out}");
    }

    #[test]
    fn too_few_shared_trials_are_no_help() {
        let cheap = by_trial((0..100).map(f64::from));
        let costly: ByTrial = (95..105).map(|k| (k, 1.0)).collect();
        assert_eq!(MeanByRungs::of(&costly, &[&cheap]), None);
        assert_eq!(MeanByRungs::of(&ByTrial::new(), &[]).map(|m| m.plain.trials), Some(0));
    }

    /// Three rungs of normal values, of which the mean is known to be 1: with a correlation of 0.99 between
    /// the first two and 0.9 between the last two the interval covers it in 95 of 100 seeds, within three
    /// deviations of that count, and is five times narrower than the plain one.
    #[test]
    fn prop_intervals_of_three_rungs_cover() {
        const SEEDS: u64 = 400;
        let (mut covered, mut narrower) = (0, 0.0);
        for seed in 0..SEEDS {
            let mut dice = Stream::new(seed, 7);
            let (mut costly, mut middle, mut cheap) = (ByTrial::new(), ByTrial::new(), ByTrial::new());
            for trial in 0..8000 {
                let x = dice.normal();
                cheap.insert(trial, x);
                if trial < 2000 {
                    let y = 0.9 * x + 0.19f64.sqrt() * dice.normal();
                    middle.insert(trial, y);
                    if trial < 100 {
                        costly.insert(trial, 1.0 + 0.99 * y + 0.0199f64.sqrt() * dice.normal());
                    }
                }
            }
            let found = MeanByRungs::of(&costly, &[&middle, &cheap]).unwrap();
            let (low, high) = found.helped.interval();
            covered += u64::from(low <= 1.0 && 1.0 <= high);
            narrower += found.narrower() / SEEDS as f64;
        }
        // sqrt(400 0.95 0.05) = 4.4
        assert!((367..=393).contains(&covered), "{covered}");
        assert!((4.5..6.5).contains(&narrower), "{narrower}");
    }

    /// Of 19 the greatest is the bound at 95 %, of 18 none is; the next of equal draws exceeds the 95th of 99
    /// in one of twenty.
    #[test]
    fn closed_form_conformal_ranks() {
        let upto = |n: u32| (0..n).rev().map(f64::from).collect::<Vec<_>>();
        assert_eq!(conformal_margin(&upto(19), 0.95), Some(18.0));
        assert_eq!(conformal_margin(&upto(18), 0.95), None);
        assert_eq!(conformal_margin(&upto(99), 0.95), Some(94.0));
        assert_eq!(conformal_margin(&[], 0.95), None);
        let mut with_lost = upto(40);
        with_lost.extend([f64::INFINITY; 5]);
        assert_eq!(conformal_margin(&with_lost, 0.95), Some(f64::INFINITY));
    }

    /// Coverage over many calibrations, of a skewed distribution: 95 % of the next values, of ln 20 for
    /// exponential ones in the limit.
    #[test]
    fn prop_conformal_margins_cover() {
        let mut dice = Stream::new(3, 3);
        let mut exponential = || -crate::math::ln(1.0 - dice.uniform());
        let mut covered = 0;
        for _ in 0..2000 {
            let excesses: Vec<f64> = (0..59).map(|_| exponential()).collect();
            covered += u32::from(exponential() <= conformal_margin(&excesses, 0.95).unwrap());
        }
        // 57/60 exactly: 1900 expected, 9.7 a deviation.
        assert!((1871..=1929).contains(&covered), "{covered}");
    }
}
