//! The Newton step of the interior point method by a sweep over the stages.
//!
//! Unknowns are grouped by node: `s_k = (x_k, u_k)`, and the rate-limited moves `w_k = u_k+1 - u_k` are the
//! controls of a linear-quadratic problem, so that rate limits are bounds on `w`, thrust limits bounds on
//! `s`, and no slack is needed. Each linearised defect is solved for the next state,
//!
//! ```text
//! dx_k+1 = A dx_k + B du_k + C dw_k + c ,   du_k+1 = du_k + dw_k ,
//! ```
//!
//! and a backward sweep carries the quadratic value function `V_k(ds) = 1/2 ds' P ds + p' ds`. The reduced
//! Hessian of each stage with respect to `dw_k` (as wide as there are rotors) must be positive definite; that
//! is exactly the condition that the whole KKT matrix has the inertia of a minimum. The second derivatives of
//! a defect couple its two ends through the midpoint; they are taken in as a quadratic in `(dx_c, du_c)`.
//!
//! The restoration phase takes the defects as least squares instead ([`Defects::Penalised`]): what is left of
//! a defect moves the next state off the point that would close it, at a cost of half its square. Each stage
//! then sees the value function minimised over that remainder, and goes on as before.

use nalgebra::{SMatrix, SVector};

use self::stage::{Relaxation, Stage};
use super::block::{Cholesky, add_mul, mul, tr_mul};
use super::dynamics::Curvature;
use super::path::MoveTerms;
use super::problem::Nodes;
use super::transcription::Linearised;
use crate::simd::{Kernel, vectorised};

mod stage;

/// Quadratic terms of node `k`: Hessian of cost, barrier and (weighted) dynamics.
#[derive(Clone, Copy, Debug)]
pub struct NodeTerms<const NX: usize, const NU: usize> {
    /// Hessian of node `k` by states, inputs and both.
    pub hessian: Curvature<NX, NU>,
    /// Diagonal of the barrier's Hessian for the move `w_k` out of this node.
    pub move_barrier: SVector<f64, NU>,
}

/// Gradients of the Lagrangian at node `k`.
#[derive(Clone, Copy, Debug)]
pub struct NodeGradient<const NX: usize, const NU: usize> {
    /// Gradient by the state `x_k`.
    pub x: SVector<f64, NX>,
    /// Gradient by the input `u_k`.
    pub u: SVector<f64, NU>,
    /// Gradient by the move `w_k`.
    pub w: SVector<f64, NU>,
}

impl<const NX: usize, const NU: usize> NodeGradient<NX, NU> {
    /// No gradient.
    pub fn zero() -> Self {
        Self { x: SVector::zeros(), u: SVector::zeros(), w: SVector::zeros() }
    }
}

/// The Hessian of a Newton system.
#[derive(Clone, Debug)]
pub struct Hessian<const NX: usize, const NU: usize> {
    /// Terms of the nodes. (Of the first node, which is given, only its move counts, and the components of
    /// its state that are free.)
    pub nodes: Vec<NodeTerms<NX, NU>>,
    /// Second derivatives by state and input at the midpoint of each interval.
    pub middles: Vec<Curvature<NX, NU>>,
    /// Terms that couple the move over each interval to itself and to its midpoint; empty where there are
    /// none.
    pub moves: Vec<MoveTerms<NX, NU>>,
}

/// How the linearised defects enter the quadratic problem that a sweep solves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Defects {
    /// The defects are constraints: a full step closes them.
    Closed,
    /// Half the sum of the squared defects is part of the cost.
    Penalised,
}

/// The factored Newton system, stage by stage.
#[derive(Clone, Debug)]
pub struct Sweep<const NX: usize, const NU: usize> {
    stages: Vec<Stage<NX, NU>>,
    /// One per interval where the defects are penalised, none where they are closed.
    relaxations: Vec<Relaxation<NX, NU>>,
    /// The moves' terms of the factored system.
    moves: Vec<MoveTerms<NX, NU>>,
    /// The first state's, where components of it are free.
    initial: Option<FreeInitial<NX>>,
}

/// Components of the first state that are free, and the factored Hessian of the value function by them.
#[derive(Clone, Debug)]
struct FreeInitial<const NX: usize> {
    free: SVector<bool, NX>,
    factor: Cholesky<NX>,
}

