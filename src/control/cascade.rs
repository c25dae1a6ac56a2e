//! The cascade: velocity, attitude, rate, mixer in a row, entered at any of the first three.
//!
//! What a step may rely on and what it guarantees: the state is the current one (no delay); integrals start from zero
//! at [`Cascade::reset`] and are used before their update; every thrust lies in `[0, T_lim]`. An input that is not
//! finite (or beyond any physical size) is replaced by the last finite one of its kind, and such a measurement leaves the integrals and the
//! outputs where they were, so that one broken message neither stops the motors nor stays in memory. Nothing allocates.

use nalgebra::Vector3;

use super::attitude::rate_setpoint;
use super::rate::RateLoop;
use super::velocity::{VelocityLoop, VelocitySetpoint};
use super::{Airframe, ControlLimits, Gains};
use crate::frames::{LEVEL, Quaternion, quaternion_from_euler};
use crate::model::{MAX_ROTORS, PerRotor};

/// What the cascade is told of the vehicle's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Attitude, body to NED.
    pub q_ned_from_body: Quaternion,
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Body rates [rad/s].
    pub omega_body: Vector3<f64>,
}

/// What a step commands, and the setpoints in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlOutput {
    /// Thrust of each rotor [N].
    pub thrust_n: PerRotor,
    /// Throttle of each rotor, `sqrt(T/T_static)`, 0..1.
    pub throttle: PerRotor,
    /// Acceleration after all limits, NED [m/s^2]; gravity is not part of it. Zero below the velocity loop.
    pub acceleration_sp_ned: Vector3<f64>,
    /// Wanted attitude, body to NED.
    pub q_sp: Quaternion,
    /// Wanted body rates [rad/s].
    pub rate_sp_body: Vector3<f64>,
    /// Collective before the mixer, along the body's up axis [N].
    pub collective_n: f64,
}

impl ControlOutput {
    /// Motors off, level.
    pub const ZERO: Self = Self {
        thrust_n: [0.0; MAX_ROTORS],
        throttle: [0.0; MAX_ROTORS],
        acceleration_sp_ned: Vector3::new(0.0, 0.0, 0.0),
        q_sp: LEVEL,
        rate_sp_body: Vector3::new(0.0, 0.0, 0.0),
        collective_n: 0.0,
    };
}

/// The controller with its state.
#[derive(Clone, Debug)]
pub struct Cascade {
    airframe: Airframe,
    gains: Gains,
    limits: ControlLimits,
    velocity: VelocityLoop,
    rate: RateLoop,
    held: Held,
    output: ControlOutput,
}

/// The last finite input of each kind.
#[derive(Clone, Copy, Debug)]
struct Held {
    v_sp_ned: Option<Vector3<f64>>,
    yaw_sp_rad: f64,
    q_sp: Quaternion,
    collective: f64,
    rate_sp: Vector3<f64>,
}

impl Held {
    const NOTHING: Self = Self {
        v_sp_ned: None,
        yaw_sp_rad: 0.0,
        q_sp: LEVEL,
        collective: 0.0,
        rate_sp: Vector3::new(0.0, 0.0, 0.0),
    };
}

/// Beyond this size no angle, speed or rate means anything; products of such numbers stay finite.
const LARGEST_INPUT: f64 = 1e9;

fn finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.abs() <= LARGEST_INPUT)
}

impl Measurement {
    fn is_finite(&self) -> bool {
        finite(&self.q_ned_from_body) && finite(self.v_ned.as_slice()) && finite(self.omega_body.as_slice())
    }
}

impl Cascade {
    /// A controller at rest, integrals zero.
    pub fn new(airframe: Airframe, gains: Gains, limits: ControlLimits) -> Self {
        Self {
            airframe,
            gains,
            limits,
            velocity: VelocityLoop::default(),
            rate: RateLoop::default(),
            held: Held::NOTHING,
            output: ControlOutput::ZERO,
        }
    }

    /// Integrals to zero, held inputs forgotten.
    pub fn reset(&mut self) {
        self.velocity = VelocityLoop::default();
        self.rate = RateLoop::default();
        self.held = Held::NOTHING;
        self.output = ControlOutput::ZERO;
    }

    /// Replaces the gains; the integrals stay.
    pub fn set_gains(&mut self, gains: Gains) {
        self.gains = gains;
    }

    /// Replaces the limits; the integrals stay.
    pub fn set_limits(&mut self, limits: ControlLimits) {
        self.limits = limits;
    }

    /// Replaces the mass [kg] that the control law believes in: the collective for a wanted acceleration scales with it.
    pub fn set_mass_kg(&mut self, mass_kg: f64) {
        self.airframe.mass_kg = mass_kg;
    }

    /// The gains in use.
    pub fn gains(&self) -> &Gains {
        &self.gains
    }

    /// The limits in use.
    pub fn limits(&self) -> &ControlLimits {
        &self.limits
    }

    /// What the control law knows of the vehicle.
    pub fn airframe(&self) -> &Airframe {
        &self.airframe
    }

    /// The integrals of the velocity loop, NED [m/s^2].
    pub fn velocity_integral_ned(&self) -> Vector3<f64> {
        self.velocity.integral_ned()
    }

