//! Elementary functions without branches, for numbers one by one and side by side: over any [`Real`], and as
//! scalar code of which the compiler makes vector instructions in a loop over lanes. A number's result does
//! not depend on its lane, its neighbours or the width of the registers.
//!
//! Polynomials of logarithm, sine and cosine: FreeBSD's msun (`e_log.c`, `k_sin.c`, `k_cos.c`; Sun
//! Microsystems, 1993).

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, LOG2_E, PI, TAU};

use super::{Bits, Real};

/// Added to a number below it in size, the sum's last bits are the number's nearest integer: 1.5 2^52.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// ln 2 as a sum, the first with 21 zero bits at its end.
const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];

/// `1/k!` from the thirteenth down.
const EXP: [f64; 14] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
    1.0,
    1.0,
];

/// `exp(-x)` of an x of at least zero, within 2 units in the last place; beyond 700 as at 700, 1e-304.
#[inline(always)]
pub fn exp_of_minus<S: Bits>(x: S) -> S {
    let x = x.at_most(x.of(700.0));
    let shifted = x * LOG2_E + ROUNDING;
    let whole = shifted - ROUNDING;
    let r = (whole * LN_2[0] - x) + whole * LN_2[1];
    // Taylor's series, |r| <= ln(2)/2.
    let mut sum = x.of(0.0);
    for coefficient in EXP {
        sum = r * sum + coefficient;
    }
    // The whole number is in the last bits of what it was shifted to.
    sum * S::two_to_minus(shifted)
}

/// Of the root of a half the upper 32 bits.
pub(crate) const ROOT_HALF: u64 = 0x3fe6_a09e_0000_0000;

/// Coefficients of `(ln(1 + f) - f + f^2/2)/s - f^2/2` in s^2, `s = f/(2 + f)`.
const LN: [f64; 7] = [
    0.666_666_666_666_673_5,
    0.399_999_999_994_094_2,
    0.285_714_287_436_623_9,
    0.222_221_984_321_497_84,
    0.181_835_721_616_180_5,
    0.153_138_376_992_093_73,
    0.147_981_986_051_165_86,
];

/// Natural logarithm of a positive normal number, within 2 units in the last place.
#[inline(always)]
pub fn ln<S: Bits>(x: S) -> S {
    let (k, m) = x.split();
    let f = m - 1.0;
    let s = f / (f + 2.0);
    let z = s * s;
    let z2 = z * z;
    let [c1, c2, c3, c4, c5, c6, c7] = LN;
    let r = z * (z2 * (z2 * (z2 * c7 + c5) + c3) + c1) + z2 * (z2 * (z2 * c6 + c4) + c2);
    let half = f * 0.5 * f;
    k * LN_2[0] - ((half - (s * (half + r) + k * LN_2[1])) - f)
}

