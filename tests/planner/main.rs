//! The planner: against an independent implementation's optima, closed forms, differences and hard problems.
#![cfg(feature = "files")]
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on fails; measured iteration counts are shown"
)]

mod convergence;
mod derivatives;
mod limits;
mod problems;
mod reference;
mod robustness;
