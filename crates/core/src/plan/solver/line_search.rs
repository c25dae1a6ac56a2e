//! The line search: how far along the Newton step, by the filter; second-order correction; the step taken.

use nalgebra::SVector;

use super::super::barrier::{BoundDuals, longest_dual_step};
use super::super::box_bounds::move_out;
use super::super::dynamics::Dynamics;
use super::super::filter::{Filter, Merit};
use super::super::problem::Nodes;
use super::super::riccati::{NodeGradient, Step, Sweep};
use super::super::slacks::PathDuals;
use super::super::transcription::{Evaluation, Linearised};
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

/// A Newton step of states, inputs and defects' multipliers, with that of the constraints on the path.
pub(super) struct Direction<const NX: usize, const NU: usize> {
    pub(super) step: Step<NX, NU>,
    pub(super) path: PathDuals,
}

/// A point that a line search tries.
struct Trial<const NX: usize, const NU: usize> {
    nodes: Nodes<NX, NU>,
    evaluation: Evaluation<NX>,
    slack: Vec<f64>,
    merit: Merit,
}

/// The system of an iteration: what its steps are solved for with.
pub(super) struct System<'a, const NX: usize, const NU: usize> {
    pub(super) sweep: &'a Sweep<NX, NU>,
    pub(super) linearised: &'a Linearised<NX, NU>,
    pub(super) gradients: &'a [NodeGradient<NX, NU>],
    pub(super) now: &'a Evaluation<NX>,
}

impl<D: Dynamics<NX, NU> + Copy, const NX: usize, const NU: usize> Run<'_, D, NX, NU> {
    /// Violation of the constraints and barrier objective of the iterate.
    pub(super) fn merit(&self, now: &Evaluation<NX>) -> Merit {
        let barrier = self.boxes.log_distance(&self.iterate.nodes).unwrap_or(f64::NEG_INFINITY);
        let path = &self.iterate.path;
        let barrier = if now.path.is_empty() { barrier } else { barrier + path.log_slack() };
        let violation = now.defect_sum + path.violation(&now.path);
        Merit { violation, objective: now.objective - self.mu * barrier }
    }

    /// The point that the part `alpha` of a direction leads to.
    fn trial(&mut self, direction: &Direction<NX, NU>, alpha: f64) -> Trial<NX, NU> {
        self.counts.evaluations += 1;
        let nodes = direction.step.applied_to(&self.iterate.nodes, alpha);
        let evaluation = self.problem.evaluate(&nodes);
        let slack = self.iterate.path.moved(&direction.path, alpha, &evaluation.path);
        let path = PathDuals { slack, z: Vec::new() };
        let objective = match self.boxes.log_distance(&nodes) {
            Some(log) if evaluation.path.is_empty() => evaluation.objective - self.mu * log,
            Some(log) => evaluation.objective - self.mu * (log + path.log_slack()),
            None => f64::INFINITY,
        };
        let violation = evaluation.defect_sum + path.violation(&evaluation.path);
        Trial { nodes, merit: Merit { violation, objective }, evaluation, slack: path.slack }
    }

    /// The Newton direction for these defects, and residuals of the constraints on the path.
    fn direction(
        &self,
        system: &System<'_, NX, NU>,
        defects: &[SVector<f64, NX>],
        residuals: &[f64],
    ) -> Direction<NX, NU> {
        if residuals.is_empty() {
            let step = system.sweep.solve(system.gradients, defects);
            return Direction { step, path: PathDuals::default() };
        }
        let path = &self.iterate.path;
        let mut gradients = system.gradients.to_vec();
        let multipliers = path.multipliers(residuals, self.mu, self.give);
        self.problem.add_path_gradient(system.linearised, &multipliers, &mut gradients);
        let step = system.sweep.solve(&gradients, defects);
        let change = self.problem.path_change(system.linearised, &step);
        Direction { path: path.step(residuals, &change, self.mu, self.give), step }
    }

    /// The longest part of a direction that keeps the fraction `1 - tau` of the distance from each bound.
    fn longest(&self, direction: &Direction<NX, NU>, tau: f64) -> f64 {
        let alpha = self.boxes.longest_step(&self.iterate.nodes, &direction.step, tau);
        alpha.min(self.iterate.path.longest_steps(&direction.path, tau).0)
    }

    pub(super) fn line_search(&mut self, system: &System<'_, NX, NU>, filter: &mut Filter) -> Search {
        let now = system.now;
        let residuals = self.iterate.path.residuals(&now.path);
        let direction = self.direction(system, &now.defects, &residuals);
        let tau = (1.0 - self.mu).max(TAU_MIN);
        let from = self.merit(now);
        let mut slope = slope_of(system.gradients, &direction.step);
        if !residuals.is_empty() {
            slope += self.iterate.path.slope(&direction.path, self.mu);
        }
        let mut alpha = self.longest(&direction, tau);
        let least = filter.least_step(from, slope);
        let mut first = true;
        while alpha >= least {
            let trial = self.trial(&direction, alpha);
            if filter.takes(from, trial.merit, alpha, slope) {
                self.accept(trial, &direction, alpha, tau);
                return Search::Moved;
            }
            if first && trial.merit.violation >= from.violation && trial.evaluation.is_finite() {
                let moved = self.correct(system, trial, alpha, (from, slope), filter);
                if let Some((trial, corrected, length)) = moved {
                    self.counts.corrections += 1;
                    self.accept(trial, &corrected, length, tau);
                    return Search::Moved;
                }
            }
            first = false;
            alpha *= 0.5;
        }
        Search::Failed
    }

    /// Second-order correction: the same sweep with the violations of the rejected trial point added.
    fn correct(
        &mut self,
        system: &System<'_, NX, NU>,
        rejected: Trial<NX, NU>,
        alpha: f64,
        (from, slope): (Merit, f64),
        filter: &mut Filter,
    ) -> Option<(Trial<NX, NU>, Direction<NX, NU>, f64)> {
        let tau = (1.0 - self.mu).max(TAU_MIN);
        let mut defects = system.now.defects.clone();
        let mut residuals = self.iterate.path.residuals(&system.now.path);
        let (mut last, mut length) = (rejected, alpha);
        for _ in 0..P_MAX {
            for (d, e) in defects.iter_mut().zip(&last.evaluation.defects) {
                *d = *d * length + e;
            }
            let left = last.evaluation.path.iter().zip(&last.slack);
            for (r, (g, t)) in residuals.iter_mut().zip(left) {
                *r = *r * length + g + t;
            }
            let violation = last.merit.violation;
            let direction = self.direction(system, &defects, &residuals);
            length = self.longest(&direction, tau);
            last = self.trial(&direction, length);
            if filter.takes(from, last.merit, alpha, slope) {
                return Some((last, direction, length));
            }
            if !(last.merit.violation <= KAPPA_SOC * violation) {
                return None;
            }
        }
        None
    }

    fn accept(&mut self, trial: Trial<NX, NU>, direction: &Direction<NX, NU>, alpha: f64, tau: f64) {
        let step = &direction.step;
        let (it, f, n, mu) = (&mut self.iterate, &self.boxes, self.problem.intervals, self.mu);
        let mut d_x = vec![BoundDuals::zero(); n + 1];
        let mut d_u = vec![BoundDuals::zero(); n + 1];
        let mut d_w = vec![BoundDuals::zero(); n];
        let mut dual_alpha = it.path.longest_steps(&direction.path, tau).1;
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
        it.nodes = trial.nodes;
        it.path.accept(trial.slack, &direction.path, dual_alpha, mu);
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
