//! The loops of the cascade in a row, over any [`Real`]: of one flight ([`super::Cascade`]), and of flights
//! side by side.

use super::ControlSettings;
use super::attitude::rate_setpoint;
use super::rate::RateLoop;
use super::velocity::{VelocityLoop, VelocitySetpoint};
use crate::frames::{Quaternion, quaternion_from_euler};
use crate::model::MAX_ROTORS;
use crate::model::rigid_body::Motion;
use crate::real::Real;
use crate::vector::V3;

/// States of velocity and rate loop.
#[derive(Clone, Copy, Debug)]
pub struct Loops<S> {
    /// The velocity loop.
    pub velocity: VelocityLoop<S>,
    /// The rate loop.
    pub rate: RateLoop<S>,
}

/// What the loops demand, from the acceleration down to the throttles: a
/// [`ControlOutput`](super::ControlOutput) over any [`Real`].
#[derive(Clone, Copy, Debug)]
pub struct Demand<S> {
    /// Acceleration after all limits, NED [m/s^2]; zero where none is asked for.
    pub acceleration_sp_ned: V3<S>,
    /// Thrust of all rotors [N].
    pub collective_n: S,
    /// Attitude, body to NED.
    pub q_sp: Quaternion<S>,
    /// Body rates [rad/s].
    pub rate_sp_body: V3<S>,
    /// Thrust of each rotor [N].
    pub thrust_n: [S; MAX_ROTORS],
    /// Throttle of each rotor, 0..1.
    pub throttle: [S; MAX_ROTORS],
}

impl<S: Real> Loops<S> {
    /// The loops at their beginning, for numbers of a kind of which one is given.
    pub fn new(kind: S) -> Self {
        Self { velocity: VelocityLoop::new(kind), rate: RateLoop::new(kind) }
    }

    /// One step of all loops, of a body in this motion, to a velocity at a heading [rad].
    #[inline(always)]
    pub fn track(
        &mut self,
        settings: &ControlSettings,
        motion: &Motion<S>,
        setpoint: &VelocitySetpoint<S>,
        yaw_rad: S,
        dt_s: f64,
    ) -> Demand<S> {
        let ControlSettings { airframe, gains, limits } = settings;
        let wanted = self.velocity.step(airframe, gains, limits.tilt_rad, motion.v_ned, setpoint, dt_s);
        let (roll, pitch) = wanted.roll_pitch(yaw_rad);
        let collective_n = wanted.up_m_s2 * airframe.mass_kg;
        let q_sp = quaternion_from_euler(roll, pitch, yaw_rad);
        let demand = self.turn(settings, motion, q_sp, collective_n, dt_s);
        Demand { acceleration_sp_ned: wanted.acceleration_sp_ned, ..demand }
    }

    /// One step of attitude and rate loop and mixer, to an attitude under a collective [N].
    #[inline(always)]
    pub fn turn(
        &mut self,
        settings: &ControlSettings,
        motion: &Motion<S>,
        q_sp: Quaternion<S>,
        collective_n: S,
        dt_s: f64,
    ) -> Demand<S> {
        let rate_sp = rate_setpoint(&settings.gains, &settings.limits, motion.q_ned_from_body, q_sp);
        Demand { q_sp, ..self.spin(settings, motion, rate_sp, collective_n, dt_s) }
    }

    /// One step of rate loop and mixer, to body rates [rad/s] under a collective [N].
    #[inline(always)]
    pub fn spin(
        &mut self,
        settings: &ControlSettings,
        motion: &Motion<S>,
        rate_sp_body: V3<S>,
        collective_n: S,
        dt_s: f64,
    ) -> Demand<S> {
        let ControlSettings { airframe, gains, limits } = settings;
        let angular = self.rate.step(gains, limits, motion.omega_body, rate_sp_body, dt_s);
        let thrust_n = airframe.mixer.thrusts(collective_n, angular.times(&airframe.inertia_kg_m2));
        let limit = collective_n.of(airframe.mixer.thrust_limit_n());
        let mut throttle = [limit; MAX_ROTORS];
        for (throttle, thrust_n) in throttle.iter_mut().zip(thrust_n) {
            *throttle = (thrust_n / limit).sqrt();
        }
        let acceleration_sp_ned = V3::zero(limit);
        let q_sp = motion.q_ned_from_body;
        Demand { acceleration_sp_ned, collective_n, q_sp, rate_sp_body, thrust_n, throttle }
    }
}
