//! A primal-dual interior point method on the stage structure: monotone barrier, filter line search,
//! second-order correction, restoration.
//!
//! The algorithm is that of IPOPT (Waechter and Biegler 2006), in its order and symbols; the linear algebra
//! is the sweep of [`super::riccati`]. Where the reduced Hessian is not positive definite, that iteration
//! uses the Gauss-Newton Hessian (cost and barrier, no curvature of the dynamics), which always is.
//!
//! | file | holds |
//! |---|---|
//! | this one | the loop, the best point |
//! | `options` | options, status, solution |
//! | `state` | the state of a running solve |
//! | `iterate` | variables; cold and warm starts |
//! | `kkt` | gradients, residuals, the Newton system's terms |
//! | `line_search` | how far to go; second-order correction |

use std::ops::ControlFlow;

use nalgebra::SVector;

use self::kkt::Residuals;
use self::line_search::{Search, System};
use self::state::{Best, Run};
use super::box_bounds::BoxBounds;
use super::dynamics::Dynamics;
use super::filter::Filter;
use super::problem::Problem;
use super::restoration::{self, Restored};
use super::riccati::Sweep;
use super::slacks::PathDuals;
use super::transcription::Evaluation;
use crate::math;

mod iterate;
mod kkt;
mod line_search;
mod options;
mod state;

pub use iterate::Iterate;
pub use options::{Counts, ProblemError, Solution, SolveProgress, SolverOptions, StartFrom, Status};

fn check<D, const NX: usize, const NU: usize>(problem: &Problem<D, NX, NU>) -> Result<(), ProblemError> {
    if problem.intervals < 2 {
        return Err(ProblemError::TooFewNodes);
    }
    let boxes = BoxBounds::new(problem);
    let open = |lo: &[f64], hi: &[f64]| lo.iter().zip(hi).all(|(l, h)| l < h);
    let pairs = [&boxes.x, &boxes.x_end];
    if !pairs.iter().all(|l| open(l.lo.as_slice(), l.hi.as_slice()))
        || !open(boxes.u.lo.as_slice(), boxes.u.hi.as_slice())
        || !open(boxes.w.lo.as_slice(), boxes.w.hi.as_slice())
    {
        return Err(ProblemError::EmptyBounds);
    }
    let c = &problem.cost;
    let finite = problem.dt_s.is_finite()
        && [&problem.x_initial, &c.x_ref, &c.q, &c.s].iter().all(|v| v.iter().all(|x| x.is_finite()))
        && [&problem.u_initial, &c.u_ref, &c.r].iter().all(|v| v.iter().all(|x| x.is_finite()));
    if !finite {
        return Err(ProblemError::NotFinite);
    }
    // A drop starts on its bound, with the rotors at rest. (Bounds on the states hold from the second node
    // on.)
    let (u, b) = (&problem.u_initial, &problem.bounds);
    match (0..NU).find(|&i| !(b.u_min[i]..=b.u_max[i]).contains(&u[i])) {
        Some(i) => {
            Err(ProblemError::InitialInput { index: i, least: b.u_min[i], greatest: b.u_max[i], found: u[i] })
        }
        None => Ok(()),
    }
}

/// Solves the problem. `observer` is called after each iteration with its progress, and may stop the solve:
/// budgets of time, which the solver knows nothing of, are kept there.
///
/// # Errors
/// [`ProblemError`] for a problem that cannot be posed. That no solution was found is not an error but a
/// [`Status`].
pub fn solve<D: Dynamics<NX, NU>, const NX: usize, const NU: usize>(
    problem: &Problem<D, NX, NU>,
    start: StartFrom<NX, NU>,
    options: &SolverOptions,
    observer: &mut dyn FnMut(&SolveProgress) -> ControlFlow<()>,
) -> Result<Solution<NX, NU>, ProblemError> {
    check(problem)?;
    let scale = cost_scale(problem);
    let scaled = problem.with_cost_times(scale);
    let problem = &scaled;
    let boxes = BoxBounds::new(problem);
    let (mut iterate, mu) =
        match start {
            StartFrom::Guess(nodes) => {
                if !nodes.fits(problem.intervals) {
                    return Err(ProblemError::GuessLength);
                }
                let mut nodes = nodes;
                (nodes.x[0], nodes.u[0]) = (problem.x_initial, problem.u_initial);
                (Iterate::cold(nodes, &boxes, options.mu_initial), options.mu_initial)
            }
            StartFrom::Warm(mut iterate) => {
                if !iterate.fits(problem.intervals) {
                    return Err(ProblemError::GuessLength);
                }
                let free = &problem.x_initial_free;
                let first = iterate.nodes.x[0];
                iterate.nodes.x[0] = problem
                    .x_initial
                    .zip_zip_map(&first, free, |given, was, free| if free { was } else { given });
                iterate.nodes.u[0] = problem.u_initial;
                iterate.scale_duals(scale);
                let change = expected_change(&iterate, &problem.evaluate(&iterate.nodes)).abs();
                let mu = (change / boxes.count() as f64).min(options.mu_warm_most).max(options.mu_warm);
                (iterate.warm(&boxes, mu), mu)
            }
        };
    // States of the guess that are not finite are replaced by the initial state.
    for x in &mut iterate.nodes.x {
        if !x.iter().all(|c| c.is_finite()) {
            *x = problem.x_initial;
        }
    }
    let run = Run {
        problem,
        boxes,
        options,
        iterate,
        mu,
        counts: Counts::default(),
        best: None,
        rolled_out: false,
        step_length: 0.0,
        give: 0.0,
    };
    let unscale = 1.0 / scale;
    let mut unscaled = |p: &SolveProgress| {
        observer(&SolveProgress {
            objective: p.objective * unscale,
            kkt_residual: p.kkt_residual * unscale,
            mu: p.mu * unscale,
            ..*p
        })
    };
    let mut solution = run.run(&mut unscaled);
    solution.objective *= unscale;
    solution.kkt_residual *= unscale;
    solution.complementarity *= unscale;
    solution.iterate.scale_duals(unscale);
    Ok(solution)
}

