//! Covariance matrix adaptation evolution strategy (N. Hansen, "The CMA evolution strategy: a tutorial",
//! arXiv 1604.00772, with its default weights and rates), within bounds: a polish, and a search of its own
//! where flights are dear.
//!
//! It works in coordinates that are scaled to the bounds: 0 at the lower, 1 at the upper one, straight, by
//! the square root or by the logarithm. By the logarithm a gain of a thousandth can shrink to a ten
//! thousandth but hardly grow into one; by the root it can. A sample that leaves them is reflected back in;
//! an optimum on a bound is then the edge of a roof, which it can find.
//!
//! The eigenvalues come from Jacobi's rotations, written here: the same operations in the same order on every
//! processor.

use super::{Optimiser, usable};
use crate::math;
use crate::random::{Purpose, Stream};

/// How a coordinate is scaled to its bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Straight.
    Linear,
    /// By the square root; the bounds must not be negative.
    Root,
    /// By the logarithm; the bounds must be positive.
    Logarithmic,
}

/// Settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CmaSettings {
    /// Samples of a generation, at least 4.
    pub samples: usize,
    /// Standard deviation to begin with, in scaled coordinates.
    pub sigma: f64,
    /// The scale of every coordinate.
    pub scale: Scale,
    /// It has converged when the standard deviation along every axis is below this, in scaled coordinates.
    pub tolerance: f64,
}

impl Default for CmaSettings {
    fn default() -> Self {
        Self { samples: 16, sigma: 0.1, scale: Scale::Logarithmic, tolerance: 1e-5 }
    }
}

/// The strategy and what it has learnt.
#[derive(Clone, Debug)]
pub struct CmaEs<const N: usize> {
    settings: CmaSettings,
    bounds: [(f64, f64); N],
    streams: Vec<Stream>,
    mean: [f64; N],
    sigma: f64,
    covariance: [[f64; N]; N],
    /// Columns are the covariance's axes, with the standard deviation along each.
    axes: ([[f64; N]; N], [f64; N]),
    path_sigma: [f64; N],
    path_c: [f64; N],
    generation: i32,
    /// Steps from the mean in units of sigma, and the candidates that they lead to.
    steps: Vec<[f64; N]>,
    candidates: Vec<[f64; N]>,
}

impl<const N: usize> CmaEs<N> {
    /// Begins at `start`, within the bounds (lower, upper).
    pub fn new(bounds: [(f64, f64); N], start: [f64; N], settings: CmaSettings, seed: u64) -> Self {
        let settings = CmaSettings { samples: settings.samples.max(4), ..settings };
        let mut made = Self {
            settings,
            bounds,
            streams: (0..settings.samples as u64)
                .map(|i| Stream::new(seed, Purpose::EvolutionStrategy, i))
                .collect(),
            mean: std::array::from_fn(|k| scaled(settings.scale, bounds[k], start[k])),
            sigma: settings.sigma,
            covariance: identity(),
            axes: (identity(), [1.0; N]),
            path_sigma: [0.0; N],
            path_c: [0.0; N],
            generation: 0,
            steps: Vec::new(),
            candidates: Vec::new(),
        };
        made.sample();
        made
    }

    fn sample(&mut self) {
        let (axes, lengths) = &self.axes;
        let step = |stream: &mut Stream| -> [f64; N] {
            let z: [f64; N] = std::array::from_fn(|_| stream.normal());
            std::array::from_fn(|r| (0..N).map(|c| axes[r][c] * lengths[c] * z[c]).sum())
        };
        self.steps = self.streams.iter_mut().map(step).collect();
        let place = |y: &[f64; N]| -> [f64; N] {
            std::array::from_fn(|k| {
                unscaled(self.settings.scale, self.bounds[k], reflected(self.mean[k] + self.sigma * y[k]))
            })
        };
        self.candidates = self.steps.iter().map(place).collect();
    }

    /// `C^(-1/2) y`.
    fn whitened(&self, y: &[f64; N]) -> [f64; N] {
        let (axes, lengths) = &self.axes;
        let along: [f64; N] =
            std::array::from_fn(|c| (0..N).map(|r| axes[r][c] * y[r]).sum::<f64>() / lengths[c]);
        std::array::from_fn(|r| (0..N).map(|c| axes[r][c] * along[c]).sum())
    }

