//! The filter of the line search: pairs (constraint violation, barrier objective) that new points must
//! improve on.
//!
//! A. Waechter, L. T. Biegler, "On the implementation of an interior-point filter line-search algorithm for
//! large-scale nonlinear programming", Math. Program. 106 (2006), section 2.3; its constants, cited by its
//! equations.

use crate::math;

/// Constraint violation and barrier objective of a point, which the filter compares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Merit {
    /// Sum of the absolute defects, theta.
    pub violation: f64,
    /// Barrier objective, phi.
    pub objective: f64,
}

/// Corners: the merits of points that the line search has left behind.
#[derive(Clone, Debug)]
pub struct Filter {
    corners: Vec<Merit>,
    violation_max: f64,
    violation_min: f64,
}

/// Least relative decrease of the violation, (18).
const GAMMA_THETA: f64 = 1e-5;
/// Least decrease of the objective as a part of the violation, (18).
const GAMMA_PHI: f64 = 1e-8;
/// Least decrease of the objective as a part of its slope (Armijo), (20).
const ETA_PHI: f64 = 1e-8;
/// Exponent of the violation in the switching condition, (19).
const S_THETA: f64 = 1.1;
/// Exponent of the slope in the switching condition, (19).
const S_PHI: f64 = 2.3;
/// Safety factor of the least step length, (23).
const GAMMA_ALPHA: f64 = 0.05;

impl Filter {
    /// An empty filter for a solve that starts at the constraint violation `violation`.
    pub fn new(violation: f64) -> Self {
        let scale = violation.max(1.0);
        Self { corners: Vec::new(), violation_max: 1e4 * scale, violation_min: 1e-4 * scale }
    }

    /// Forgets all corners, as after a change of the barrier parameter.
    pub fn clear(&mut self) {
        self.corners.clear();
    }

    /// Adds the corner of a point that is left behind.
    pub fn add(&mut self, from: Merit) {
        self.corners.push(Merit {
            violation: (1.0 - GAMMA_THETA) * from.violation,
            objective: from.objective - GAMMA_PHI * from.violation,
        });
    }

    /// Whether no corner of the filter dominates the trial point.
    pub fn accepts(&self, trial: Merit) -> bool {
        trial.violation.is_finite()
            && trial.objective.is_finite()
            && trial.violation <= self.violation_max
            && self.corners.iter().all(|c| trial.violation < c.violation || trial.objective < c.objective)
    }

    /// Whether a trial point at step length `alpha` is taken; `slope` is the directional derivative of the
    /// objective. Unless it is taken for a decrease of the objective (Armijo), the point left behind enters
    /// the filter.
    pub fn takes(&mut self, from: Merit, trial: Merit, alpha: f64, slope: f64) -> bool {
        if !self.accepts(trial) {
            return false;
        }
        let noise = 10.0 * f64::EPSILON * from.objective.abs();
        let switching = slope < 0.0
            && alpha * math::powf(-slope, S_PHI) > math::powf(from.violation, S_THETA)
            && from.violation <= self.violation_min;
        if switching {
            return trial.objective <= from.objective + ETA_PHI * alpha * slope + noise;
        }
        let better = trial.violation <= (1.0 - GAMMA_THETA) * from.violation
            || trial.objective <= from.objective - GAMMA_PHI * from.violation + noise;
        if better {
            self.add(from);
        }
        better
    }

    /// Step length below which the line search gives up and restores feasibility.
    pub fn least_step(&self, from: Merit, slope: f64) -> f64 {
        let mut alpha = GAMMA_THETA;
        if slope < 0.0 {
            alpha = alpha.min(GAMMA_PHI * from.violation / -slope);
            if from.violation <= self.violation_min {
                alpha = alpha.min(math::powf(from.violation, S_THETA) / math::powf(-slope, S_PHI));
            }
        }
        (GAMMA_ALPHA * alpha).max(1e-12)
    }
}
