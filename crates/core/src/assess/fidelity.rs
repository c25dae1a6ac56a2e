//! What a costly way to fly a campaign says of its trials, with the help of cheaper ways that have flown the
//! same trials and many more: control variates over rungs of fidelity, and the bound from the value of a
//! cheaper rung to that of the costly one.
//!
//! With C a quantity in the costly rung and B in the next cheaper one, both on n trials,
//!
//! ```text
//! C^ = mean_n(C) + beta (M_B - mean_n(B)),   beta = S_BC / S_BB,
//! var C^ = s_e^2 (1/n + (M_B - mean_n(B))^2 / S_BB) + beta^2 var M_B + 2 beta cov(mean_n(e), M_B)
//! ```
//!
//! where e is what the line leaves, `s_e^2` its variance with n - 2, and M_B the mean of B over all its
//! trials, or estimated in turn with the help of a rung that is cheaper still (Glasserman 2003, section 4.1;
//! Peherstorfer, Willcox and Gunzburger 2016, doi:10.1137/15M1046472). With `C = a + beta B + e` the mean of
//! e and that of B are uncorrelated, so the last term is zero where M_B is the mean of B. Where a third rung
//! A helps to M_B it is not, since e may go with A. It is summed over the trials in both: each has a part
//! `e_t/n` in the error of the one and a part in that of M_B, by the same rule.
//!
//! M_B is the mean of the trials that have a value in B. Where one of the n has a value in one of the two
//! rungs alone, those n are not like them, and there is no help.

use std::collections::BTreeMap;

use super::chosen::quantile_rank;
use super::statistics::{Summary, student_t_at};

/// Fewest trials that two rungs must share: of fewer the interval is too short unless their values are
/// normal and along a line.
pub const FEWEST_SHARED: u64 = 30;

/// A quantity by the number of the trial; `None` where a trial that was flown has no value.
pub type ByTrial = BTreeMap<u64, Option<f64>>;

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
    /// Confidence of its interval.
    pub confidence: f64,
}

impl MeanEstimate {
    /// Half of the interval that covers the mean with its confidence, by Student's t.
    pub fn half_width(&self) -> f64 {
        student_t_at(self.confidence, self.degrees) * self.variance.sqrt()
    }

    /// That interval.
    pub fn interval(&self) -> (f64, f64) {
        (self.mean - self.half_width(), self.mean + self.half_width())
    }
}

/// An estimate with the part of each trial in its error.
struct Known {
    estimate: MeanEstimate,
    parts: BTreeMap<u64, f64>,
}

impl Known {
    /// The mean of values that are drawn alike, without help; its variance is NaN with fewer than two.
    fn plain(values: &ByTrial, confidence: f64) -> Self {
        let mut summary = Summary::default();
        values.values().flatten().for_each(|x| summary.push(*x));
        let (mean, trials, std) = (summary.mean(), summary.count(), summary.std());
        let n = trials as f64;
        let estimate = MeanEstimate { mean, variance: std * std / n, degrees: n - 1.0, trials, confidence };
        let part = |(trial, x): (&u64, &Option<f64>)| Some((*trial, ((*x)? - mean) / n));
        Self { estimate, parts: values.iter().filter_map(part).collect() }
    }
}

