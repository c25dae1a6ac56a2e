//! What a set of gains costs: its flights along the plan, judged in tracking (45)-(46), safety (51) and steadiness.
//!
//! Flights begin at t = 0 of the study with the rotors at rest and are flown by the cascade at the study's control period. The
//! first one is the nominal case: it goes on after the plan's end with the target velocity commanded, and shows whether the
//! gains come to rest. The others end with the plan. What is scattered in a robust bench the controller does not know of.

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::Vector3;

use super::{Longitudinal, ReleaseCase};
use crate::assess::tracking::control_period_s;
use crate::assess::{SafetyLimits, StateCost, TrackingError};
use crate::control::{Airframe, Cascade, ControlLimits, Gains, Measurement};
use crate::model::rigid_body::{BodyState, MassProperties};
use crate::model::{Environment, ModelError, Vehicle};
use crate::sim::{DropSimulation, PlantKind, Reference};
use crate::trajectory::Trajectory;

/// The last part of the nominal flight that must be steady [s].
const STEADY_FOR_S: f64 = 1.0;

/// What the flights are flown with.
#[derive(Clone, Debug)]
pub struct Setting<'a> {
    /// The vehicle as the controller knows it.
    pub vehicle: Arc<Vehicle>,
    /// The site as the controller knows it.
    pub environment: Environment,
    /// Limits of the cascade.
    pub control_limits: ControlLimits,
    /// The controller's model of the vehicle.
    pub airframe: Airframe,
    /// Gains whose yaw part is used.
    pub yaw: Gains,
    /// The plan to follow.
    pub plan: &'a Trajectory,
    /// Velocity after the plan's end, NED [m/s].
    pub target_v_ned: Vector3<f64>,
    /// Limits that J_state is measured by.
    pub safety: SafetyLimits,
    /// The actuators.
    pub plant: PlantKind,
    /// How long the nominal flight goes on after the plan's end [s].
    pub settle_s: f64,
}

/// One flight of a bench.
#[derive(Clone, Debug)]
struct Trial {
    start: BodyState,
    vehicle: Arc<Vehicle>,
    environment: Environment,
    /// Control periods by which the measurement is late.
    late: usize,
    /// Whether the target follows the plan.
    settles: bool,
    tracked: bool,
}

/// The worst of a candidate's flights, or one flight. Infinite where a flight diverged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation {
    /// J_RMS, (45), over the flights of the mission's cases.
    pub rms: f64,
    /// J_TPF, (51), over all flights.
    pub j_tpf: f64,
    /// Largest `|v - v_cmd|/|v_cmd|` in the last second of the nominal flight.
    pub unsteady: f64,
}

impl Evaluation {
    /// The best there is.
    pub const PERFECT: Self = Self { rms: 0.0, j_tpf: 0.0, unsteady: 0.0 };
    const DIVERGED: Self = Self { rms: f64::INFINITY, j_tpf: f64::INFINITY, unsteady: f64::INFINITY };

    /// The worse of two in each number.
    pub fn worse(self, other: Self) -> Self {
        Self {
            rms: self.rms.max(other.rms),
            j_tpf: self.j_tpf.max(other.j_tpf),
            unsteady: self.unsteady.max(other.unsteady),
        }
    }

    /// Whether every flight came to its end.
    pub fn is_finite(&self) -> bool {
        self.rms.is_finite() && self.j_tpf.is_finite() && self.unsteady.is_finite()
    }
}

/// Flights to judge gains by.
#[derive(Clone, Debug)]
pub struct Bench<'a> {
    setting: Setting<'a>,
    trials: Vec<Trial>,
}

impl<'a> Bench<'a> {
    /// The flights of (46): the mission's cases, the first one nominal.
    pub fn of_cases(setting: Setting<'a>, cases: &[ReleaseCase]) -> Self {
        let trial = |(i, case): (usize, &ReleaseCase)| Trial {
            settles: i == 0,
            tracked: true,
            ..nominal(&setting, case.state())
        };
        let trials = cases.iter().enumerate().map(trial).collect();
        Self { setting, trials }
    }

    /// Only J_TPF of flights from these states.
    pub fn of_states(setting: Setting<'a>, states: &[BodyState]) -> Self {
        let trials = states.iter().map(|s| nominal(&setting, *s)).collect();
        Self { setting, trials }
    }

    /// Adds flights from these states, judged by J_TPF.
    pub fn and_states(mut self, states: &[BodyState]) -> Self {
        self.trials.extend(states.iter().map(|s| nominal(&self.setting, *s)));
        self
    }

