//! A plan with all that its renewals need.

use std::sync::Arc;

use super::exchange::ReplanSettings;
use super::renewal::{PlanSource, Renewal};
use super::replanner::{Cadence, Replanner};
use crate::plan::Plan;

/// A plan with all that its renewals need.
#[derive(Clone, Debug)]
pub struct ReplanSetup {
    /// The mission.
    pub source: Arc<dyn PlanSource>,
    /// The plan that begins at t = 0; it has converged.
    pub plan: Plan,
    /// When it is renewed.
    pub cadence: Cadence,
    /// How it is renewed.
    pub settings: ReplanSettings,
}

impl ReplanSetup {
    /// What solves.
    pub fn renewal(&self) -> Renewal {
        Renewal::new(self.source.clone(), self.plan.clone(), self.settings)
    }

    /// What decides when to solve, and what is in force.
    pub fn replanner(&self) -> Replanner {
        Replanner::new(self.plan.trajectory.clone(), self.cadence, self.settings)
    }
}
