//! Dryden's turbulence (MIL-F-8785C, 3.7.2.2; the same filters as MIL-HDBK-1797's, whose lengths are
//! defined as twice these for v and w), for `N` flights side by side.
//!
//! With T = L/V and white noise of unit intensity, the longitudinal velocity is
//! `sigma sqrt(2 T)/(1 + T s)`, the lateral and vertical ones `sigma sqrt(T) (1 + sqrt(3) T s)/(1 + T s)^2`;
//! each has the variance sigma^2. The filters are advanced exactly, by the distance D = V dt/L in units of
//! their scale, and begin in their stationary distribution. Their states have no unit, and their
//! distribution depends on neither V, L nor sigma, so that these may change from step to step and the
//! turbulence stays what it is.

use std::sync::Arc;

use crate::random::{Stream, normal_pair};
use crate::real::straight;

/// Random numbers of a step: one longitudinal, two lateral, two vertical; normal, mean 0, variance 1.
pub type Draw = [f64; 5];

/// Where the random numbers of a filter come from.
#[derive(Clone, Debug)]
pub enum Noise<const N: usize> {
    /// Drawn, two at a time, from a stream of each flight's own.
    Drawn(Box<[Stream; N]>),
    /// Given, two columns for each flight: the first numbers begin the filter, each further two drive a step;
    /// zero when they have run out.
    Given {
        /// The columns.
        columns: Box<[[Arc<[f64]>; 2]; N]>,
        /// The place of the next numbers.
        next: usize,
    },
}

impl<const N: usize> Noise<N> {
    /// The noise of flights side by side, each where it is; `None` where they are not at one place of columns
    /// that are given.
    fn abreast(each: [&Noise<1>; N]) -> Option<Self> {
        let streams: Vec<Stream> = each
            .iter()
            .filter_map(|one| match one {
                Noise::Drawn(streams) => Some(streams[0].clone()),
                Noise::Given { .. } => None,
            })
            .collect();
        if !streams.is_empty() {
            return Some(Self::Drawn(Box::new(streams.try_into().ok()?)));
        }
        let given = each.iter().filter_map(|one| match one {
            Noise::Given { columns, next } => Some((columns[0].clone(), *next)),
            Noise::Drawn(_) => None,
        });
        let (columns, places): (Vec<_>, Vec<usize>) = given.unzip();
        let next = *places.first()?;
        if places.iter().any(|place| *place != next) {
            return None;
        }
        Some(Self::Given { columns: Box::new(columns.try_into().ok()?), next })
    }

    #[inline(always)]
    fn pair(&mut self) -> [[f64; N]; 2] {
        let mut pair = [[0.0; N]; 2];
        match self {
            Self::Drawn(streams) => {
                let mut bits = [0; N];
                for i in 0..N {
                    bits[i] = streams[i].bits();
                }
                for i in 0..N {
                    [pair[0][i], pair[1][i]] = normal_pair(bits[i]);
                }
            }
            Self::Given { columns, next } => {
                for i in 0..N {
                    for k in 0..2 {
                        pair[k][i] = columns[i][k].get(*next).copied().unwrap_or_default();
                    }
                }
                *next += 1;
            }
        }
        pair
    }
}

/// What a step over the distances D, in units of the scale, does to the filters.
#[derive(Clone, Copy, Debug)]
pub struct Step<const N: usize> {
    distance: [f64; N],
    /// `exp(-D)`.
    decay: [f64; N],
    /// Standard deviation of what noise adds to the longitudinal velocity.
    along: [f64; N],
    /// Cholesky factor l11, l21, l22 of the covariance of what it adds to a transverse filter.
    across: [[f64; N]; 3],
}

impl<const N: usize> Step<N> {
    /// Whether it is over these distances.
    #[inline(always)]
    pub fn is_over(&self, distance: &[f64; N]) -> bool {
        self.distance == *distance
    }

    /// The step over the distances.
    #[inline(always)]
    pub fn over(distance: [f64; N]) -> Self {
        let mut step = Self { distance, decay: [0.0; N], along: [0.0; N], across: [[0.0; N]; 3] };
        for i in 0..N {
            step.decay[i] = straight::exp_of_minus(distance[i]);
            let q = increments(distance[i], step.decay[i] * step.decay[i]);
            step.along[i] = (2.0 * q[0]).sqrt();
            [step.across[0][i], step.across[1][i], step.across[2][i]] = cholesky(q);
        }
        step
    }
}

