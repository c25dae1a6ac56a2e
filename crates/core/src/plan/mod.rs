//! The planner: the optimal control problem (25)-(31) by direct collocation (32)-(39).
//!
//! | file | holds |
//! |---|---|
//! | [`vehicle`](mod@vehicle) | the planner's interface: a drop in the vehicle's terms, a trajectory back |
//! | `guess` | what the solver starts from |
//! | `multipliers` | what each constraint costs a plan |
//! | [`grid`] | plans on a grid of release states, interpolated at the release |
//! | [`problem`] | the problem: cost, bounds, nodes |
//! | [`demands`](Demands) | what a plan is asked for beyond cost and bounds on thrusts |
//! | `demanded` | the constraints that it comes to |
//! | [`extended`] | the dynamics with altitude lost, peak and stretch of time |
//! | [`dynamics`] | `f(x, u)` with exact first and second derivatives |
//! | [`transcription`] | Hermite-Simpson defects (33)-(37) and cost (38)-(39) |
//! | [`solver`] | the interior point method |
//! | [`riccati`] | the Newton step of that method, by a sweep over the stages |
//! | [`barrier`], `box_bounds` | bounds of a vector and their logarithmic barrier; those of a problem |
//! | [`filter`] | which of two points is better |
//! | [`restoration`] | the way back to feasibility |
//! | [`path`] | inequality constraints on the path: the seam |
//! | `slacks` | their slacks and multipliers in the Newton system |
//! | [`block`] | products of small matrices |
//!
//! Another vehicle model is another [`dynamics::Dynamics`]; another solver takes a [`problem::Problem`] and
//! returns nodes.

pub mod barrier;
pub mod block;
mod box_bounds;
mod demanded;
mod demands;
pub mod dynamics;
pub mod extended;
pub mod filter;
pub mod grid;
mod guess;
mod multipliers;
pub mod path;
pub mod problem;
pub mod restoration;
pub mod riccati;
mod slacks;
pub mod solver;
pub mod transcription;
pub mod vehicle;

#[cfg(test)]
mod dynamics_tests;

pub use demands::{Demands, FreeHorizon, MotionBounds, PeakCost, RingBounds};
pub use guess::Guess;
pub use multipliers::Multipliers;
pub use solver::{Counts, SolveProgress, SolverOptions, Status};
pub use vehicle::{
    InputReference, Plan, PlanError, PlanProblem, PlanState, TERMINAL_TOLERANCE_LEAST_M_S, plan,
};
