//! Restoration: when no step is acceptable, walk back towards feasibility.
//!
//! Minimises `1/2 sum |e_k|^2 + zeta/2 |s - s_R|^2 - mu' sum log(distance)` by Gauss-Newton steps
//! (Levenberg's zeta keeps them near the point where the line search failed), until the point is acceptable
//! to the filter and has lost a tenth of its violation, or the decrease peters out: then the problem has no
//! feasible point nearby. The step is the sweep of [`super::riccati`] with penalised defects.

use nalgebra::{SMatrix, SVector};

use super::box_bounds::{BoxBounds, move_out};
use super::dynamics::{Curvature, Dynamics};
use super::filter::{Filter, Merit};
use super::path::MoveTerms;
use super::problem::{Nodes, Problem};
use super::riccati::{Defects, Hessian, NodeGradient, NodeTerms, Step, Sweep};
use super::slacks::PathHessian;
use super::transcription::{Evaluation, Linearised};
use crate::math;

/// How a restoration ended.
pub enum Restored<const NX: usize, const NU: usize> {
    /// A point that the filter accepts.
    Found {
        /// The point.
        nodes: Nodes<NX, NU>,
        /// Slacks of the constraints on the path.
        slack: Vec<f64>,
        /// Iterations spent.
        iterations: usize,
    },
    /// The violation has a minimum here that is not zero.
    Infeasible,
    /// The iterates became non-finite.
    NotFinite,
    /// The budget ran out.
    Exhausted,
}

/// Most iterations of one restoration.
const ITERATIONS: usize = 100;
/// The violation has a minimum when this many iterations together gain less than a hundredth.
const PATIENCE: usize = 10;
/// Sum of violations below which there is none to speak of.
const VIOLATION_LEAST: f64 = 1e-9;

/// A trajectory that satisfies the dynamics under the inputs of `nodes`, one interval after another; `None`
/// where the inputs lead out of the model's range, and for problems with constraints on states or path, which
/// it would know nothing of.
pub(super) fn rolled_out<D: Dynamics<NX, NU> + Copy, const NX: usize, const NU: usize>(
    problem: &Problem<D, NX, NU>,
    boxes: &BoxBounds<NX, NU>,
    nodes: &Nodes<NX, NU>,
) -> Option<Nodes<NX, NU>> {
    if boxes.on_state || !problem.constraints.is_empty() {
        return None;
    }
    let mut rolled = nodes.clone();
    for k in 0..problem.intervals {
        rolled.x[k + 1] = problem.next_state(&rolled.x[k], [&nodes.u[k], &nodes.u[k + 1]])?;
    }
    Some(rolled)
}

/// Restores feasibility from these nodes and slacks; the barrier keeps the parameter `mu`.
pub(super) fn restore<D: Dynamics<NX, NU>, const NX: usize, const NU: usize>(
    problem: &Problem<D, NX, NU>,
    boxes: &BoxBounds<NX, NU>,
    (from, slack): (&Nodes<NX, NU>, &[f64]),
    mu: f64,
    filter: &Filter,
) -> Restored<NX, NU> {
    let phase = Phase { problem, boxes, barrier: mu.clamp(1e-9, 1e-4) };
    let mut at = Slacked { nodes: from.clone(), slack: slack.to_vec() };
    let (mut linearised, mut now) = problem.linearise(&at.nodes);
    let goal = 0.9 * at.violation(&now);
    let mut zeta = 1e-4;
    let mut history = Vec::with_capacity(ITERATIONS);
    for iteration in 0..ITERATIONS {
        let violation = at.violation(&now);
        if violation <= goal {
            let log = boxes.log_distance(&at.nodes).unwrap_or(f64::NEG_INFINITY) + at.log_slack();
            let objective = now.objective - mu * log;
            if filter.accepts(Merit { violation, objective }) {
                return Restored::Found { nodes: at.nodes, slack: at.slack, iterations: iteration };
            }
        }
        if iteration >= PATIENCE
            && violation > 0.99 * history[iteration - PATIENCE]
            && violation > VIOLATION_LEAST
        {
            return Restored::Infeasible;
        }
        history.push(violation);
        let value = phase.merit(&now, &at);
        // Raise zeta until the step decreases the merit.
        let mut moved = false;
        for _ in 0..12 {
            let Some((step, slack_step)) = phase.step(&linearised, &now, &at, zeta) else {
                zeta *= 10.0;
                continue;
            };
            let alpha = slack_step
                .iter()
                .zip(&at.slack)
                .filter(|(dt, _)| **dt < 0.0)
                .fold(boxes.longest_step(&at.nodes, &step, 0.99), |alpha, (dt, t)| alpha.min(0.99 * t / -dt));
            let nodes = step.applied_to(&at.nodes, alpha);
            let evaluation = problem.evaluate(&nodes);
            let slack = at.slack.iter().zip(&slack_step).map(|(t, dt)| t + alpha * dt).collect();
            let trial = Slacked { nodes, slack };
            let trial_value = phase.merit(&evaluation, &trial);
            if trial_value.is_finite() && trial_value < value * (1.0 - 1e-9) - 1e-300 {
                zeta = (zeta * 0.2).max(1e-10);
                at = trial;
                moved = true;
                break;
            }
            zeta *= 10.0;
        }
        if !moved {
            return if now.is_finite() { Restored::Infeasible } else { Restored::NotFinite };
        }
        (linearised, now) = problem.linearise(&at.nodes);
        if !now.is_finite() {
            return Restored::NotFinite;
        }
    }
    Restored::Exhausted
}

