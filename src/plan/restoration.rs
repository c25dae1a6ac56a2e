//! Restoration: when no step is acceptable, walk back towards feasibility.
//!
//! Minimises `1/2 sum |e_k|^2 + zeta/2 |s - s_R|^2 - mu' sum log(distance)` by Gauss-Newton steps
//! (Levenberg's zeta keeps them near the point where the line search failed), until the point is acceptable
//! to the filter and has lost a tenth of its violation, or the decrease peters out: then the problem has no
//! feasible point nearby. Rare, so the linear algebra is general-purpose: the same stage recursion, with the
//! next state as a free control.

use nalgebra::{DMatrix, DVector, SVector};

use super::dynamics::Dynamics;
use super::filter::{Filter, Merit};
use super::problem::{Nodes, Problem};
use super::riccati::Step;
use super::solver::{BoxBounds, move_out};
use super::transcription::{Evaluation, Linearised};

/// How a restoration ended.
pub enum Restored<const NX: usize, const NU: usize> {
    /// A point that the filter accepts.
    Found {
        /// The point.
        nodes: Nodes<NX, NU>,
        /// Iterations spent.
        iterations: usize,
    },
    /// The violation has a minimum here that is not zero.
    Infeasible,
    /// The iterates became non-finite or the budget ran out.
    Failed,
}

const ITERATIONS: usize = 100;
/// The violation has a minimum when this many iterations together gain less than a hundredth.
const PATIENCE: usize = 10;

/// Restores feasibility from `from`; the barrier keeps the parameter `mu`.
pub(super) fn restore<D: Dynamics<NX, NU>, const NX: usize, const NU: usize>(
    problem: &Problem<D, NX, NU>,
    boxes: &BoxBounds<NX, NU>,
    from: &Nodes<NX, NU>,
    mu: f64,
    filter: &Filter,
) -> Restored<NX, NU> {
    let mut nodes = from.clone();
    let (mut linearised, mut now) = problem.linearise(&nodes);
    let goal = 0.9 * now.defect_sum;
    let barrier = mu.clamp(1e-9, 1e-4);
    let mut zeta = 1e-4;
    let mut history = Vec::with_capacity(ITERATIONS);
    for iteration in 0..ITERATIONS {
        if now.defect_sum <= goal {
            let objective = now.objective - mu * boxes.log_distance(&nodes).unwrap_or(f64::NEG_INFINITY);
            if filter.accepts(Merit { violation: now.defect_sum, objective }) {
                return Restored::Found { nodes, iterations: iteration };
            }
        }
        let value = merit(&now, boxes, &nodes, barrier);
        if iteration >= PATIENCE && value > 0.99 * history[iteration - PATIENCE] && value > 1e-10 {
            return Restored::Infeasible;
        }
        history.push(value);
        // Raise zeta until the step decreases the merit.
        let mut moved = false;
        for _ in 0..12 {
            let Some(step) = step(problem, boxes, &linearised, &now, &nodes, barrier, zeta) else {
                zeta *= 10.0;
                continue;
            };
            let alpha = boxes.longest_step(&nodes, &step, 0.99);
            let trial = nodes.advanced(&step, alpha);
            let evaluation = problem.evaluate(&trial);
            let trial_value = merit(&evaluation, boxes, &trial, barrier);
            if trial_value.is_finite() && trial_value < value * (1.0 - 1e-9) - 1e-300 {
                zeta = (zeta * 0.2).max(1e-10);
                nodes = trial;
                moved = true;
                break;
            }
            zeta *= 10.0;
        }
        if !moved {
            return if now.is_finite() { Restored::Infeasible } else { Restored::Failed };
        }
        (linearised, now) = problem.linearise(&nodes);
        if !now.is_finite() {
            return Restored::Failed;
        }
    }
    Restored::Failed
}

fn merit<const NX: usize, const NU: usize>(
    now: &Evaluation<NX>,
    boxes: &BoxBounds<NX, NU>,
    nodes: &Nodes<NX, NU>,
    barrier: f64,
) -> f64 {
    match boxes.log_distance(nodes) {
        Some(log) => 0.5 * now.defects.iter().map(SVector::norm_squared).sum::<f64>() - barrier * log,
        None => f64::INFINITY,
    }
}

