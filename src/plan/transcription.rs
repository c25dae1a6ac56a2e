//! Hermite-Simpson transcription (33)-(39): defects, cost, and their derivatives interval by interval.
//!
//! ```text
//! e_k = x_k - x_k+1 + dt/6 (f_k + 4 f_c + f_k+1)                    (33)
//! u_c = (u_k + u_k+1)/2,  x_c = (x_k + x_k+1)/2 + dt/8 (f_k - f_k+1) (35), (36)
//! ```

use nalgebra::{SMatrix, SVector};

use super::block::{add_mul, add_scaled, scaled};
use super::dynamics::{Dynamics, Linearisation};
use super::problem::{Nodes, Problem};

/// Defects and cost at a set of node values.
#[derive(Clone, Debug)]
pub struct Evaluation<const NX: usize> {
    /// Defect (33) of each interval.
    pub defects: Vec<SVector<f64, NX>>,
    /// Cost J_d of (32).
    pub objective: f64,
    /// Sum of the absolute defects.
    pub defect_sum: f64,
    /// Largest absolute defect.
    pub defect_max: f64,
}

/// The dynamics linearised at all nodes and midpoints.
#[derive(Clone, Debug)]
pub struct Linearised<const NX: usize, const NU: usize> {
    /// Linearisation at each node.
    pub nodes: Vec<Linearisation<NX, NU>>,
    /// Linearisation at the midpoint of each interval.
    pub middles: Vec<Linearisation<NX, NU>>,
}

/// State and input at the midpoint of an interval, (35) and (36).
#[inline(always)]
pub fn midpoint<const NX: usize, const NU: usize>(
    nodes: &Nodes<NX, NU>,
    k: usize,
    dt_s: f64,
    f_left: &SVector<f64, NX>,
    f_right: &SVector<f64, NX>,
) -> (SVector<f64, NX>, SVector<f64, NU>) {
    let x_c = (nodes.x[k] + nodes.x[k + 1]) * 0.5 + (f_left - f_right) * (dt_s / 8.0);
    (x_c, (nodes.u[k] + nodes.u[k + 1]) * 0.5)
}

/// The defect (33) from its parts.
#[inline(always)]
fn defect<const NX: usize, const NU: usize>(
    nodes: &Nodes<NX, NU>,
    k: usize,
    dt_s: f64,
    f: [&SVector<f64, NX>; 3],
) -> SVector<f64, NX> {
    nodes.x[k] - nodes.x[k + 1] + (f[0] + f[1] * 4.0 + f[2]) * (dt_s / 6.0)
}

impl<D: Dynamics<NX, NU>, const NX: usize, const NU: usize> Problem<D, NX, NU> {
    /// Weight of node `k` in the trapezoid: dt, half of it at the ends.
    #[inline(always)]
    pub fn node_weight(&self, k: usize) -> f64 {
        if k == 0 || k == self.intervals { 0.5 * self.dt_s } else { self.dt_s }
    }

    /// Diagonal of half the cost's Hessian with respect to the state at node `k`.
    #[inline(always)]
    pub fn state_weight(&self, k: usize) -> SVector<f64, NX> {
        let stage = self.cost.q * self.node_weight(k);
        if k == self.intervals { stage + self.cost.s } else { stage }
    }

    /// Cost J_d of node values, (32), (38), (39).
    pub fn objective(&self, nodes: &Nodes<NX, NU>) -> f64 {
        (0..=self.intervals).fold(0.0, |sum, k| {
            let (dx, du) = (nodes.x[k] - self.cost.x_ref, nodes.u[k] - self.cost.u_ref);
            sum + dx.component_mul(&dx).dot(&self.state_weight(k))
                + du.component_mul(&du).dot(&self.cost.r) * self.node_weight(k)
        })
    }

    /// Defects and cost of node values.
    pub fn evaluate(&self, nodes: &Nodes<NX, NU>) -> Evaluation<NX> {
        let mut left = self.dynamics.value(&nodes.x[0], &nodes.u[0]);
        let mut defects = Vec::with_capacity(self.intervals);
        for k in 0..self.intervals {
            let right = self.dynamics.value(&nodes.x[k + 1], &nodes.u[k + 1]);
            let (x_c, u_c) = midpoint(nodes, k, self.dt_s, &left, &right);
            let middle = self.dynamics.value(&x_c, &u_c);
            defects.push(defect(nodes, k, self.dt_s, [&left, &middle, &right]));
            left = right;
        }
        Evaluation::new(defects, self.objective(nodes))
    }