    /// Adds the mission's cases with what the controller does not know of: mass and inertia, the air's density, a wind that
    /// blows from t = 0, a release delay that is longer or shorter, measurements that are a period late. Judged by J_TPF.
    ///
    /// # Errors
    /// [`ModelError`] when a scattered vehicle cannot be.
    pub fn and_scattered(mut self, cases: &[ReleaseCase]) -> Result<Self, ModelError> {
        let setting = &self.setting;
        let mut scattered = Vec::new();
        for case in cases {
            let plain = nominal(setting, case.state());
            for (mass, inertia) in [(0.95, 1.0), (1.05, 1.0), (1.0, 0.8), (1.0, 1.2)] {
                let mut vehicle = (*setting.vehicle).clone();
                let of = &vehicle.mass;
                vehicle.mass = MassProperties::new(mass * of.mass_kg, inertia * of.inertia_kg_m2)?;
                scattered.push(Trial { vehicle: Arc::new(vehicle), ..plain.clone() });
            }
            for (density, wind) in [(0.9, 0.0), (1.1, 0.0), (1.0, 0.25), (1.0, -0.25)] {
                let mut environment = setting.environment.clone();
                environment.density_kg_m3 *= density;
                environment.wind_ned_m_s.x += wind * setting.target_v_ned.norm();
                scattered.push(Trial { environment, ..plain.clone() });
            }
            for delay_s in [-0.1, 0.1] {
                let mut late = plain.clone();
                late.start.v_ned.z += setting.environment.gravity_m_s2 * delay_s;
                scattered.push(late);
            }
            scattered.push(Trial { late: 1, ..plain });
        }
        self.trials.extend(scattered);
        Ok(self)
    }

    /// How many flights a candidate is judged by.
    pub fn flights(&self) -> usize {
        self.trials.len()
    }

    /// The worst of a candidate's flights.
    pub fn evaluate(&self, k: &Longitudinal) -> Evaluation {
        let mut worst = Evaluation::PERFECT;
        for i in 0..self.trials.len() {
            worst = worst.worse(self.fly(k, i));
            if !worst.is_finite() {
                return Evaluation::DIVERGED;
            }
        }
        worst
    }

    /// One flight of a candidate.
    pub fn fly(&self, k: &Longitudinal, flight: usize) -> Evaluation {
        let (setting, trial) = (&self.setting, &self.trials[flight]);
        let plan = setting.plan;
        let gains = Gains { k_ppsi: setting.yaw.k_ppsi, k_pr: setting.yaw.k_pr, ..Gains::longitudinal(*k) };
        let mut cascade = Cascade::new(setting.airframe.clone(), gains, setting.control_limits);
        let then_v_ned = trial.settles.then_some(setting.target_v_ned);
        let reference = Reference::Plan { trajectory: plan, then_v_ned, feed_forward: false };
        let duration_s = plan.end_s() + if trial.settles { setting.settle_s } else { 0.0 };
        let dt_s = control_period_s(plan);
        let mut sim = DropSimulation::at_t0(
            trial.vehicle.clone(),
            trial.environment.clone(),
            trial.start,
            setting.plant,
        );
        let mut tracking = TrackingError::new(plan);
        let mut result = Evaluation::PERFECT;
        let mut seen: VecDeque<BodyState> = VecDeque::with_capacity(trial.late + 1);
        let steps = (duration_s / dt_s).round() as u64;
        for step in 0..=steps {
            let t_s = step as f64 * dt_s;
            let body = sim.state().body;
            if tracking.observe_state(t_s, &body).is_break() {
                return Evaluation::DIVERGED;
            }
            result.j_tpf = result.j_tpf.max(StateCost::of(&body, &setting.safety).max());
            if trial.settles && t_s > duration_s - STEADY_FOR_S {
                let error = (body.v_ned - setting.target_v_ned).norm() / setting.target_v_ned.norm();
                result.unsteady = result.unsteady.max(error);
            }
            if seen.len() > trial.late {
                seen.pop_front();
            }
            seen.push_back(body);
            let known = seen.front().unwrap_or(&body);
            let m = Measurement {
                q_ned_from_body: known.q_ned_from_body,
                v_ned: known.v_ned,
                omega_body: known.omega_body,
            };
            let (v_sp, a_ff) = reference.at(t_s);
            sim.step(&cascade.track_velocity(&m, v_sp, a_ff, 0.0, dt_s).throttle, dt_s);
        }
        if trial.tracked {
            result.rms = tracking.rms();
        }
        result
    }
}

fn nominal(setting: &Setting<'_>, start: BodyState) -> Trial {
    Trial {
        start,
        vehicle: setting.vehicle.clone(),
        environment: setting.environment.clone(),
        late: 0,
        settles: false,
        tracked: false,
    }
}
