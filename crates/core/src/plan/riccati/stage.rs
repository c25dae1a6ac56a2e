//! One interval of the sweep: its defect solved for the next state, and the stage's minimisation over the
//! move `dw`.

use nalgebra::{SMatrix, SVector};

use super::super::block::{
    Cholesky, add_mul, add_scaled, add_tr_mul, inverse, mul, scaled, symmetric_part, tr_mul,
};
use super::super::dynamics::Curvature;
use super::super::path::MoveTerms;
use super::super::transcription::Linearised;

/// The factors of one interval that a sweep keeps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stage<const NX: usize, const NU: usize> {
    /// Inverse of the defect's Jacobian by the next state.
    pub(super) by_defect: SMatrix<f64, NX, NX>,
    pub(super) a: SMatrix<f64, NX, NX>,
    pub(super) b: SMatrix<f64, NX, NU>,
    pub(super) c: SMatrix<f64, NX, NU>,
    /// Midpoint by (dx, du, dw, next state).
    pub(super) mid_x: SMatrix<f64, NX, NX>,
    pub(super) mid_u: SMatrix<f64, NX, NU>,
    pub(super) mid_w: SMatrix<f64, NX, NU>,
    pub(super) mid_next: SMatrix<f64, NX, NX>,
    /// Weighted curvature at the midpoint.
    pub(super) middle: Curvature<NX, NU>,
    /// Value function behind this interval, at node k+1.
    pub(super) p_xx: SMatrix<f64, NX, NX>,
    pub(super) p_ux: SMatrix<f64, NU, NX>,
    /// Reduced Hessian by `dw` and its coupling to (dx, du).
    pub(super) q_ww: Cholesky<NU>,
    pub(super) q_wx: SMatrix<f64, NU, NX>,
    pub(super) q_wu: SMatrix<f64, NU, NU>,
    pub(super) gain_x: SMatrix<f64, NU, NX>,
    pub(super) gain_u: SMatrix<f64, NU, NU>,
}

/// Gains of the remainder of a penalised defect, `r = -k_x y - k_u u`, with `y` the next state that would
/// close the defect and `u` the next input.
#[derive(Clone, Copy, Debug)]
pub(super) struct Relaxation<const NX: usize, const NU: usize> {
    pub(super) k_x: SMatrix<f64, NX, NX>,
    pub(super) k_u: SMatrix<f64, NX, NU>,
}

impl<const NX: usize, const NU: usize> Stage<NX, NU> {
    pub(super) fn empty() -> Self {
        Self {
            by_defect: SMatrix::zeros(),
            a: SMatrix::zeros(),
            b: SMatrix::zeros(),
            c: SMatrix::zeros(),
            mid_x: SMatrix::zeros(),
            mid_u: SMatrix::zeros(),
            mid_w: SMatrix::zeros(),
            mid_next: SMatrix::zeros(),
            middle: Curvature::zero(),
            p_xx: SMatrix::zeros(),
            p_ux: SMatrix::zeros(),
            q_ww: Cholesky::identity(),
            q_wx: SMatrix::zeros(),
            q_wu: SMatrix::zeros(),
            gain_x: SMatrix::zeros(),
            gain_u: SMatrix::zeros(),
        }
    }

    /// Solves the linearised defect for the next state and expresses the midpoint. `None` when it cannot be
    /// solved.
    #[inline(always)]
    pub(super) fn condense(&mut self, linearised: &Linearised<NX, NU>, k: usize, dt_s: f64) -> Option<()> {
        let jacobian = linearised.defect_jacobian(k, dt_s);
        self.by_defect = inverse(&jacobian.x_right)?;
        let solve = scaled(&self.by_defect, -1.0);
        self.a = mul(&solve, &jacobian.x_left);
        self.b = mul(&solve, &(jacobian.u_left + jacobian.u_right));
        self.c = mul(&solve, &jacobian.u_right);
        let (left, right, eighth) = (&linearised.nodes[k], &linearised.nodes[k + 1], dt_s / 8.0);
        let half = SMatrix::<f64, NX, NX>::from_diagonal_element(0.5);
        self.mid_next = half;
        add_scaled(&mut self.mid_next, &right.a, -eighth);
        self.mid_x = half;
        add_scaled(&mut self.mid_x, &left.a, eighth);
        add_mul(&mut self.mid_x, &self.mid_next, &self.a);
        self.mid_w = scaled(&right.b, -eighth);
        self.mid_u = self.mid_w;
        add_scaled(&mut self.mid_u, &left.b, eighth);
        add_mul(&mut self.mid_u, &self.mid_next, &self.b);
        add_mul(&mut self.mid_w, &self.mid_next, &self.c);
        Some(())
    }