/// One Gauss-Newton step; `None` when the stage system is singular.
fn step<D: Dynamics<NX, NU>, const NX: usize, const NU: usize>(
    problem: &Problem<D, NX, NU>,
    boxes: &BoxBounds<NX, NU>,
    linearised: &Linearised<NX, NU>,
    now: &Evaluation<NX>,
    nodes: &Nodes<NX, NU>,
    barrier: f64,
    zeta: f64,
) -> Option<Step<NX, NU>> {
    let (n, ns) = (problem.intervals, NX + NU);
    // Own terms of node k >= 1: zeta and the barrier.
    let own = |k: usize| {
        let mut hessian = DMatrix::identity(ns, ns) * zeta;
        let mut gradient = DVector::zeros(ns);
        let central = boxes.u.central_duals(&nodes.u[k], barrier);
        let (g, h) = boxes.u.terms(&nodes.u[k], &central, barrier);
        for i in 0..NU {
            hessian[(NX + i, NX + i)] += h[i];
            gradient[NX + i] += g[i];
        }
        let central = boxes.at(k).central_duals(&nodes.x[k], barrier);
        let (g, h) = boxes.at(k).terms(&nodes.x[k], &central, barrier);
        for i in 0..NX {
            hessian[(i, i)] += h[i];
            gradient[i] += g[i];
        }
        (hessian, gradient)
    };
    // Stage decision (x', w) with u' = u + w: m maps (x, u, x', w) to the linearised defect, t to the next
    // node.
    let mut gains: Vec<(DMatrix<f64>, DVector<f64>)> = Vec::with_capacity(n);
    let (mut p, mut p_lin) = own(n);
    for k in (0..n).rev() {
        let j = linearised.defect_jacobian(k, problem.dt_s);
        let total = 2 * ns;
        let mut m = DMatrix::zeros(NX, total);
        m.view_mut((0, 0), (NX, NX)).copy_from(&j.x_left);
        m.view_mut((0, NX), (NX, NU)).copy_from(&(j.u_left + j.u_right));
        m.view_mut((0, ns), (NX, NX)).copy_from(&j.x_right);
        m.view_mut((0, ns + NX), (NX, NU)).copy_from(&j.u_right);
        let mut t = DMatrix::zeros(ns, total);
        t.view_mut((0, ns), (NX, NX)).fill_with_identity();
        t.view_mut((NX, NX), (NU, NU)).fill_with_identity();
        t.view_mut((NX, ns + NX), (NU, NU)).fill_with_identity();
        let defect = DVector::from_column_slice(now.defects[k].as_slice());
        let mut q = m.tr_mul(&m) + t.tr_mul(&(&p * &t));
        let mut g = m.tr_mul(&defect) + t.tr_mul(&p_lin);
        let w = move_out(nodes, k);
        let (gw, hw) = boxes.w.terms(&w, &boxes.w.central_duals(&w, barrier), barrier);
        for i in 0..NU {
            q[(ns + NX + i, ns + NX + i)] += hw[i];
            g[ns + NX + i] += gw[i];
        }
        let factor = q.view((ns, ns), (ns, ns)).clone_owned().cholesky()?;
        let cross = q.view((ns, 0), (ns, ns)).clone_owned();
        let gain = -factor.solve(&cross);
        let offset = -factor.solve(&g.rows(ns, ns).clone_owned());
        p = q.view((0, 0), (ns, ns)) + cross.tr_mul(&gain);
        p_lin = g.rows(0, ns) + cross.tr_mul(&offset);
        if k > 0 {
            let (h, g) = own(k);
            p += h;
            p_lin += g;
        }
        gains.push((gain, offset));
    }
    gains.reverse();
    let mut step: Step<NX, NU> = Step {
        x: vec![SVector::zeros(); n + 1],
        u: vec![SVector::zeros(); n + 1],
        w: vec![SVector::zeros(); n],
        lambda: vec![SVector::zeros(); n],
    };
    let mut s = DVector::zeros(ns);
    for (k, (gain, offset)) in gains.iter().enumerate() {
        let decision = gain * &s + offset;
        step.x[k + 1] = SVector::from_fn(|i, _| decision[i]);
        step.w[k] = SVector::from_fn(|i, _| decision[NX + i]);
        step.u[k + 1] = step.u[k] + step.w[k];
        s = DVector::from_iterator(ns, step.x[k + 1].iter().chain(step.u[k + 1].iter()).copied());
    }
    s.iter().all(|x| x.is_finite()).then_some(step)
}