const SIN: [f64; 6] = [
    -0.166_666_666_666_666_32,
    0.008_333_333_333_322_49,
    -0.000_198_412_698_298_579_5,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
const COS: [f64; 6] = [
    0.041_666_666_666_666_6,
    -0.001_388_888_888_887_411,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// Sine and cosine of an angle of at most a turn or so, given in turns; within 1e-15.
#[inline(always)]
pub fn sin_cos_of_turns<S: Bits>(turns: S) -> (S, S) {
    let shifted = turns * 4.0 + ROUNDING;
    let x = (turns - (shifted - ROUNDING) * 0.25) * TAU;
    let z = x * x;
    let [s1, s2, s3, s4, s5, s6] = SIN;
    let [c1, c2, c3, c4, c5, c6] = COS;
    let sin = x + x * z * (z * (z * (z * (z * (z * s6 + s5) + s4) + s3) + s2) + s1);
    let cos = x.of(1.0) - z * 0.5 + z * z * (z * (z * (z * (z * (z * c6 + c5) + c4) + c3) + c2) + c1);
    let swapped = S::is_odd(shifted);
    let (a, b) = (S::select(swapped, cos, sin), S::select(swapped, sin, cos));
    // The sine is negative in the third and the fourth quarter, the cosine in the second and the third.
    (a.signed_by(shifted, 0), b.signed_by(shifted, 1))
}

/// Sine and cosine of an angle [rad]; within 1e-15 up to a turn or so, beyond by as much as the angle is
/// greater.
#[inline(always)]
pub fn sin_cos<S: Real>(x: S) -> (S, S) {
    (x * (1.0 / TAU)).sin_cos_of_turns()
}

/// Arc sine [rad], within -pi/2..pi/2; that of the nearest end outside -1..1.
#[inline(always)]
pub fn asin<S: Real>(x: S) -> S {
    x.atan2(other_leg(x))
}

/// Arc cosine [rad], within 0..pi; that of the nearest end outside -1..1.
#[inline(always)]
pub fn acos<S: Real>(x: S) -> S {
    other_leg(x).atan2(x)
}

/// `sqrt(1 - x^2)`, 0 beyond 1.
#[inline(always)]
fn other_leg<S: Real>(x: S) -> S {
    let one = x.of(1.0);
    let square = (one - x) * (one + x);
    S::select(square.less(x.of(0.0)), x.of(0.0), square).sqrt()
}

/// Length of the hypotenuse of two legs whose squares are numbers of usual size.
#[inline(always)]
pub fn hypot<S: Real>(x: S, y: S) -> S {
    (x * x + y * y).sqrt()
}

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
pub fn atan2<S: Real>(y: S, x: S) -> S {
    let (ax, ay, zero) = (x.abs(), y.abs(), x.of(0.0));
    let steep = ax.less(ay);
    let near = S::select(steep, ax, ay);
    let far = S::select(steep, ay, ax);
    let diagonal = (far * TAN_PI_8).less(near);
    let numerator = S::select(diagonal, near - far, near);
    let denominator = S::select(diagonal, near + far, far);
    let t = numerator / denominator.at_least(x.of(f64::MIN_POSITIVE));
    let z = t * t;
    // Estrin's scheme: the products do not wait for one another.
    let [c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10] = ATAN;
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = (z * c1 + c0) + (z * c3 + c2) * z2;
    let middle = (z * c5 + c4) + (z * c7 + c6) * z2;
    let high = (z * c9 + c8) + z2 * c10;
    let series = low + (middle + high * z4) * z4;
    let angle = t + t * z * series + S::select(diagonal, x.of(FRAC_PI_4), zero);
    let angle = S::select(steep, x.of(FRAC_PI_2) - angle, angle);
    let angle = S::select(x.less(zero), x.of(PI) - angle, angle);
    angle.copysign(y)
}

/// A number of 32 bits as a floating-point one.
#[inline(always)]
pub fn of_u32(bits: u64) -> f64 {
    f64::from_bits((bits & 0xffff_ffff) | 0x4330_0000_0000_0000) - 4_503_599_627_370_496.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn prop_they_are_the_librarys(
            x in prop_oneof![0.0..1.0f64, 0.0..700.0f64, 0.0..1e-9f64], size in -40.0..40.0f64,
            turns in -1.0..1.0f64, whole: u32,
        ) {
            let exp = exp_of_minus(x);
            prop_assert!((exp / libm::exp(-x) - 1.0).abs() < 5e-16, "exp(-{x}): {exp:e}");
            for y in [libm::exp(size), 1.0 - x * 1e-9, 1.0 + x * 1e-9] {
                let (found, wanted) = (ln(y), libm::log(y));
                prop_assert!((found - wanted).abs() <= 5e-16 * wanted.abs(), "ln({y}): {found:e} {wanted:e}");
            }
            let (sin, cos) = sin_cos_of_turns(turns);
            let (wanted_sin, wanted_cos) = libm::sincos(TAU * turns);
            prop_assert!((sin - wanted_sin).abs() < 2e-15 && (cos - wanted_cos).abs() < 2e-15, "{turns}");
            prop_assert_eq!(of_u32(u64::from(whole)), f64::from(whole));
        }
    }

    proptest! {
        #[test]
        fn prop_circular_functions_are_the_librarys(angle in -7.0..7.0f64, x in -1.0..1.0f64) {
            let (sin, cos) = sin_cos(angle);
            prop_assert!((sin - libm::sin(angle)).abs() < 2e-15 && (cos - libm::cos(angle)).abs() < 2e-15);
            prop_assert!((asin(x) - libm::asin(x)).abs() < 1e-15, "{x}: {:e}", asin(x));
            prop_assert!((acos(x) - libm::acos(x)).abs() < 2e-15, "{x}: {:e}", acos(x));
        }

        #[test]
        fn prop_atan2_is_the_librarys_to_two_ulp(angle in -PI..PI, size in -200.0f64..200.0) {
            let (y, x) = (libm::sin(angle) * libm::exp(size), libm::cos(angle) * libm::exp(size));
            let (found, wanted) = (atan2(y, x), libm::atan2(y, x));
            prop_assert!((found - wanted).abs() <= 3.0 * f64::EPSILON * wanted.abs(), "{found:e} {wanted:e}");
        }
    }

    #[test]
    fn closed_form_ends_of_the_inverses() {
        assert_eq!([asin(1.0), asin(-1.5), acos(-1.0), acos(1.5)], [FRAC_PI_2, -FRAC_PI_2, PI, 0.0]);
        assert!(asin(f64::NAN).is_nan() && acos(f64::NAN).is_nan());
    }

    #[test]
    fn closed_form_atan2_in_the_eight_directions() {
        for k in -7..=8 {
            let angle = f64::from(k) * PI / 8.0;
            let (sin, cos) = libm::sincos(angle);
            assert!((atan2(sin, cos) - angle).abs() < 1e-15, "{k}");
        }
        assert_eq!(atan2(0.0, 0.0), 0.0);
        assert_eq!(atan2(0.0, 3.0), 0.0);
        assert_eq!(atan2(0.0, -3.0), PI);
        assert!(atan2(f64::NAN, 1.0).is_nan());
    }

    #[test]
    fn closed_form_whole_quarters_and_ends() {
        for (turns, wanted) in
            [(0.0, (0.0, 1.0)), (0.25, (1.0, 0.0)), (0.5, (0.0, -1.0)), (0.75, (-1.0, 0.0))]
        {
            let (sin, cos) = sin_cos_of_turns(turns);
            assert_eq!((sin + 0.0, cos + 0.0), wanted, "{turns}");
        }
        assert_eq!((exp_of_minus(0.0), ln(1.0)), (1.0, 0.0));
        assert!(exp_of_minus(f64::INFINITY) < 1e-303 && exp_of_minus(f64::NAN) < 1e-303);
    }
}