    /// The value function's Hessian at node k+1 where the next state may be off by `M r` at a cost of `r'
    /// r/2`, minimised over the remainder `r` of the defect; as a sum of squares (Joseph's form), since next
    /// to a bound the Hessian is huge. Call after [`Self::condense`]. `None` when it is not positive
    /// definite.
    #[inline(always)]
    pub(super) fn relax(&self, value: &Curvature<NX, NU>) -> Option<(Curvature<NX, NU>, Relaxation<NX, NU>)> {
        let m = &self.by_defect;
        let mut weight = SMatrix::identity();
        add_tr_mul(&mut weight, m, &mul(&value.xx, m));
        let mut s = m.transpose();
        Cholesky::new(weight)?.solve(&mut s);
        let (k_x, k_u) = (mul(&s, &value.xx), mul(&s, &value.ux.transpose()));
        // The next state by y and u.
        let by_y = SMatrix::identity() - mul(m, &k_x);
        let by_u = -mul(m, &k_u);
        let mut xx = tr_mul(&k_x, &k_x);
        add_tr_mul(&mut xx, &by_y, &mul(&value.xx, &by_y));
        let mut ux = tr_mul(&k_u, &k_x) + mul(&value.ux, &by_y);
        add_tr_mul(&mut ux, &by_u, &mul(&value.xx, &by_y));
        let cross = mul(&value.ux, &by_u);
        let mut uu = value.uu + cross + cross.transpose() + tr_mul(&k_u, &k_u);
        add_tr_mul(&mut uu, &by_u, &mul(&value.xx, &by_u));
        let relaxed = Curvature { xx: symmetric_part(&xx), ux, uu: symmetric_part(&uu) };
        Some((relaxed, Relaxation { k_x, k_u }))
    }

    /// Minimises the stage over `dw`: `value` comes in as the value function's Hessian at node k+1 and leaves
    /// as that at node k, to which the node's own terms are still to be added. Returns `None` when the stage
    /// is indefinite.
    #[inline(always)]
    pub(super) fn reduce(
        &mut self,
        value: &Curvature<NX, NU>,
        middle: &Curvature<NX, NU>,
        moves: Option<&MoveTerms<NX, NU>>,
        move_barrier: &SVector<f64, NU>,
    ) -> Option<Curvature<NX, NU>> {
        self.middle = *middle;
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
            let ux_transposed = h.ux.transpose();
            let mut hu = ux_transposed;
            add_mul(&mut hu, &h.xx, by_u);
            let mut uu = h.uu;
            add_mul(&mut uu, &h.ux, by_u);
            let mut hw = scaled(&ux_transposed, share);
            add_mul(&mut hw, &h.xx, by_w);
            let mut uw = scaled(&h.uu, share);
            add_mul(&mut uw, &h.ux, by_w);
            let (by_u, by_w) = (by_u.transpose(), by_w.transpose());
            add_tr_mul(&mut q.xx, by_x, &hx);
            q.ux += ux;
            add_mul(&mut q.ux, &by_u, &hx);
            q.uu += uu;
            add_mul(&mut q.uu, &by_u, &hu);
            add_scaled(&mut q_wx, &ux, share);
            add_mul(&mut q_wx, &by_w, &hx);
            add_scaled(&mut q_wu, &uu, share);
            add_mul(&mut q_wu, &by_w, &hu);
            add_scaled(&mut q_ww, &uw, share);
            add_mul(&mut q_ww, &by_w, &hw);
        }
        if let Some(MoveTerms { ww, wx, wu }) = moves {
            let by_w = mul(wx, &self.mid_w) + scaled(wu, 0.5);
            q_ww += ww + by_w + by_w.transpose();
            add_mul(&mut q_wx, wx, &self.mid_x);
            add_mul(&mut q_wu, wx, &self.mid_u);
            q_wu += wu;
        }
        let factor = Cholesky::new(q_ww)?;
        let (mut gain_x, mut gain_u) = (scaled(&q_wx, -1.0), scaled(&q_wu, -1.0));
        factor.solve(&mut gain_x);
        factor.solve(&mut gain_u);
        add_tr_mul(&mut q.xx, &q_wx, &gain_x);
        add_tr_mul(&mut q.ux, &q_wu, &gain_x);
        add_tr_mul(&mut q.uu, &q_wu, &gain_u);
        q.xx = symmetric_part(&q.xx);
        q.uu = symmetric_part(&q.uu);
        (self.q_ww, self.q_wx, self.q_wu, self.gain_x, self.gain_u) = (factor, q_wx, q_wu, gain_x, gain_u);
        Some(q)
    }
}
