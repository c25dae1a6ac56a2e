//! What the interior point method needs of the constraints on the path ([`super::path`]): slacks,
//! multipliers, and their share of the Newton system.
//!
//! ```text
//! g_i(x, u, u') + t_i = 0 ,   t_i >= 0
//! ```
//!
//! Each constraint has a slack `t` of its own at each place, with a logarithmic barrier and a multiplier `z`.
//! A Newton step of the slacks and their multipliers follows from that of states and inputs, so that the
//! sweep over the stages ([`super::riccati`]) sees no more than a Hessian `J' (z/t) J` and a gradient
//! `J' (mu/t + z/t (g + t))` at nodes and midpoints: its size does not grow.
//!
//! Where more constraints are active than there is freedom left (a pitch at its bound at a node and at the
//! midpoints beside it), their gradients depend on each other, multipliers have no single value, and weights
//! `z/t` beyond the digits of a number hide the rest of the Hessian. Then the rows give way by a small `d`,
//! as in IPOPT (Waechter and Biegler 2006, (13)):
//!
//! ```text
//! g_i + J d_x + t_i + dt_i = d dz_i    (otherwise 0)
//! ```
//!
//! No weight is then larger than `1/d`. The solution is the same: where multipliers no longer change, nothing
//! gives way.

use nalgebra::SVector;

use super::dynamics::{Curvature, Dynamics};
use super::path::{MoveTerms, PathRow, PointCurvature};
use super::problem::{Nodes, Problem};
use super::riccati::{NodeGradient, NodeTerms, Step};
use super::transcription::{Linearised, midpoint};

/// Slacks and multipliers of the constraints, one of each for a constraint at a place.
#[derive(Clone, Debug, Default)]
pub struct PathDuals {
    /// Slacks, above zero.
    pub slack: Vec<f64>,
    /// Multipliers, above zero.
    pub z: Vec<f64>,
}

/// Least slack that a cold start gives a constraint.
const SLACK_LEAST: f64 = 1e-2;
/// Greatest factor between a multiplier and its central value (Waechter and Biegler 2006, (16)).
const KAPPA_SIGMA: f64 = 1e10;

impl PathDuals {
    /// Slacks that make up for the values `g` where these leave room, and multipliers on the central path.
    pub(super) fn centred(g: &[f64], mu: f64) -> Self {
        Self::with_slacks(g.iter().map(|g| (-g).max(SLACK_LEAST)).collect(), mu)
    }

    pub(super) fn with_slacks(slack: Vec<f64>, mu: f64) -> Self {
        let z = slack.iter().map(|t| mu / t).collect();
        Self { slack, z }
    }

    /// Sum of the violations `|g + t|`.
    pub(super) fn violation(&self, g: &[f64]) -> f64 {
        g.iter().zip(&self.slack).fold(0.0, |sum, (g, t)| sum + (g + t).abs())
    }

    /// Largest violation `|g + t|`.
    pub(super) fn violation_max(&self, g: &[f64]) -> f64 {
        g.iter().zip(&self.slack).fold(0.0, |most, (g, t)| {
            let v = (g + t).abs();
            // `max` would drop a NaN.
            if v <= most { most } else { v }
        })
    }

    /// Largest deviation `|z t - mu|` from the central path.
    pub(super) fn complementarity(&self, mu: f64) -> f64 {
        self.slack.iter().zip(&self.z).fold(0.0f64, |most, (t, z)| most.max((t * z - mu).abs()))
    }

    /// Sum of the logarithms of the slacks.
    pub(super) fn log_slack(&self) -> f64 {
        self.slack.iter().map(|t| crate::math::ln(*t)).sum()
    }

    /// The residuals `g + t`.
    pub(super) fn residuals(&self, g: &[f64]) -> Vec<f64> {
        g.iter().zip(&self.slack).map(|(g, t)| g + t).collect()
    }

    /// Weights `z/(t + give z)` of the rows in the Hessian.
    pub(super) fn weights(&self, give: f64) -> Vec<f64> {
        self.slack.iter().zip(&self.z).map(|(t, z)| z / (t + give * z)).collect()
    }

    /// Multipliers `(mu + give z^2 + z r)/(t + give z)` of the rows in the gradient, for residuals `r`.
    pub(super) fn multipliers(&self, residuals: &[f64], mu: f64, give: f64) -> Vec<f64> {
        let pairs = self.slack.iter().zip(&self.z).zip(residuals);
        pairs.map(|((t, z), r)| (mu + give * z * z + z * r) / (t + give * z)).collect()
    }

