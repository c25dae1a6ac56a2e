//! Hermite-Simpson transcription (33)-(39): defects, cost, and their derivatives interval by interval.
//!
//! ```text
//! e_k = x_k - x_k+1 + dt/6 (f_k + 4 f_c + f_k+1)                    (33)
//! u_c = (u_k + u_k+1)/2,  x_c = (x_k + x_k+1)/2 + dt/8 (f_k - f_k+1) (35), (36)
//! ```

use nalgebra::{SMatrix, SVector};

use super::block::{add_mul, add_scaled, inverse, scaled};
use super::dynamics::{Curvature, Dynamics, Linearisation};
use super::path::PathRow;
use super::problem::{Nodes, Problem};

/// Defects and cost at a set of node values.
#[derive(Clone, Debug)]
pub struct Evaluation<const NX: usize> {
    /// Defect (33) of each interval.
    pub defects: Vec<SVector<f64, NX>>,
    /// Values of the constraints on the path, interval by interval, the midpoint before the node at its end.
    pub path: Vec<f64>,
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
    /// Constraints on the path, linearised, in the order of [`Evaluation::path`].
    pub path: Vec<PathRow<NX, NU>>,
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
        if let Some(stretch) = self.cost.stretch {
            let (end, c) = (&nodes.x[self.intervals], &self.cost);
            let off = end - c.x_ref;
            let running = (0..=self.intervals).fold(0.0, |sum, k| {
                let (x, u) = (&nodes.x[k], &nodes.u[k]);
                sum + x[stretch] * self.node_weight(k) * c.running(x, u)
            });
            return running + off.component_mul(&off).dot(&c.s) + end.dot(&c.s_linear);
        }
        let linear = nodes.x[self.intervals].dot(&self.cost.s_linear);
        linear
            + (0..=self.intervals).fold(0.0, |sum, k| {
                let (dx, du) = (nodes.x[k] - self.cost.x_ref, nodes.u[k] - self.cost.u_ref);
                sum + dx.component_mul(&dx).dot(&self.state_weight(k))
                    + du.component_mul(&du).dot(&self.cost.r) * self.node_weight(k)
            })
    }

    /// Gradient of the cost by state and input at node `k`.
    #[inline(always)]
    pub fn cost_gradient(&self, nodes: &Nodes<NX, NU>, k: usize) -> (SVector<f64, NX>, SVector<f64, NU>) {
        let (c, x, u) = (&self.cost, &nodes.x[k], &nodes.u[k]);
        let (dx, du) = (x - c.x_ref, (u - c.u_ref).component_mul(&c.r));
        let mut by_x = if let Some(stretch) = c.stretch {
            let mut by_x = dx.component_mul(&c.q) * (2.0 * self.node_weight(k) * x[stretch]);
            by_x[stretch] += self.node_weight(k) * c.running(x, u);
            if k == self.intervals {
                by_x += dx.component_mul(&c.s) * 2.0;
            }
            by_x
        } else {
            dx.component_mul(&self.state_weight(k)) * 2.0
        };
        if k == self.intervals {
            by_x += c.s_linear;
        }
        (by_x, du * (2.0 * self.node_weight(k) * self.stretch_at(nodes, k)))
    }

    /// Diagonals of the cost's Hessian by state and input at node `k`, without what couples the stretch of
    /// time to the others: positive semidefinite.
    #[inline(always)]
    pub fn cost_hessian(&self, nodes: &Nodes<NX, NU>, k: usize) -> (SVector<f64, NX>, SVector<f64, NU>) {
        let stretch = self.stretch_at(nodes, k);
        let by_x = match self.cost.stretch {
            None => self.state_weight(k) * 2.0,
            Some(_) => {
                let running = self.cost.q * (2.0 * self.node_weight(k) * stretch);
                if k == self.intervals { running + self.cost.s * 2.0 } else { running }
            }
        };
        (by_x, self.cost.r * (2.0 * self.node_weight(k) * stretch))
    }

    /// Adds what couples the stretch of time to state and input in the cost's Hessian at node `k`.
    pub fn add_stretch_coupling(&self, nodes: &Nodes<NX, NU>, k: usize, hessian: &mut Curvature<NX, NU>) {
        let (Some(stretch), c) = (self.cost.stretch, &self.cost) else { return };
        let by_x = (nodes.x[k] - c.x_ref).component_mul(&c.q) * (2.0 * self.node_weight(k));
        let by_u = (nodes.u[k] - c.u_ref).component_mul(&c.r) * (2.0 * self.node_weight(k));
        for i in 0..NX {
            hessian.xx[(i, stretch)] += by_x[i];
            hessian.xx[(stretch, i)] += by_x[i];
        }
        for i in 0..NU {
            hessian.ux[(i, stretch)] += by_u[i];
        }
    }

    /// The factor by which time is stretched at node `k`.
    #[inline(always)]
    fn stretch_at(&self, nodes: &Nodes<NX, NU>, k: usize) -> f64 {
        self.cost.stretch.map_or(1.0, |i| nodes.x[k][i])
    }

    /// Defects and cost of node values.
    pub fn evaluate(&self, nodes: &Nodes<NX, NU>) -> Evaluation<NX> {
        let mut left = self.dynamics.value(&nodes.x[0], &nodes.u[0]);
        let mut defects = Vec::with_capacity(self.intervals);
        let mut path = Vec::new();
        for k in 0..self.intervals {
            let right = self.dynamics.value(&nodes.x[k + 1], &nodes.u[k + 1]);
            let (x_c, u_c) = midpoint(nodes, k, self.dt_s, &left, &right);
            let middle = self.dynamics.value(&x_c, &u_c);
            defects.push(defect(nodes, k, self.dt_s, [&left, &middle, &right]));
            if !self.constraints.is_empty() {
                self.along_path(nodes, k, (&x_c, &u_c), |constraint, at| path.push(constraint.value(at)));
            }
            left = right;
        }
        Evaluation::new(defects, path, self.objective(nodes))
    }

    /// The dynamics linearised at nodes and midpoints, with defects and cost.
    pub fn linearise(&self, nodes: &Nodes<NX, NU>) -> (Linearised<NX, NU>, Evaluation<NX>) {
        let mut at_nodes = Vec::with_capacity(self.intervals + 1);
        let mut middles = Vec::with_capacity(self.intervals);
        let mut defects = Vec::with_capacity(self.intervals);
        let (mut rows, mut path) = (Vec::new(), Vec::new());
        at_nodes.push(self.dynamics.linearise(&nodes.x[0], &nodes.u[0]));
        for k in 0..self.intervals {
            let right = self.dynamics.linearise(&nodes.x[k + 1], &nodes.u[k + 1]);
            let left: &Linearisation<NX, NU> = &at_nodes[k];
            let (x_c, u_c) = midpoint(nodes, k, self.dt_s, &left.f, &right.f);
            let middle = self.dynamics.linearise(&x_c, &u_c);
            defects.push(defect(nodes, k, self.dt_s, [&left.f, &middle.f, &right.f]));
            if !self.constraints.is_empty() {
                self.along_path(nodes, k, (&x_c, &u_c), |constraint, at| {
                    path.push(constraint.value(at));
                    rows.push(self.row(constraint, at));
                });
            }
            middles.push(middle);
            at_nodes.push(right);
        }
        let evaluation = Evaluation::new(defects, path, self.objective(nodes));
        (Linearised { nodes: at_nodes, middles, path: rows }, evaluation)
    }
}