#[cfg(test)]
mod tests {
    use nalgebra::SMatrix;

    use super::super::dynamics::{Curvature, Linearisation};
    use super::super::problem::{Bounds, QuadraticCost};
    use super::*;

    /// A driven pendulum: `x_1' = x_2`, `x_2' = u - sin x_1`.
    struct Pendulum;

    impl Dynamics<2, 1> for Pendulum {
        fn value(&self, x: &SVector<f64, 2>, u: &SVector<f64, 1>) -> SVector<f64, 2> {
            SVector::from([x[1], u[0] - x[0].sin()])
        }
        fn linearise(&self, x: &SVector<f64, 2>, u: &SVector<f64, 1>) -> Linearisation<2, 1> {
            let a = SMatrix::<f64, 2, 2>::new(0.0, 1.0, -x[0].cos(), 0.0);
            Linearisation { f: self.value(x, u), a, b: SVector::from([0.0, 1.0]) }
        }
        fn curvature(
            &self,
            x: &SVector<f64, 2>,
            _: &SVector<f64, 1>,
            weights: &SVector<f64, 2>,
        ) -> Curvature<2, 1> {
            let mut c = Curvature::zero();
            c.xx[(0, 0)] = weights[1] * x[0].sin();
            c
        }
    }

    fn problem() -> Problem<Pendulum, 2, 1> {
        Problem {
            dynamics: Pendulum,
            x_initial: SVector::zeros(),
            u_initial: SVector::zeros(),
            intervals: 20,
            dt_s: 0.2,
            cost: QuadraticCost {
                x_ref: SVector::zeros(),
                u_ref: SVector::zeros(),
                q: SVector::from([1.0, 1.0]),
                r: SVector::from([1.0]),
                s: SVector::from([1.0, 1.0]),
            },
            bounds: Bounds::on_input(SVector::from([-1.0]), SVector::from([1.0]), SVector::from([2.0])),
        }
    }

    /// Node values that have nothing to do with the dynamics, inputs inside their bounds.
    fn far_off() -> Nodes<2, 1> {
        let mut nodes = Nodes {
            x: (0..=20).map(|k| SVector::from([f64::from(k * k % 7) - 3.0, f64::from(k % 5)])).collect(),
            u: (0..=20).map(|k| SVector::from([0.3 * (0.2 * f64::from(k)).sin()])).collect(),
        };
        nodes.x[0] = SVector::zeros();
        nodes
    }

    #[test]
    fn closed_form_a_point_far_off_is_brought_back() {
        let problem = problem();
        let boxes = BoxBounds::new(&problem);
        let before = problem.evaluate(&far_off());
        let filter = Filter::new(before.defect_sum);
        let Restored::Found { nodes, .. } = restore(&problem, &boxes, &far_off(), 1e-3, &filter) else {
            unreachable!("every input has a flow")
        };
        let after = problem.evaluate(&nodes);
        assert!(after.defect_sum <= 0.9 * before.defect_sum);
        assert!(boxes.log_distance(&nodes).is_some(), "inside the bounds");
    }

    #[test]
    fn closed_form_an_end_out_of_reach_is_told() {
        let mut problem = problem();
        // From rest with |u| <= 1 in 4 s: never at ten turns.
        (problem.bounds.x_end_min[0], problem.bounds.x_end_max[0]) = (60.0, 61.0);
        let boxes = BoxBounds::new(&problem);
        let mut from = far_off();
        from.x[20][0] = 60.5;
        // Each restoration may gain its tenth; the last one finds that no more is to be had.
        let filter = Filter::new(problem.evaluate(&from).defect_sum);
        let mut last = restore(&problem, &boxes, &from, 1e-3, &filter);
        for _ in 0..50 {
            let Restored::Found { nodes, .. } = &last else { break };
            last = restore(&problem, &boxes, nodes, 1e-3, &filter);
        }
        assert!(matches!(last, Restored::Infeasible));
    }
}
