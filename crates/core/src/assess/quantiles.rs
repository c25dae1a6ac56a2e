//! Quantiles of a campaign: from a histogram of whole numbers, which add up whatever parts a campaign was
//! flown in, or exactly, where the values are kept.
//!
//! A quantile is a value that occurs: the least that a given share of the values does not exceed. Histograms
//! give it to half the width of a bin. What has no value - a trial that was never steady, or lost - lies
//! beyond all that have one.

use std::collections::BTreeMap;

/// A share of the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantile {
    /// Key in files.
    pub key: &'static str,
    /// Name for people.
    pub name: &'static str,
    /// The share, in hundredths.
    pub percent: u64,
}

/// The quantiles that are reported.
pub const QUANTILES: [Quantile; 2] = [
    Quantile { key: "p50", name: "median", percent: 50 },
    Quantile { key: "p99", name: "99 %", percent: 99 },
];

/// Values of [`QUANTILES`], in their order; `None` where there is none.
pub type Quantiles = [Option<f64>; QUANTILES.len()];

impl Quantile {
    /// The rank, from 1, of the value among `count` in ascending order; 0 of none.
    pub fn rank(&self, count: u64) -> u64 {
        let rank = (u128::from(count) * u128::from(self.percent)).div_ceil(100);
        u64::try_from(rank).unwrap_or(u64::MAX).clamp(count.min(1), count)
    }

    /// The quantile of values in ascending order.
    pub fn of_ascending(&self, ascending: &[f64]) -> Option<f64> {
        let rank = self.rank(ascending.len() as u64);
        ascending.get(usize::try_from(rank.checked_sub(1)?).ok()?).copied()
    }
}

/// Bins to either side of zero; what lies beyond is counted in the last, whose quantiles are not known.
const BINS_MOST: i32 = 1 << 22;

/// A histogram: bin k holds the values nearest to k widths.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Histogram {
    bins: BTreeMap<i32, u64>,
}

impl Histogram {
    /// The histogram with so many values in each of these bins.
    pub fn of(bins: impl IntoIterator<Item = (i32, u64)>) -> Self {
        let mut histogram = Self::default();
        bins.into_iter().for_each(|(bin, count)| histogram.add(bin, count));
        histogram
    }

    fn add(&mut self, bin: i32, count: u64) {
        let there = self.bins.entry(bin.clamp(-BINS_MOST, BINS_MOST)).or_default();
        *there = there.saturating_add(count);
    }

    /// Takes the next value, with the width of a bin; what is no number is left out.
    pub fn push(&mut self, x: f64, width: f64) {
        if !x.is_nan() {
            // The conversion saturates.
            self.add((x / width).round() as i32, 1);
        }
    }

    /// Takes the values of another histogram.
    pub fn append(&mut self, other: &Self) {
        other.bins.iter().for_each(|(bin, count)| self.add(*bin, *count));
    }

    /// The bins that hold a value, in ascending order, with the number of values.
    pub fn bins(&self) -> impl Iterator<Item = (i32, u64)> {
        self.bins.iter().map(|(bin, count)| (*bin, *count))
    }

    /// [`QUANTILES`] to half of `width`, which is that of the values taken, among so many of which those that
    /// were not taken lie beyond all others.
    pub fn quantiles(&self, width: f64, among: u64) -> Quantiles {
        QUANTILES.map(|quantile| {
            let mut left = quantile.rank(among);
            let (bin, _) = self.bins().find(|(_, count)| {
                let found = left <= *count;
                left = left.saturating_sub(*count);
                found
            })?;
            (bin.abs() < BINS_MOST).then(|| f64::from(bin) * width)
        })
    }
}

/// Bits of a value that one pass decides.
const DIGIT_BITS: u32 = 16;
const DIGITS: usize = 1 << DIGIT_BITS;