    /// Newton steps of slacks and multipliers, for residuals `r` and a change `change = J d` of the values.
    pub(super) fn step(&self, residuals: &[f64], change: &[f64], mu: f64, give: f64) -> Self {
        let rows = self.slack.iter().zip(&self.z).zip(residuals.iter().zip(change));
        let steps = rows.map(|((t, z), (r, jd))| {
            let closing = -r - jd;
            let dz = (mu + give * z * z - z * closing) / (t + give * z) - z;
            (closing + give * dz, dz)
        });
        let (slack, z) = steps.unzip();
        Self { slack, z }
    }

    /// Directional derivative of `-mu sum log(t)` along a step.
    pub(super) fn slope(&self, step: &Self, mu: f64) -> f64 {
        -mu * self.slack.iter().zip(&step.slack).fold(0.0, |sum, (t, dt)| sum + dt / t)
    }

    /// Longest steps of slacks and multipliers in [0, 1] that keep the fraction `1 - tau` of each.
    pub(super) fn longest_steps(&self, step: &Self, tau: f64) -> (f64, f64) {
        let longest = |values: &[f64], steps: &[f64]| {
            values.iter().zip(steps).fold(
                1.0f64,
                |alpha, (v, d)| {
                    if *d < 0.0 { alpha.min(tau * v / -d) } else { alpha }
                },
            )
        };
        (longest(&self.slack, &step.slack), longest(&self.z, &step.z))
    }

    /// The slacks moved along a step; where the new values `g` leave more room, the room itself.
    pub(super) fn moved(&self, step: &Self, alpha: f64, g: &[f64]) -> Vec<f64> {
        let moved = self.slack.iter().zip(&step.slack).zip(g);
        moved.map(|((t, dt), g)| (t + alpha * dt).max(-g)).collect()
    }

    /// Moves the multipliers along a step and keeps each near its central value.
    pub(super) fn accept(&mut self, slack: Vec<f64>, step: &Self, alpha: f64, mu: f64) {
        self.slack = slack;
        for ((z, dz), t) in self.z.iter_mut().zip(&step.z).zip(&self.slack) {
            *z = (*z + alpha * dz).min(KAPPA_SIGMA * mu / t).max(mu / (KAPPA_SIGMA * t));
        }
    }
}

impl<D: Dynamics<NX, NU>, const NX: usize, const NU: usize> Problem<D, NX, NU> {
    /// Adds the gradient `J' multipliers` of the rows to those of the nodes.
    pub(super) fn add_path_gradient(
        &self,
        linearised: &Linearised<NX, NU>,
        multipliers: &[f64],
        gradients: &mut [NodeGradient<NX, NU>],
    ) {
        let eighth = self.dt_s / 8.0;
        for (row, &m) in linearised.path.iter().zip(multipliers) {
            let k = row.interval;
            if row.middle {
                let (left, right) = (&linearised.nodes[k], &linearised.nodes[k + 1]);
                let (half_x, half_u) = (row.x * (0.5 * m), row.u * (0.5 * m));
                gradients[k].x += half_x + left.a.tr_mul(&row.x) * (eighth * m);
                gradients[k].u += half_u + left.b.tr_mul(&row.x) * (eighth * m);
                gradients[k].w += row.w * m;
                gradients[k + 1].x += half_x - right.a.tr_mul(&row.x) * (eighth * m);
                gradients[k + 1].u += half_u - right.b.tr_mul(&row.x) * (eighth * m);
            } else {
                gradients[k + 1].x += row.x * m;
                gradients[k + 1].u += row.u * m;
            }
        }
    }

    /// The change `J d` of the rows' values along a step.
    pub(super) fn path_change(&self, linearised: &Linearised<NX, NU>, step: &Step<NX, NU>) -> Vec<f64> {
        let mut middle = (usize::MAX, SVector::zeros());
        let change = |row: &PathRow<NX, NU>| {
            let k = row.interval;
            if !row.middle {
                return row.x.dot(&step.x[k + 1]) + row.u.dot(&step.u[k + 1]);
            }
            if middle.0 != k {
                middle = (k, self.middle_change(linearised, step, k));
            }
            let du = (step.u[k] + step.u[k + 1]) * 0.5;
            row.x.dot(&middle.1) + row.u.dot(&du) + row.w.dot(&(step.u[k + 1] - step.u[k]))
        };
        linearised.path.iter().map(change).collect()
    }

