//! When one thing flies better than another: by a margin that is larger than what the judges' arithmetic and
//! chance leave.
//!
//! The two fly the same draws, so flights come in pairs, and most of what chance does to one it does to the
//! other. A number of theirs - a quantile, a worst flight, a mean - is **clearly less** when it is so by
//! [`LEAST_DIFFERENCE`]. That is beyond any arithmetic: a bit in a logarithm that a search went through moves
//! J_TPF by 1e-12. Of a quantile there is a test beside it: of the flights of which one of the two passes the
//! other's quantile and the other does not, more than chance allows must speak for it (McNemar 1947, exact).
//! It supposes nothing of the distribution.

use super::{ChosenAmong, Share};

/// The least difference, as a part of the greater number, by which one number is clearly less than another:
/// one unit of the third digit of a J_TPF near 1.
pub const LEAST_DIFFERENCE: f64 = 1e-3;

/// Whether `a` is less than `b` by [`LEAST_DIFFERENCE`] or more. Anything is less than what is infinite, and
/// what is no number is less than nothing.
pub fn clearly_less(a: f64, b: f64) -> bool {
    a.is_finite() && (b == f64::INFINITY || (a < b && a <= b - LEAST_DIFFERENCE * b.abs()))
}

/// Whether flights `a` pass a value less often than flights `b`, more than by chance, with
/// [`CONFIDENCE`](super::CONFIDENCE): flights of a place in both are of one draw. Of the pairs of which only
/// one passes, one half would be of each.
pub fn passes_less_often(a: &[f64], b: &[f64], value: f64) -> bool {
    let passes = |x: f64| !(x <= value);
    let only = |pair: (&f64, &f64)| match pair {
        (a, b) if passes(*b) && !passes(*a) => Some(true),
        (a, b) if passes(*a) && !passes(*b) => Some(false),
        _ => None,
    };
    let mut for_a = Share::default();
    a.iter().zip(b).filter_map(only).for_each(|speaks_for_a| for_a.push(speaks_for_a));
    ChosenAmong::ONE.misses_at_most(&for_a) < 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_a_margin_of_a_thousandth() {
        for (a, b, less) in [
            (0.5, 0.5, false),
            (0.5 - 1e-12, 0.5, false),
            (0.4996, 0.5, false),
            (0.4994, 0.5, true),
            (0.5, 0.4994, false),
            (0.0, 0.0, false),
            (0.5, f64::INFINITY, true),
            (f64::INFINITY, f64::INFINITY, false),
            (f64::NAN, 0.5, false),
            (0.5, f64::NAN, false),
        ] {
            assert_eq!(clearly_less(a, b), less, "{a} {b}");
        }
    }

    /// The sign test by hand: five pairs that all speak for one have a probability of 1/32 by chance, four of
    /// 1/16; nine of ten 11/1024, eight of ten 56/1024.
    #[test]
    fn closed_form_pairs_of_which_only_one_passes() {
        let pairs = |for_a: usize, for_b: usize| {
            // A hundred more of which both pass, or neither.
            let of = |mine: usize, others: usize| {
                [vec![2.0; mine], vec![0.5; others], vec![2.0; 50], vec![0.5; 50]].concat()
            };
            let (b, mut a) = (of(for_a, for_b), of(for_a, for_b));
            a[..for_a].fill(0.5);
            a[for_a..for_a + for_b].fill(2.0);
            passes_less_often(&a, &b, 1.0)
        };
        let found = [(0, 0), (4, 0), (5, 0), (8, 2), (9, 1), (1, 9)].map(|(a, b)| pairs(a, b));
        assert_eq!(found, [false, false, true, false, true, false]);
        assert!(!passes_less_often(&[], &[], 1.0));
        // A flight that is no number passes everything.
        assert!(passes_less_often(&[0.5; 5], &[f64::NAN; 5], 1.0));
    }
}