/// How much the cost is to change where the defects go, by the multipliers of a neighbouring problem. Shared
/// out among the bounds it is the barrier parameter of a point that is so far from optimal: in a problem that
/// begins elsewhere other bounds are active, and under a smaller parameter those of the neighbour let go
/// slowly. Zero where that is no number.
fn expected_change<const NX: usize, const NU: usize>(iterate: &Iterate<NX, NU>, at: &Evaluation<NX>) -> f64 {
    let change: f64 = iterate.lambda.iter().zip(&at.defects).map(|(lambda, e)| lambda.dot(e)).sum();
    if change.is_finite() { change } else { 0.0 }
}

/// Largest weight of the running cost that the options' barrier parameters and tolerance are made for, (27).
const USUAL_WEIGHT: f64 = 10.0;
/// Largest weights of the running cost from the least to the greatest that are taken as they are.
const PLAIN_WEIGHTS: [f64; 2] = [1.0, 1e3];

/// A power of two that the cost is multiplied with inside the solver, so that costs in any unit converge
/// alike: 1 for weights of the usual size.
fn cost_scale<D, const NX: usize, const NU: usize>(problem: &Problem<D, NX, NU>) -> f64 {
    let (c, b) = (&problem.cost, &problem.bounds);
    let inputs = (0..NU).map(|i| {
        let reach = b.u_max[i] - b.u_min[i];
        c.r[i] * if reach.is_finite() { reach * reach } else { 1.0 }
    });
    let running = inputs.fold(c.q.max(), f64::max);
    let largest = if running > 0.0 { running } else { c.s.max().max(c.s_linear.amax()) };
    let mut scale = 1.0;
    if !(largest > 0.0 && largest.is_finite()) || (PLAIN_WEIGHTS[0]..=PLAIN_WEIGHTS[1]).contains(&largest) {
        return scale;
    }
    while largest * scale > USUAL_WEIGHT {
        scale *= 0.5;
    }
    while largest * scale < 0.5 * USUAL_WEIGHT {
        scale *= 2.0;
    }
    scale
}

// Constants of Waechter and Biegler (2006), by their names and equations there.

/// A barrier problem is solved well enough for the next when its residual is at most this multiple of `mu`,
/// step A-3. (IPOPT's 10 costs a fifth more iterations on this problem.)
const KAPPA_EPSILON: f64 = 100.0;
/// Linear decrease of the barrier parameter, (7).
const KAPPA_MU: f64 = 0.2;
/// Superlinear decrease of the barrier parameter, (7).
const THETA_MU: f64 = 1.5;
/// Least barrier parameter as a part of the tolerance, (7). (The paper's is 0.1.)
const MU_LEAST: f64 = 0.05;

