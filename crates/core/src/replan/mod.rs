//! Plans that are renewed during a drop: from what was measured, for when the new plan can take effect.
//!
//! ```text
//! measured at t ---- predicted over the latency ----> takes effect at max(0, t + latency)
//! ```
//!
//! A plan is made for one state at t = 0, and no release brings just that one. A renewed plan begins at the
//! state that the vehicle is expected to have once the solve is over, and ends where the first one does: the
//! horizon shrinks, its nodes draw closer, and where nothing has gone otherwise than planned the renewed plan
//! is the rest of the one before (Bellman's principle). What cannot be renewed in time is flown on as it was
//! planned, and the reason is said.
//!
//! | file | holds |
//! |---|---|
//! | [`exchange`] | settings, request and answer, and why a plan is kept |
//! | [`prediction`] | the state at which a renewed plan begins |
//! | [`renewal`] | the solve: a warm start from the newest plan, with bounded iterations |
//! | [`replanner`] | when a plan is renewed, which one is in force, what came of each attempt; no clock |
//! | [`setup`] | a plan with all that its renewals need |

pub mod exchange;
pub mod prediction;
pub mod renewal;
pub mod replanner;
pub mod setup;

#[cfg(test)]
mod tests;

pub use exchange::{Kept, ReplanAnswer, ReplanRequest, ReplanSettings};
pub use prediction::{expected_state, nose_north};
pub use renewal::{PlanSource, Renewal};
pub use replanner::{Cadence, ReplanRecord, Replanner, UNTIL_SHARE};
pub use setup::ReplanSetup;
