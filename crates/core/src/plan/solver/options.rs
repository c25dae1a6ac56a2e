//! Arguments and results of a solve: options, starting point, progress, status, counts, solution.

use super::Iterate;
use crate::hints::No;
use crate::plan::problem::Nodes;

/// Options of the interior point method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverOptions {
    /// Bound on the KKT residual, the complementarity and the largest defect, the first two in units in which
    /// the largest weight of the running cost is from 1 to 1000: costs beyond are scaled.
    pub tolerance: f64,
    /// Most iterations, those of the restoration phase included.
    pub max_iterations: usize,
    /// First barrier parameter of a cold start, in units of the cost. Large enough to hold the first iterates
    /// off the bounds: with IPOPT's 0.1 the median over 300 random releases is 24 iterations, with 30 it is
    /// 17.
    pub mu_initial: f64,
    /// Least first barrier parameter of a warm start, in units of the cost. Over 720 plans renewed in flight,
    /// each off a little, the mean is 5.8 iterations with 1e-4 and 6.9 with 1e-2 (and a wider margin to the
    /// bounds). Off in yaw too, which the Titan lander cannot steer and which adds up, it is 11.7 against
    /// 11.0.
    pub mu_warm: f64,
    /// Greatest first barrier parameter of a warm start, in units of the cost. Between the two it is the
    /// change of cost that the multipliers expect of the defects, over the number of bounds. As small as
    /// `mu_warm`, unless it is said otherwise: for a problem that is near.
    pub mu_warm_most: f64,
}

impl Default for SolverOptions {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: 300, mu_initial: 30.0, mu_warm: 1e-4, mu_warm_most: 1e-4 }
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
    /// The constraints hold, but no step gets nearer to the optimum, or none can be solved for: the tolerance
    /// asks for more digits than the numbers have.
    Stalled,
    /// The iterates left the region where the model can be evaluated.
    Diverged,
}

impl Status {
    /// What kind of a no it is; `None` where a plan was found.
    pub const fn no(self) -> Option<No> {
        match self {
            Self::Converged => None,
            Self::IterationLimit => Some(No::PlanBudget),
            Self::Stopped => Some(No::PlanStopped),
            Self::Infeasible => Some(No::PlanInfeasible),
            Self::Stalled => Some(No::PlanStalled),
            Self::Diverged => Some(No::PlanDiverged),
        }
    }
}

/// The state of a solve after an iteration, as an observer sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveProgress {
    /// Iterations so far.
    pub iteration: usize,
    /// Cost J_d of (32).
    pub objective: f64,
    /// Largest absolute defect (33).
    pub defect_max: f64,
    /// Largest entry of the Lagrangian's gradient.
    pub kkt_residual: f64,
    /// Barrier parameter.
    pub mu: f64,
    /// Length of the last primal step, from 0 to 1.
    pub step_length: f64,
}

/// Numbers of iterations, evaluations and factorisations of a solve.
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

/// The point from which a solve starts.
#[derive(Clone, Debug)]
pub enum StartFrom<const NX: usize, const NU: usize> {
    /// Node values only; multipliers are put on the central path.
    Guess(Nodes<NX, NU>),
    /// Primal and dual variables of a neighbouring problem.
    Warm(Iterate<NX, NU>),
}

/// The result of a solve.
#[derive(Clone, Debug)]
pub struct Solution<const NX: usize, const NU: usize> {
    /// How the solve ended.
    pub status: Status,
    /// The solution, or the best point found (feasible with the least cost; else the least infeasible).
    pub iterate: Iterate<NX, NU>,
    /// Cost J_d at [`Self::iterate`].
    pub objective: f64,
    /// Largest absolute defect at [`Self::iterate`], or largest violation of a constraint on the path.
    pub defect_max: f64,
    /// Largest entry of the Lagrangian's gradient at [`Self::iterate`].
    pub kkt_residual: f64,
    /// Largest product of a bound's multiplier and distance at [`Self::iterate`].
    pub complementarity: f64,
    /// Iterations, evaluations and factorisations that the solve took.
    pub counts: Counts,
}

/// Why a problem cannot be posed.
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
        /// Index of the input, from 0.
        index: usize,
        /// Least value of that input.
        least: f64,
        /// Greatest value of that input.
        greatest: f64,
        /// Value of that input at the first node.
        found: f64,
    },
    /// The starting point has another number of nodes than the problem.
    #[error("the guess has another number of nodes than the problem")]
    GuessLength,
    /// The initial state, the weights or the time step are not finite.
    #[error("the initial state, the weights and the step must be finite")]
    NotFinite,
}