/// How a rung goes with the next cheaper one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Trials that both have flown, with a value in both.
    pub shared: u64,
    /// Trials that both have flown, with a value in one of them alone; with any of them there is no help.
    pub value_in_one: u64,
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
    /// The mean of `costly`, by rungs that are each cheaper than the one before, with intervals of this
    /// `confidence`; a rung's own where the help of those makes its interval no narrower, and where a trial
    /// that both have flown has a value in one alone. `None` where two neighbours share fewer than
    /// [`FEWEST_SHARED`] trials.
    pub fn of(costly: &ByTrial, cheaper: &[&ByTrial], confidence: f64) -> Option<Self> {
        let rungs: Vec<&ByTrial> = std::iter::once(costly).chain(cheaper.iter().copied()).collect();
        let mut known = Known::plain(rungs.last()?, confidence);
        let mut agreements = Vec::new();
        for pair in rungs.windows(2).rev() {
            let own = Known::plain(pair[0], confidence);
            let (helped, agreement) = help(pair[0], pair[1], &known)?;
            let helps =
                agreement.value_in_one == 0 && helped.estimate.half_width() < own.estimate.half_width();
            known = if helps { helped } else { own };
            agreements.insert(0, agreement);
        }
        let plain = Known::plain(costly, confidence).estimate;
        Some(Self { plain, helped: known.estimate, agreements })
    }

    /// By how much the helped interval is narrower than the plain one; 1 where nothing helps.
    pub fn narrower(&self) -> f64 {
        self.plain.half_width() / self.helped.half_width()
    }
}