    fn adapt(&mut self, best_first: &[usize]) {
        let n = N as f64;
        let weights = weights(best_first.len());
        let mu_eff = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        let c_sigma = (mu_eff + 2.0) / (n + mu_eff + 5.0);
        let d_sigma = 1.0 + 2.0 * (((mu_eff - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + c_sigma;
        let c_c = (4.0 + mu_eff / n) / (n + 4.0 + 2.0 * mu_eff / n);
        let c_1 = 2.0 / ((n + 1.3).powi(2) + mu_eff);
        let c_mu = (2.0 * (mu_eff - 2.0 + 1.0 / mu_eff) / ((n + 2.0).powi(2) + mu_eff)).min(1.0 - c_1);
        let expected_length = n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));

        let chosen: Vec<[f64; N]> = best_first[..weights.len()].iter().map(|&i| self.steps[i]).collect();
        let shift: [f64; N] =
            std::array::from_fn(|k| weights.iter().zip(&chosen).map(|(w, y)| w * y[k]).sum());
        // The mean stays within the bounds; the paths follow the unreflected steps.
        self.mean = std::array::from_fn(|k| reflected(self.mean[k] + self.sigma * shift[k]));
        let white = self.whitened(&shift);
        let keep = (c_sigma * (2.0 - c_sigma) * mu_eff).sqrt();
        self.path_sigma = std::array::from_fn(|k| (1.0 - c_sigma) * self.path_sigma[k] + keep * white[k]);
        let length = self.path_sigma.iter().map(|p| p * p).sum::<f64>().sqrt();
        self.generation += 1;
        let usual = (1.0 - math::powf(1.0 - c_sigma, 2.0 * f64::from(self.generation))).sqrt();
        let moving = length / usual < (1.4 + 2.0 / (n + 1.0)) * expected_length;
        let h = if moving { 1.0 } else { 0.0 };
        let keep = h * (c_c * (2.0 - c_c) * mu_eff).sqrt();
        self.path_c = std::array::from_fn(|k| (1.0 - c_c) * self.path_c[k] + keep * shift[k]);
        let lost = (1.0 - h) * c_1 * c_c * (2.0 - c_c);
        for r in 0..N {
            for c in 0..N {
                let rank_mu: f64 = weights.iter().zip(&chosen).map(|(w, y)| w * y[r] * y[c]).sum();
                self.covariance[r][c] = (1.0 - c_1 - c_mu + lost) * self.covariance[r][c]
                    + c_1 * self.path_c[r] * self.path_c[c]
                    + c_mu * rank_mu;
            }
        }
        self.sigma = (self.sigma * math::exp(c_sigma / d_sigma * (length / expected_length - 1.0))).min(1.0);
        let (axes, variances) = jacobi(self.covariance);
        self.axes = (axes, variances.map(|v| v.max(1e-20).sqrt()));
    }
}

/// Weights of the better half of `samples`, falling with the logarithm of the rank, summing to 1.
fn weights(samples: usize) -> Vec<f64> {
    let raw: Vec<f64> =
        (1..=samples / 2).map(|i| math::ln((samples as f64 + 1.0) / 2.0) - math::ln(i as f64)).collect();
    let sum: f64 = raw.iter().sum();
    raw.iter().map(|w| w / sum).collect()
}

impl<const N: usize> Optimiser<N> for CmaEs<N> {
    fn candidates(&self) -> &[[f64; N]] {
        &self.candidates
    }

    fn update(&mut self, costs: &[f64]) {
        let mut best_first: Vec<usize> = (0..self.steps.len()).collect();
        let cost = |i: usize| costs.get(i).map_or(f64::INFINITY, |c| usable(*c));
        // A stable sort: equals stay in their order.
        best_first.sort_by(|&a, &b| cost(a).total_cmp(&cost(b)));
        self.adapt(&best_first);
        self.sample();
    }

