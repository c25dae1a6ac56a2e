//! What holds of the best of several: bounds on the results of something that was chosen among `N` on the
//! flights that are quoted.
//!
//! The best of several looks better than it is on the flights that it was chosen by. Bonferroni's correction
//! holds whatever the rule of choice: when each of N bounds fails with a probability of at most
//! `(1 - CONFIDENCE)/N`, all hold together with [`CONFIDENCE`], so that of the chosen one does. Flights that
//! nothing was chosen by need none: N is 1.
//!
//! With the bounds on a probability, a quantile, a mean and the mean of a tail these are the finite-sample
//! statements of Vincent, Feldman and Schwager (2024, arXiv:2309.10874): none needs a limit theorem.

use super::beta::{beta_cdf, beta_quantile};
use super::statistics::{CONFIDENCE, Share};
use crate::math;

/// How many there were to choose among, at least one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChosenAmong(u64);

impl ChosenAmong {
    /// Nothing was chosen by these flights.
    pub const ONE: Self = Self(1);

    /// So many were tried on these flights; 0 counts as 1.
    pub fn new(count: u64) -> Self {
        Self(count.max(1))
    }

    /// How many there were.
    pub fn count(self) -> u64 {
        self.0
    }

    /// Confidence of each single bound, for all to hold together with [`CONFIDENCE`].
    pub fn confidence(self) -> f64 {
        1.0 - (1.0 - CONFIDENCE) / self.0 as f64
    }

    /// The greatest probability of a miss that so few misses leave possible (Clopper and Pearson, one-sided);
    /// 1 without trials.
    pub fn misses_at_most(self, share: &Share) -> f64 {
        let (misses, trials) = (share.misses() as f64, share.trials() as f64);
        if misses >= trials {
            return 1.0;
        }
        beta_quantile(self.confidence(), misses + 1.0, trials - misses)
    }

    /// A bound that the quantile `p` of the distribution lies below, of values in ascending order: the
    /// lowest of them with `P(at most k - 1 of n lie below the quantile) >= confidence`, whatever the
    /// distribution. `None` where there are too few.
    pub fn quantile_at_most(self, ascending: &[f64], p: f64) -> Option<f64> {
        let n = ascending.len();
        // P(Binomial(n, p) <= k - 1) = I_(1-p)(n - k + 1, k)
        let covers = |k: usize| beta_cdf(1.0 - p, (n - k + 1) as f64, k as f64) >= self.confidence();
        let first = quantile_rank(n, p);
        (first.max(1)..=n).find(|&k| covers(k)).map(|k| ascending[k - 1])
    }

    /// A bound that the mean of the worst share `1 - p` of the distribution lies below (its conditional value
    /// at risk; with p = 0 the mean), of values in ascending order; what is above `cap` counts as `cap`.
    ///
    /// `cap - 1/(1-p) int (F(x) - eps - p)^+ dx`, where F is the share of the values up to x and `eps =
    /// sqrt(ln(1/alpha)/(2 n))` what F may lie too high by (Dvoretzky, Kiefer and Wolfowitz, with Massart's
    /// constant): Anderson's bound for the mean, Thomas and Learned-Miller's (2019, theorem 3) for the tail.
    pub fn tail_mean_at_most(self, ascending: &[f64], p: f64, cap: f64) -> f64 {
        let n = ascending.len() as f64;
        let eps = (-math::ln(1.0 - self.confidence()) / (2.0 * n)).sqrt();
        let capped = || ascending.iter().map(|x| x.min(cap));
        let nexts = capped().skip(1).chain(std::iter::once(cap));
        let area: f64 = (1..)
            .zip(capped().zip(nexts))
            .map(|(i, (x, next)): (u32, _)| (next - x) * (f64::from(i) / n - eps - p).max(0.0))
            .sum();
        cap - area / (1.0 - p)
    }
}

