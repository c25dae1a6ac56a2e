//! The loops in their order and at their rates, as they run in lockstep with a simulator.
//!
//! With each IMU sample (250 Hz) the work queue `rate_ctrl` filters the gyroscope, runs the rate loop on
//! the rate setpoint of the sample before and sends the motors' commands. Meanwhile the estimator works on
//! the same sample, and after it, on `nav_and_controllers`, the attitude loop (on the attitude setpoint of
//! the sample before) and, every 10 ms (8 ms from v1.14 on), the velocity loop. So a velocity error reaches
//! the attitude setpoint at once, the rate setpoint one sample later and the motors after another; thrust
//! goes the same way, from loop to loop.
//!
//! The estimate is the state that is given. PX4 takes 9.80665 m/s^2 for gravity; where it is another, the
//! controller flies by Froude's scaling (`k`): velocities and rates reach it times k, its clock runs k times
//! slower.

use nalgebra::Vector3;

use super::Parameters;
use super::allocator::Allocator;
use super::attitude::{attitude_for, rates_for};
use super::battery::BatteryScale;
use super::filter::{LowPass1, LowPass2};
use super::law::Law;
use super::mixer::{self, Saturation};
use super::output;
use super::rate::RateLoop;
use super::reference::Reference;
use super::velocity::VelocityLoop;
use crate::control::{ControlOutput, Controller, Measurement, Setpoint};
use crate::frames::{LEVEL, Quaternion, yaw};
use crate::model::{MAX_ROTORS, Vehicle};

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
    law: Law,
    similarity: f64,
    thrust_limit_n: f64,
    hold_s: f64,
    time_s: f64,
    /// Time since the velocity loop was due [s].
    velocity_due_s: f64,
    velocity_run_s: Option<f64>,
    velocity: VelocityLoop,
    /// The attitude setpoint's model, where the law has one.
    reference: Reference,
    /// Time at which the newest attitude setpoint was made, and of the one that the reference has taken [s].
    attitude_asked_s: f64,
    attitude_taken_s: f64,
    rate: RateLoop,
    filters: Option<Filters>,
    battery: BatteryScale,
    motors: Motors,
    /// The state at the IMU sample before.
    before: Option<Measurement>,
    trace: Trace,
}

#[derive(Clone, Debug)]
struct Filters {
    rate: LowPass2,
    acceleration: AccelerationFilter,
    yaw_torque: Option<(LowPass1, Option<f64>)>,
    before: Option<Vector3<f64>>,
}

#[derive(Clone, Debug)]
enum AccelerationFilter {
    Once(LowPass1, Vector3<f64>),
    Twice(LowPass2),
}

impl AccelerationFilter {
    fn apply(&mut self, sample: Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Once(filter, filtered) => {
                *filtered = filtered.zip_map(&sample, |before, new| filter.apply(before, new));
                *filtered
            }
            Self::Twice(filter) => filter.apply(sample),
        }
    }
}

/// What gives torque and thrust to the motors.
#[derive(Clone, Debug)]
enum Motors {
    /// The mixer of a quadrotor in X, and what it could not do at the step before.
    QuadX(Saturation),
    /// Allocation from the rotors' geometry.
    Allocated(Box<Allocator>),
}

impl Motors {
    const QUAD_X: fn() -> Self = || Self::QuadX(mixer::saturation(&[-1.0; mixer::MOTORS]));