/// Node values and slacks of the constraints on the path.
#[derive(Clone, Debug)]
struct Slacked<const NX: usize, const NU: usize> {
    nodes: Nodes<NX, NU>,
    slack: Vec<f64>,
}

impl<const NX: usize, const NU: usize> Slacked<NX, NU> {
    /// What is left of the constraints on the path, `g + t`.
    fn left<'a>(&'a self, now: &'a Evaluation<NX>) -> impl Iterator<Item = f64> + 'a {
        now.path.iter().zip(&self.slack).map(|(g, t)| g + t)
    }

    fn violation(&self, now: &Evaluation<NX>) -> f64 {
        self.left(now).fold(now.defect_sum, |sum, r| sum + r.abs())
    }

    fn log_slack(&self) -> f64 {
        self.slack.iter().map(|t| math::ln(*t)).sum()
    }
}

/// The problem of a restoration.
struct Phase<'a, D, const NX: usize, const NU: usize> {
    problem: &'a Problem<D, NX, NU>,
    boxes: &'a BoxBounds<NX, NU>,
    barrier: f64,
}

impl<D: Dynamics<NX, NU>, const NX: usize, const NU: usize> Phase<'_, D, NX, NU> {
    fn merit(&self, now: &Evaluation<NX>, at: &Slacked<NX, NU>) -> f64 {
        let Some(log) = self.boxes.log_distance(&at.nodes) else { return f64::INFINITY };
        let defects = 0.5 * now.defects.iter().map(SVector::norm_squared).sum::<f64>();
        if now.path.is_empty() {
            return defects - self.barrier * log;
        }
        let path = 0.5 * at.left(now).map(|r| r * r).sum::<f64>();
        defects + path - self.barrier * (log + at.log_slack())
    }

    /// One Gauss-Newton step and that of the slacks; `None` when it cannot be solved for.
    ///
    /// With `b` the barrier's parameter, a slack that is minimised over, `dt = -(r + J d - b/t)/(1 + b/t^2)`,
    /// leaves a square of weight `s/(1 + s)`, `s = b/t^2`, in the others.
    fn step(
        &self,
        linearised: &Linearised<NX, NU>,
        now: &Evaluation<NX>,
        at: &Slacked<NX, NU>,
        zeta: f64,
    ) -> Option<(Step<NX, NU>, Vec<f64>)> {
        let Self { problem, boxes, barrier } = *self;
        let n = problem.intervals;
        let free = &problem.x_initial_free;
        let (nodes, mut gradients): (Vec<_>, Vec<_>) =
            (0..=n).map(|k| quadratic_terms(boxes, &at.nodes, k, barrier, zeta)).unzip();
        let mut hessian = Hessian { nodes, middles: vec![Curvature::zero(); n], moves: Vec::new() };
        let stiffness: Vec<f64> = at.slack.iter().map(|t| barrier / (t * t)).collect();
        let freed = |r: f64, t: f64, s: f64| (r - barrier / t) / (1.0 + s);
        if !linearised.path.is_empty() {
            hessian.moves = vec![MoveTerms::zero(); n];
            let Hessian { nodes, middles, moves } = &mut hessian;
            let weights: Vec<f64> = stiffness.iter().map(|s| s / (1.0 + s)).collect();
            problem.add_path_hessian(linearised, &weights, &mut PathHessian { nodes, middles, moves });
            let left = at.left(now).zip(&at.slack).zip(&stiffness);
            let multipliers: Vec<f64> = left.map(|((r, t), s)| r - freed(r, *t, *s)).collect();
            problem.add_path_gradient(linearised, &multipliers, &mut gradients);
        }
        let mut sweep = Sweep::new(n, free);
        sweep.factor(linearised, problem.dt_s, Defects::Penalised, &hessian).ok()?;
        let step = sweep.solve(&gradients, &now.defects);
        let finite = |v: &[f64]| v.iter().all(|x| x.is_finite());
        if !(finite(step.x[n].as_slice()) && finite(step.u[n].as_slice())) {
            return None;
        }
        let change = problem.path_change(linearised, &step);
        let slack = at.left(now).zip(&change).zip(at.slack.iter().zip(&stiffness));
        let slack = slack.map(|((r, jd), (t, s))| -freed(r + jd, *t, *s)).collect();
        Some((step, slack))
    }
}