    /// The dynamics linearised at nodes and midpoints, with defects and cost.
    pub fn linearise(&self, nodes: &Nodes<NX, NU>) -> (Linearised<NX, NU>, Evaluation<NX>) {
        let mut at_nodes = Vec::with_capacity(self.intervals + 1);
        let mut middles = Vec::with_capacity(self.intervals);
        let mut defects = Vec::with_capacity(self.intervals);
        at_nodes.push(self.dynamics.linearise(&nodes.x[0], &nodes.u[0]));
        for k in 0..self.intervals {
            let right = self.dynamics.linearise(&nodes.x[k + 1], &nodes.u[k + 1]);
            let left: &Linearisation<NX, NU> = &at_nodes[k];
            let (x_c, u_c) = midpoint(nodes, k, self.dt_s, &left.f, &right.f);
            let middle = self.dynamics.linearise(&x_c, &u_c);
            defects.push(defect(nodes, k, self.dt_s, [&left.f, &middle.f, &right.f]));
            middles.push(middle);
            at_nodes.push(right);
        }
        (Linearised { nodes: at_nodes, middles }, Evaluation::new(defects, self.objective(nodes)))
    }
}

impl<const NX: usize> Evaluation<NX> {
    fn new(defects: Vec<SVector<f64, NX>>, objective: f64) -> Self {
        let mut defect_sum = 0.0;
        let mut defect_max = 0.0f64;
        for e in &defects {
            for x in e.iter() {
                defect_sum += x.abs();
                // `max` would drop a NaN.
                defect_max = if x.abs() <= defect_max { defect_max } else { x.abs() };
            }
        }
        Self { defects, objective, defect_sum, defect_max }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.objective.is_finite() && self.defect_sum.is_finite()
    }
}

/// Jacobians of a defect `e_k` with respect to the nodes at its ends.
#[derive(Clone, Copy, Debug)]
pub struct DefectJacobian<const NX: usize, const NU: usize> {
    /// Jacobian by the state `x_k`.
    pub x_left: SMatrix<f64, NX, NX>,
    /// Jacobian by the input `u_k`.
    pub u_left: SMatrix<f64, NX, NU>,
    /// Jacobian by the state `x_k+1`.
    pub x_right: SMatrix<f64, NX, NX>,
    /// Jacobian by the input `u_k+1`.
    pub u_right: SMatrix<f64, NX, NU>,
}

impl<const NX: usize, const NU: usize> Linearised<NX, NU> {
    /// Jacobians of defect `k` with respect to the nodes at its ends.
    #[inline(always)]
    pub fn defect_jacobian(&self, k: usize, dt_s: f64) -> DefectJacobian<NX, NU> {
        let (left, middle, right) = (&self.nodes[k], &self.middles[k], &self.nodes[k + 1]);
        let (w, h12) = (dt_s / 6.0, dt_s * dt_s / 12.0);
        // By the left state: I + dt/6 (A_k + 2 A_c) + dt^2/12 A_c A_k; by the right: -I + dt/6 (..) - dt^2/12
        // ..
        let by_f = scaled(&middle.a, h12);
        let mut jacobian = DefectJacobian {
            x_left: SMatrix::from_diagonal_element(1.0),
            u_left: SMatrix::zeros(),
            x_right: SMatrix::from_diagonal_element(-1.0),
            u_right: SMatrix::zeros(),
        };
        add_end(&mut jacobian.x_left, &left.a, &middle.a, &by_f, w);
        add_end(&mut jacobian.u_left, &left.b, &middle.b, &by_f, w);
        let by_f = scaled(&by_f, -1.0);
        add_end(&mut jacobian.x_right, &right.a, &middle.a, &by_f, w);
        add_end(&mut jacobian.u_right, &right.b, &middle.b, &by_f, w);
        jacobian
    }
}

/// `out += w (end + 2 middle) + by_f end`.
#[inline(always)]
fn add_end<const NX: usize, const C: usize>(
    out: &mut SMatrix<f64, NX, C>,
    end: &SMatrix<f64, NX, C>,
    middle: &SMatrix<f64, NX, C>,
    by_f: &SMatrix<f64, NX, NX>,
    w: f64,
) {
    add_scaled(out, end, w);
    add_scaled(out, middle, 2.0 * w);
    add_mul(out, by_f, end);
}
