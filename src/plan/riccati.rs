//! The Newton step of the interior point method by a sweep over the stages.
//!
//! Unknowns are grouped by node: `s_k = (x_k, u_k)`, and the rate-limited moves `w_k = u_k+1 - u_k` are the controls of a
//! linear-quadratic problem, so that rate limits are bounds on `w`, thrust limits bounds on `s`, and no slack is
//! needed. Each linearised defect is solved for the next state,
//!
//! ```text
//! dx_k+1 = A dx_k + B du_k + C dw_k + c ,   du_k+1 = du_k + dw_k ,
//! ```
//!
//! and a backward sweep carries the quadratic value function `V_k(ds) = 1/2 ds' P ds + p' ds`. The reduced Hessian of each
//! stage with respect to `dw_k` (as wide as there are rotors) must be positive definite; that is exactly the condition that
//! the whole KKT matrix has the inertia of a minimum. The second derivatives of a defect couple its two ends through the
//! midpoint; they are taken in as a quadratic in `(dx_c, du_c)`.

use nalgebra::{SMatrix, SVector};

use super::block::{Cholesky, Lu, add_mul, add_tr_mul, mul, tr_mul};
use super::dynamics::Curvature;
use super::transcription::Linearised;

/// Quadratic terms of node `k`: Hessian of cost, barrier and (weighted) dynamics.
#[derive(Clone, Copy, Debug)]
pub struct NodeTerms<const NX: usize, const NU: usize> {
    /// Hessian by states, inputs and both.
    pub hessian: Curvature<NX, NU>,
    /// Diagonal of the barrier's Hessian for the move `w_k` out of this node.
    pub move_barrier: SVector<f64, NU>,
}

/// Gradients of node `k`.
#[derive(Clone, Copy, Debug)]
pub struct NodeGradient<const NX: usize, const NU: usize> {
    /// By the state.
    pub x: SVector<f64, NX>,
    /// By the input.
    pub u: SVector<f64, NU>,
    /// By the move `w_k`.
    pub w: SVector<f64, NU>,
}

/// What the sweep keeps of an interval.
#[derive(Clone, Copy, Debug)]
struct Stage<const NX: usize, const NU: usize> {
    /// Factors of the defect's Jacobian by the next state.
    lu: Lu<NX>,
    a: SMatrix<f64, NX, NX>,
    b: SMatrix<f64, NX, NU>,
    c: SMatrix<f64, NX, NU>,
    /// Midpoint by (dx, du, dw, next state).
    mid_x: SMatrix<f64, NX, NX>,
    mid_u: SMatrix<f64, NX, NU>,
    mid_w: SMatrix<f64, NX, NU>,
    mid_next: SMatrix<f64, NX, NX>,
    /// Weighted curvature at the midpoint.
    middle: Curvature<NX, NU>,
    /// Value function behind this interval, at node k+1.
    p_xx: SMatrix<f64, NX, NX>,
    p_ux: SMatrix<f64, NU, NX>,
    /// Reduced Hessian by `dw` and its coupling to (dx, du).
    q_ww: Cholesky<NU>,
    q_wx: SMatrix<f64, NU, NX>,
    q_wu: SMatrix<f64, NU, NU>,
    gain_x: SMatrix<f64, NU, NX>,
    gain_u: SMatrix<f64, NU, NU>,
}

/// The factored Newton system.
#[derive(Clone, Debug)]
pub struct Sweep<const NX: usize, const NU: usize> {
    stages: Vec<Stage<NX, NU>>,
}

/// Why a Newton system could not be factored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FactorError {
    /// A linearised defect cannot be solved for the next state (interval).
    SingularDefect(usize),
    /// The reduced Hessian of a stage is not positive definite (interval).
    Indefinite(usize),
}

/// A Newton step.
#[derive(Clone, Debug)]
pub struct Step<const NX: usize, const NU: usize> {
    /// Of the states.
    pub x: Vec<SVector<f64, NX>>,
    /// Of the inputs.
    pub u: Vec<SVector<f64, NU>>,
    /// Of the moves.
    pub w: Vec<SVector<f64, NU>>,
    /// New multipliers of the defects (not their change).
    pub lambda: Vec<SVector<f64, NX>>,
}

