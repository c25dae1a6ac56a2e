//! A whole flight, controller and vehicle, without MAVLink frames: what tuning and campaigns fly, and what a drop over
//! MAVLink is compared with.
//!
//! Until the rotors are free the commands are zero. Then the cascade, its integrals at zero, follows the reference, once per
//! control period, on the true state and without delay; a setpoint period longer than that holds the setpoint as a stream
//! of messages does.

use std::ops::ControlFlow;

use nalgebra::Vector3;

use super::drop::{DropSimulation, Phase};
use super::record::Sample;
use crate::control::{Cascade, Measurement};
use crate::model::MAX_ROTORS;
use crate::trajectory::Trajectory;

/// What the flight shall follow, from t = 0.
#[derive(Clone, Copy, Debug)]
pub enum Reference<'a> {
    /// A velocity at once, NED [m/s].
    Step(Vector3<f64>),
    /// The velocity of a plan.
    Plan {
        /// The plan.
        trajectory: &'a Trajectory,
        /// The velocity from the plan's end on, NED [m/s]; `None` holds its last node.
        then_v_ned: Option<Vector3<f64>>,
        /// Whether the plan's acceleration is fed forward.
        feed_forward: bool,
    },
}

impl Reference<'_> {
    /// Velocity [m/s] and fed-forward acceleration [m/s^2], NED, at `t_s` from the start of powered flight.
    pub fn at(&self, t_s: f64) -> (Vector3<f64>, Vector3<f64>) {
        match *self {
            Self::Step(v_ned) => (v_ned, Vector3::zeros()),
            Self::Plan { trajectory, then_v_ned, feed_forward } => {
                if let Some(v_ned) = then_v_ned
                    && t_s > trajectory.end_s() - 1e-9
                {
                    return (v_ned, Vector3::zeros());
                }
                let a_ned = if feed_forward { trajectory.acceleration_ned(t_s) } else { Vector3::zeros() };
                (trajectory.velocity_ned(t_s), a_ned)
            }
        }
    }
}

/// How a flight is flown.
#[derive(Clone, Copy, Debug)]
pub struct FlightPlan<'a> {
    /// What to follow.
    pub reference: Reference<'a>,
    /// Heading to hold [rad].
    pub yaw_sp_rad: f64,
    /// Control period and step of the simulation [s].
    pub control_period_s: f64,
    /// Period of the setpoints [s], held in between; `None`: a fresh one at each control step.
    pub setpoint_period_s: Option<f64>,
    /// Length of the flight, from the present time of the simulation [s].
    pub duration_s: f64,
}

impl FlightPlan<'_> {
    /// How many control periods the flight has.
    pub fn steps(&self) -> u64 {
        // `as u64` saturates: NaN and negatives give 0.
        (self.duration_s / self.control_period_s).round() as u64
    }

    /// Velocity [m/s] and fed-forward acceleration [m/s^2], NED, in force at `t_s` from the start of powered flight.
    pub fn setpoint_at(&self, t_s: f64) -> (Vector3<f64>, Vector3<f64>) {
        self.reference.at(setpoint_time(t_s, self.setpoint_period_s))
    }
}

/// Flies: `observe` gets the state at each control step with the command computed there, and the final state with the last
/// command; it may break the flight off. Returns whether it did.
pub fn fly(
    sim: &mut DropSimulation,
    cascade: &mut Cascade,
    plan: &FlightPlan<'_>,
    observe: &mut impl FnMut(&Sample) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let dt = plan.control_period_s;
    let mut throttle = [0.0; MAX_ROTORS];
    cascade.reset();
    for _ in 0..plan.steps() {
        let mut v_sp_ned = None;
        if let (Phase::Powered, Some(t)) = (sim.phase(), sim.time_powered_s()) {
            let (v_sp, a_ff) = plan.setpoint_at(t);
            let body = &sim.state().body;
            let m = Measurement {
                q_ned_from_body: body.q_ned_from_body,
                v_ned: body.v_ned,
                omega_body: body.omega_body,
            };
            throttle = cascade.track_velocity(&m, v_sp, a_ff, plan.yaw_sp_rad, dt).throttle;
            v_sp_ned = Some(v_sp);
        }
        let before = sim.moment();
        let instant = sim.advance(&throttle, dt);
        observe(&before.sample(instant, &throttle, v_sp_ned))?;
    }
    let v_sp_ned = match (sim.phase(), sim.time_powered_s()) {
        (Phase::Powered, Some(t)) => Some(plan.setpoint_at(t).0),
        _ => None,
    };
    observe(&sim.sample(&throttle, v_sp_ned))
}

/// Time of the setpoint in force at `t_s`.
fn setpoint_time(t_s: f64, period_s: Option<f64>) -> f64 {
    match period_s {
        Some(period) if period > 0.0 => (t_s / period + 1e-6).floor() * period,
        _ => t_s,
    }
}
