//! Elementary functions whose last digit is the same on every machine.
//!
//! `f64::sin` and its kin call the system's C library, whose results differ in the last digit from one
//! release to the next, and between processors with and without fused multiply-add. These are the functions
//! of the `libm` crate, MUSL's in Rust: within 1 unit in the last place, the hyperbolic ones within about 2,
//! and no call of the system. What IEEE 754 rounds exactly (`sqrt`, `floor`, `round`, `abs`, `%`) needs none
//! of this. clippy.toml refuses the methods of `f64` that this module replaces.

/// Sine of an angle [rad].
#[inline]
pub fn sin(x: f64) -> f64 {
    libm::sin(x)
}

/// Cosine of an angle [rad].
#[inline]
pub fn cos(x: f64) -> f64 {
    libm::cos(x)
}

/// Sine and cosine of an angle [rad].
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// Sine and cosine of an angle [rad] in single precision.
#[inline]
pub fn sin_cos_f32(x: f32) -> (f32, f32) {
    libm::sincosf(x)
}

/// Tangent of an angle [rad].
#[inline]
pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

/// Arc sine [rad], within -pi/2..pi/2; NaN outside -1..1.
#[inline]
pub fn asin(x: f64) -> f64 {
    libm::asin(x)
}

/// Arc cosine [rad], within 0..pi; NaN outside -1..1.
#[inline]
pub fn acos(x: f64) -> f64 {
    libm::acos(x)
}

/// Four-quadrant arc tangent of `y / x` [rad].
#[inline]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// Hyperbolic cosine.
#[inline]
pub fn cosh(x: f64) -> f64 {
    libm::cosh(x)
}

/// Hyperbolic tangent.
#[inline]
pub fn tanh(x: f64) -> f64 {
    libm::tanh(x)
}

/// Complement of the error function, `1 - erf(x)`.
#[inline]
pub fn erfc(x: f64) -> f64 {
    libm::erfc(x)
}

/// Inverse of the hyperbolic tangent.
#[inline]
pub fn atanh(x: f64) -> f64 {
    libm::atanh(x)
}

/// Exponential `e^x`.
#[inline]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Natural logarithm.
#[inline]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// Natural logarithm of `1 + x`, exact for small `x`.
#[inline]
pub fn ln_1p(x: f64) -> f64 {
    libm::log1p(x)
}

/// Logarithm to base 2.
#[inline]
pub fn log2(x: f64) -> f64 {
    libm::log2(x)
}

/// Logarithm to base 10.
#[inline]
pub fn log10(x: f64) -> f64 {
    libm::log10(x)
}

/// A finite number with that many digits that count.
///
/// ```
/// # use samara_core::math::with_digits;
/// assert_eq!([0.056_568, 1e-4, -1234.5, 0.0].map(|x| with_digits(x, 3)), [0.0566, 1e-4, -1230.0, 0.0]);
/// ```
pub fn with_digits(x: f64, digits: u32) -> f64 {
    if x == 0.0 {
        return x;
    }
    let decimals = f64::from(digits) - 1.0 - log10(x.abs()).floor();
    let scale = powf(10.0, decimals.clamp(-300.0, 300.0));
    (x * scale).round() / scale
}

/// Power `x^y`.
#[inline]
pub fn powf(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// Length of the hypotenuse, `sqrt(x^2 + y^2)`, without overflow.
#[inline]
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}
