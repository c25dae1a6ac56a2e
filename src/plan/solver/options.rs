//! What a solve is asked and what it answers: settings, starting point, status, progress, work, solution.

use super::Iterate;
use crate::plan::problem::Nodes;

/// Settings of the solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverOptions {
    /// Bound on the KKT residual, the complementarity and the largest defect, all unscaled.
    pub tolerance: f64,
    /// Iterations, restoration included.
    pub max_iterations: usize,
    /// First barrier parameter of a cold start, in units of the cost. Large enough to hold the first iterates off the bounds:
    /// with IPOPT's 0.1 the median over 300 random releases is 24 iterations, with 30 it is 17.
    pub mu_initial: f64,
    /// First barrier parameter of a warm start, in units of the cost. Over 720 plans renewed in flight, each off a little,
    /// the mean is 5.8 iterations with 1e-4 and 6.9 with 1e-2 (and a wider margin to the bounds). Off in yaw too, which the
    /// Titan lander cannot steer and which adds up, it is 11.7 against 11.0.
    pub mu_warm: f64,
}

impl Default for SolverOptions {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: 300, mu_initial: 30.0, mu_warm: 1e-4 }
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// A point that satisfies the optimality conditions to tolerance.
    Converged,
    /// The iteration budget is used up; the best point found is returned.
    IterationLimit,
    /// The observer asked to stop; the best point found is returned.
    Stopped,
    /// No point near this one satisfies the constraints.
    Infeasible,
    /// The constraints hold, but no step gets nearer to the optimum: the tolerance asks for more digits than the numbers have.
    Stalled,
    /// The iterates left the region where the model can be evaluated.
    Diverged,
}

/// How a solve stands after an iteration: what an observer sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Iterations so far.
    pub iteration: usize,
    /// J_d.
    pub objective: f64,
    /// Largest defect.
    pub defect_max: f64,
    /// Largest entry of the Lagrangian's gradient.
    pub kkt_residual: f64,
    /// Barrier parameter.
    pub mu: f64,
    /// Length of the last step.
    pub step_length: f64,
}

/// Work done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Interior point iterations.
    pub iterations: usize,
    /// Evaluations of all defects without derivatives.
    pub evaluations: usize,
    /// Sweeps factored.
    pub factorisations: usize,
    /// Iterations that fell back on the Gauss-Newton Hessian.
    pub gauss_newton: usize,
    /// Second-order corrections taken.
    pub corrections: usize,
    /// Restoration phases entered.
    pub restorations: usize,
}

/// What a solve starts from.
#[derive(Clone, Debug)]
pub enum StartFrom<const NX: usize, const NU: usize> {
    /// Node values only.
    Guess(Nodes<NX, NU>),
    /// Primal and dual variables of a neighbouring problem.
    Warm(Iterate<NX, NU>),
}

/// What a solve ends with.
#[derive(Clone, Debug)]
pub struct Solution<const NX: usize, const NU: usize> {
    /// How it ended.
    pub status: Status,
    /// The solution, or the best point found (feasible with the least cost; else the least infeasible).
    pub iterate: Iterate<NX, NU>,
    /// J_d there.
    pub objective: f64,
    /// Largest defect there.
    pub defect_max: f64,
    /// Largest entry of the Lagrangian's gradient there.
    pub kkt_residual: f64,
    /// Largest product of a bound's multiplier and distance there.
    pub complementarity: f64,
    /// Work done.
    pub counts: Counts,
}

/// A problem that cannot be posed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProblemError {
    /// Fewer than two intervals.
    #[error("at least 3 nodes are needed")]
    TooFewNodes,
    /// Bounds that leave no interior.
    #[error("lower bounds must lie below upper bounds, and rate limits above zero")]
    EmptyBounds,
    /// The input at the first node, which is given, lies outside its bounds.
    #[error("input {} of the first node must lie from {least} to {greatest}, found {found}", index + 1)]
    InitialInput {
        /// Which input, from 0.
        index: usize,
        /// Its least value.
        least: f64,
        /// Its greatest value.
        greatest: f64,
        /// The given value.
        found: f64,
    },
    /// The start has another number of nodes than the problem.
    #[error("the guess has another number of nodes than the problem")]
    GuessLength,
    /// A number that is not finite in the initial state, the weights or the guess.
    #[error("the initial state, the weights and the step must be finite")]
    NotFinite,
}