/// The mean of `costly` by the mean of `cheap`, which is known from more trials.
fn help(costly: &ByTrial, cheap: &ByTrial, known: &Known) -> Option<(Known, Agreement)> {
    let (mut shared, mut value_in_one) = (Vec::new(), 0);
    for (trial, c) in costly {
        match (cheap.get(trial), c) {
            (Some(Some(b)), Some(c)) => shared.push((*trial, *b, *c)),
            (Some(Some(_)), None) | (Some(None), Some(_)) => value_in_one += 1,
            (Some(None), None) | (None, _) => {}
        }
    }
    let (mut b, mut c) = (Summary::default(), Summary::default());
    for (_, of_cheap, of_costly) in &shared {
        b.push(*of_cheap);
        c.push(*of_costly);
    }
    if b.count() < FEWEST_SHARED {
        return None;
    }
    let n = b.count() as f64;
    let (mut bb, mut bc, mut cc) = (0.0, 0.0, 0.0);
    for (_, of_cheap, of_costly) in &shared {
        let (db, dc) = (of_cheap - b.mean(), of_costly - c.mean());
        bb += db * db;
        bc += db * dc;
        cc += dc * dc;
    }
    let slope = if bb > 0.0 { bc / bb } else { 0.0 };
    let left = (cc - slope * bc).max(0.0) / (n - 2.0);
    let away = known.estimate.mean - b.mean();
    let leverage = if bb > 0.0 { away * away / bb } else { 0.0 };
    let mut parts: BTreeMap<u64, f64> =
        known.parts.iter().map(|(trial, part)| (*trial, slope * part)).collect();
    let mut together = 0.0;
    for (trial, of_cheap, of_costly) in &shared {
        let residual = of_costly - c.mean() - slope * (of_cheap - b.mean());
        let part = parts.entry(*trial).or_default();
        together += residual / (n - 2.0) * *part;
        *part += residual / n;
    }
    let Known { estimate: MeanEstimate { variance, confidence, .. }, .. } = *known;
    let estimate = MeanEstimate {
        mean: c.mean() + slope * away,
        variance: (left * (1.0 / n + leverage) + slope * slope * variance + 2.0 * together).max(0.0),
        degrees: n - 2.0,
        trials: b.count(),
        confidence,
    };
    let correlation = if bb > 0.0 && cc > 0.0 { bc / (bb * cc).sqrt() } else { 0.0 };
    Some((Known { estimate, parts }, Agreement { shared: b.count(), value_in_one, correlation, slope }))
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
    use crate::assess::CONFIDENCE;
    use crate::random::{Purpose, Stream};

    fn by_trial(values: impl IntoIterator<Item = f64>) -> ByTrial {
        (0..).zip(values.into_iter().map(Some)).collect()
    }

    /// A rung of the first trials of another, by a function of its values.
    fn line(cheap: &ByTrial, trials: usize, mut of: impl FnMut(f64) -> f64) -> ByTrial {
        cheap.iter().take(trials).map(|(k, b)| (*k, b.map(&mut of))).collect()
    }

    fn found_of(costly: &ByTrial, cheaper: &[&ByTrial]) -> Option<MeanByRungs> {
        MeanByRungs::of(costly, cheaper, CONFIDENCE)
    }

    fn plain(values: &ByTrial) -> MeanEstimate {
        Known::plain(values, CONFIDENCE).estimate
    }

    /// Where the costly rung is a line of the cheap one, its mean is that line of the known mean, exactly,
    /// and the interval is the cheap one's by the slope.
    #[test]
    fn closed_form_a_line_needs_no_more_trials() {
        let cheap = by_trial((0..1000).map(|k| f64::from(k * 7919 % 1000)));
        let costly = line(&cheap, 30, |b| 3.0 - 2.0 * b);
        let found = found_of(&costly, &[&cheap]).unwrap();
        assert!((found.helped.mean - (3.0 - 2.0 * 499.5)).abs() < 1e-9, "{found:?}");
        let alone = plain(&cheap);
        assert!((found.helped.variance / (4.0 * alone.variance) - 1.0).abs() < 1e-9);
        assert!((found.agreements[0].correlation + 1.0).abs() < 1e-12);
        assert!(found.agreements[0].least_width() < 1e-6 && (found.agreements[0].slope + 2.0).abs() < 1e-12);
    }

    /// A cheap rung that has flown the same trials and no more adds nothing.
    #[test]
    fn closed_form_no_more_trials_no_help() {
        let mut dice = Stream::new(1, Purpose::Dice, 1);
        let cheap = by_trial((0..50).map(|_| dice.normal()));
        let costly = line(&cheap, 50, |b| b + dice.normal());
        let found = found_of(&costly, &[&cheap]).unwrap();
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
            let mut dice = Stream::new(seed, Purpose::Dice, 9);
            let cheap = by_trial((0..2000).map(|_| dice.normal()));
            let costly = line(&cheap, 40, |b| 0.2 * b + dice.normal());
            let found = found_of(&costly, &[&cheap]).unwrap();
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
        let costly = |from: u64| -> ByTrial { (from..from + 100).map(|k| (k, Some(1.0))).collect() };
        assert_eq!(found_of(&costly(71), &[&cheap]), None);
        assert_eq!(found_of(&costly(70), &[&cheap]).map(|m| m.agreements[0].shared), Some(30));
        assert_eq!(found_of(&ByTrial::new(), &[]).map(|m| m.plain.trials), Some(0));
    }

    /// A value in one rung alone takes the help away, whichever it is; in neither it says nothing: the trial
    /// is left out in both. B is 0 to 99 and C its square root where B is below 50.
    #[test]
    fn closed_form_a_value_in_one_rung_alone_is_no_help() {
        let cheap = by_trial((0..100).map(f64::from));
        let below = |most: u64| -> ByTrial {
            cheap.iter().map(|(k, b)| (*k, b.map(f64::sqrt).filter(|_| *k < most))).collect()
        };
        let found = found_of(&below(50), &[&cheap]).unwrap();
        assert_eq!((found.agreements[0].value_in_one, found.helped), (50, found.plain));
        let turned = found_of(&cheap, &[&below(50)]).unwrap();
        assert_eq!((turned.agreements[0].value_in_one, turned.helped), (50, turned.plain));
        let left_out: ByTrial = cheap.iter().map(|(k, b)| (*k, b.filter(|_| *k < 50))).collect();
        let more: ByTrial = left_out
            .iter()
            .map(|(k, b)| (*k, *b))
            .chain((100..1000).map(|k| (k, Some((k % 50) as f64))))
            .collect();
        let neither = found_of(&below(50), &[&more]).unwrap();
        assert_eq!((neither.agreements[0].value_in_one, neither.agreements[0].shared), (0, 50));
        assert!(neither.narrower() > 2.0, "{neither:?}");
    }

    /// C = exp(B) of a normal B, whose mean is `sqrt(e)`: where the relation is bent and the values skewed an
    /// interval covers less than it says, 83 of 100 with 50 trials (docs/fidelity.md; 8000 tries in numpy),
    /// within three deviations of 1000 seeds.
    #[test]
    fn reference_intervals_of_a_bent_relation_cover_less() {
        const SEEDS: u64 = 1000;
        let mut covered = 0;
        for seed in 0..SEEDS {
            let mut dice = Stream::new(seed, Purpose::Dice, 10);
            let cheap = by_trial((0..2000).map(|_| dice.normal()));
            let costly = line(&cheap, 50, crate::math::exp);
            let (low, high) = found_of(&costly, &[&cheap]).unwrap().helped.interval();
            let mean = crate::math::exp(0.5);
            covered += u64::from(low <= mean && mean <= high);
        }
        // sqrt(1000 0.83 0.17) = 12
        assert!((793..=865).contains(&covered), "{covered}");
    }

    /// Three rungs of normal values, of which the mean is known to be 1: with a correlation of 0.99 between
    /// the first two and 0.9 between the last two the interval covers it in 95 of 100 seeds, within three
    /// deviations of that count, and is five times narrower than the plain one.
    #[test]
    fn prop_intervals_of_three_rungs_cover() {
        const SEEDS: u64 = 400;
        let (mut covered, mut narrower) = (0, 0.0);
        for seed in 0..SEEDS {
            let mut dice = Stream::new(seed, Purpose::Dice, 7);
            let (mut costly, mut middle, mut cheap) = (ByTrial::new(), ByTrial::new(), ByTrial::new());
            for trial in 0..8000 {
                let x = dice.normal();
                cheap.insert(trial, Some(x));
                if trial < 2000 {
                    let y = 0.9 * x + 0.19f64.sqrt() * dice.normal();
                    middle.insert(trial, Some(y));
                    if trial < 100 {
                        let rest = 0.0199f64.sqrt() * dice.normal();
                        costly.insert(trial, Some(1.0 + 0.99 * y + rest));
                    }
                }
            }
            let found = found_of(&costly, &[&middle, &cheap]).unwrap();
            let (low, high) = found.helped.interval();
            covered += u64::from(low <= 1.0 && 1.0 <= high);
            narrower += found.narrower() / SEEDS as f64;
        }
        // sqrt(400 0.95 0.05) = 4.4
        assert!((367..=393).contains(&covered), "{covered}");
        assert!((4.5..6.5).contains(&narrower), "{narrower}");
    }

    /// What the line leaves of the costly rung may go with the third one, though not with the second: A and u
    /// normal, B = A + u, C = B - 0.7 (A - u), which leaves -0.7 (A - u) of variance 0.98 and a covariance of
    /// -0.7 with A. With as many trials of C and of B the variance is `(0.98 + 1 + 1.4)/n`, 1.4 of it by that
    /// covariance; without, the interval covers the mean of 0 in 85 of 100.
    #[test]
    fn closed_form_what_is_left_may_go_with_the_third_rung() {
        const SEEDS: u64 = 400;
        let mut covered = 0;
        for seed in 0..SEEDS {
            let mut dice = Stream::new(seed, Purpose::Dice, 8);
            let (mut costly, mut middle, mut cheap) = (ByTrial::new(), ByTrial::new(), ByTrial::new());
            for trial in 0..4000 {
                let a = dice.normal();
                cheap.insert(trial, Some(a));
                if trial < 100 {
                    let u = dice.normal();
                    middle.insert(trial, Some(a + u));
                    costly.insert(trial, Some(a + u - 0.7 * (a - u)));
                }
            }
            let found = found_of(&costly, &[&middle, &cheap]).unwrap();
            let (low, high) = found.helped.interval();
            covered += u64::from(low <= 0.0 && 0.0 <= high);
        }
        // sqrt(400 0.95 0.05) = 4.4
        assert!((367..=393).contains(&covered), "{covered}");
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
        let mut dice = Stream::new(3, Purpose::Dice, 3);
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
