//! The optimal control problem (25)-(31), transcribed at equidistant nodes (32).
//!
//! ```text
//! min  Phi(x_N) + sum_k dt/2 (L(x_k, u_k) + L(x_k+1, u_k+1))
//!      L = (x - x_ref)' Q (x - x_ref) + (u - u_ref)' R (u - u_ref)
//! s.t. e_k(x_k, u_k, x_k+1, u_k+1) = 0          Hermite-Simpson defects (33)-(37)
//!      x_1, u_1 given;  u_min <= u_k <= u_max;  |u_k+1 - u_k| <= dt u_rate;  x_min <= x_k <= x_max
//!      g(x, u, u') <= 0 at midpoints and nodes
//! ```
//!
//! Differs from the paper: 37 intervals join its 38 nodes (it prints dt = t_f/38 *and* nodes from t_0 to t_f,
//! which cannot both be); the cost (39) is the trapezoid over nodes (printed with `L_d` on both sides).
//! Beyond the paper, and off by default: bounds on the states (on the way and at the end), a reference for
//! the input cost, constraints on the path ([`super::path`]), and for quantities that are one number for the
//! whole plan (a peak, the length of the horizon): states that do not change and whose initial value is free,
//! a cost that is linear in the final state, and a state that stretches time.

use std::sync::Arc;

use nalgebra::SVector;

use super::path::{PathConstraint, PathPlace, PathRow, Point, PointGradient};

/// Quadratic cost with diagonal weights, (26)-(30).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraticCost<const NX: usize, const NU: usize> {
    /// Reference x_ss of the state cost.
    pub x_ref: SVector<f64, NX>,
    /// Input that costs nothing; zero in the paper.
    pub u_ref: SVector<f64, NU>,
    /// Diagonal of Q, the weight of the state along the way.
    pub q: SVector<f64, NX>,
    /// Diagonal of R, the weight of the input.
    pub r: SVector<f64, NU>,
    /// Diagonal of S, the weight of the final state.
    pub s: SVector<f64, NX>,
    /// Cost per unit of each component of the final state; zero in the paper.
    pub s_linear: SVector<f64, NX>,
    /// Index of the state that the running cost is multiplied with: the stretch of time where the dynamics
    /// have one.
    pub stretch: Option<usize>,
}

impl<const NX: usize, const NU: usize> QuadraticCost<NX, NU> {
    /// The cost of (26)-(30) with these weights about these references.
    pub fn new(
        (x_ref, u_ref): (SVector<f64, NX>, SVector<f64, NU>),
        q: SVector<f64, NX>,
        r: SVector<f64, NU>,
        s: SVector<f64, NX>,
    ) -> Self {
        Self { x_ref, u_ref, q, r, s, s_linear: SVector::zeros(), stretch: None }
    }

    /// The running cost `L` of a point.
    #[inline(always)]
    pub fn running(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>) -> f64 {
        let (dx, du) = (x - self.x_ref, u - self.u_ref);
        dx.component_mul(&dx).dot(&self.q) + du.component_mul(&du).dot(&self.r)
    }

    /// The cost multiplied by a factor.
    fn times(&self, factor: f64) -> Self {
        Self {
            q: self.q * factor,
            r: self.r * factor,
            s: self.s * factor,
            s_linear: self.s_linear * factor,
            ..*self
        }
    }
}

/// Bounds on inputs, their rates, and states; infinite where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds<const NX: usize, const NU: usize> {
    /// Least input.
    pub u_min: SVector<f64, NU>,
    /// Greatest input.
    pub u_max: SVector<f64, NU>,
    /// Greatest rate of change of the input [1/s].
    pub u_rate: SVector<f64, NU>,
    /// Least state, at every node but the first.
    pub x_min: SVector<f64, NX>,
    /// Greatest state, at every node but the first.
    pub x_max: SVector<f64, NX>,
    /// Least state at the last node (with `x_end_max`: a terminal set).
    pub x_end_min: SVector<f64, NX>,
    /// Greatest state at the last node.
    pub x_end_max: SVector<f64, NX>,
}

impl<const NX: usize, const NU: usize> Bounds<NX, NU> {
    /// Bounds on the inputs and their rates only.
    pub fn on_input(u_min: SVector<f64, NU>, u_max: SVector<f64, NU>, u_rate: SVector<f64, NU>) -> Self {
        let (least, greatest) =
            (SVector::from_element(f64::NEG_INFINITY), SVector::from_element(f64::INFINITY));
        Self { u_min, u_max, u_rate, x_min: least, x_max: greatest, x_end_min: least, x_end_max: greatest }
    }

    /// Bounds on the state at node `k` of `last`.
    #[inline(always)]
    pub fn on_state(&self, k: usize, last: usize) -> (SVector<f64, NX>, SVector<f64, NX>) {
        if k == last {
            (self.x_min.sup(&self.x_end_min), self.x_max.inf(&self.x_end_max))
        } else {
            (self.x_min, self.x_max)
        }
    }
}

