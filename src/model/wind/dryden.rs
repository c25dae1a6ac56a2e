//! Dryden's turbulence (MIL-F-8785C, 3.7.2.2; the same filters as MIL-HDBK-1797's, whose lengths are
//! defined as twice these for v and w).
//!
//! With T = L/V and white noise of unit intensity, the longitudinal velocity is
//! `sigma sqrt(2 T)/(1 + T s)`, the lateral and vertical ones `sigma sqrt(T) (1 + sqrt(3) T s)/(1 + T s)^2`;
//! each has the variance sigma^2. The filters are advanced exactly, by the distance D = V dt/L in units of
//! their scale, and begin in their stationary distribution. Their states have no unit, and their
//! distribution depends on neither V, L nor sigma, so that these may change from step to step and the
//! turbulence stays what it is.

use std::sync::Arc;

use crate::math;
use crate::random::Stream;

/// Random numbers of a step: one longitudinal, two lateral, two vertical; normal, mean 0, variance 1.
pub type Draw = [f64; 5];

/// Where the random numbers of a filter come from.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "the larger variant is the usual one, and few are made")]
pub enum Noise {
    /// Drawn from a stream of the filter's own, two at a time.
    Drawn(Stream),
    /// Given: the first row begins the filter, each further one drives a step; zero when they have run out.
    Given {
        /// The rows.
        rows: Arc<[Draw]>,
        /// The next row.
        next: usize,
    },
}

impl Noise {
    fn pair(&mut self, column: usize) -> [f64; 2] {
        match self {
            Self::Drawn(stream) => stream.normal_pair(),
            Self::Given { rows, next } => {
                let row = rows.get(*next).copied().unwrap_or_default();
                *next += 1;
                [row[column], row.get(column + 1).copied().unwrap_or_default()]
            }
        }
    }
}

/// The longitudinal filter, in units of its standard deviation.
#[derive(Clone, Debug)]
pub struct Longitudinal {
    noise: Noise,
    /// The second number of a pair that was drawn.
    spare: Option<f64>,
    velocity: f64,
}

impl Longitudinal {
    /// The filter in its stationary distribution.
    pub fn new(noise: Noise) -> Self {
        let mut filter = Self { noise, spare: None, velocity: 0.0 };
        filter.velocity = filter.number();
        filter
    }

    fn number(&mut self) -> f64 {
        match (&self.noise, self.spare.take()) {
            (Noise::Drawn(_), Some(spare)) => spare,
            _ => {
                let [number, spare] = self.noise.pair(0);
                self.spare = Some(spare);
                number
            }
        }
    }

    /// Velocity now, over its standard deviation.
    pub fn velocity(&self) -> f64 {
        self.velocity
    }

    /// Goes on by a distance through the air in units of the scale.
    pub fn advance(&mut self, distance: f64) {
        let a = math::exp(-distance);
        self.velocity = a * self.velocity + (1.0 - a * a).max(0.0).sqrt() * self.number();
    }
}

/// The lateral or the vertical filter, in units of its standard deviation: the velocity is
/// `sqrt(3) z_1 + (1 - sqrt(3)) z_2`.
#[derive(Clone, Debug)]
pub struct Transverse {
    noise: Noise,
    /// First of the two columns of given noise.
    column: usize,
    z: [f64; 2],
}

/// Cholesky factor of the stationary covariance, [[1/2, 1/4], [1/4, 1/4]].
const STATIONARY: [f64; 3] =
    [std::f64::consts::FRAC_1_SQRT_2, 0.5 * std::f64::consts::FRAC_1_SQRT_2, 0.353_553_390_593_273_8];

impl Transverse {
    /// The filter in its stationary distribution; given noise is in the columns from `column` on.
    pub fn new(mut noise: Noise, column: usize) -> Self {
        let z = correlated(STATIONARY, noise.pair(column));
        Self { noise, column, z }
    }

    /// Velocity now, over its standard deviation.
    pub fn velocity(&self) -> f64 {
        const ROOT: f64 = 1.732_050_807_568_877_2;
        ROOT * self.z[0] + (1.0 - ROOT) * self.z[1]
    }

    /// Goes on by a distance through the air in units of the scale.
    pub fn advance(&mut self, distance: f64) {
        let decay = math::exp(-distance);
        let factor = cholesky(increments(distance, decay * decay));
        let fresh = correlated(factor, self.noise.pair(self.column));
        let [z1, z2] = self.z;
        self.z = [decay * z1 + fresh[0], decay * (distance * z1 + z2) + fresh[1]];
    }
}

fn correlated(l: [f64; 3], [a, b]: [f64; 2]) -> [f64; 2] {
    [l[0] * a, l[1] * a + l[2] * b]
}

/// Covariance q11, q12, q22 of what noise adds over a distance d, whose `exp(-2 d)` is `a2`: the integrals
/// I_k of (1, s, s^2) exp(-2 s) from 0 to d. The highest is computed, and from it, by parts and without
/// cancellation, `I_1 = I_2 + d^2 a2/2` and `I_0 = 2 I_1 + d a2`.
fn increments(d: f64, a2: f64) -> [f64; 3] {
    let q22 = if d < 0.1 {
        // The closed form cancels.
        let (mut term, mut sum) = (d * d * d, 0.0);
        for j in 0..12 {
            let part = term / f64::from(3 + j);
            sum += part;
            if part.abs() <= 1e-17 * sum {
                break;
            }
            term *= -2.0 * d / f64::from(j + 1);
        }
        sum
    } else {
        (1.0 - a2 * (1.0 + 2.0 * d + 2.0 * d * d)) / 4.0
    };
    let q12 = q22 + 0.5 * d * d * a2;
    [2.0 * q12 + d * a2, q12, q22]
}