    /// The change of the state at the midpoint of interval `k` along a step.
    fn middle_change(
        &self,
        linearised: &Linearised<NX, NU>,
        step: &Step<NX, NU>,
        k: usize,
    ) -> SVector<f64, NX> {
        let f = |k: usize| linearised.nodes[k].a * step.x[k] + linearised.nodes[k].b * step.u[k];
        (step.x[k] + step.x[k + 1]) * 0.5 + (f(k) - f(k + 1)) * (self.dt_s / 8.0)
    }

    /// Adds the Hessian `J' weights J` of the rows to those at nodes, midpoints and of the moves.
    pub(super) fn add_path_hessian(
        &self,
        linearised: &Linearised<NX, NU>,
        weights: &[f64],
        hessian: &mut PathHessian<'_, NX, NU>,
    ) {
        for (row, &weight) in linearised.path.iter().zip(weights) {
            let own = hessian.at(row.interval, row.middle);
            for i in 0..NX {
                own.xx.column_mut(i).axpy(weight * row.x[i], &row.x, 1.0);
                own.ux.column_mut(i).axpy(weight * row.x[i], &row.u, 1.0);
            }
            for i in 0..NU {
                own.uu.column_mut(i).axpy(weight * row.u[i], &row.u, 1.0);
            }
            if row.middle {
                let moves = &mut hessian.moves[row.interval];
                for i in 0..NU {
                    moves.ww.column_mut(i).axpy(weight * row.w[i], &row.w, 1.0);
                    moves.wu.column_mut(i).axpy(weight * row.u[i], &row.w, 1.0);
                }
                for i in 0..NX {
                    moves.wx.column_mut(i).axpy(weight * row.x[i], &row.w, 1.0);
                }
            }
        }
    }

    /// Adds the second derivatives of the constraints, weighted with their multipliers `z`, to those at
    /// nodes, midpoints and of the moves; and to `weights` what the state of a midpoint, which the dynamics
    /// at the nodes beside it decide, hands on to them.
    pub(super) fn add_path_curvature(
        &self,
        nodes: &Nodes<NX, NU>,
        linearised: &Linearised<NX, NU>,
        z: &[f64],
        hessian: &mut PathHessian<'_, NX, NU>,
        weights: &mut [SVector<f64, NX>],
    ) {
        let (per_s, eighth) = (1.0 / self.dt_s, self.dt_s / 8.0);
        let mut rows = linearised.path.iter().zip(z);
        for k in 0..self.intervals {
            let (f_left, f_right) = (&linearised.nodes[k].f, &linearised.nodes[k + 1].f);
            let (x_c, u_c) = midpoint(nodes, k, self.dt_s, f_left, f_right);
            self.along_path(nodes, k, (&x_c, &u_c), |constraint, at| {
                let Some((row, &z)) = rows.next() else { return };
                let mut sum = PointCurvature::zero();
                constraint.add_curvature(at, z, &mut sum);
                let own = hessian.at(k, row.middle);
                *own += sum.states;
                if row.middle {
                    let moves = &mut hessian.moves[k];
                    moves.ww += sum.moves.ww * (per_s * per_s);
                    moves.wx += sum.moves.wx * per_s;
                    moves.wu += sum.moves.wu * per_s;
                    weights[k] += row.x * (eighth * z);
                    weights[k + 1] -= row.x * (eighth * z);
                }
            });
        }
    }
}

/// Where the Hessian of the constraints goes: to the terms of the nodes and the midpoints, and of the moves.
pub(super) struct PathHessian<'a, const NX: usize, const NU: usize> {
    pub(super) nodes: &'a mut [NodeTerms<NX, NU>],
    pub(super) middles: &'a mut [Curvature<NX, NU>],
    pub(super) moves: &'a mut [MoveTerms<NX, NU>],
}

impl<const NX: usize, const NU: usize> PathHessian<'_, NX, NU> {
    fn at(&mut self, interval: usize, middle: bool) -> &mut Curvature<NX, NU> {
        if middle { &mut self.middles[interval] } else { &mut self.nodes[interval + 1].hessian }
    }
}
