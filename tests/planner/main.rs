//! The planner: against an independent implementation's optima, closed forms, differences and hard problems.
#![cfg(feature = "files")]
#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod convergence;
mod derivatives;
mod limits;
mod problems;
mod reference;
mod robustness;