impl<const NX: usize, const NU: usize> Stage<NX, NU> {
    /// Solves the linearised defect for the next state and expresses the midpoint.
    #[inline(always)]
    fn condense(
        linearised: &Linearised<NX, NU>,
        k: usize,
        dt_s: f64,
        middle: &Curvature<NX, NU>,
    ) -> Option<Self> {
        let jacobian = linearised.defect_jacobian(k, dt_s);
        let lu = Lu::new(jacobian.x_right)?;
        let (mut a, mut b, mut c) =
            (-jacobian.x_left, -(jacobian.u_left + jacobian.u_right), -jacobian.u_right);
        lu.solve(&mut a);
        lu.solve(&mut b);
        lu.solve(&mut c);
        let (left, right, eighth) = (&linearised.nodes[k], &linearised.nodes[k + 1], dt_s / 8.0);
        let half = SMatrix::<f64, NX, NX>::from_diagonal_element(0.5);
        let mid_next = half - right.a * eighth;
        let mut mid_x = half + left.a * eighth;
        add_mul(&mut mid_x, &mid_next, &a);
        let right_b = right.b * eighth;
        let mut mid_u = left.b * eighth - right_b;
        add_mul(&mut mid_u, &mid_next, &b);
        let mut mid_w = -right_b;
        add_mul(&mut mid_w, &mid_next, &c);
        Some(Self {
            lu,
            a,
            b,
            c,
            mid_x,
            mid_u,
            mid_w,
            mid_next,
            middle: *middle,
            p_xx: SMatrix::zeros(),
            p_ux: SMatrix::zeros(),
            q_ww: Cholesky::identity(),
            q_wx: SMatrix::zeros(),
            q_wu: SMatrix::zeros(),
            gain_x: SMatrix::zeros(),
            gain_u: SMatrix::zeros(),
        })
    }

    /// Minimises the stage over `dw`: `value` comes in as the value function's Hessian at node k+1 and leaves as that at
    /// node k, to which the node's own terms are still to be added. Returns `None` when the stage is indefinite.
    #[inline(always)]
    fn reduce(
        &mut self,
        value: &Curvature<NX, NU>,
        move_barrier: &SVector<f64, NU>,
    ) -> Option<Curvature<NX, NU>> {
        let mut q = Curvature::<NX, NU>::zero();
        let mut q_wx = SMatrix::<f64, NU, NX>::zeros();
        let mut q_wu = SMatrix::<f64, NU, NU>::zeros();
        let mut q_ww = SMatrix::<f64, NU, NU>::from_diagonal(move_barrier);
        self.p_xx = value.xx;
        self.p_ux = value.ux;
        // Next node: x' = A dx + B du + C dw, u' = du + dw. Midpoint: x_c likewise, u_c = du + dw/2.
        let parts = [
            (value, &self.a, &self.b, &self.c, 1.0),
            (&self.middle, &self.mid_x, &self.mid_u, &self.mid_w, 0.5),
        ];
        for (h, by_x, by_u, by_w, share) in parts {
            let hx = mul(&h.xx, by_x);
            let ux = mul(&h.ux, by_x);
            let mut hu = h.ux.transpose();
            add_mul(&mut hu, &h.xx, by_u);
            let mut uu = h.uu;
            add_mul(&mut uu, &h.ux, by_u);
            let mut hw = h.ux.transpose() * share;
            add_mul(&mut hw, &h.xx, by_w);
            let mut uw = h.uu * share;
            add_mul(&mut uw, &h.ux, by_w);
            add_tr_mul(&mut q.xx, by_x, &hx);
            q.ux += ux;
            add_tr_mul(&mut q.ux, by_u, &hx);
            q.uu += uu;
            add_tr_mul(&mut q.uu, by_u, &hu);
            q_wx += ux * share;
            add_tr_mul(&mut q_wx, by_w, &hx);
            q_wu += uu * share;
            add_tr_mul(&mut q_wu, by_w, &hu);
            q_ww += uw * share;
            add_tr_mul(&mut q_ww, by_w, &hw);
        }
        let factor = Cholesky::new(q_ww)?;
        let (mut gain_x, mut gain_u) = (-q_wx, -q_wu);
        factor.solve(&mut gain_x);
        factor.solve(&mut gain_u);
        add_tr_mul(&mut q.xx, &q_wx, &gain_x);
        add_tr_mul(&mut q.ux, &q_wu, &gain_x);
        add_tr_mul(&mut q.uu, &q_wu, &gain_u);
        q.xx = (q.xx + q.xx.transpose()) * 0.5;
        q.uu = (q.uu + q.uu.transpose()) * 0.5;
        (self.q_ww, self.q_wx, self.q_wu, self.gain_x, self.gain_u) = (factor, q_wx, q_wu, gain_x, gain_u);
        Some(q)
    }
}

