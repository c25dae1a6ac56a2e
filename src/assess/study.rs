//! The paper's safety study, section V: controllers flown from many releases on the plant with actuators.
//!
//! A flight begins at t = 0 of the study (rotors at rest and free), is commanded at 100 Hz, and lasts as long as the plan;
//! its cost is J_TPF, (51). Trials fly side by side on the planar engine ([`crate::sim::planar`]) where it can hold them, else
//! one by one in space; the two agree to 1e-9.

use std::ops::ControlFlow;
use std::sync::Arc;

use nalgebra::Vector3;

use super::batch::{Outcome, Study, judge_flights};
use super::releases::RandomRelease;
use super::safety::{SafetyLimits, StateCost};
use super::tracking::{self, TrackingError};
use crate::control::{Airframe, Cascade, ControlLimits, Gains};
use crate::frames::{bank, pitch, rotate_body_from_ned};
use crate::model::rigid_body::BodyState;
use crate::model::{Environment, Vehicle};
use crate::sim::planar::{Flight, Model, NotPlanar, Release, Variation};
use crate::sim::{DropSimulation, FlightPlan, PlantKind, Reference, Sample, fly};
use crate::trajectory::Trajectory;

/// Period of control and of the simulation's steps [s].
pub const CONTROL_PERIOD_S: f64 = tracking::NOMINAL_PERIOD_S;
/// A trace keeps about so many instants.
const TRACE_INSTANTS: f64 = 1500.0;

/// What a controller is told to follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// The target velocity at once.
    Step,
    /// The velocity of the plan.
    Optimal,
}

/// Gains with what they follow: a row of Table 5, a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Controller {
    /// Name in files: `near_hover_step`.
    pub name: &'static str,
    /// Name of the gains.
    pub gains_name: String,
    /// The gains.
    pub gains: Gains,
    /// What is followed.
    pub command: Command,
}

/// What all flights share.
#[derive(Clone, Debug)]
pub struct SafetyStudy {
    /// The vehicle.
    pub vehicle: Arc<Vehicle>,
    /// The site.
    pub environment: Environment,
    /// The control law's model of the vehicle.
    pub airframe: Airframe,
    /// Limits of the cascade.
    pub control_limits: ControlLimits,
    /// Safety limits, Table 1.
    pub limits: SafetyLimits,
    /// Steady velocity to reach, NED [m/s].
    pub target_v_ned: Vector3<f64>,
    /// The plan from the nominal release; flights last as long.
    pub plan: Trajectory,
}

/// What a flight came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrialOutcome {
    /// J_TPF, (51); infinite when a state was no number.
    pub j_tpf: f64,
    /// Largest speed [m/s].
    pub peak_speed_m_s: f64,
    /// Largest pitch, either way, with its sign [rad].
    pub peak_pitch_rad: f64,
    /// Largest pitch rate, either way, with its sign [rad/s].
    pub peak_pitch_rate_rad_s: f64,
    /// Largest roll, either way, with its sign [rad]; zero in the plane.
    pub peak_roll_rad: f64,
    /// Largest roll rate, either way, with its sign [rad/s]; zero in the plane.
    pub peak_roll_rate_rad_s: f64,
    /// Velocity at the end, NED [m/s].
    pub final_v_ned: Vector3<f64>,
}

/// What figures show of a flight at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceInstant {
    /// Time since the rotors were freed [s].
    pub t_s: f64,
    /// Way north and down since t = 0 [m].
    pub north_down_m: (f64, f64),
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Velocity, body axes [m/s].
    pub v_body: Vector3<f64>,
    /// J_state, (47).
    pub j_state: f64,
}

impl From<&Outcome> for TrialOutcome {
    fn from(outcome: &Outcome) -> Self {
        let [v_north_m_s, v_down_m_s] = outcome.final_v_m_s;
        Self {
            j_tpf: outcome.j_tpf,
            peak_speed_m_s: outcome.peak_speed_m_s,
            peak_pitch_rad: outcome.peak_pitch_rad,
            peak_pitch_rate_rad_s: outcome.peak_pitch_rate_rad_s,
            peak_roll_rad: 0.0,
            peak_roll_rate_rad_s: 0.0,
            final_v_ned: Vector3::new(v_north_m_s, 0.0, v_down_m_s),
        }
    }
}

impl SafetyStudy {
    /// Flies a trial from each release, side by side where the vehicle and the releases are of the plane. The outcome of a
    /// release does not depend on the others in the slice.
    pub fn fly_releases(&self, controller: &Controller, releases: &[RandomRelease]) -> Vec<TrialOutcome> {
        let alone = |release: &RandomRelease| self.outcome(controller, &release.state);
        match self.side_by_side(controller, releases) {
            // A flight that the batch engine gave up on still has its peaks before it.
            Ok(outcomes) => outcomes
                .iter()
                .zip(releases)
                .map(|(outcome, release)| if outcome.given_up { alone(release) } else { outcome.into() })
                .collect(),
            Err(_) => releases.iter().map(alone).collect(),
        }
    }

