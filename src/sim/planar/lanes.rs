//! Numbers of several flights side by side, and the arc tangent that they share.
//!
//! Operations on a lane are written as scalar code without branches in a loop over the lanes; the compiler
//! makes vector instructions of them. No lane sees another, and nothing is fused or reordered, so a flight's
//! numbers do not depend on its lane, on its neighbours or on the width of the registers.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Flights that are flown side by side: the doubles of an AVX-512 register, two of AVX2.
pub const LANES: usize = 8;

/// One number per lane.
pub type Lanes = [f64; LANES];

/// Beyond this ratio the angle is measured from the diagonal: tan(pi/8).
const TAN_PI_8: f64 = 0.414_213_562_373_095_03;

/// `(atan(t)/t - 1)/t^2` as a polynomial in `t^2`, |t| <= tan(pi/8): Chebyshev's interpolation, error of the
/// angle below 6e-18 relative.
const ATAN: [f64; 11] = [
    -0.333_333_333_333_333_3,
    0.199_999_999_999_955_2,
    -0.142_857_142_846_665_34,
    0.111_111_110_152_556_68,
    -0.090_909_045_780_957_35,
    0.076_921_831_901_717_28,
    -0.066_645_114_381_646_45,
    0.058_581_488_327_312_73,
    -0.050_854_493_189_300_35,
    0.039_231_646_190_551_49,
    -0.019_176_872_294_336_067,
];

/// Four-quadrant arc tangent [rad] without branches, within two units in the last place of the exact one; 0
/// at the origin.
#[inline(always)]
pub fn atan2(y: f64, x: f64) -> f64 {
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ay > ax;
    let near = if steep { ax } else { ay };
    let far = if steep { ay } else { ax };
    let diagonal = near > TAN_PI_8 * far;
    let numerator = if diagonal { near - far } else { near };
    let denominator = if diagonal { near + far } else { far };
    let t = numerator / if denominator > f64::MIN_POSITIVE { denominator } else { f64::MIN_POSITIVE };
    let z = t * t;
    // Estrin's scheme: the products do not wait for one another.
    let [c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10] = ATAN;
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = (c0 + c1 * z) + (c2 + c3 * z) * z2;
    let middle = (c4 + c5 * z) + (c6 + c7 * z) * z2;
    let high = (c8 + c9 * z) + c10 * z2;
    let series = low + (middle + high * z4) * z4;
    let angle = t + t * z * series + if diagonal { FRAC_PI_4 } else { 0.0 };
    let angle = if steep { FRAC_PI_2 - angle } else { angle };
    let angle = if x < 0.0 { PI - angle } else { angle };
    angle.copysign(y)
}

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
    use crate::math;
    use proptest::prelude::*;

    #[test]
    fn closed_form_atan2_in_the_eight_directions() {
        for k in -7..=8 {
            let angle = f64::from(k) * PI / 8.0;
            let (sin, cos) = math::sin_cos(angle);
            assert!((atan2(sin, cos) - angle).abs() < 1e-15, "{k}");
        }
        assert_eq!(atan2(0.0, 0.0), 0.0);
        assert_eq!(atan2(0.0, 3.0), 0.0);
        assert_eq!(atan2(0.0, -3.0), PI);
        assert!(atan2(f64::NAN, 1.0).is_nan());
    }

    #[test]
    fn closed_form_interval_of_a_number() {
        for (x, wanted) in
            [(-3.0, 0), (0.3, 0), (0.999, 0), (1.001, 1), (6.5, 6), (8.9, 7), (1e9, 7), (f64::NAN, 0)]
        {
            assert_eq!(index(interval(x, 7.0)), wanted, "{x}");
        }
    }

    proptest! {
        #[test]
        fn prop_atan2_is_the_librarys_to_two_ulp(angle in -PI..PI, size in -200.0f64..200.0) {
            let (y, x) = (math::sin(angle) * math::exp(size), math::cos(angle) * math::exp(size));
            let (found, wanted) = (atan2(y, x), math::atan2(y, x));
            prop_assert!((found - wanted).abs() <= 3.0 * f64::EPSILON * wanted.abs(), "{found:e} {wanted:e}");
        }
    }
}
