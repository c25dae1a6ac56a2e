//! The loops in their order and at their rates, as they run in lockstep with a simulator.
//!
//! With each IMU sample (250 Hz) the work queue `rate_ctrl` filters the gyroscope, runs the rate loop on the
//! rate setpoint of the sample before and sends the motors' commands. Meanwhile the estimator works on the
//! same sample, and after it, on `nav_and_controllers`, the attitude loop (on the attitude setpoint of the
//! sample before) and, every 10 ms, the velocity loop. So a velocity error reaches the attitude setpoint at
//! once, the rate setpoint one sample later and the motors after another; thrust goes the same way, from loop
//! to loop.
//!
//! The estimate is the state that is given. PX4 takes 9.80665 m/s^2 for gravity; where it is another, the
//! controller flies by Froude's scaling (`k`): velocities and rates reach it times k, its clock runs k times
//! slower.

use nalgebra::Vector3;

use super::Parameters;
use super::attitude::{attitude_for, rates_for};
use super::filter::LowPass2;
use super::mixer::{self, MOTORS, Saturation};
use super::output;
use super::rate::RateLoop;
use super::velocity::VelocityLoop;
use crate::control::{ControlOutput, Controller, Measurement, Setpoint};
use crate::frames::{LEVEL, Quaternion, yaw};
use crate::model::MAX_ROTORS;

/// Period of the estimator and the velocity loop, in PX4's time [s].
pub const VELOCITY_PERIOD_S: f64 = 0.01;

/// Setpoints between the loops at an instant, as PX4's topics of these names hold them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trace {
    /// Attitude setpoint, body to NED.
    pub q_sp: Quaternion,
    /// Thrust setpoint that goes with it, 0..1.
    pub thrust_sp: f64,
    /// Rate setpoint [rad/s].
    pub rate_sp_body: Vector3<f64>,
    /// Thrust setpoint that goes with the rates: the attitude loop hands it on, a sample later.
    pub rate_thrust_sp: f64,
    /// Normalised torque.
    pub torque: Vector3<f64>,
}

/// The model of PX4's controller with its state.
#[derive(Clone, Debug)]
pub struct Px4Controller {
    parameters: Parameters,
    similarity: f64,
    thrust_limit_n: f64,
    hold_s: f64,
    time_s: f64,
    /// Time since the velocity loop was due [s].
    velocity_due_s: f64,
    velocity_run_s: Option<f64>,
    velocity: VelocityLoop,
    rate: RateLoop,
    filters: Option<Filters>,
    saturation: Saturation,
    trace: Trace,
}

#[derive(Clone, Debug)]
struct Filters {
    rate: LowPass2,
    acceleration: LowPass2,
    before: Option<Vector3<f64>>,
}

impl Px4Controller {
    /// The controller at rest, armed now, after a HOLD in which its tilt limit has come up. `similarity` is
    /// Froude's k = sqrt(g0/g), 1 on Earth; `thrust_limit_n` the thrust of a rotor at full throttle in still
    /// air [N], by which motor commands are reported as thrusts.
    pub fn new(parameters: Parameters, similarity: f64, thrust_limit_n: f64) -> Self {
        Self::held_for(parameters, similarity, thrust_limit_n, f64::INFINITY)
    }

    /// As [`Self::new`], after `hold_s` in HOLD [s].
    pub fn held_for(parameters: Parameters, similarity: f64, thrust_limit_n: f64, hold_s: f64) -> Self {
        Self {
            velocity: VelocityLoop::new(&parameters, hold_s),
            rate: RateLoop::default(),
            parameters,
            similarity,
            thrust_limit_n,
            hold_s,
            time_s: 0.0,
            velocity_due_s: 0.0,
            velocity_run_s: None,
            filters: None,
            saturation: mixer::saturation(&[-1.0; MOTORS]),
            trace: Trace {
                q_sp: LEVEL,
                thrust_sp: 0.0,
                rate_sp_body: Vector3::zeros(),
                rate_thrust_sp: 0.0,
                torque: Vector3::zeros(),
            },
        }
    }

    /// Setpoints between the loops in the last step, in PX4's terms.
    pub fn trace(&self) -> &Trace {
        &self.trace
    }