fn cholesky([q11, q12, q22]: [f64; 3]) -> [f64; 3] {
    if !(q11 > 0.0) {
        return [0.0; 3];
    }
    let l11 = q11.sqrt();
    let l21 = q12 / l11;
    [l11, l21, (q22 - l21 * l21).max(0.0).sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `F P F' + Q = P` with P = [[1/2, 1/4], [1/4, 1/4]], and two steps add what one of both does,
    /// `Q(2d) = F Q F' + Q`, on both sides of the change of formula.
    #[test]
    fn closed_form_a_step_keeps_the_stationary_covariance() {
        let through = |d: f64, p: [f64; 3]| {
            let a2 = math::exp(-2.0 * d);
            [a2 * p[0], a2 * (d * p[0] + p[1]), a2 * (d * d * p[0] + 2.0 * d * p[1] + p[2])]
        };
        for d in [1e-9, 1e-6, 1e-4, 0.004, 0.049, 0.051, 0.099, 0.101, 1.0, 5.0, 60.0] {
            let q = increments(d, math::exp(-2.0 * d));
            let carried = through(d, [0.5, 0.25, 0.25]);
            for (i, p) in [0.5, 0.25, 0.25].into_iter().enumerate() {
                assert!((carried[i] + q[i] - p).abs() < 2e-16, "{d}");
            }
            let (twice, once) = (increments(2.0 * d, math::exp(-4.0 * d)), through(d, q));
            for i in 0..3 {
                let error = (once[i] + q[i]) / twice[i] - 1.0;
                assert!(error.abs() < 1e-12, "{d} {i} {error}");
            }
            let l = cholesky(q);
            assert!((l[1] * l[1] + l[2] * l[2] - q[2]).abs() <= 1e-12 * q[2], "{d}");
        }
        let [a, b, c] = STATIONARY;
        for (found, expected) in [(a * a, 0.5), (a * b, 0.25), (b * b + c * c, 0.25)] {
            assert!((found - expected).abs() < 1e-15);
        }
    }

    /// Variance 1 at every time, and autocorrelation exp(-x) along, exp(-x) (1 - x/2) across (the Fourier
    /// transforms of Dryden's spectra), x in units of the scale: over 1000 seeds, within five standard
    /// deviations of the estimates.
    #[test]
    fn closed_form_variance_and_autocorrelation_over_1000_seeds() {
        let (seeds, step, lags) = (1_000u64, 0.02, [0usize, 5, 25, 50, 100, 200]);
        let mut sums = [[0.0; 3]; 6];
        let mut squares = [[0.0; 3]; 6];
        for seed in 0..seeds {
            let noise = |k| Noise::Drawn(Stream::new(seed, k));
            let mut along = Longitudinal::new(noise(0));
            let mut across = [1, 2].map(|k| Transverse::new(noise(k), 1));
            let mut past = Vec::new();
            for _ in 0..=200 {
                past.push([along.velocity(), across[0].velocity(), across[1].velocity()]);
                along.advance(step);
                across.iter_mut().for_each(|filter| filter.advance(step));
            }
            for (k, lag) in lags.into_iter().enumerate() {
                for i in 0..3 {
                    sums[k][i] += past[0][i] * past[lag][i];
                    squares[k][i] += past[lag][i] * past[lag][i];
                }
            }
        }
        let bound = 5.0 * (2.0 / seeds as f64).sqrt();
        for (k, lag) in lags.into_iter().enumerate() {
            let x = step * lag as f64;
            let across = math::exp(-x) * (1.0 - 0.5 * x);
            for (i, expected) in [math::exp(-x), across, across].into_iter().enumerate() {
                let (found, variance) = (sums[k][i] / seeds as f64, squares[k][i] / seeds as f64);
                assert!((found - expected).abs() < bound, "{i} after {x}: {found}, expected {expected}");
                assert!((variance - 1.0).abs() < bound, "{i} after {x}: {variance}");
            }
        }
    }

    #[test]
    fn given_noise_drives_the_filters_and_then_they_decay() {
        let rows: Arc<[Draw]> = [[1.0, 0.0, 0.0, 2.0, 0.0], [0.0; 5]].into();
        let noise = || Noise::Given { rows: rows.clone(), next: 0 };
        let (mut u, mut v, mut w) =
            (Longitudinal::new(noise()), Transverse::new(noise(), 1), Transverse::new(noise(), 3));
        // Without noise z_1 and z_2 follow z_1' = -z_1, z_2' = z_1 - z_2, from sqrt(2) and sqrt(2)/2.
        let root = 2f64.sqrt();
        for k in 0..10 {
            let x = 0.5 * f64::from(k);
            let z = [root * math::exp(-x), (0.5 + x) * root * math::exp(-x)];
            let expected = 3f64.sqrt() * z[0] + (1.0 - 3f64.sqrt()) * z[1];
            assert!((u.velocity() - math::exp(-x)).abs() < 1e-15 && v.velocity() == 0.0, "{k}");
            assert!((w.velocity() - expected).abs() < 1e-14, "{k}");
            u.advance(0.5);
            v.advance(0.5);
            w.advance(0.5);
        }
    }
}
