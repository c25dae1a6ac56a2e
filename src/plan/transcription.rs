//! Hermite-Simpson transcription (33)-(39): defects, cost, and their derivatives interval by interval.
//!
//! ```text
//! e_k = x_k - x_k+1 + dt/6 (f_k + 4 f_c + f_k+1)                    (33)
//! u_c = (u_k + u_k+1)/2,  x_c = (x_k + x_k+1)/2 + dt/8 (f_k - f_k+1) (35), (36)
//! ```

use nalgebra::{SMatrix, SVector};

use super::block::{add_mul, mul};
use super::dynamics::{Dynamics, Linearisation};
use super::problem::{Nodes, Problem};

/// Defects and cost at a point.
#[derive(Clone, Debug)]
pub struct Evaluation<const NX: usize> {
    /// Defect of each interval.
    pub defects: Vec<SVector<f64, NX>>,
    /// J_d of (32).
    pub objective: f64,
    /// Sum of the absolute defects.
    pub defect_sum: f64,
    /// Largest absolute defect.
    pub defect_max: f64,
}

/// The dynamics linearised at all nodes and midpoints.
#[derive(Clone, Debug)]
pub struct Linearised<const NX: usize, const NU: usize> {
    /// At the nodes.
    pub nodes: Vec<Linearisation<NX, NU>>,
    /// At the midpoints.
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

    /// J_d, (32), (38), (39).
    pub fn objective(&self, nodes: &Nodes<NX, NU>) -> f64 {
        (0..=self.intervals).fold(0.0, |sum, k| {
            let (dx, du) = (nodes.x[k] - self.cost.x_ref, nodes.u[k] - self.cost.u_ref);
            sum + dx.component_mul(&dx).dot(&self.state_weight(k))
                + du.component_mul(&du).dot(&self.cost.r) * self.node_weight(k)
        })
    }

    /// Defects and cost at `nodes`.
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

    /// The dynamics linearised at nodes and midpoints, with the defects that come with it.
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
    /// By x_k.
    pub x_left: SMatrix<f64, NX, NX>,
    /// By u_k.
    pub u_left: SMatrix<f64, NX, NU>,
    /// By x_k+1.
    pub x_right: SMatrix<f64, NX, NX>,
    /// By u_k+1.
    pub u_right: SMatrix<f64, NX, NU>,
}

impl<const NX: usize, const NU: usize> Linearised<NX, NU> {
    /// Jacobians of defect `k`.
    #[inline(always)]
    pub fn defect_jacobian(&self, k: usize, dt_s: f64) -> DefectJacobian<NX, NU> {
        let (left, middle, right) = (&self.nodes[k], &self.middles[k], &self.nodes[k + 1]);
        let (w, eighth) = (dt_s / 6.0, dt_s / 8.0);
        let twice = middle.a * 2.0;
        let mut x_left = left.a + twice;
        let mut x_right = right.a + twice;
        let scaled = middle.a * (4.0 * eighth);
        add_mul(&mut x_left, &scaled, &left.a);
        add_mul(&mut x_right, &scaled, &(-right.a));
        x_left *= w;
        x_right *= w;
        for i in 0..NX {
            x_left[(i, i)] += 1.0;
            x_right[(i, i)] -= 1.0;
        }
        let half_b = middle.b * 2.0;
        let u_left = (left.b + half_b + mul(&scaled, &left.b)) * w;
        let u_right = (right.b + half_b - mul(&scaled, &right.b)) * w;
        DefectJacobian { x_left, u_left, x_right, u_right }
    }
}
