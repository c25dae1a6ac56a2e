//! How safe: what a flight cost, and whether it stayed within its limits.
//!
//! | file | holds | paper |
//! |---|---|---|
//! | [`safety`] | J_state, J_TPF, the verdict on a drop | (47)-(51), Table 1 |
//! | [`tracking`] | RMS distance of a flight from its plan | (45)-(46) |
//! | [`batch`] | both for many planar flights at once | |

pub mod batch;
pub mod safety;
pub mod tracking;

pub use batch::{Outcome, Study, judge_flights};
pub use safety::{SafetyLimits, StateCost, Verdict, VerdictBuilder, plan_j_tpf, steady_within_m_s};
pub use tracking::TrackingError;