    fn side_by_side(
        &self,
        controller: &Controller,
        releases: &[RandomRelease],
    ) -> Result<Vec<Outcome>, NotPlanar> {
        let model = Model::new(&self.vehicle, &self.environment, &self.control_limits, PlantKind::Actuator)?;
        let target_m_s = [self.target_v_ned.x, self.target_v_ned.z];
        let plan = self.flight_plan(controller, CONTROL_PERIOD_S);
        let study = Study::new(&plan, None, self.limits, target_m_s)?;
        let flights = releases
            .iter()
            .map(|release| {
                Ok(Flight {
                    gains: controller.gains,
                    release: Release::of(&release.state)?,
                    variation: Variation::NONE,
                })
            })
            .collect::<Result<Vec<_>, NotPlanar>>()?;
        let mut outcomes = vec![Outcome::default(); flights.len()];
        judge_flights(&model, &study, &flights, &mut outcomes);
        Ok(outcomes)
    }

    fn flight_plan(&self, controller: &Controller, period_s: f64) -> FlightPlan<'_> {
        let reference = match controller.command {
            Command::Step => Reference::Step(self.target_v_ned),
            Command::Optimal => {
                Reference::Plan { trajectory: &self.plan, then_v_ned: None, feed_forward: false }
            }
        };
        FlightPlan {
            reference,
            yaw_sp_rad: 0.0,
            control_period_s: period_s,
            setpoint_period_s: None,
            duration_s: self.plan.end_s(),
        }
    }

    /// Flies from a state at t = 0.
    pub fn outcome(&self, controller: &Controller, start: &BodyState) -> TrialOutcome {
        let mut peaks = Peaks::new(self.limits);
        self.fly(controller, start, CONTROL_PERIOD_S, &mut |sample| {
            peaks.observe(sample);
            ControlFlow::Continue(())
        });
        peaks.outcome
    }

    /// Distance from the plan, (45), of a flight whose steps fall on the plan's nodes.
    pub fn tracking_rms(&self, controller: &Controller, start: &BodyState) -> f64 {
        let mut error = TrackingError::new(&self.plan);
        let period_s = tracking::control_period_s(&self.plan);
        self.fly(controller, start, period_s, &mut |sample| error.observe(sample));
        error.rms()
    }

    /// A flight for figures, in about 1500 instants.
    pub fn trace(&self, controller: &Controller, start: &BodyState) -> Vec<TraceInstant> {
        let steps = self.plan.end_s() / CONTROL_PERIOD_S;
        let every = ((steps / TRACE_INSTANTS).round() as usize).max(1);
        let (mut trace, mut count) = (Vec::new(), 0);
        self.fly(controller, start, CONTROL_PERIOD_S, &mut |sample| {
            if count % every == 0 {
                trace.push(self.trace_instant(sample));
            }
            count += 1;
            ControlFlow::Continue(())
        });
        trace
    }

    /// Every sample of a flight.
    pub fn samples(&self, controller: &Controller, start: &BodyState) -> Vec<Sample> {
        let mut samples = Vec::new();
        self.fly(controller, start, CONTROL_PERIOD_S, &mut |sample| {
            samples.push(*sample);
            ControlFlow::Continue(())
        });
        samples
    }

    fn trace_instant(&self, sample: &Sample) -> TraceInstant {
        let body = &sample.state.body;
        TraceInstant {
            t_s: sample.t_s,
            north_down_m: (body.p_ned.x, body.p_ned.z),
            v_ned: body.v_ned,
            v_body: rotate_body_from_ned(body.q_ned_from_body, body.v_ned),
            j_state: StateCost::of(body, &self.limits).max(),
        }
    }

    fn fly(
        &self,
        controller: &Controller,
        start: &BodyState,
        period_s: f64,
        observe: &mut impl FnMut(&Sample) -> ControlFlow<()>,
    ) {
        let (vehicle, environment) = (self.vehicle.clone(), self.environment.clone());
        let mut sim = DropSimulation::at_t0(vehicle, environment, *start, PlantKind::Actuator);
        let mut cascade = Cascade::new(self.airframe.clone(), controller.gains, self.control_limits);
        let flight = self.flight_plan(controller, period_s);
        // Whether it was broken off is the observer's to know.
        let _ = fly(&mut sim, &mut cascade, &flight, observe);
    }
}

/// Gathers an [`TrialOutcome`].
struct Peaks {
    limits: SafetyLimits,
    outcome: TrialOutcome,
}

impl Peaks {
    fn new(limits: SafetyLimits) -> Self {
        let outcome = TrialOutcome {
            j_tpf: 0.0,
            peak_speed_m_s: 0.0,
            peak_pitch_rad: 0.0,
            peak_pitch_rate_rad_s: 0.0,
            peak_roll_rad: 0.0,
            peak_roll_rate_rad_s: 0.0,
            final_v_ned: Vector3::zeros(),
        };
        Self { limits, outcome }
    }

    fn observe(&mut self, sample: &Sample) {
        let (body, o) = (&sample.state.body, &mut self.outcome);
        let cost = StateCost::of(body, &self.limits);
        o.j_tpf = o.j_tpf.max(cost.max());
        o.peak_speed_m_s = o.peak_speed_m_s.max(body.v_ned.norm());
        for (peak, now) in [
            (&mut o.peak_pitch_rad, pitch(body.q_ned_from_body)),
            (&mut o.peak_pitch_rate_rad_s, body.omega_body.y),
            (&mut o.peak_roll_rad, bank(body.q_ned_from_body)),
            (&mut o.peak_roll_rate_rad_s, body.omega_body.x),
        ] {
            if now.abs() > peak.abs() {
                *peak = now;
            }
        }
        o.final_v_ned = body.v_ned;
    }
}
