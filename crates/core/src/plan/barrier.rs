//! Bounds and their logarithmic barrier: `-mu sum log(x - lo) - mu sum log(hi - x)`, with multipliers of
//! their own.

use crate::math;
use nalgebra::SVector;

/// Lower and upper bounds of a vector; infinite where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<const N: usize> {
    /// Least values.
    pub lo: SVector<f64, N>,
    /// Greatest values.
    pub hi: SVector<f64, N>,
}

/// Multipliers of the bounds in [`Limits`]; zero where there is no bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundDuals<const N: usize> {
    /// Multipliers of the lower bounds.
    pub lo: SVector<f64, N>,
    /// Multipliers of the upper bounds.
    pub hi: SVector<f64, N>,
}

impl<const N: usize> BoundDuals<N> {
    /// Multipliers of bounds that exert no force: zeros.
    pub fn zero() -> Self {
        Self { lo: SVector::zeros(), hi: SVector::zeros() }
    }

    /// Gradient of the bound terms in the Lagrangian: `-z_lo + z_hi`.
    #[inline(always)]
    pub fn net(&self) -> SVector<f64, N> {
        self.hi - self.lo
    }
}

impl<const N: usize> Limits<N> {
    /// Multipliers on the central path: `mu` over the distance from the bound.
    pub fn central_duals(&self, x: &SVector<f64, N>, mu: f64) -> BoundDuals<N> {
        BoundDuals { lo: (x - self.lo).map(|s| mu / s), hi: (self.hi - x).map(|s| mu / s) }
    }

    /// The point `x`, moved into the bounds by at least the fraction `margin` of their distance (or by
    /// `margin` itself where there is only one).
    pub fn interior(&self, x: &SVector<f64, N>, margin: f64) -> SVector<f64, N> {
        SVector::from_fn(|i, _| {
            let (lo, hi) = (self.lo[i], self.hi[i]);
            let width = hi - lo;
            let m = margin * if width.is_finite() { width } else { 1.0 };
            if x[i].is_finite() {
                x[i].max(lo + m).min(hi - m)
            } else if width.is_finite() {
                0.5 * (lo + hi)
            } else {
                0.0f64.max(lo + m).min(hi - m)
            }
        })
    }

    /// Gradient of the barrier and diagonal of its primal-dual Hessian.
    #[inline(always)]
    pub fn terms(
        &self,
        x: &SVector<f64, N>,
        z: &BoundDuals<N>,
        mu: f64,
    ) -> (SVector<f64, N>, SVector<f64, N>) {
        let (mut gradient, mut hessian) = (SVector::zeros(), SVector::zeros());
        for i in 0..N {
            // An infinite distance contributes exactly nothing.
            let (below, above) = (1.0 / (x[i] - self.lo[i]), 1.0 / (self.hi[i] - x[i]));
            gradient[i] = mu * (above - below);
            hessian[i] = z.lo[i] * below + z.hi[i] * above;
        }
        (gradient, hessian)
    }

    /// Gradient of the barrier and diagonal of its primal Hessian: [`Self::terms`] on the central path.
    pub fn primal_terms(&self, x: &SVector<f64, N>, mu: f64) -> (SVector<f64, N>, SVector<f64, N>) {
        self.terms(x, &self.central_duals(x, mu), mu)
    }

    /// Sum of the logarithms of all distances; `None` on or beyond a bound.
    #[inline(always)]
    pub fn log_distance(&self, x: &SVector<f64, N>) -> Option<f64> {
        // The logarithm of a product is cheaper than the sum of logarithms; N is small, and distances are far
        // from the ends of the exponent range.
        let mut product = 1.0;
        for i in 0..N {
            for distance in [x[i] - self.lo[i], self.hi[i] - x[i]] {
                if !(distance > 0.0) {
                    return None;
                }
                if distance.is_finite() {
                    product *= distance;
                }
            }
        }
        Some(math::ln(product))
    }

    /// Longest step in [0, 1] along `dx` that keeps the fraction `1 - tau` of each distance.
    #[inline(always)]
    pub fn longest_step(&self, x: &SVector<f64, N>, dx: &SVector<f64, N>, tau: f64) -> f64 {
        let mut alpha = 1.0f64;
        for i in 0..N {
            if dx[i] < 0.0 {
                alpha = alpha.min(tau * (x[i] - self.lo[i]) / -dx[i]);
            } else if dx[i] > 0.0 {
                alpha = alpha.min(tau * (self.hi[i] - x[i]) / dx[i]);
            }
        }
        alpha
    }

    /// Newton step of the multipliers: `dz = mu/s - z - z/s ds`.
    #[inline(always)]
    pub fn dual_step(
        &self,
        x: &SVector<f64, N>,
        dx: &SVector<f64, N>,
        z: &BoundDuals<N>,
        mu: f64,
    ) -> BoundDuals<N> {
        let mut step = BoundDuals::zero();
        for i in 0..N {
            let (below, above) = (1.0 / (x[i] - self.lo[i]), 1.0 / (self.hi[i] - x[i]));
            step.lo[i] = (mu - z.lo[i] * dx[i]) * below - z.lo[i];
            step.hi[i] = (mu + z.hi[i] * dx[i]) * above - z.hi[i];
        }
        step
    }

    /// Largest deviation `|z s - mu|` from the central path, with `s` the distance from a bound.
    #[inline(always)]
    pub fn complementarity(&self, x: &SVector<f64, N>, z: &BoundDuals<N>, mu: f64) -> f64 {
        let mut worst = 0.0f64;
        for i in 0..N {
            if self.lo[i].is_finite() {
                worst = worst.max((z.lo[i] * (x[i] - self.lo[i]) - mu).abs());
            }
            if self.hi[i].is_finite() {
                worst = worst.max((z.hi[i] * (self.hi[i] - x[i]) - mu).abs());
            }
        }
        worst
    }

    /// Keeps each multiplier within a factor of 1e10 of its central value (Waechter and Biegler 2006, (16)).
    #[inline(always)]
    pub fn tame(&self, x: &SVector<f64, N>, z: &mut BoundDuals<N>, mu: f64) {
        const KAPPA: f64 = 1e10;
        for i in 0..N {
            let tame = |z: f64, s: f64| {
                if s.is_finite() { z.min(KAPPA * mu / s).max(mu / (KAPPA * s)) } else { 0.0 }
            };
            z.lo[i] = tame(z.lo[i], x[i] - self.lo[i]);
            z.hi[i] = tame(z.hi[i], self.hi[i] - x[i]);
        }
    }
}

/// Longest step in [0, 1] that keeps the fraction `1 - tau` of each multiplier.
#[inline(always)]
pub fn longest_dual_step<const N: usize>(z: &BoundDuals<N>, dz: &BoundDuals<N>, tau: f64) -> f64 {
    let mut alpha = 1.0f64;
    for (z, dz) in z.lo.iter().chain(z.hi.iter()).zip(dz.lo.iter().chain(dz.hi.iter())) {
        if *dz < 0.0 {
            alpha = alpha.min(tau * z / -dz);
        }
    }
    alpha
}
