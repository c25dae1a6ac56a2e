//! A check and its verdict; groups of checks with one source.

use crate::control::ControlError;
use crate::model::{ModelError, TrimError};
use crate::plan::PlanError;
use crate::plan::solver::ProblemError;

/// Why the checks cannot be made. (A check that fails is a result: [`Check::holds`].)
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VerifyError {
    /// The body or parachute of a check is impossible.
    #[error("the body of a check")]
    Model(#[from] ModelError),
    /// A vehicle has no steady flight at its target.
    #[error("a vehicle that is verified")]
    Trim(#[from] TrimError),
    /// The transcription has no code for the lander.
    #[error("the lander's plan")]
    Plan(#[from] PlanError),
    /// A vehicle cannot be controlled.
    #[error("the control of a vehicle that is verified")]
    Control(#[from] ControlError),
    /// The planner's solver does not take a check's problem.
    #[error("an optimal transfer")]
    Problem(#[from] ProblemError),
}

/// A computed quantity and the value that it should have.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Name of the quantity.
    pub what: String,
    /// Unit of the check's numbers; empty for a bare number.
    pub unit: &'static str,
    /// Computed value; of a series the one with the largest error.
    pub computed: f64,
    /// Exact value; of a series the one beside [`Self::computed`].
    pub exact: f64,
    /// The largest deviation, not below zero.
    pub error: f64,
    /// The largest deviation that passes.
    pub bar: f64,
}

impl Check {
    /// Checks a number against its exact value.
    pub fn new(what: impl Into<String>, unit: &'static str, computed: f64, exact: f64, bar: f64) -> Self {
        Self { what: what.into(), unit, computed, exact, error: (computed - exact).abs(), bar }
    }

    /// Checks a series of `(computed, exact)` by its worst pair; one that is not a number is worse than any
    /// other. An empty series fails.
    pub fn worst(
        what: impl Into<String>,
        unit: &'static str,
        series: impl IntoIterator<Item = (f64, f64)>,
        bar: f64,
    ) -> Self {
        let none = Self::new(what, unit, f64::NAN, f64::NAN, bar);
        let checks = series.into_iter().map(|(computed, exact)| Self {
            computed,
            exact,
            error: (computed - exact).abs(),
            ..none.clone()
        });
        let worse = |a: &Self, b: &Self| a.error.is_nan() || a.error >= b.error;
        checks.reduce(|worst, next| if worse(&worst, &next) { worst } else { next }).unwrap_or(none)
    }

    /// Whether the error is within the bar; an error that is not a number is not.
    pub fn holds(&self) -> bool {
        self.error <= self.bar
    }
}

/// Checks of one kind, with one source.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckGroup {
    /// Subject of the checks.
    pub title: &'static str,
    /// Source of the exact values.
    pub source: &'static str,
    /// The checks.
    pub checks: Vec<Check>,
}

impl CheckGroup {
    /// Whether every check holds.
    pub fn holds(&self) -> bool {
        self.checks.iter().all(Check::holds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_the_worst_of_a_series_is_shown_and_nan_never_holds() {
        let worst = |series: &[(f64, f64)]| Check::worst("x", "m", series.iter().copied(), 0.5);
        let check = worst(&[(1.0, 1.0), (2.0, 2.4), (3.0, 3.1)]);
        assert_eq!((check.computed, check.exact), (2.0, 2.4));
        assert!(check.holds());
        assert!(!worst(&[(1.0, 1.6), (2.0, 2.0)]).holds());
        assert!(!worst(&[(1.0, 1.0), (f64::NAN, 2.0), (3.0, 3.0)]).holds());
        assert!(!worst(&[(f64::NAN, 2.0), (3.0, 3.0)]).holds());
        assert!(!worst(&[]).holds());
    }
}