    fn saturation(&self) -> &Saturation {
        match self {
            Self::QuadX(saturation) => saturation,
            Self::Allocated(allocator) => allocator.saturation(),
        }
    }
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
            law: Law::V1_12,
            velocity: VelocityLoop::new(&parameters, hold_s),
            rate: RateLoop::default(),
            parameters,
            similarity,
            thrust_limit_n,
            hold_s,
            time_s: 0.0,
            velocity_due_s: 0.0,
            velocity_run_s: None,
            reference: Reference::default(),
            attitude_asked_s: 0.0,
            attitude_taken_s: 0.0,
            filters: None,
            battery: BatteryScale::default(),
            motors: Motors::QUAD_X(),
            before: None,
            trace: Trace {
                q_sp: LEVEL,
                thrust_sp: 0.0,
                rate_sp_body: Vector3::zeros(),
                rate_thrust_sp: 0.0,
                torque: Vector3::zeros(),
            },
        }
    }

    /// The controller with a version's law, for a vehicle in air of a density [kg/m^3]: where the law
    /// allocates, by the vehicle's rotors.
    pub fn with_law(mut self, law: Law, vehicle: &Vehicle, density_kg_m3: f64) -> Self {
        self.law = law;
        self.motors = if law.allocates {
            Motors::Allocated(Box::new(Allocator::new(vehicle, density_kg_m3)))
        } else {
            Motors::QUAD_X()
        };
        self
    }

    /// Takes over what PX4's rate loop held, its integral and its last yaw torque, and how long ago PX4 was
    /// asked for the last attitude [s].
    #[cfg(test)]
    pub(super) fn hold(&mut self, integral: Vector3<f64>, yaw_torque: f64, asked_before_s: f64) {
        self.attitude_asked_s = self.time_s - asked_before_s;
        self.attitude_taken_s = self.attitude_asked_s;
        self.rate = RateLoop::holding(integral);
        if let Some((_, filtered)) = self.filters.as_mut().and_then(|filters| filters.yaw_torque.as_mut()) {
            *filtered = Some(yaw_torque);
        }
    }

    /// Setpoints between the loops in the last step, in PX4's terms.
    pub fn trace(&self) -> &Trace {
        &self.trace
    }

    fn rate_control(&mut self, m: &Measurement, dt_s: f64) -> [f64; MAX_ROTORS] {
        let (p, law) = (&self.parameters, &self.law);
        let omega = m.omega_body * self.similarity;
        let filters = self.filters.get_or_insert_with(|| Filters {
            rate: LowPass2::new(1.0 / dt_s, p.gyro_cutoff_hz),
            acceleration: if law.smooths_acceleration_once {
                AccelerationFilter::Once(LowPass1::new(1.0 / dt_s, p.dgyro_cutoff_hz), Vector3::zeros())
            } else {
                AccelerationFilter::Twice(LowPass2::new(1.0 / dt_s, p.dgyro_cutoff_hz))
            },
            yaw_torque: law.filters_yaw_torque.then(|| (LowPass1::new(1.0 / dt_s, p.yaw_tq_cutoff_hz), None)),
            before: None,
        });
        let rate = filters.rate.apply(omega);
        let change = (rate - filters.before.replace(rate).unwrap_or(rate)) / dt_s;
        let acceleration = filters.acceleration.apply(change);
        let sp = self.trace.rate_sp_body;
        let mut torque = self.rate.step(p, &rate, &acceleration, &sp, self.motors.saturation(), dt_s);
        if let Some((filter, filtered)) = &mut filters.yaw_torque {
            torque.z = filter.apply(filtered.unwrap_or(torque.z), torque.z);
            *filtered = Some(torque.z);
        }
        let mut thrust = self.trace.rate_thrust_sp;
        if let (true, Some(bus_v)) = (p.bat_scale_en != 0.0, m.bus_v) {
            let scale = self.battery.step(p, law, bus_v, m.pack_a, dt_s);
            (torque, thrust) = (torque * scale, thrust * scale);
            if law.allocates {
                (torque, thrust) = (torque.map(|x| x.clamp(-1.0, 1.0)), thrust.clamp(-1.0, 1.0));
            }
            self.battery.note_throttle(thrust);
        }
        self.trace.torque = torque;
        match &mut self.motors {
            Motors::QuadX(saturation) => {
                let signals = output::signals(p, mixer::mix(&torque, thrust));
                *saturation = mixer::saturation(&signals);
                let mut commands = [0.0; MAX_ROTORS];
                commands[..mixer::MOTORS].copy_from_slice(&output::commands(law, signals, self.time_s));
                commands
            }
            Motors::Allocated(allocator) => {
                let signals = output::signals(p, allocator.allocate(&torque, thrust, dt_s));
                output::commands(law, signals, self.time_s)
            }
        }
    }

    fn attitude_control(&mut self, q: Quaternion) -> Vector3<f64> {
        let (p, q_sp) = (&self.parameters, self.trace.q_sp);
        if !self.law.follows_a_reference {
            return rates_for(p, q, q_sp, Vector3::zeros());
        }
        if self.attitude_asked_s > self.attitude_taken_s {
            self.reference.take(p, q_sp, self.attitude_asked_s - self.attitude_taken_s);
            self.attitude_taken_s = self.attitude_asked_s;
        }
        rates_for(p, q, self.reference.attitude().unwrap_or(q_sp), self.reference.fed_forward(p, q))
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
                let thrust_ned = self.velocity.step(&self.parameters, &self.law, v_ned, v_sp, a_ff, dt_s);
                let heading = yaw_rad.unwrap_or_else(|| yaw(m.q_ned_from_body));
                self.trace.q_sp = attitude_for(thrust_ned, heading);
                self.trace.thrust_sp = thrust_ned.norm();
                self.attitude_asked_s = self.time_s;
            }
        }
    }
}

impl Controller for Px4Controller {
    /// Back to being armed just now, after the HOLD that it was built with.
    fn reset(&mut self) {
        let Self { law, similarity, thrust_limit_n, hold_s, .. } = *self;
        let motors = match &self.motors {
            Motors::QuadX(_) => Motors::QUAD_X(),
            Motors::Allocated(allocator) => Motors::Allocated(Box::new(allocator.as_ref().clone().at_rest())),
        };
        let fresh = Self::held_for(self.parameters.clone(), similarity, thrust_limit_n, hold_s);
        *self = Self { law, motors, ..fresh };
    }

    /// One IMU sample, `dt_s` [s] of the vehicle's time after the last one.
    fn step(&mut self, m: &Measurement, setpoint: &Setpoint, dt_s: f64) -> ControlOutput {
        let k = self.similarity;
        let dt_s = dt_s / k;
        self.time_s += dt_s;
        let commands = self.rate_control(m, dt_s);
        let before = self.before.replace(*m);
        let m = &before.filter(|_| self.law.estimates_the_sample_before).unwrap_or(*m);
        if let Setpoint::Rates { omega_body, collective } = *setpoint {
            self.trace.rate_sp_body = omega_body * k;
            self.trace.rate_thrust_sp = collective;
        } else {
            self.trace.rate_sp_body = self.attitude_control(m.q_ned_from_body);
            self.trace.rate_thrust_sp = self.trace.thrust_sp;
        }
        self.velocity_due_s += dt_s;
        let period_s = self.law.velocity_period_s;
        if self.velocity_due_s >= period_s - 0.5 * dt_s - 1e-9 {
            self.velocity_due_s -= period_s;
            let since = self.velocity_run_s.map_or(period_s, |t| self.time_s - t);
            self.velocity_run_s = Some(self.time_s);
            self.velocity_control(m, setpoint, since);
        }
        if let Setpoint::Attitude { q_ned_from_body, collective } = *setpoint {
            self.trace.q_sp = q_ned_from_body;
            self.trace.thrust_sp = collective;
            self.attitude_asked_s = self.time_s;
        }
        ControlOutput {
            q_sp: self.trace.q_sp,
            rate_sp_body: self.trace.rate_sp_body / k,
            ..ControlOutput::from_throttles(commands, self.thrust_limit_n)
        }
    }
}
