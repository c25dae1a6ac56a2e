//! How it should fly: the optimal control problem (25)-(31) by direct collocation (32)-(39).
pub mod barrier;
pub mod block;
pub mod dynamics;
pub mod filter;
pub mod problem;
pub mod restoration;
pub mod riccati;
pub mod solver;
pub mod transcription;
pub mod vehicle;
pub use vehicle::{Guess, InputReference, Plan, PlanError, PlanProblem, PlanState, plan};