/// Hessian and gradient of `zeta/2 |s - s_R|^2` and the barrier at node `k`; the first node is fixed, only
/// the move out of it counts.
fn quadratic_terms<const NX: usize, const NU: usize>(
    boxes: &BoxBounds<NX, NU>,
    nodes: &Nodes<NX, NU>,
    k: usize,
    barrier: f64,
    zeta: f64,
) -> (NodeTerms<NX, NU>, NodeGradient<NX, NU>) {
    let mut gradient = NodeGradient::zero();
    let (mut h_x, mut h_u, mut h_w) = (SVector::zeros(), SVector::zeros(), SVector::zeros());
    if k > 0 {
        (gradient.x, h_x) = boxes.at(k).primal_terms(&nodes.x[k], barrier);
        (gradient.u, h_u) = boxes.u.primal_terms(&nodes.u[k], barrier);
    }
    if k < boxes.last {
        (gradient.w, h_w) = boxes.w.primal_terms(&move_out(nodes, k), barrier);
    }
    let hessian = Curvature {
        xx: SMatrix::from_diagonal(&h_x.add_scalar(zeta)),
        ux: SMatrix::zeros(),
        uu: SMatrix::from_diagonal(&h_u.add_scalar(zeta)),
    };
    (NodeTerms { hessian, move_barrier: h_w }, gradient)
}

#[cfg(test)]
mod tests {
    use super::super::dynamics::Linearisation;
    use super::super::problem::{Bounds, QuadraticCost};
    use super::*;

    /// A driven pendulum: `x_1' = x_2`, `x_2' = u - sin x_1`.
    struct Pendulum;

    impl Dynamics<2, 1> for Pendulum {
        fn value(&self, x: &SVector<f64, 2>, u: &SVector<f64, 1>) -> SVector<f64, 2> {
            SVector::from([x[1], u[0] - math::sin(x[0])])
        }
        fn linearise(&self, x: &SVector<f64, 2>, u: &SVector<f64, 1>) -> Linearisation<2, 1> {
            let a = SMatrix::<f64, 2, 2>::new(0.0, 1.0, -math::cos(x[0]), 0.0);
            Linearisation { f: self.value(x, u), a, b: SVector::from([0.0, 1.0]) }
        }
        fn curvature(
            &self,
            x: &SVector<f64, 2>,
            _: &SVector<f64, 1>,
            weights: &SVector<f64, 2>,
        ) -> Curvature<2, 1> {
            let mut c = Curvature::zero();
            c.xx[(0, 0)] = weights[1] * math::sin(x[0]);
            c
        }
    }

    fn problem() -> Problem<Pendulum, 2, 1> {
        let cost = QuadraticCost::new(
            (SVector::zeros(), SVector::zeros()),
            SVector::from([1.0, 1.0]),
            SVector::from([1.0]),
            SVector::from([1.0, 1.0]),
        );
        let bounds = Bounds::on_input(SVector::from([-1.0]), SVector::from([1.0]), SVector::from([2.0]));
        Problem::new(Pendulum, (SVector::zeros(), SVector::zeros()), (20, 0.2), cost, bounds)
    }

    /// Node values that have nothing to do with the dynamics, inputs inside their bounds.
    fn far_off() -> Nodes<2, 1> {
        let mut nodes = Nodes {
            x: (0..=20).map(|k| SVector::from([f64::from(k * k % 7) - 3.0, f64::from(k % 5)])).collect(),
            u: (0..=20).map(|k| SVector::from([0.3 * math::sin(0.2 * f64::from(k))])).collect(),
        };
        nodes.x[0] = SVector::zeros();
        nodes
    }