/// The longitudinal filter, in units of its standard deviation.
#[derive(Clone, Debug)]
pub struct Longitudinal<const N: usize> {
    noise: Noise<N>,
    /// The second number of a pair that was drawn.
    spare: Option<[f64; N]>,
    velocity: [f64; N],
}

impl<const N: usize> Longitudinal<N> {
    /// The filter in its stationary distribution.
    pub fn new(noise: Noise<N>) -> Self {
        let mut filter = Self { noise, spare: None, velocity: [0.0; N] };
        filter.velocity = filter.number();
        filter
    }

    /// The filters of flights side by side, each where it is; `None` where they cannot be.
    pub fn abreast(each: [&Longitudinal<1>; N]) -> Option<Self> {
        let spare = each.map(|one| one.spare.map(|[spare]| spare));
        let is_spare = spare[0].is_some();
        (spare.iter().all(|spare| spare.is_some() == is_spare)).then_some(())?;
        Some(Self {
            noise: Noise::abreast(each.map(|one| &one.noise))?,
            spare: is_spare.then(|| spare.map(Option::unwrap_or_default)),
            velocity: each.map(|one| one.velocity[0]),
        })
    }

    #[inline(always)]
    fn number(&mut self) -> [f64; N] {
        match (&self.noise, self.spare.take()) {
            (Noise::Drawn(_), Some(spare)) => spare,
            _ => {
                let [number, spare] = self.noise.pair();
                self.spare = Some(spare);
                number
            }
        }
    }

    /// Velocities now, over their standard deviation.
    #[inline(always)]
    pub fn velocity(&self) -> [f64; N] {
        self.velocity
    }

    /// Goes on by a step.
    #[inline(always)]
    pub fn advance(&mut self, step: &Step<N>) {
        let number = self.number();
        for i in 0..N {
            self.velocity[i] = step.decay[i] * self.velocity[i] + step.along[i] * number[i];
        }
    }
}

/// The lateral or the vertical filter, in units of its standard deviation: the velocity is
/// `sqrt(3) z_1 + (1 - sqrt(3)) z_2`.
#[derive(Clone, Debug)]
pub struct Transverse<const N: usize> {
    noise: Noise<N>,
    z: [[f64; N]; 2],
}

/// Cholesky factor of the stationary covariance, [[1/2, 1/4], [1/4, 1/4]].
const STATIONARY: [f64; 3] =
    [std::f64::consts::FRAC_1_SQRT_2, 0.5 * std::f64::consts::FRAC_1_SQRT_2, 0.353_553_390_593_273_8];

impl<const N: usize> Transverse<N> {
    /// The filter in its stationary distribution.
    pub fn new(mut noise: Noise<N>) -> Self {
        let [a, b] = noise.pair();
        let [l11, l21, l22] = STATIONARY;
        let z = [a.map(|a| l11 * a), std::array::from_fn(|i| l21 * a[i] + l22 * b[i])];
        Self { noise, z }
    }

    /// The filters of flights side by side, each where it is; `None` where they cannot be.
    pub fn abreast(each: [&Transverse<1>; N]) -> Option<Self> {
        let noise = Noise::abreast(each.map(|one| &one.noise))?;
        Some(Self { noise, z: [0, 1].map(|k| each.map(|one| one.z[k][0])) })
    }

    /// Velocities now, over their standard deviation.
    #[inline(always)]
    pub fn velocity(&self) -> [f64; N] {
        const ROOT: f64 = 1.732_050_807_568_877_2;
        let mut velocity = [0.0; N];
        for i in 0..N {
            velocity[i] = ROOT * self.z[0][i] + (1.0 - ROOT) * self.z[1][i];
        }
        velocity
    }

    /// Goes on by a step.
    #[inline(always)]
    pub fn advance(&mut self, step: &Step<N>) {
        let [a, b] = self.noise.pair();
        let [l11, l21, l22] = &step.across;
        for i in 0..N {
            let (z1, z2) = (self.z[0][i], self.z[1][i]);
            self.z[0][i] = step.decay[i] * z1 + l11[i] * a[i];
            self.z[1][i] = step.decay[i] * (step.distance[i] * z1 + z2) + (l21[i] * a[i] + l22[i] * b[i]);
        }
    }
}

