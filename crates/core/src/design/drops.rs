//! Whole drops that judge designs: with everything that a mission names, from the hang to the mission's end.
//!
//! What happens before the rotors are free does not depend on a design: a search flies it once, and each of
//! its designs from there.

use nalgebra::Vector3;

use super::objective::{JudgedFlight, LOST};
use super::space::Design;
use crate::assess::{Course, Objection, Outcome, Verdict, VerdictBuilder, Verdicts, judge};
use crate::control::px4::timing::{IMU_PERIOD_S, SETPOINT_PERIOD_S};
use crate::control::{Cascade, ControlSettings, KeepsHeading};
use crate::model::MAX_ROTORS;
use crate::sim::{DropSimulation, Flight, FlightPlan, Phase, Reference, fly_many};
use crate::trajectory::Trajectory;

/// What the controller of a random flight does not know of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// Mass, inertia, air loads, density, steady wind and delays ([`crate::uncertain`]).
    pub vehicle: bool,
    /// Gusts and turbulence.
    pub air: bool,
}

/// A fresh flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreshFlight {
    /// The flight's numbers; the J_TPF of a flight that was lost is [`LOST`].
    pub outcome: Outcome,
    /// Whether the judge of all flights objects to nothing ([`crate::assess::judge_trial`]).
    pub safe: bool,
    /// Whether no limit is among its objections.
    pub within_limits: bool,
    /// Distance of the velocity from the target at the end [m/s]; infinite of a flight that was lost.
    pub end_error_m_s: f64,
}

/// Random drops by their numbers.
pub trait RandomDrops: std::fmt::Debug + Send + Sync {
    /// The drop of a number, with what its controller does not know of: it has not begun, and is released
    /// without a command.
    fn numbered(&self, number: u64, unknown: Unknown) -> DropSimulation;

    /// Time in the simulation before which no drop's rotors are free [s].
    fn held_until_s(&self) -> f64;

    /// Time in the simulation at which a drop along a plan ends [s].
    fn ends_s(&self, plan: &Trajectory) -> f64;
}

/// A drop on its way, and what has been seen of it.
#[derive(Clone, Debug)]
pub struct DrawnDrop {
    simulation: DropSimulation,
    seen: VerdictBuilder,
}

impl DrawnDrop {
    /// A drop that has not begun, seen by a builder that has not seen anything.
    pub fn new(simulation: DropSimulation, seen: VerdictBuilder) -> Self {
        Self { simulation, seen }
    }

    /// The drop at a time before which its rotors are not free [s], or a control period before.
    pub fn advanced_to(mut self, time_s: f64) -> Self {
        while self.simulation.time_s() + IMU_PERIOD_S <= time_s {
            let sample = self.simulation.advance_sampled(&[0.0; MAX_ROTORS], None, IMU_PERIOD_S);
            if sample.phase != Phase::Hanging {
                self.seen.observe(&sample);
            }
        }
        self
    }
}

/// What a drop came to.
#[derive(Clone, Debug)]
pub struct FlownDrop {
    /// The drop's numbers; the J_TPF of a drop that was lost is [`LOST`].
    pub outcome: Outcome,
    /// What the judge of all flights objects to.
    pub objections: Vec<Objection>,
}

impl FlownDrop {
    fn of(verdict: Option<Verdict>) -> Self {
        let objections = judge(verdict.as_ref(), &Course::WHOLE);
        let outcome = verdict.map_or_else(Outcome::lost, |verdict| verdict.outcome);
        let j_tpf = if outcome.j_tpf < LOST { outcome.j_tpf } else { LOST };
        Self { outcome: Outcome { j_tpf, ..outcome }, objections }
    }

    /// The drop among fresh flights to a target velocity [m/s].
    pub(super) fn fresh(&self, target_v_ned: &Vector3<f64>) -> FreshFlight {
        let (safe, within_limits) = (self.objections.is_empty(), self.is_within_limits());
        let end_error_m_s = (self.outcome.final_v_ned() - target_v_ned).norm();
        FreshFlight { outcome: self.outcome, safe, within_limits, end_error_m_s }
    }

    /// The drop as a search takes it, of a mission whose plan has this horizon [s].
    pub(super) fn judged(&self, horizon_s: f64) -> JudgedFlight {
        JudgedFlight {
            j_tpf: self.outcome.j_tpf,
            steady_share: JudgedFlight::share_of(self.outcome.steady_after_s, horizon_s),
            safe: self.objections.is_empty(),
            within_limits: self.is_within_limits(),
        }
    }

    fn is_within_limits(&self) -> bool {
        self.objections.iter().all(Objection::is_of_the_course)
    }
}

/// Flies drops by a design along its plan until they end [s], side by side where they may be; `settings` are
/// the cascade's but for what the design has.
pub fn fly_drops(
    drops: Vec<DrawnDrop>,
    design: &Design,
    (plan, target): (&Trajectory, Vector3<f64>),
    settings: ControlSettings,
    ends_s: f64,
) -> Vec<FlownDrop> {
    let controller = Box::new(KeepsHeading::new(Box::new(Cascade::from(settings))));
    let feed_forward = design.feed_forward;
    let reference = Reference::Plan { trajectory: plan, then_v_ned: Some(target), feed_forward };
    let (mut flights, mut builders) = (Vec::with_capacity(drops.len()), Vec::with_capacity(drops.len()));
    for DrawnDrop { simulation, seen } in drops {
        let plan_flown = FlightPlan {
            setpoint_period_s: Some(SETPOINT_PERIOD_S),
            yaw_sp_rad: None,
            ..FlightPlan::new(reference, IMU_PERIOD_S, ends_s - simulation.time_s())
        };
        flights.push(Flight { simulation, controller: controller.clone(), plan: plan_flown });
        builders.push(seen.along(plan));
    }
    let mut verdicts = Verdicts::by(builders);
    fly_many(flights, &mut verdicts);
    verdicts.finish().into_iter().map(FlownDrop::of).collect()
}