    /// The integrals of the roll and pitch rate loop [rad/s^2].
    pub fn rate_integral(&self) -> [f64; 2] {
        self.rate.integral()
    }

    /// What the last step commanded.
    pub fn output(&self) -> &ControlOutput {
        &self.output
    }

    /// One step of the whole cascade: velocity setpoint [m/s] and acceleration feed-forward [m/s^2] in NED, heading
    /// [rad], control period [s].
    pub fn track_velocity(
        &mut self,
        m: &Measurement,
        v_sp_ned: Vector3<f64>,
        a_ff_ned: Vector3<f64>,
        yaw_sp_rad: f64,
        dt_s: f64,
    ) -> ControlOutput {
        if finite(v_sp_ned.as_slice()) {
            self.held.v_sp_ned = Some(v_sp_ned);
        }
        if finite(&[yaw_sp_rad]) {
            self.held.yaw_sp_rad = yaw_sp_rad;
        }
        if !m.is_finite() {
            return self.output;
        }
        let setpoint = VelocitySetpoint {
            // With no finite setpoint yet: keep the velocity that there is.
            v_ned: self.held.v_sp_ned.unwrap_or(m.v_ned),
            a_ff_ned: if finite(a_ff_ned.as_slice()) { a_ff_ned } else { Vector3::zeros() },
        };
        let dt_s = usable_period(dt_s);
        let tilt = self.limits.tilt_rad;
        let wanted = self.velocity.step(&self.airframe, &self.gains, tilt, &m.v_ned, &setpoint, dt_s);
        let yaw = self.held.yaw_sp_rad;
        let (roll, pitch) = wanted.roll_pitch(yaw);
        self.output.acceleration_sp_ned = wanted.acceleration_sp_ned;
        self.output.collective_n = self.airframe.mass_kg * wanted.up_m_s2;
        self.attitude_step(m, quaternion_from_euler(roll, pitch, yaw), dt_s);
        self.output
    }

    /// One step of attitude, rate and mixer. `collective` is the fraction 0..1 of all rotors' largest thrust; exactly
    /// zero stops all motors, as in PX4, and leaves the integrals alone.
    pub fn hold_attitude(
        &mut self,
        m: &Measurement,
        q_sp_ned_from_body: Quaternion,
        collective: f64,
        dt_s: f64,
    ) -> ControlOutput {
        if finite(&q_sp_ned_from_body) && q_sp_ned_from_body.iter().any(|&c| c != 0.0) {
            self.held.q_sp = q_sp_ned_from_body;
        }
        if !self.take_collective(m, collective) {
            return self.output;
        }
        self.attitude_step(m, self.held.q_sp, usable_period(dt_s));
        self.output
    }

    /// One step of rate loop and mixer: body rates [rad/s], collective as in [`Self::hold_attitude`].
    pub fn hold_rates(
        &mut self,
        m: &Measurement,
        rate_sp_body: Vector3<f64>,
        collective: f64,
        dt_s: f64,
    ) -> ControlOutput {
        if finite(rate_sp_body.as_slice()) {
            self.held.rate_sp = rate_sp_body;
        }
        if !self.take_collective(m, collective) {
            return self.output;
        }
        self.output.q_sp = m.q_ned_from_body;
        let (rate, yaw) = (self.limits.rate_command_rad_s, self.limits.yaw_rate_command_rad_s);
        let bound = Vector3::new(rate, rate, yaw);
        self.output.rate_sp_body = self.held.rate_sp.zip_map(&bound, |x, b| x.min(b).max(-b));
        self.rate_step(m, usable_period(dt_s));
        self.output
    }

    /// Takes over the collective; false when there is nothing more to do in this step.
    fn take_collective(&mut self, m: &Measurement, collective: f64) -> bool {
        if collective.is_finite() {
            self.held.collective = collective.clamp(0.0, 1.0);
        }
        if self.held.collective == 0.0 {
            self.output = ControlOutput { q_sp: self.held.q_sp, ..ControlOutput::ZERO };
            return false;
        }
        if !m.is_finite() {
            return false;
        }
        self.output.acceleration_sp_ned = Vector3::zeros();
        self.output.collective_n = self.held.collective * self.airframe.lift_max_n;
        true
    }

    fn attitude_step(&mut self, m: &Measurement, q_sp: Quaternion, dt_s: f64) {
        self.output.q_sp = q_sp;
        self.output.rate_sp_body = rate_setpoint(&self.gains, &self.limits, m.q_ned_from_body, q_sp);
        self.rate_step(m, dt_s);
    }

    fn rate_step(&mut self, m: &Measurement, dt_s: f64) {
        let out = &mut self.output;
        let angular = self.rate.step(&self.gains, &self.limits, &m.omega_body, &out.rate_sp_body, dt_s);
        let moment = self.airframe.inertia_kg_m2 * angular;
        out.thrust_n = self.airframe.mixer.thrusts(out.collective_n, &moment);
        let limit = self.airframe.mixer.thrust_limit_n();
        out.throttle = out.thrust_n.map(|t| (t / limit).sqrt());
    }
}

/// A control period that is not a positive number integrates nothing.
fn usable_period(dt_s: f64) -> f64 {
    if dt_s.is_finite() && dt_s > 0.0 { dt_s } else { 0.0 }
}