/// Covariance q11, q12, q22 of what noise adds over a distance d, whose `exp(-2 d)` is `a2`: the integrals
/// I_k of (1, s, s^2) exp(-2 s) from 0 to d. The highest is computed, and from it, by parts and without
/// cancellation, `I_1 = I_2 + d^2 a2/2` and `I_0 = 2 I_1 + d a2`.
#[inline(always)]
fn increments(d: f64, a2: f64) -> [f64; 3] {
    // The closed form cancels where d is small: there the series of the integrand, integrated.
    let x = if d < 0.1 { -2.0 * d } else { -0.2 };
    let mut series = 0.0;
    for coefficient in SERIES {
        series = coefficient + x * series;
    }
    let closed = (1.0 - a2 * (1.0 + 2.0 * d + 2.0 * d * d)) / 4.0;
    let q22 = if d < 0.1 { d * d * d * series } else { closed };
    let q12 = q22 + 0.5 * d * d * a2;
    [2.0 * q12 + d * a2, q12, q22]
}

/// `1/(j! (3 + j))` from the tenth down to the first, j = 0.
const SERIES: [f64; 11] = [
    1.0 / (3_628_800.0 * 13.0),
    1.0 / (362_880.0 * 12.0),
    1.0 / (40_320.0 * 11.0),
    1.0 / (5_040.0 * 10.0),
    1.0 / (720.0 * 9.0),
    1.0 / (120.0 * 8.0),
    1.0 / (24.0 * 7.0),
    1.0 / (6.0 * 6.0),
    1.0 / (2.0 * 5.0),
    1.0 / 4.0,
    1.0 / 3.0,
];

/// Cholesky factor; zero where there is nothing.
#[inline(always)]
fn cholesky([q11, q12, q22]: [f64; 3]) -> [f64; 3] {
    let there = q11 > 0.0;
    let l11 = if there { q11.sqrt() } else { 1.0 };
    let l21 = q12 / l11;
    let rest = q22 - l21 * l21;
    let l22 = if rest > 0.0 { rest.sqrt() } else { 0.0 };
    [if there { l11 } else { 0.0 }, l21, l22]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use crate::random::Purpose;

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
            let noise = |k| Noise::Drawn(Box::new([Stream::of_part(seed, Purpose::Turbulence, k, 0)]));
            let mut along = Longitudinal::new(noise(0));
            let mut across = [1, 2].map(|k| Transverse::new(noise(k)));
            let (mut past, step) = (Vec::new(), Step::over([step]));
            for _ in 0..=200 {
                let [[v], [w]] = [&across[0], &across[1]].map(Transverse::velocity);
                past.push([along.velocity()[0], v, w]);
                along.advance(&step);
                across.iter_mut().for_each(|filter| filter.advance(&step));
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
        let noise = |first: f64| {
            let columns = [[first, 0.0], [0.0, 0.0]].map(Arc::from);
            Noise::<1>::Given { columns: Box::new([columns]), next: 0 }
        };
        let (mut u, mut v, mut w) =
            (Longitudinal::new(noise(1.0)), Transverse::new(noise(0.0)), Transverse::new(noise(2.0)));
        // Without noise z_1 and z_2 follow z_1' = -z_1, z_2' = z_1 - z_2, from sqrt(2) and sqrt(2)/2.
        let root = 2f64.sqrt();
        let step = Step::over([0.5]);
        for k in 0..10 {
            let x = 0.5 * f64::from(k);
            let z = [root * math::exp(-x), (0.5 + x) * root * math::exp(-x)];
            let expected = 3f64.sqrt() * z[0] + (1.0 - 3f64.sqrt()) * z[1];
            assert!((u.velocity()[0] - math::exp(-x)).abs() < 1e-15 && v.velocity() == [0.0], "{k}");
            assert!((w.velocity()[0] - expected).abs() < 1e-14, "{k}");
            u.advance(&step);
            v.advance(&step);
            w.advance(&step);
        }
    }
}