    /// The gradient of what a step minimises, `1/2 sum |e + J ds|^2 + zeta/2 |ds|^2` with the barrier's
    /// quadratic terms, vanishes at the step; and the multiplier of a defect is what the step leaves of it.
    #[test]
    fn closed_form_a_step_minimises_its_quadratic_model() {
        step_minimises_its_model(&problem());
    }

    /// With the last state 1e-7 inside a bound, where the barrier's Hessian is 1e10: to the rounding of the
    /// step.
    #[test]
    fn closed_form_a_step_next_to_a_bound_minimises_its_quadratic_model() {
        let mut problem = problem();
        let end = far_off().x[20];
        (problem.bounds.x_end_min, problem.bounds.x_end_max) = (end.add_scalar(-1e-7), end.add_scalar(1.0));
        step_minimises_its_model(&problem);
    }

    fn step_minimises_its_model(problem: &Problem<Pendulum, 2, 1>) {
        let (boxes, nodes, n) = (BoxBounds::new(problem), far_off(), problem.intervals);
        let (linearised, now) = problem.linearise(&nodes);
        let (barrier, zeta) = (1e-4, 1e-3);
        let phase = Phase { problem, boxes: &boxes, barrier };
        let at = Slacked { nodes: nodes.clone(), slack: Vec::new() };
        let (d, _) = phase.step(&linearised, &now, &at, zeta).unwrap();
        let jacobian = |k: usize| linearised.defect_jacobian(k, problem.dt_s);
        let rest = |k: usize| {
            let j = jacobian(k);
            now.defects[k]
                + j.x_left * d.x[k]
                + j.u_left * d.u[k]
                + j.x_right * d.x[k + 1]
                + j.u_right * d.u[k + 1]
        };
        let by_move = |k: usize| {
            let (g, h) = boxes.w.primal_terms(&move_out(&nodes, k), barrier);
            g + h.component_mul(&(d.u[k + 1] - d.u[k]))
        };
        for k in 1..=n {
            let (terms, gradient) = quadratic_terms(&boxes, &nodes, k, barrier, zeta);
            let stiffness = 1.0 + terms.hessian.xx.amax();
            let before = jacobian(k - 1);
            let mut by_x = gradient.x + terms.hessian.xx * d.x[k] + before.x_right.tr_mul(&rest(k - 1));
            let mut by_u = gradient.u + terms.hessian.uu * d.u[k] + before.u_right.tr_mul(&rest(k - 1));
            by_u += by_move(k - 1);
            if k < n {
                by_x += jacobian(k).x_left.tr_mul(&rest(k));
                by_u += jacobian(k).u_left.tr_mul(&rest(k)) - by_move(k);
            }
            assert!(by_x.amax() < 1e-12 * stiffness && by_u.amax() < 1e-12, "{k}: {by_x} {by_u}");
            assert!((d.lambda[k - 1] - rest(k - 1)).amax() < 1e-12 * stiffness, "{k}");
        }
    }

    #[test]
    fn closed_form_a_point_far_off_is_brought_back() {
        let problem = problem();
        let boxes = BoxBounds::new(&problem);
        let before = problem.evaluate(&far_off());
        let filter = Filter::new(before.defect_sum);
        let Restored::Found { nodes, .. } = restore(&problem, &boxes, (&far_off(), &[]), 1e-3, &filter)
        else {
            unreachable!("every input has a flow")
        };
        let after = problem.evaluate(&nodes);
        assert!(after.defect_sum <= 0.9 * before.defect_sum);
        assert!(boxes.log_distance(&nodes).is_some(), "inside the bounds");
    }

    #[test]
    fn closed_form_an_end_out_of_reach_is_infeasible() {
        let mut problem = problem();
        // From rest with |u| <= 1 in 4 s: never at ten turns.
        (problem.bounds.x_end_min[0], problem.bounds.x_end_max[0]) = (60.0, 61.0);
        let boxes = BoxBounds::new(&problem);
        let mut from = far_off();
        from.x[20][0] = 60.5;
        // Each restoration may gain its tenth; the last one finds that no more is to be had.
        let filter = Filter::new(problem.evaluate(&from).defect_sum);
        let mut last = restore(&problem, &boxes, (&from, &[]), 1e-3, &filter);
        for _ in 0..50 {
            let Restored::Found { nodes, .. } = &last else { break };
            last = restore(&problem, &boxes, (nodes, &[]), 1e-3, &filter);
        }
        assert!(matches!(last, Restored::Infeasible));
    }
}