/// A number whose order is that of `f64::total_cmp`.
fn ordered(x: f64) -> u64 {
    let bits = x.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

fn from_ordered(bits: u64) -> f64 {
    f64::from_bits(if bits >> 63 == 1 { bits & !(1 << 63) } else { !bits })
}

/// A quantile that is searched.
#[derive(Clone, Debug)]
struct Wanted {
    /// Rank among the values that begin with the digits found, from 0.
    rank: u64,
    found: u64,
    counts: Vec<u64>,
}

/// The exact [`QUANTILES`] of more values than memory holds, in [`Selection::PASSES`] passes over them, each
/// of which decides 16 bits of every quantile; the memory does not depend on the number of values.
#[derive(Clone, Debug)]
pub struct Selection {
    wanted: Vec<Wanted>,
    passes: u32,
}

impl Selection {
    /// Passes over all values that are needed.
    pub const PASSES: u32 = 64 / DIGIT_BITS;

    /// The selection among `count` values.
    pub fn new(count: u64) -> Self {
        let ranks = QUANTILES.iter().filter_map(|quantile| quantile.rank(count).checked_sub(1));
        let wanted = ranks.map(|rank| Wanted { rank, found: 0, counts: vec![0; DIGITS] });
        Self { wanted: wanted.collect(), passes: 0 }
    }

    fn shift(&self) -> u32 {
        64 - DIGIT_BITS * (self.passes.min(Self::PASSES - 1) + 1)
    }

    /// Takes the next value of a pass.
    pub fn push(&mut self, x: f64) {
        let (bits, shift) = (ordered(x), self.shift());
        for wanted in &mut self.wanted {
            // Nothing is found before the first pass.
            if self.passes == 0 || bits >> (shift + DIGIT_BITS) == wanted.found {
                wanted.counts[(bits >> shift) as usize % DIGITS] += 1;
            }
        }
    }

    /// Ends a pass.
    pub fn end_pass(&mut self) {
        if self.passes == Self::PASSES {
            return;
        }
        for wanted in &mut self.wanted {
            let mut digit = 0;
            while digit + 1 < DIGITS && wanted.rank >= wanted.counts[digit] {
                wanted.rank -= wanted.counts[digit];
                digit += 1;
            }
            wanted.found = wanted.found << DIGIT_BITS | digit as u64;
            wanted.counts.fill(0);
        }
        self.passes += 1;
    }

    /// The quantiles; `None` before all passes, and of no values.
    pub fn quantiles(&self) -> Quantiles {
        let all = self.passes == Self::PASSES;
        std::array::from_fn(|i| self.wanted.get(i).filter(|_| all).map(|wanted| from_ordered(wanted.found)))
    }
}

#[cfg(test)]
mod tests {
    use proptest::num::f64::{INFINITE, NORMAL, ZERO};
    use proptest::prelude::*;

    use super::*;

    /// By hand: the lowest value that half, or 99 %, of the values do not exceed.
    #[test]
    fn closed_form_ranks() {
        let ranks = |count: u64| QUANTILES.map(|quantile| quantile.rank(count));
        assert_eq!([0, 1, 2, 3, 100, 101].map(ranks), [[0, 0], [1, 1], [1, 2], [2, 3], [50, 99], [51, 100]]);
        assert_eq!(ranks(u64::MAX)[0], u64::MAX / 2 + 1);
        assert_eq!(QUANTILES.map(|q| q.of_ascending(&[1.0, 2.0, 4.0])), [Some(2.0), Some(4.0)]);
        assert_eq!(QUANTILES.map(|q| q.of_ascending(&[])), [None, None]);
    }

    #[test]
    fn what_lies_beyond_the_bins_has_no_quantile() {
        let mut histogram = Histogram::default();
        assert_eq!([0, 7].map(|among| histogram.quantiles(1.0, among)), [[None, None]; 2]);
        for x in [0.26, 0.31, 1e300, f64::INFINITY, f64::NAN] {
            histogram.push(x, 0.1);
        }
        assert_eq!(histogram.quantiles(0.1, 4), [Some(0.1 * 3.0), None]);
        // Of five with one that was not taken the third is beyond the bins.
        assert_eq!(histogram.quantiles(0.1, 5), [None, None]);
        assert_eq!(histogram.bins().collect::<Vec<_>>(), [(3, 2), (BINS_MOST, 2)]);
        histogram.append(&Histogram::of([(i32::MIN, 1), (3, 4)]));
        assert_eq!(histogram.bins().collect::<Vec<_>>(), [(-BINS_MOST, 1), (3, 6), (BINS_MOST, 2)]);
    }

    proptest! {
        /// Passes find what sorting finds, of any numbers; a histogram, whatever its parts, to half a bin.
        #[test]
        fn prop_passes_and_bins_find_what_sorting_finds(
            any in prop::collection::vec(NORMAL | ZERO | INFINITE, 0..200),
            near in prop::collection::vec(-2.0..2.0f64, 1..300),
            cut in 0usize..300,
        ) {
            for values in [&any, &near] {
                let mut selection = Selection::new(values.len() as u64);
                for _ in 0..Selection::PASSES {
                    values.iter().for_each(|x| selection.push(*x));
                    selection.end_pass();
                }
                let mut ascending = values.clone();
                ascending.sort_by(f64::total_cmp);
                let sorted = QUANTILES.map(|quantile| quantile.of_ascending(&ascending));
                let bits = |quantiles: Quantiles| quantiles.map(|x| x.map(f64::to_bits));
                prop_assert_eq!(bits(selection.quantiles()), bits(sorted));
            }
            let width = 1e-3;
            let (mut one, mut other) = (Histogram::default(), Histogram::default());
            let cut = cut.min(near.len());
            near[..cut].iter().for_each(|x| one.push(*x, width));
            near[cut..].iter().for_each(|x| other.push(*x, width));
            one.append(&other);
            let mut ascending = near.clone();
            ascending.sort_by(f64::total_cmp);
            for (found, quantile) in one.quantiles(width, near.len() as u64).iter().zip(QUANTILES) {
                let exact = quantile.of_ascending(&ascending).unwrap();
                prop_assert!((found.unwrap() - exact).abs() <= 0.5 * width + 1e-12);
            }
        }
    }
}
