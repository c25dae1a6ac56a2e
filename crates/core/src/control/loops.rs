//! The loops of the cascade in a row, over any [`Real`]: of one flight ([`super::Cascade`]), and of flights
//! side by side.

use super::ControlSettings;
use super::attitude::rate_setpoint;
use super::rate::RateLoop;
use super::velocity::{VelocityLoop, VelocitySetpoint};
use crate::frames::{Quaternion, quaternion_from_euler};
use crate::model::MAX_ROTORS;
use crate::model::rigid_body::Motion;
use crate::real::{Mask as _, Real};
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

    /// One step of all loops, of a body in this motion on a bus of this voltage [V] where it is measured, to
    /// a velocity at a heading [rad].
    #[inline(always)]
    pub fn track(
        &mut self,
        settings: &ControlSettings,
        (motion, bus_v): (&Motion<S>, Option<S>),
        setpoint: &VelocitySetpoint<S>,
        yaw_rad: S,
        dt_s: f64,
    ) -> Demand<S> {
        let ControlSettings { airframe, gains, limits } = settings;
        let wanted = self.velocity.step(airframe, gains, limits, motion.v_ned, setpoint, dt_s);
        let (roll, pitch) = wanted.roll_pitch(yaw_rad);
        let collective_n = wanted.collective_m_s2 * airframe.mass_kg;
        let q_sp = quaternion_from_euler(roll, pitch, yaw_rad);
        let demand = self.turn(settings, (motion, bus_v), q_sp, collective_n, dt_s);
        Demand { acceleration_sp_ned: wanted.acceleration_sp_ned, ..demand }
    }

    /// One step of attitude and rate loop and mixer, to an attitude under a collective [N].
    #[inline(always)]
    pub fn turn(
        &mut self,
        settings: &ControlSettings,
        (motion, bus_v): (&Motion<S>, Option<S>),
        q_sp: Quaternion<S>,
        collective_n: S,
        dt_s: f64,
    ) -> Demand<S> {
        let rate_sp = rate_setpoint(&settings.gains, &settings.limits, motion.q_ned_from_body, q_sp);
        Demand { q_sp, ..self.spin(settings, (motion, bus_v), rate_sp, collective_n, dt_s) }
    }

    /// One step of rate loop and mixer, to body rates [rad/s] under a collective [N]. What the bus makes of a
    /// throttle is mixed, so that where the voltage is low it is the collective that gives way, not a moment.
    #[inline(always)]
    pub fn spin(
        &mut self,
        settings: &ControlSettings,
        (motion, bus_v): (&Motion<S>, Option<S>),
        rate_sp_body: V3<S>,
        collective_n: S,
        dt_s: f64,
    ) -> Demand<S> {
        let ControlSettings { airframe, gains, limits } = settings;
        let angular = self.rate.step(gains, limits, motion.omega_body, rate_sp_body, dt_s);
        let per_newton = limits.nominal_per_newton(bus_v, collective_n);
        let moment = angular.times(&airframe.inertia_kg_m2) * per_newton;
        let mut thrust_n = airframe.mixer.thrusts_of(collective_n * per_newton, moment);
        let zero = collective_n.of(0.0);
        let mut throttle = [zero; MAX_ROTORS];
        for (throttle, thrust_n) in throttle.iter_mut().zip(&mut thrust_n) {
            *throttle = airframe.mixer.throttle_of(*thrust_n);
            *thrust_n = *thrust_n / per_newton;
        }
        let acceleration_sp_ned = V3::zero(zero);
        let q_sp = motion.q_ned_from_body;
        Demand { acceleration_sp_ned, collective_n, q_sp, rate_sp_body, thrust_n, throttle }
    }
}

/// Beyond this size no angle, speed or rate means anything; products of such numbers stay finite.
pub(crate) const LARGEST_INPUT: f64 = 1e9;

/// Whether all are of a physical size.
pub(crate) fn finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.abs() <= LARGEST_INPUT)
}

/// Cascades of flights side by side from their reset on, each of which does what
/// [`Cascade`](super::Cascade) does under velocity setpoints.
#[derive(Clone, Debug)]
pub struct Cascades<S: Real> {
    settings: ControlSettings,
    loops: Loops<S>,
    throttle: [S; MAX_ROTORS],
}

impl<S: Real> Cascades<S> {
    /// Cascades at their beginning, for numbers of a kind of which one is given.
    pub fn new(settings: ControlSettings, kind: S) -> Self {
        Self { settings, loops: Loops::new(kind), throttle: [kind.of(0.0); MAX_ROTORS] }
    }

    /// The throttle commands of the last step, 0..1.
    pub fn throttle(&self) -> &[S; MAX_ROTORS] {
        &self.throttle
    }

    /// One step to a finite velocity at a heading [rad] of those that are asked for one, on buses of these
    /// voltages [V] where they are measured; the motors of the others stand. Where the motion is not finite,
    /// integrals and commands stay.
    #[inline(always)]
    pub fn step(
        &mut self,
        asked: S::Mask,
        (motion, bus_v): (&Motion<S>, Option<S>),
        setpoint: &VelocitySetpoint<S>,
        yaw_rad: S,
        dt_s: f64,
    ) {
        let zero = yaw_rad.of(0.0);
        if !asked.any() {
            self.throttle = [zero; MAX_ROTORS];
            return;
        }
        let Motion { q_ned_from_body: [q0, q1, q2, q3], v_ned: v, omega_body: w } = *motion;
        // The next number after the largest.
        let beyond = zero.of(LARGEST_INPUT.next_up());
        let mut flies = asked;
        for number in [q0, q1, q2, q3, v.x, v.y, v.z, w.x, w.y, w.z] {
            flies = flies & number.abs().less(beyond);
        }
        let mut loops = self.loops;
        let demand = loops.track(&self.settings, (motion, bus_v), setpoint, yaw_rad, dt_s);
        self.loops.velocity.take(flies, &loops.velocity);
        self.loops.rate.take(flies, &loops.rate);
        for (throttle, now) in self.throttle.iter_mut().zip(demand.throttle) {
            let held = S::select(asked, *throttle, zero);
            *throttle = S::select(flies, now, held);
        }
    }
}
