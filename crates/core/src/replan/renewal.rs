//! The solve: the mission's problem from the expected state to the plan's end, begun from the newest plan.

use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;

use super::exchange::{Kept, ReplanAnswer, ReplanRequest, ReplanSettings};
use super::prediction::{expected_state, nose_north};
use crate::model::rigid_body::BodyState;
use crate::plan::{Guess, Plan, PlanProblem, PlanState, SolverOptions, Status, plan};
use crate::sim::Start;
use crate::trajectory::{Node, Trajectory};

/// The mission whose plan is renewed.
pub trait PlanSource: fmt::Debug + Send + Sync {
    /// The planner's problem from this state at t = 0, rotors at rest.
    fn problem_from(&self, initial: PlanState) -> PlanProblem<'_>;

    /// How the vehicle comes from the release to t = 0.
    fn start(&self) -> Start;
}

/// Bound on residuals and defects of a renewed plan: a hundred times the planner's own, and far below what
/// a vehicle follows.
pub const TOLERANCE: f64 = 1e-6;

/// Renews plans of one drop after another; it remembers the newest plan, from which the next solve begins.
#[derive(Clone, Debug)]
pub struct Renewal {
    source: Arc<dyn PlanSource>,
    settings: ReplanSettings,
    newest: Plan,
    /// When the newest plan begins, since the rotors are freed [s].
    newest_from_s: f64,
    end_s: f64,
}

impl Renewal {
    /// Renews this plan of a mission, which begins at t = 0.
    pub fn new(source: Arc<dyn PlanSource>, plan: Plan, settings: ReplanSettings) -> Self {
        let end_s = plan.trajectory.end_s();
        Self { source, settings, newest: plan, newest_from_s: 0.0, end_s }
    }

    /// The settings.
    pub fn settings(&self) -> ReplanSettings {
        self.settings
    }

    /// The plan that it was made with, or the newest that was found since.
    pub fn newest(&self) -> &Plan {
        &self.newest
    }

    /// Solves for what is asked.
    pub fn answer(&mut self, request: &ReplanRequest) -> ReplanAnswer {
        let (found, iterations) = match self.solve(request) {
            Ok((trajectory, iterations)) => (Ok(trajectory), iterations),
            Err((kept, iterations)) => (Err(kept), iterations),
        };
        ReplanAnswer { number: request.number, found, iterations }
    }

    fn solve(&mut self, request: &ReplanRequest) -> Result<(Trajectory, usize), (Kept, usize)> {
        let source = self.source.clone();
        let from_s = request.takes_effect_s;
        let mut problem = source.problem_from([0.0; 10]);
        let site = (problem.vehicle, problem.environment, source.start());
        let expected = expected_state(site, (request.seen_s, request.seen), &request.in_force, from_s)
            .ok_or((Kept::NotFinite, 0))?;
        let BodyState { q_ned_from_body: q, v_ned: v, omega_body: w, .. } = nose_north(&expected);
        problem.initial = [q[0], q[1], q[2], q[3], v.x, v.y, v.z, w.x, w.y, w.z];
        if from_s > 0.0 {
            problem.initial_thrust_n =
                request.in_force.thrust_n(from_s).map(|n| n.clamp(0.0, problem.thrust_max_n));
        }
        problem.horizon_s = self.end_s - from_s;
        if let Some(ring) = &mut problem.demands.vortex_ring {
            (ring.from_s, ring.to_s) = (ring.from_s - from_s, ring.to_s - from_s);
        }
        // A release may be far from the plan's: on 60 of `titan_drop` a solve took 39 iterations in the mean
        // and 117 at most with the barrier parameter of near problems, and takes 13 and 20 with this one.
        let options = SolverOptions {
            tolerance: TOLERANCE,
            max_iterations: self.settings.iterations,
            mu_warm_most: SolverOptions::default().mu_initial,
            ..SolverOptions::default()
        };
        if problem.horizon_s <= 0.0 {
            return Err((Kept::PlanOver, 0));
        }
        let passed = (from_s - self.newest_from_s) / (self.end_s - self.newest_from_s);
        let guess = if passed > 0.0 { self.newest.rest(passed) } else { self.newest.moved_on(0) };
        let solved = solve(&problem, &guess, &options).map_err(|kept| (kept, 0))?;
        let iterations = solved.counts.iterations;
        if solved.status != Status::Converged {
            return Err((Kept::Unsolved { status: solved.status, iterations }, iterations));
        }
        let trajectory = later(&solved.trajectory, from_s).ok_or((Kept::NotFinite, iterations))?;
        (self.newest, self.newest_from_s) = (solved, from_s);
        Ok((trajectory, iterations))
    }
}

fn solve(problem: &PlanProblem<'_>, guess: &Guess<'_>, options: &SolverOptions) -> Result<Plan, Kept> {
    plan(problem, guess, options, &mut |_| ControlFlow::Continue(()))
        .map_err(|error| Kept::Unposed(error.to_string()))
}

/// A trajectory whose times begin at `from_s` [s].
fn later(trajectory: &Trajectory, from_s: f64) -> Option<Trajectory> {
    if from_s == 0.0 {
        return Some(trajectory.clone());
    }
    let nodes = trajectory.nodes().iter().map(|node| Node { t_s: node.t_s + from_s, ..*node }).collect();
    Trajectory::new(nodes, trajectory.n_rotors()).ok()
}