/// The rank, from 1, of the value of `n` in ascending order that stands for the quantile `p`: the lowest that
/// a share `p` of them does not exceed; 0 of none.
pub fn quantile_rank(n: usize, p: f64) -> usize {
    let wanted = p * n as f64;
    // p n may lie a rounding error above a whole number.
    let rank = (wanted - 1e-9 * wanted.abs().max(1.0)).ceil().max(0.0) as usize;
    rank.clamp(usize::from(n > 0), n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, Stream};

    /// None of n missed: `(1-q)^n = alpha/N`. The correction of ten asks for the tenth part of alpha.
    #[test]
    fn closed_form_no_misses() {
        let mut share = Share::default();
        (0..1000).for_each(|_| share.push(true));
        for among in [1u64, 10] {
            let alpha = 0.05 / among as f64;
            let wanted = 1.0 - math::powf(alpha, 1.0 / 1000.0);
            let found = ChosenAmong::new(among).misses_at_most(&share);
            assert!((found - wanted).abs() < 1e-12, "{among}: {found}");
        }
        assert_eq!(ChosenAmong::ONE.misses_at_most(&Share::default()), 1.0);
    }

    /// The greatest of n lies above the quantile p with probability 1 - p^n: 299 are the fewest for p = 0.99
    /// at 95 % (Wilks 1941), and of these the greatest is the bound.
    #[test]
    fn closed_form_wilks_number() {
        let values: Vec<f64> = (0..299).map(f64::from).collect();
        assert_eq!(ChosenAmong::ONE.quantile_at_most(&values, 0.99), Some(298.0));
        assert_eq!(ChosenAmong::ONE.quantile_at_most(&values[..298], 0.99), None);
        assert_eq!(ChosenAmong::new(2).quantile_at_most(&values, 0.99), None);
    }

    /// Evenly spaced values on 0 to 1, whose F is x: `1 - (1 - eps - p)^2/(2 (1 - p))`, but for the steps.
    #[test]
    fn closed_form_tail_means_of_even_values() {
        let values: Vec<f64> = (0..10_000).map(|i| (f64::from(i) + 0.5) / 1e4).collect();
        let eps = (math::ln(20.0) / 2e4).sqrt();
        for p in [0.0, 0.9] {
            let wanted = 1.0 - (1.0 - eps - p) * (1.0 - eps - p) / (2.0 * (1.0 - p));
            let found = ChosenAmong::ONE.tail_mean_at_most(&values, p, 1.0);
            assert!((found - wanted).abs() < 1e-4, "{p}: {found} {wanted}");
        }
        assert_eq!(ChosenAmong::ONE.tail_mean_at_most(&[0.5; 3], 0.9, 2.0), 2.0, "too few say nothing");
        assert!(ChosenAmong::ONE.tail_mean_at_most(&[9.0; 1000], 0.0, 2.0) <= 2.0);
    }

    /// Of a uniform distribution, whose mean is 1/2 and whose worst tenth has a mean of 0.95, the bounds hold
    /// in 95 of 100 at the least.
    #[test]
    fn prop_tail_means_hold() {
        let mut dice = Stream::new(5, Purpose::Dice, 5);
        let mut held = [0; 2];
        for _ in 0..400 {
            let mut values: Vec<f64> = (0..200).map(|_| dice.uniform()).collect();
            values.sort_by(f64::total_cmp);
            for (held, (p, mean)) in held.iter_mut().zip([(0.0, 0.5), (0.9, 0.95)]) {
                *held += u32::from(ChosenAmong::ONE.tail_mean_at_most(&values, p, 1.0) >= mean);
            }
        }
        assert!(held.iter().all(|n| *n >= 380), "{held:?}");
    }

    #[test]
    fn closed_form_ranks() {
        assert_eq!([1, 100, 200, 201].map(|n| quantile_rank(n, 0.99)), [1, 99, 198, 199]);
        assert_eq!((quantile_rank(0, 0.5), quantile_rank(10, 1.0), quantile_rank(10, 0.7)), (0, 10, 7));
    }
}