impl<const NX: usize, const NU: usize> Sweep<NX, NU> {
    /// Factors the system: `terms` per node (the first node is fixed: only its move counts), `middles` per interval.
    ///
    /// # Errors
    /// [`FactorError`] names the interval at which it failed.
    pub fn factor(
        linearised: &Linearised<NX, NU>,
        dt_s: f64,
        terms: &[NodeTerms<NX, NU>],
        middles: &[Curvature<NX, NU>],
    ) -> Result<Self, FactorError> {
        let intervals = middles.len();
        let mut stages = Vec::with_capacity(intervals);
        for (k, middle) in middles.iter().enumerate() {
            let stage = Stage::condense(linearised, k, dt_s, middle).ok_or(FactorError::SingularDefect(k))?;
            stages.push(stage);
        }
        let mut value = terms[intervals].hessian;
        for k in (0..intervals).rev() {
            value = stages[k].reduce(&value, &terms[k].move_barrier).ok_or(FactorError::Indefinite(k))?;
            let own = &terms[k].hessian;
            value.xx += own.xx;
            value.ux += own.ux;
            value.uu += own.uu;
        }
        Ok(Self { stages })
    }

    /// The step for the given gradients and defects.
    pub fn solve(&self, gradients: &[NodeGradient<NX, NU>], defects: &[SVector<f64, NX>]) -> Step<NX, NU> {
        let intervals = self.stages.len();
        let mut offsets = vec![SVector::<f64, NX>::zeros(); intervals];
        let mut moves = vec![SVector::<f64, NU>::zeros(); intervals];
        let mut p_next = vec![SVector::<f64, NX>::zeros(); intervals];
        let (mut p_x, mut p_u) = (gradients[intervals].x, gradients[intervals].u);
        for k in (0..intervals).rev() {
            let s = &self.stages[k];
            let mut c = -defects[k];
            s.lu.solve(&mut c);
            offsets[k] = c;
            p_next[k] = p_x;
            let mut v_x = p_x;
            add_mul(&mut v_x, &s.p_xx, &c);
            let mut v_u = p_u;
            add_mul(&mut v_u, &s.p_ux, &c);
            let x_c = mul(&s.mid_next, &c);
            let (h_x, h_u) = (mul(&s.middle.xx, &x_c), mul(&s.middle.ux, &x_c));
            let g_x = tr_mul(&s.a, &v_x) + tr_mul(&s.mid_x, &h_x);
            let g_u = tr_mul(&s.b, &v_x) + v_u + tr_mul(&s.mid_u, &h_x) + h_u;
            let g_w = tr_mul(&s.c, &v_x) + v_u + tr_mul(&s.mid_w, &h_x) + h_u * 0.5 + gradients[k].w;
            let mut w = -g_w;
            s.q_ww.solve(&mut w);
            moves[k] = w;
            p_x = gradients[k].x + g_x + tr_mul(&s.q_wx, &w);
            p_u = gradients[k].u + g_u + tr_mul(&s.q_wu, &w);
        }
        let mut step = Step {
            x: vec![SVector::zeros(); intervals + 1],
            u: vec![SVector::zeros(); intervals + 1],
            w: moves,
            lambda: vec![SVector::zeros(); intervals],
        };
        for k in 0..intervals {
            let s = &self.stages[k];
            let (dx, du) = (step.x[k], step.u[k]);
            step.w[k] += mul(&s.gain_x, &dx) + mul(&s.gain_u, &du);
            let dw = step.w[k];
            let (u_next, u_c) = (du + dw, du + dw * 0.5);
            let x_next = mul(&s.a, &dx) + mul(&s.b, &du) + mul(&s.c, &dw) + offsets[k];
            let x_c =
                mul(&s.mid_x, &dx) + mul(&s.mid_u, &du) + mul(&s.mid_w, &dw) + mul(&s.mid_next, &offsets[k]);
            let curvature = mul(&s.middle.xx, &x_c) + tr_mul(&s.middle.ux, &u_c);
            let slope = p_next[k]
                + mul(&s.p_xx, &x_next)
                + tr_mul(&s.p_ux, &u_next)
                + tr_mul(&s.mid_next, &curvature);
            step.lambda[k] = -s.lu.solve_transposed(&slope);
            step.x[k + 1] = x_next;
            step.u[k + 1] = u_next;
        }
        step
    }
}
