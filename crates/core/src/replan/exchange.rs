//! What passes between those who decide when to renew a plan and those who solve: settings, request, answer.

use crate::model::rigid_body::BodyState;
use crate::plan::Status;
use crate::trajectory::Trajectory;

/// How plans are renewed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReplanSettings {
    /// Time from a measurement until the plan made of it takes effect [s].
    pub latency_s: f64,
    /// Most iterations of a solve.
    pub iterations: usize,
    /// Latest time at which a renewed plan takes effect, since the rotors are freed [s]; `None`:
    /// [`UNTIL_SHARE`](super::UNTIL_SHARE) of the plan.
    pub until_s: Option<f64>,
}

impl Default for ReplanSettings {
    fn default() -> Self {
        Self { latency_s: 0.02, iterations: 50, until_s: None }
    }
}

/// What a solve is asked for. Times are since the rotors are freed [s], negative before.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplanRequest {
    /// Number of the request, from 0.
    pub number: u64,
    /// When the state was measured [s].
    pub seen_s: f64,
    /// State that was measured; the position does not matter.
    pub seen: BodyState,
    /// When the plan is to take effect [s].
    pub takes_effect_s: f64,
    /// The trajectory in force until then.
    pub in_force: Trajectory,
}

/// What came of a solve.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplanAnswer {
    /// Number of the request.
    pub number: u64,
    /// The trajectory from when it takes effect on, to the plan's end; or why the plan is kept.
    pub found: Result<Trajectory, Kept>,
    /// Iterations that the solve took.
    pub iterations: usize,
}

/// Why a plan was kept.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Kept {
    /// Nothing new was measured.
    #[error("no state has come within the latency")]
    NoState,
    /// The state, or what is expected of it, is no number.
    #[error("the state is not a number")]
    NotFinite,
    /// Nothing of the plan is left.
    #[error("the plan is over")]
    PlanOver,
    /// The problem cannot be posed.
    #[error("no problem to solve: {0}")]
    Unposed(String),
    /// The solve did not converge within its iterations.
    #[error("not solved after {iterations} iterations ({})", status_words(*status))]
    Unsolved {
        /// How the solve ended.
        status: Status,
        /// Iterations that it took.
        iterations: usize,
    },
    /// The solve was over after the time at which its plan was to take effect.
    #[error("late by {:.1} ms", late_s * 1e3)]
    Late {
        /// By how much [s].
        late_s: f64,
    },
}

fn status_words(status: Status) -> &'static str {
    match status {
        Status::Converged => "converged",
        Status::IterationLimit => "all that it is given",
        Status::Stopped => "stopped",
        Status::Infeasible => "no trajectory found",
        Status::Stalled => "stalled",
        Status::Diverged => "diverged",
    }
}
