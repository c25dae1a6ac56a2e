//! Drops along one plan and along plans that are renewed, from the same random numbers.
//!
//! [`ReplanFlights`] flies each drop from the hang to the mission's end without a wire: 250 Hz, setpoints
//! held at 50 Hz, on the true state. A renewed plan takes effect `replan.latency_s` after the state that it
//! is made of, however long the solve took here. The planner knows the mission's air; the wind that is drawn
//! for a drop it does not know.

use std::ops::ControlFlow;
use std::sync::Arc;

use nalgebra::Vector3;

use crate::controller::{KeepsHeading, controller_or};
use crate::effects::JudgedDrop;
use crate::jobs::row_of;
use samara_core::assess::{Verdict, VerdictBuilder};
use samara_core::control::px4::timing::{IMU_PERIOD_S, SETPOINT_PERIOD_S};
use samara_core::control::{ControlError, Gains};
use samara_core::plan::Plan;
use samara_core::replan::{Cadence, Renewal, ReplanRecord, Replanner};
use samara_core::sim::flight::setpoint_time;
use samara_core::sim::{DropSimulation, FlightPlan, Phase, Reference, fly_by};
use samara_mission::Mission;

/// How the drops of a campaign are flown.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplanRow {
    /// Whether drops are flown so without `--replan`.
    pub as_without: bool,
    /// When plans are renewed; `None`: never.
    pub cadence: Option<Cadence>,
    /// Whether the plan's acceleration is fed forward.
    pub feed_forward: bool,
    /// Name of the gains.
    pub gains_name: String,
    /// The gains.
    pub gains: Gains,
}

impl ReplanRow {
    /// The campaigns of a mission and of the gains for renewed plans, in the order of the report: one plan by
    /// the mission's gains, as drops are flown without `--replan`; unless that is the same, one plan with its
    /// acceleration fed forward by the gains for renewed plans, which tells what these do; and each cadence.
    pub fn campaigns(mission: &Mission, cadences: &[Cadence], of_renewed: (&str, &Gains)) -> Vec<Self> {
        let row = |cadence, feed_forward, (name, gains): (&str, &Gains)| Self {
            as_without: false,
            cadence,
            feed_forward,
            gains_name: name.to_owned(),
            gains: *gains,
        };
        let own = (mission.control.gains_name.as_str(), &mission.control.gains);
        let once = row(None, mission.control.feed_forward, own);
        let fed_forward = row(None, true, of_renewed);
        let differs = fed_forward != once;
        let mut rows = vec![Self { as_without: true, ..once }];
        rows.extend(differs.then_some(fed_forward));
        rows.extend(cadences.iter().map(|cadence| row(Some(*cadence), true, of_renewed)));
        rows
    }

    /// Name in files: `once`, `once_fed_forward`, `release`, `2_hz`.
    pub fn name(&self) -> String {
        match self.cadence {
            None if self.as_without => "once".to_owned(),
            None => "once_fed_forward".to_owned(),
            Some(Cadence::Release) => "release".to_owned(),
            Some(Cadence::Hz(hz)) => format!("{hz}_hz"),
        }
    }

    /// How plans are renewed, in words.
    pub fn words(&self) -> String {
        match self.cadence {
            None if self.feed_forward => "plan once, fed forward".to_owned(),
            None => "plan once".to_owned(),
            Some(Cadence::Release) => "plan at the release".to_owned(),
            Some(Cadence::Hz(hz)) => format!("plan at {hz} Hz"),
        }
    }
}

/// What came of a drop and of its plans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReplanDrop {
    /// What came of the drop.
    pub drop: JudgedDrop,
    /// Plans that were renewed.
    pub renewed: usize,
    /// Attempts after which the plan was kept.
    pub kept: usize,
    /// Iterations of all solves.
    pub iterations: usize,
}

row_of!(ReplanDrop { drop, renewed, kept, iterations });

impl ReplanDrop {
    /// A drop by its verdict, `None` where nothing was released, and what came of each attempt to renew its
    /// plan.
    pub fn of(verdict: Option<Verdict>, records: &[ReplanRecord]) -> Self {
        let kept = records.iter().filter(|record| record.kept.is_some()).count();
        Self {
            drop: JudgedDrop::of(verdict),
            renewed: records.len() - kept,
            kept,
            iterations: records.iter().map(|record| record.iterations).sum(),
        }
    }
}

/// Flies drops of a mission along its plan, renewed or not.
#[derive(Clone, Debug)]
pub struct ReplanFlights {
    mission: Arc<Mission>,
    row: ReplanRow,
    renewal: Renewal,
    controller: KeepsHeading,
}

impl ReplanFlights {
    /// Drops flown as `row` says, from a plan that has converged.
    ///
    /// # Errors
    /// [`ControlError`] for a vehicle that cannot be controlled.
    pub fn new(mission: &Arc<Mission>, plan: &Plan, row: &ReplanRow) -> Result<Self, ControlError> {
        Ok(Self {
            mission: mission.clone(),
            row: row.clone(),
            renewal: Renewal::new(mission.clone(), plan.clone(), mission.replan.settings),
            controller: KeepsHeading::new(controller_or(mission, &row.gains)?),
        })
    }

    /// Flies a trial, a drop by the numbers that a campaign of whole drops draws.
    pub fn fly(&self, trial: u64) -> ReplanDrop {
        self.fly_recorded(trial).0
    }

    /// Flies a trial as [`Self::fly`] does; and what came of each attempt to renew its plan.
    pub fn fly_recorded(&self, trial: u64) -> (ReplanDrop, Vec<ReplanRecord>) {
        let mission = self.mission.with_drop(&self.mission.draw_drop(trial));
        let mut renewal = self.renewal.clone();
        let first = &renewal.newest().trajectory;
        let cadence = self.row.cadence;
        let mut replanner =
            Replanner::new(first.clone(), cadence.unwrap_or(Cadence::Release), renewal.settings());
        let flight = FlightPlan {
            yaw_sp_rad: None,
            ..FlightPlan::new(Reference::Step(mission.target_v_ned), IMU_PERIOD_S, mission.duration_s)
        };
        let mut verdict = VerdictBuilder::judging(mission.limits, mission.target_v_ned).along(first);
        let mut controller = self.controller.clone();
        let mut setpoint = |sim: &DropSimulation| {
            let t_s = sim.time_powered_s()?;
            if cadence.is_some()
                && let Some(request) = replanner.poll(t_s, Some((t_s, sim.state().body)))
            {
                replanner.take(t_s, renewal.answer(&request), None);
            }
            // Powered flight may begin a rounding early.
            let powered = sim.phase() == Phase::Powered && t_s > -1e-9;
            powered.then(|| self.setpoint(&mut replanner, t_s))
        };
        let _ = fly_by(
            &mut mission.released_simulation(),
            &mut controller,
            &flight,
            &mut setpoint,
            &mut |sample| {
                verdict.observe(sample);
                ControlFlow::Continue(())
            },
        );
        let records = replanner.records();
        (ReplanDrop::of(verdict.finish(), records), records.to_vec())
    }

    /// The setpoint in force at the time since the rotors were freed [s].
    fn setpoint(&self, replanner: &mut Replanner, t_s: f64) -> (Vector3<f64>, Vector3<f64>) {
        let sent_s = setpoint_time(t_s, Some(SETPOINT_PERIOD_S));
        let reference = Reference::Plan {
            trajectory: replanner.in_force(sent_s),
            then_v_ned: Some(self.mission.target_v_ned),
            feed_forward: self.row.feed_forward,
        };
        reference.at(sent_s)
    }
}