impl<D: Dynamics<NX, NU> + Copy, const NX: usize, const NU: usize> Run<'_, D, NX, NU> {
    /// Algorithm A of Waechter and Biegler (2006), step by step.
    fn run(mut self, observer: &mut dyn FnMut(&SolveProgress) -> ControlFlow<()>) -> Solution<NX, NU> {
        // initialise.
        let tolerance = self.options.tolerance;
        let mu_least = MU_LEAST * tolerance;
        let (mut linearised, mut now) = self.problem.linearise(&self.iterate.nodes);
        let mut sweep = Sweep::new(self.problem.intervals, &self.problem.x_initial_free);
        if self.iterate.path.slack.len() != now.path.len() {
            self.iterate.path = PathDuals::centred(&now.path, self.mu);
        }
        let mut filter = Filter::new(self.merit(&now).violation);
        loop {
            // check convergence of the whole problem.
            let gradient = self.lagrangian_gradient(&linearised);
            let residuals = self.residuals(&gradient, &now, 0.0);
            self.remember(&now);
            if residuals.worst() <= tolerance && self.mu <= tolerance {
                return self.finish(Status::Converged, &now, residuals);
            }
            if !(now.is_finite() && residuals.worst().is_finite()) {
                return self.finish_with_best(Status::Diverged);
            }
            if observer(&self.progress(&now, residuals)).is_break() {
                return self.finish_with_best(Status::Stopped);
            }
            if self.counts.iterations >= self.options.max_iterations {
                return self.finish_with_best(Status::IterationLimit);
            }
            self.counts.iterations += 1;
            // check convergence of the barrier problem.
            while self.mu > mu_least
                && self.residuals(&gradient, &now, self.mu).worst() <= KAPPA_EPSILON * self.mu
            {
                self.mu = (KAPPA_MU * self.mu).min(math::powf(self.mu, THETA_MU)).max(mu_least);
                filter.clear();
            }
            // compute the search direction.
            let search = match self.factor(&mut sweep, &linearised) {
                // backtracking line search; accept the trial point and augment the filter.
                Some(gradients) => {
                    let (sweep, linearised, gradients) = (&sweep, &linearised, &gradients);
                    self.line_search(&System { sweep, linearised, gradients, now: &now }, &mut filter)
                }
                // Optimal as it is, with a barrier parameter that was to become smaller still.
                None if residuals.worst() <= tolerance => {
                    return self.finish(Status::Converged, &now, residuals);
                }
                None => Search::Failed,
            };
            if let Search::Failed = search
                // feasibility restoration.
                && let Err(status) = self.restore(&now, &mut filter)
            {
                return self.finish_with_best(status);
            }
            // continue with the next iteration.
            (linearised, now) = self.problem.linearise(&self.iterate.nodes);
        }
    }

    fn progress(&self, now: &Evaluation<NX>, residuals: Residuals) -> SolveProgress {
        SolveProgress {
            iteration: self.counts.iterations,
            objective: now.objective,
            defect_max: now.defect_max,
            kkt_residual: residuals.dual,
            mu: self.mu,
            step_length: self.step_length,
        }
    }

    /// Goes back towards feasibility from where no step was acceptable, or says how the solve has ended.
    fn restore(&mut self, now: &Evaluation<NX>, filter: &mut Filter) -> Result<(), Status> {
        self.counts.restorations += 1;
        filter.add(self.merit(now));
        let slack = &self.iterate.path.slack;
        match restoration::restore(self.problem, &self.boxes, (&self.iterate.nodes, slack), self.mu, filter) {
            Restored::Found { nodes, slack, iterations } => {
                self.counts.iterations += iterations;
                self.iterate.nodes = nodes;
                self.iterate.path = PathDuals::with_slacks(slack, self.mu);
                self.iterate.centre(&self.boxes, self.mu);
                self.iterate.lambda.fill(SVector::zeros());
                Ok(())
            }
            // There was nothing to restore: it is the search for a lower cost that has come to its end.
            _ if now.violation_max() <= self.feasible() => Err(Status::Stalled),
            lost => self.roll_out(filter).ok_or(match lost {
                Restored::Exhausted => Status::IterationLimit,
                Restored::Found { .. } | Restored::Infeasible => Status::Infeasible,
                Restored::NotFinite => Status::Diverged,
            }),
        }
    }

    /// Goes on from the trajectory that the inputs lead to, once in a solve; `None` where there is none.
    fn roll_out(&mut self, filter: &mut Filter) -> Option<()> {
        if std::mem::replace(&mut self.rolled_out, true) {
            return None;
        }
        self.iterate.nodes = restoration::rolled_out(self.problem, &self.boxes, &self.iterate.nodes)?;
        self.iterate.centre(&self.boxes, self.mu);
        self.iterate.lambda.fill(SVector::zeros());
        filter.clear();
        Some(())
    }

    /// Largest defect of a point that counts as feasible.
    fn feasible(&self) -> f64 {
        1e-6f64.max(self.options.tolerance)
    }

    /// Keeps the point if it is the best so far: feasible with the least cost, else the least infeasible.
    fn remember(&mut self, now: &Evaluation<NX>) {
        if !now.is_finite() {
            return;
        }
        let feasible = self.feasible();
        let better = self.best.as_ref().is_none_or(|best| {
            let violation = now.violation_max();
            if violation <= feasible && best.violation_max <= feasible {
                now.objective < best.objective
            } else {
                violation < best.violation_max
            }
        });
        if better {
            self.best = Some(Best {
                iterate: self.iterate.clone(),
                objective: now.objective,
                violation_max: now.violation_max(),
            });
        }
    }

    fn finish(self, status: Status, now: &Evaluation<NX>, residuals: Residuals) -> Solution<NX, NU> {
        Solution {
            status,
            objective: now.objective,
            defect_max: now.violation_max(),
            kkt_residual: residuals.dual,
            complementarity: residuals.complementarity,
            iterate: self.iterate,
            counts: self.counts,
        }
    }

    fn finish_with_best(mut self, status: Status) -> Solution<NX, NU> {
        if let Some(best) = self.best.take() {
            self.iterate = best.iterate;
        }
        let (linearised, now) = self.problem.linearise(&self.iterate.nodes);
        let gradient = self.lagrangian_gradient(&linearised);
        let residuals = self.residuals(&gradient, &now, 0.0);
        self.finish(status, &now, residuals)
    }
}
