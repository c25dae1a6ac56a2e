//! Numbers of several flights side by side.
//!
//! Operations on a lane are written as scalar code without branches in a loop over the lanes; the compiler
//! makes vector instructions of them. No lane sees another, and nothing is fused or reordered, so a flight's
//! numbers do not depend on its lane, on its neighbours or on the width of the registers.

/// Flights that are flown side by side: the doubles of an AVX-512 register, two of AVX2.
pub const LANES: usize = 8;

/// One number per lane.
pub type Lanes = [f64; LANES];

/// `x` within `[low, high]`; `low` when they contradict or `x` is not a number.
#[inline(always)]
pub fn clip(x: f64, low: f64, high: f64) -> f64 {
    let x = if x < high { x } else { high };
    if x > low { x } else { low }
}

/// Added to this a number's bits end in its nearest integer: 2^52.
const TWO_52: f64 = 4_503_599_627_370_496.0;

/// The left end `floor(x)` of an interval, `x` clamped to `[0, last]`; a number that is none gives 0. Just
/// below a whole number it may be that number: for interpolants that are continuous.
#[inline(always)]
pub fn interval(x: f64, last: f64) -> f64 {
    let shifted = x - 0.5;
    let shifted = if shifted > 0.0 { shifted } else { 0.0 };
    let shifted = if shifted < last { shifted } else { last };
    (shifted + TWO_52) - TWO_52
}

/// A whole number from 0 to 2^32 - 1 as an index.
#[inline(always)]
pub fn index(whole: f64) -> usize {
    ((whole + TWO_52).to_bits() & 0xffff_ffff) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_interval_of_a_number() {
        for (x, wanted) in
            [(-3.0, 0), (0.3, 0), (0.999, 0), (1.001, 1), (6.5, 6), (8.9, 7), (1e9, 7), (f64::NAN, 0)]
        {
            assert_eq!(index(interval(x, 7.0)), wanted, "{x}");
        }
    }
}