impl<const NX: usize> FreeInitial<NX> {
    /// Factors the value function's Hessian by the free components; `None` where it is not positive definite.
    fn factor(&mut self, value_xx: &SMatrix<f64, NX, NX>) -> Option<()> {
        let both = |i, j| self.free[i] && self.free[j];
        let unit = |i, j| if i == j { 1.0 } else { 0.0 };
        let masked = SMatrix::from_fn(|i, j| if both(i, j) { value_xx[(i, j)] } else { unit(i, j) });
        self.factor = Cholesky::new(masked)?;
        Some(())
    }

    /// The step of the first state for the value function's gradient by it.
    fn step(&self, gradient: &SVector<f64, NX>) -> SVector<f64, NX> {
        let mut step = SVector::from_fn(|i, _| if self.free[i] { -gradient[i] } else { 0.0 });
        self.factor.solve(&mut step);
        step
    }
}

/// Why a Newton system could not be factored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FactorError {
    /// The linearised defect of this interval cannot be solved for the next state.
    SingularDefect(usize),
    /// The reduced Hessian of the stage over this interval is not positive definite.
    Indefinite(usize),
}

/// A Newton step.
#[derive(Clone, Debug)]
pub struct Step<const NX: usize, const NU: usize> {
    /// Steps of the states, one per node.
    pub x: Vec<SVector<f64, NX>>,
    /// Steps of the inputs, one per node.
    pub u: Vec<SVector<f64, NU>>,
    /// Steps of the moves, one per interval.
    pub w: Vec<SVector<f64, NU>>,
    /// New multipliers of the defects, one per interval (the multipliers, not their change).
    pub lambda: Vec<SVector<f64, NX>>,
}

impl<const NX: usize, const NU: usize> Step<NX, NU> {
    /// The node values `nodes`, moved along the step by the part `alpha` of its length.
    pub(super) fn applied_to(&self, nodes: &Nodes<NX, NU>, alpha: f64) -> Nodes<NX, NU> {
        Nodes {
            x: nodes.x.iter().zip(&self.x).map(|(a, d)| a + d * alpha).collect(),
            u: nodes.u.iter().zip(&self.u).map(|(a, d)| a + d * alpha).collect(),
        }
    }
}

impl<const NX: usize, const NU: usize> Sweep<NX, NU> {
    /// An empty system with room for `intervals` stages, whose first state is given but for the components
    /// that are `free`.
    pub fn new(intervals: usize, free: &SVector<bool, NX>) -> Self {
        let any = free.iter().any(|free| *free);
        Self {
            stages: vec![Stage::empty(); intervals],
            relaxations: Vec::new(),
            moves: Vec::new(),
            initial: any.then(|| FreeInitial { free: *free, factor: Cholesky::identity() }),
        }
    }

    /// Factors the system.
    ///
    /// # Errors
    /// [`FactorError`] names the interval at which it failed; nothing can be solved then.
    pub fn factor(
        &mut self,
        linearised: &Linearised<NX, NU>,
        dt_s: f64,
        defects: Defects,
        hessian: &Hessian<NX, NU>,
    ) -> Result<(), FactorError> {
        self.moves.clone_from(&hessian.moves);
        vectorised(Factoring { sweep: self, linearised, dt_s, defects, hessian })
    }

    /// The Newton step for the given gradients (one per node) and defects (one per interval).
    pub fn solve(&self, gradients: &[NodeGradient<NX, NU>], defects: &[SVector<f64, NX>]) -> Step<NX, NU> {
        vectorised(Substitution { sweep: self, gradients, defects })
    }
}

/// The arguments of [`Sweep::factor`], as a kernel.
struct Factoring<'a, const NX: usize, const NU: usize> {
    sweep: &'a mut Sweep<NX, NU>,
    linearised: &'a Linearised<NX, NU>,
    dt_s: f64,
    defects: Defects,
    hessian: &'a Hessian<NX, NU>,
}

impl<const NX: usize, const NU: usize> Kernel for Factoring<'_, NX, NU> {
    type Output = Result<(), FactorError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Sweep { stages, relaxations, moves, initial } = self.sweep;
        let Hessian { nodes, middles, .. } = self.hessian;
        relaxations.clear();
        let mut value = nodes[middles.len()].hessian;
        for (k, stage) in stages.iter_mut().enumerate().rev() {
            stage.condense(self.linearised, k, self.dt_s).ok_or(FactorError::SingularDefect(k))?;
            if self.defects == Defects::Penalised {
                let (relaxed, relaxation) = stage.relax(&value).ok_or(FactorError::Indefinite(k))?;
                value = relaxed;
                relaxations.push(relaxation);
            }
            let own = &nodes[k];
            value = stage
                .reduce(&value, &middles[k], moves.get(k), &own.move_barrier)
                .ok_or(FactorError::Indefinite(k))?;
            value += own.hessian;
        }
        if let Some(initial) = initial {
            initial.factor(&value.xx).ok_or(FactorError::Indefinite(0))?;
        }
        relaxations.reverse();
        Ok(())
    }
}