    fn rate_control(&mut self, omega: Vector3<f64>, dt_s: f64) -> [f64; MOTORS] {
        let p = &self.parameters;
        let filters = self.filters.get_or_insert_with(|| Filters {
            rate: LowPass2::new(1.0 / dt_s, p.gyro_cutoff_hz),
            acceleration: LowPass2::new(1.0 / dt_s, p.dgyro_cutoff_hz),
            before: None,
        });
        let rate = filters.rate.apply(omega);
        let change = (rate - filters.before.replace(rate).unwrap_or(rate)) / dt_s;
        let acceleration = filters.acceleration.apply(change);
        let sp = self.trace.rate_sp_body;
        self.trace.torque = self.rate.step(p, &rate, &acceleration, &sp, &self.saturation, dt_s);
        let thrust = mixer::mix(&self.trace.torque, self.trace.rate_thrust_sp);
        let (commands, saturation) = output::commands(p, thrust, self.time_s);
        self.saturation = saturation;
        commands
    }

    fn velocity_control(&mut self, m: &Measurement, setpoint: &Setpoint, dt_s: f64) {
        let k = self.similarity;
        let v_ned = m.v_ned * k;
        match *setpoint {
            Setpoint::Attitude { .. } | Setpoint::Rates { .. } => {
                self.velocity.watch(&self.parameters, v_ned, dt_s);
            }
            Setpoint::Velocity { v_ned: v_sp_ned, a_ff_ned, yaw_rad } => {
                let (v_sp, a_ff) = (v_sp_ned * k, a_ff_ned * (k * k));
                let thrust_ned = self.velocity.step(&self.parameters, v_ned, v_sp, a_ff, dt_s);
                let heading = yaw_rad.unwrap_or_else(|| yaw(m.q_ned_from_body));
                self.trace.q_sp = attitude_for(thrust_ned, heading);
                self.trace.thrust_sp = thrust_ned.norm();
            }
        }
    }
}

impl Controller for Px4Controller {
    /// Back to being armed just now, after the HOLD that it was built with.
    fn reset(&mut self) {
        let Self { similarity, thrust_limit_n, hold_s, .. } = *self;
        *self = Self::held_for(self.parameters.clone(), similarity, thrust_limit_n, hold_s);
    }

    /// One IMU sample, `dt_s` [s] of the vehicle's time after the last one.
    fn step(&mut self, m: &Measurement, setpoint: &Setpoint, dt_s: f64) -> ControlOutput {
        let k = self.similarity;
        let dt_s = dt_s / k;
        self.time_s += dt_s;
        let omega = m.omega_body * k;
        let commands = self.rate_control(omega, dt_s);
        if let Setpoint::Rates { omega_body, collective } = *setpoint {
            self.trace.rate_sp_body = omega_body * k;
            self.trace.rate_thrust_sp = collective;
        } else {
            let yaw_rate = 0.0;
            let q_sp = self.trace.q_sp;
            self.trace.rate_sp_body = rates_for(&self.parameters, m.q_ned_from_body, q_sp, yaw_rate);
            self.trace.rate_thrust_sp = self.trace.thrust_sp;
        }
        self.velocity_due_s += dt_s;
        if self.velocity_due_s >= VELOCITY_PERIOD_S - 0.5 * dt_s - 1e-9 {
            self.velocity_due_s -= VELOCITY_PERIOD_S;
            let since = self.velocity_run_s.map_or(VELOCITY_PERIOD_S, |t| self.time_s - t);
            self.velocity_run_s = Some(self.time_s);
            self.velocity_control(m, setpoint, since);
        }
        if let Setpoint::Attitude { q_ned_from_body, collective } = *setpoint {
            self.trace.q_sp = q_ned_from_body;
            self.trace.thrust_sp = collective;
        }
        let mut throttle = [0.0; MAX_ROTORS];
        throttle[..MOTORS].copy_from_slice(&commands);
        ControlOutput {
            q_sp: self.trace.q_sp,
            rate_sp_body: self.trace.rate_sp_body / k,
            ..ControlOutput::from_throttles(throttle, self.thrust_limit_n)
        }
    }
}
