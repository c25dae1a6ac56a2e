//! The optimal control problem (25)-(31), transcribed at equidistant nodes (32).
//!
//! ```text
//! min  Phi(x_N) + sum_k dt/2 (L(x_k, u_k) + L(x_k+1, u_k+1))
//!      L = (x - x_ref)' Q (x - x_ref) + (u - u_ref)' R (u - u_ref)
//! s.t. e_k(x_k, u_k, x_k+1, u_k+1) = 0          Hermite-Simpson defects (33)-(37)
//!      x_1, u_1 given;  u_min <= u_k <= u_max;  |u_k+1 - u_k| <= dt u_rate;  x_min <= x_k <= x_max
//! ```
//!
//! Differs from the paper: 37 intervals join its 38 nodes (it prints dt = t_f/38 *and* nodes from t_0 to t_f,
//! which cannot both be); the cost (39) is the trapezoid over nodes (printed with `L_d` on both sides).
//! Beyond the paper, and off by default: bounds on the states (on the way and at the end) and a reference for
//! the input cost.

use nalgebra::SVector;

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