/// The arguments of [`Sweep::solve`], as a kernel.
struct Substitution<'a, const NX: usize, const NU: usize> {
    sweep: &'a Sweep<NX, NU>,
    gradients: &'a [NodeGradient<NX, NU>],
    defects: &'a [SVector<f64, NX>],
}

impl<const NX: usize, const NU: usize> Kernel for Substitution<'_, NX, NU> {
    type Output = Step<NX, NU>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { sweep, gradients, defects } = self;
        let intervals = sweep.stages.len();
        let mut offsets = vec![SVector::<f64, NX>::zeros(); intervals];
        let mut moves = vec![SVector::<f64, NU>::zeros(); intervals];
        let mut p_next = vec![SVector::<f64, NX>::zeros(); intervals];
        let (mut p_x, mut p_u) = (gradients[intervals].x, gradients[intervals].u);
        for k in (0..intervals).rev() {
            let s = &sweep.stages[k];
            let c = -mul(&s.by_defect, &defects[k]);
            offsets[k] = c;
            if let Some(Relaxation { k_x, k_u }) = sweep.relaxations.get(k) {
                let by_rest = tr_mul(&s.by_defect, &p_x);
                (p_x, p_u) = (p_x - tr_mul(k_x, &by_rest), p_u - tr_mul(k_u, &by_rest));
            }
            p_next[k] = p_x;
            let mut v_x = p_x;
            add_mul(&mut v_x, &s.p_xx, &c);
            let mut v_u = p_u;
            add_mul(&mut v_u, &s.p_ux, &c);
            let x_c = mul(&s.mid_next, &c);
            let (h_x, h_u) = (mul(&s.middle.xx, &x_c), mul(&s.middle.ux, &x_c));
            let g_x = tr_mul(&s.a, &v_x) + tr_mul(&s.mid_x, &h_x);
            let g_u = tr_mul(&s.b, &v_x) + v_u + tr_mul(&s.mid_u, &h_x) + h_u;
            let mut g_w = tr_mul(&s.c, &v_x) + v_u + tr_mul(&s.mid_w, &h_x) + h_u * 0.5 + gradients[k].w;
            if let Some(moves) = sweep.moves.get(k) {
                add_mul(&mut g_w, &moves.wx, &x_c);
            }
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
        if let Some(initial) = &sweep.initial {
            step.x[0] = initial.step(&p_x);
        }
        for k in 0..intervals {
            let s = &sweep.stages[k];
            let (dx, du) = (step.x[k], step.u[k]);
            step.w[k] += mul(&s.gain_x, &dx) + mul(&s.gain_u, &du);
            let dw = step.w[k];
            let (u_next, u_c) = (du + dw, du + dw * 0.5);
            let x_next = mul(&s.a, &dx) + mul(&s.b, &du) + mul(&s.c, &dw) + offsets[k];
            let x_c =
                mul(&s.mid_x, &dx) + mul(&s.mid_u, &du) + mul(&s.mid_w, &dw) + mul(&s.mid_next, &offsets[k]);
            let mut curvature = mul(&s.middle.xx, &x_c) + tr_mul(&s.middle.ux, &u_c);
            if let Some(moves) = sweep.moves.get(k) {
                curvature += tr_mul(&moves.wx, &dw);
            }
            let slope = p_next[k]
                + mul(&s.p_xx, &x_next)
                + tr_mul(&s.p_ux, &u_next)
                + tr_mul(&s.mid_next, &curvature);
            step.lambda[k] = -tr_mul(&s.by_defect, &slope);
            step.x[k + 1] = match sweep.relaxations.get(k) {
                None => x_next,
                // The multiplier of a penalised defect is what is left of it.
                Some(_) => x_next + mul(&s.by_defect, &step.lambda[k]),
            };
            step.u[k + 1] = u_next;
        }
        step
    }
}