    fn has_converged(&self) -> bool {
        self.axes.1.iter().all(|length| self.sigma * length < self.settings.tolerance)
    }
}

fn scaled(scale: Scale, (low, high): (f64, f64), x: f64) -> f64 {
    let x = x.clamp(low, high);
    match scale {
        Scale::Linear => (x - low) / (high - low),
        Scale::Root => (x.sqrt() - low.sqrt()) / (high.sqrt() - low.sqrt()),
        Scale::Logarithmic => math::ln(x / low) / math::ln(high / low),
    }
}

fn unscaled(scale: Scale, (low, high): (f64, f64), s: f64) -> f64 {
    let x = match scale {
        Scale::Linear => low + (high - low) * s,
        Scale::Root => {
            let root = low.sqrt() + (high.sqrt() - low.sqrt()) * s;
            root * root
        }
        Scale::Logarithmic => low * math::exp(s * math::ln(high / low)),
    };
    x.clamp(low, high)
}

/// Folds the line into 0..1: ..., -0.1 -> 0.1, 1.1 -> 0.9, ...
fn reflected(s: f64) -> f64 {
    let t = s.rem_euclid(2.0);
    if t > 1.0 { 2.0 - t } else { t }
}

fn identity<const N: usize>() -> [[f64; N]; N] {
    std::array::from_fn(|r| std::array::from_fn(|c| if r == c { 1.0 } else { 0.0 }))
}

/// Eigenvectors (columns) and eigenvalues of a symmetric matrix, by Jacobi's cyclic rotations.
fn jacobi<const N: usize>(mut a: [[f64; N]; N]) -> ([[f64; N]; N], [f64; N]) {
    let mut vectors = identity();
    for _ in 0..60 {
        let off: f64 = (0..N).flat_map(|r| (0..r).map(move |c| (r, c))).map(|(r, c)| a[r][c] * a[r][c]).sum();
        let diagonal: f64 = (0..N).map(|k| a[k][k] * a[k][k]).sum();
        if off <= 1e-30 * diagonal {
            break;
        }
        for p in 0..N {
            for q in p + 1..N {
                rotate(&mut a, &mut vectors, p, q);
            }
        }
    }
    (vectors, std::array::from_fn(|k| a[k][k]))
}

/// Turns in the plane of `p` and `q` so that `a[p][q]` vanishes.
fn rotate<const N: usize>(a: &mut [[f64; N]; N], vectors: &mut [[f64; N]; N], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
    let cos = 1.0 / (1.0 + t * t).sqrt();
    let sin = t * cos;
    for row in a.iter_mut() {
        (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
    }
    let (row_p, row_q) = (a[p], a[q]);
    a[p] = std::array::from_fn(|k| cos * row_p[k] - sin * row_q[k]);
    a[q] = std::array::from_fn(|k| sin * row_p[k] + cos * row_q[k]);
    for row in vectors.iter_mut() {
        (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_eigenvectors_diagonalise() {
        let a = [[4.0, 1.0, -2.0], [1.0, 3.0, 0.5], [-2.0, 0.5, 1.0]];
        let (v, lambda) = jacobi(a);
        for c in 0..3 {
            for r in 0..3 {
                let av: f64 = (0..3).map(|k| a[r][k] * v[k][c]).sum();
                assert!((av - lambda[c] * v[r][c]).abs() < 1e-14);
            }
        }
        assert!((lambda.iter().sum::<f64>() - 8.0).abs() < 1e-14);
    }

    #[test]
    fn closed_form_scales_and_reflection() {
        for scale in [Scale::Linear, Scale::Root, Scale::Logarithmic] {
            for x in [1e-4, 0.3, 5.0] {
                assert!((unscaled(scale, (1e-4, 5.0), scaled(scale, (1e-4, 5.0), x)) - x).abs() < 1e-14);
            }
        }
        for (s, folded) in [(0.3, 0.3), (-0.1, 0.1), (1.1, 0.9), (2.3, 0.3), (-1.2, 0.8)] {
            assert!((reflected(s) - folded).abs() < 1e-14, "{s}");
        }
    }

    #[test]
    fn closed_form_weights_fall_and_sum_to_one() {
        let w = weights(16);
        assert!(w.len() == 8 && w.is_sorted_by(|a, b| a > b) && (w.iter().sum::<f64>() - 1.0).abs() < 1e-15);
    }
}