/// The optimal control problem, transcribed at equidistant nodes.
#[derive(Clone, Debug)]
pub struct Problem<D, const NX: usize, const NU: usize> {
    /// The dynamics `x_dot = f(x, u)`.
    pub dynamics: D,
    /// State at the first node.
    pub x_initial: SVector<f64, NX>,
    /// Components of the state at the first node that are free, for the solver to choose; `x_initial` is then
    /// where it begins.
    pub x_initial_free: SVector<bool, NX>,
    /// Input at the first node.
    pub u_initial: SVector<f64, NU>,
    /// Number of intervals: nodes less one.
    pub intervals: usize,
    /// Length of an interval [s].
    pub dt_s: f64,
    /// The quadratic cost (26)-(30).
    pub cost: QuadraticCost<NX, NU>,
    /// Bounds on inputs, rates and states.
    pub bounds: Bounds<NX, NU>,
    /// Inequality constraints on the path.
    pub constraints: Vec<Arc<dyn PathConstraint<NX, NU>>>,
}

impl<D, const NX: usize, const NU: usize> Problem<D, NX, NU> {
    /// The problem from this state and input, both given, over so many intervals of this length [s], without
    /// constraints on the path.
    pub fn new(
        dynamics: D,
        (x_initial, u_initial): (SVector<f64, NX>, SVector<f64, NU>),
        (intervals, dt_s): (usize, f64),
        cost: QuadraticCost<NX, NU>,
        bounds: Bounds<NX, NU>,
    ) -> Self {
        Self {
            dynamics,
            x_initial,
            x_initial_free: SVector::from_element(false),
            u_initial,
            intervals,
            dt_s,
            cost,
            bounds,
            constraints: Vec::new(),
        }
    }

    /// The problem with its dynamics borrowed, which can be copied, and its cost multiplied by a factor.
    pub fn with_cost_times(&self, factor: f64) -> Problem<&D, NX, NU> {
        Problem {
            dynamics: &self.dynamics,
            x_initial: self.x_initial,
            x_initial_free: self.x_initial_free,
            u_initial: self.u_initial,
            intervals: self.intervals,
            dt_s: self.dt_s,
            cost: self.cost.times(factor),
            bounds: self.bounds,
            constraints: self.constraints.clone(),
        }
    }

    /// Calls `visit` with each constraint that applies at the midpoint `(x_c, u_c)` of interval `k` and at
    /// the node at its end, in that order.
    #[inline]
    pub(super) fn along_path(
        &self,
        nodes: &Nodes<NX, NU>,
        k: usize,
        middle: (&SVector<f64, NX>, &SVector<f64, NU>),
        mut visit: impl FnMut(&dyn PathConstraint<NX, NU>, &Point<'_, NX, NU>),
    ) {
        let u_dot = (nodes.u[k + 1] - nodes.u[k]) / self.dt_s;
        let place = PathPlace { interval: k, middle: true, t_s: (k as f64 + 0.5) * self.dt_s, last: false };
        let last = k + 1 == self.intervals;
        let end = PathPlace { middle: false, t_s: (k as f64 + 1.0) * self.dt_s, last, ..place };
        let points = [
            Point { place, x: middle.0, u: middle.1, u_dot },
            Point { place: end, x: &nodes.x[k + 1], u: &nodes.u[k + 1], u_dot: SVector::zeros() },
        ];
        for at in &points {
            for constraint in &self.constraints {
                if constraint.applies(&at.place) {
                    visit(&**constraint, at);
                }
            }
        }
    }

    /// The constraint at a point, as a row.
    pub(super) fn row(
        &self,
        constraint: &dyn PathConstraint<NX, NU>,
        at: &Point<'_, NX, NU>,
    ) -> PathRow<NX, NU> {
        let PointGradient { x, u, u_dot } = constraint.gradient(at);
        PathRow { interval: at.place.interval, middle: at.place.middle, x, u, w: u_dot / self.dt_s }
    }

    /// Whether any component of the initial state is free.
    pub fn has_free_initial(&self) -> bool {
        self.x_initial_free.iter().any(|free| *free)
    }
}

/// States and inputs at the nodes: what a solver starts from and ends with.
#[derive(Clone, Debug, PartialEq)]
pub struct Nodes<const NX: usize, const NU: usize> {
    /// States, one per node.
    pub x: Vec<SVector<f64, NX>>,
    /// Inputs, one per node.
    pub u: Vec<SVector<f64, NU>>,
}

impl<const NX: usize, const NU: usize> Nodes<NX, NU> {
    /// Whether there is one node more than `intervals`.
    pub(super) fn fits(&self, intervals: usize) -> bool {
        self.x.len() == intervals + 1 && self.u.len() == intervals + 1
    }
}
