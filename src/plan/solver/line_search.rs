//! The line search: how far along the Newton step, by the filter; second-order correction; the step taken.

use super::super::barrier::{BoundDuals, longest_dual_step};
use super::super::box_bounds::move_out;
use super::super::dynamics::Dynamics;
use super::super::filter::{Filter, Merit};
use super::super::problem::Nodes;
use super::super::riccati::{NodeGradient, Step, Sweep};
use super::super::transcription::Evaluation;
use super::state::Run;

// Constants of Waechter and Biegler (2006), by their names, equations and steps there.

/// Least fraction of the way to a bound that a step may go, (8).
const TAU_MIN: f64 = 0.99;
/// Most second-order corrections of one trial point, step.
const P_MAX: usize = 4;
/// A second-order correction must reduce the violation to this part, or it is given up, step.
const KAPPA_SOC: f64 = 0.99;

/// The result of a line search.
pub(super) enum Search {
    Moved,
    Failed,
}

impl<D: Dynamics<NX, NU>, const NX: usize, const NU: usize> Run<'_, D, NX, NU> {
    pub(super) fn merit(&self, now: &Evaluation<NX>) -> Merit {
        let barrier = self.boxes.log_distance(&self.iterate.nodes).unwrap_or(f64::NEG_INFINITY);
        Merit { violation: now.defect_sum, objective: now.objective - self.mu * barrier }
    }

    pub(super) fn merit_at(&mut self, nodes: &Nodes<NX, NU>) -> (Merit, Evaluation<NX>) {
        self.counts.evaluations += 1;
        let evaluation = self.problem.evaluate(nodes);
        let objective = match self.boxes.log_distance(nodes) {
            Some(log) => evaluation.objective - self.mu * log,
            None => f64::INFINITY,
        };
        (Merit { violation: evaluation.defect_sum, objective }, evaluation)
    }

    pub(super) fn line_search(
        &mut self,
        sweep: &Sweep<NX, NU>,
        gradients: &[NodeGradient<NX, NU>],
        step: Step<NX, NU>,
        now: &Evaluation<NX>,
        filter: &mut Filter,
    ) -> Search {
        let tau = (1.0 - self.mu).max(TAU_MIN);
        let from = self.merit(now);
        let slope = slope_of(gradients, &step);
        let mut alpha = self.boxes.longest_step(&self.iterate.nodes, &step, tau);
        let least = filter.least_step(from, slope);
        let mut first = true;
        while alpha >= least {
            let nodes = step.applied_to(&self.iterate.nodes, alpha);
            let (trial, evaluation) = self.merit_at(&nodes);
            if filter.takes(from, trial, alpha, slope) {
                self.accept(nodes, &step, alpha, tau);
                return Search::Moved;
            }
            if first && trial.violation >= from.violation && evaluation.is_finite() {
                let moved = self.correct(sweep, gradients, now, &evaluation, alpha, (from, slope), filter);
                if let Some((nodes, corrected, length)) = moved {
                    self.counts.corrections += 1;
                    self.accept(nodes, &corrected, length, tau);
                    return Search::Moved;
                }
            }
            first = false;
            alpha *= 0.5;
        }
        Search::Failed
    }

    /// Second-order correction: the same sweep with the defects of the rejected trial point added.
    #[expect(clippy::too_many_arguments, reason = "the state of one line search, used once")]
    pub(super) fn correct(
        &mut self,
        sweep: &Sweep<NX, NU>,
        gradients: &[NodeGradient<NX, NU>],
        now: &Evaluation<NX>,
        trial: &Evaluation<NX>,
        alpha: f64,
        (from, slope): (Merit, f64),
        filter: &mut Filter,
    ) -> Option<(Nodes<NX, NU>, Step<NX, NU>, f64)> {
        let tau = (1.0 - self.mu).max(TAU_MIN);
        let mut defects: Vec<_> =
            now.defects.iter().zip(&trial.defects).map(|(c, t)| c * alpha + t).collect();
        let mut violation = trial.defect_sum;
        for _ in 0..P_MAX {
            let step = sweep.solve(gradients, &defects);
            let length = self.boxes.longest_step(&self.iterate.nodes, &step, tau);
            let nodes = step.applied_to(&self.iterate.nodes, length);
            let (merit, evaluation) = self.merit_at(&nodes);
            if filter.takes(from, merit, alpha, slope) {
                return Some((nodes, step, length));
            }
            if !(evaluation.defect_sum <= KAPPA_SOC * violation) {
                return None;
            }
            violation = evaluation.defect_sum;
            for (d, e) in defects.iter_mut().zip(&evaluation.defects) {
                *d = *d * length + e;
            }
        }
        None
    }

    pub(super) fn accept(&mut self, nodes: Nodes<NX, NU>, step: &Step<NX, NU>, alpha: f64, tau: f64) {
        let (it, f, n, mu) = (&mut self.iterate, &self.boxes, self.problem.intervals, self.mu);
        let mut d_x = vec![BoundDuals::zero(); n + 1];
        let mut d_u = vec![BoundDuals::zero(); n + 1];
        let mut d_w = vec![BoundDuals::zero(); n];
        let mut dual_alpha = 1.0f64;
        for k in 1..=n {
            d_u[k] = f.u.dual_step(&it.nodes.u[k], &step.u[k], &it.z_u[k], mu);
            d_w[k - 1] = f.w.dual_step(&move_out(&it.nodes, k - 1), &step.w[k - 1], &it.z_w[k - 1], mu);
            dual_alpha = dual_alpha.min(longest_dual_step(&it.z_u[k], &d_u[k], tau));
            dual_alpha = dual_alpha.min(longest_dual_step(&it.z_w[k - 1], &d_w[k - 1], tau));
            if f.on_state {
                d_x[k] = f.at(k).dual_step(&it.nodes.x[k], &step.x[k], &it.z_x[k], mu);
                dual_alpha = dual_alpha.min(longest_dual_step(&it.z_x[k], &d_x[k], tau));
            }
        }
        for (lambda, new) in it.lambda.iter_mut().zip(&step.lambda) {
            *lambda += (new - *lambda) * alpha;
        }
        it.nodes = nodes;
        for k in 1..=n {
            let w = move_out(&it.nodes, k - 1);
            it.z_u[k].lo += d_u[k].lo * dual_alpha;
            it.z_u[k].hi += d_u[k].hi * dual_alpha;
            it.z_w[k - 1].lo += d_w[k - 1].lo * dual_alpha;
            it.z_w[k - 1].hi += d_w[k - 1].hi * dual_alpha;
            f.u.tame(&it.nodes.u[k], &mut it.z_u[k], mu);
            f.w.tame(&w, &mut it.z_w[k - 1], mu);
            if f.on_state {
                it.z_x[k].lo += d_x[k].lo * dual_alpha;
                it.z_x[k].hi += d_x[k].hi * dual_alpha;
                f.at(k).tame(&it.nodes.x[k], &mut it.z_x[k], mu);
            }
        }
        self.step_length = alpha;
    }
}

fn slope_of<const NX: usize, const NU: usize>(
    gradients: &[NodeGradient<NX, NU>],
    step: &Step<NX, NU>,
) -> f64 {
    let nodes = gradients.iter().zip(step.x.iter().zip(&step.u));
    let by_nodes = nodes.fold(0.0, |sum, (g, (x, u))| sum + g.x.dot(x) + g.u.dot(u));
    gradients.iter().zip(&step.w).fold(by_nodes, |sum, (g, w)| sum + g.w.dot(w))
}