impl<D: Dynamics<NX, NU> + Copy, const NX: usize, const NU: usize> Problem<D, NX, NU> {
    /// The state at the end of one interval that the defect (33) leads to from `x` under the inputs at its
    /// ends, by Newton's method; `None` where that does not converge.
    pub fn next_state(
        &self,
        x: &SVector<f64, NX>,
        [u_left, u_right]: [&SVector<f64, NU>; 2],
    ) -> Option<SVector<f64, NX>> {
        let one = Problem::new(self.dynamics, (*x, *u_left), (1, self.dt_s), self.cost, self.bounds);
        let guess = x + self.dynamics.value(x, u_left) * self.dt_s;
        let mut nodes = Nodes { x: vec![*x, guess], u: vec![*u_left, *u_right] };
        let mut last = f64::INFINITY;
        for _ in 0..NEXT_STATE_ITERATIONS {
            let (linearised, now) = one.linearise(&nodes);
            let by_right = inverse(&linearised.defect_jacobian(0, self.dt_s).x_right)?;
            let step = by_right * now.defects[0];
            nodes.x[1] -= step;
            if !(step.amax() <= 1e3) {
                return None;
            }
            // Rounding is all that is left once steps do not get smaller.
            let size = step.amax() / (1.0 + nodes.x[1].amax());
            if size < 1e-15 || (size < 1e-12 && size >= last) {
                return Some(nodes.x[1]);
            }
            last = size;
        }
        None
    }
}

/// Most iterations of Newton's method for the state at the end of an interval.
const NEXT_STATE_ITERATIONS: usize = 30;

impl<const NX: usize> Evaluation<NX> {
    fn new(defects: Vec<SVector<f64, NX>>, path: Vec<f64>, objective: f64) -> Self {
        let mut defect_sum = 0.0;
        let mut defect_max = 0.0f64;
        for e in &defects {
            for x in e.iter() {
                defect_sum += x.abs();
                // `max` would drop a NaN.
                defect_max = if x.abs() <= defect_max { defect_max } else { x.abs() };
            }
        }
        Self { defects, path, objective, defect_sum, defect_max }
    }

    /// Largest absolute defect, or largest violation of a constraint on the path if that is larger.
    pub fn violation_max(&self) -> f64 {
        self.path.iter().fold(self.defect_max, |most, g| if *g <= most { most } else { *g })
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.objective.is_finite() && self.defect_sum.is_finite() && self.path.iter().all(|g| g.is_finite())
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
