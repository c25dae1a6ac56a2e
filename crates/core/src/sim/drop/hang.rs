//! Motion under a parachute that is prescribed, and what it takes.

use nalgebra::Vector3;

use super::super::two_bodies::CanopyFlight;
use super::course::Course;
use crate::frames::pitch;
use crate::math;
use crate::model::parachute::Pendulum;
use crate::model::rigid_body::BodyState;
use crate::model::{Environment, Parachute, Vehicle};

/// A parachute, whose motion is prescribed where it is no body of its own, or not yet.
#[derive(Clone, Debug)]
pub(super) struct Hang {
    pub(super) parachute: Parachute,
    /// The motion that is prescribed.
    pub(super) prescribed: Parachute,
    /// Vehicle and canopy as they begin, where two bodies take over from the prescribed motion.
    next: Option<Box<(BodyState, CanopyFlight)>>,
    /// Time [s] and acceleration, NED [m/s^2], of the last state under it.
    last: Option<(f64, Vector3<f64>)>,
}

impl Hang {
    /// Under a parachute.
    pub(super) fn under(parachute: Parachute) -> Self {
        Self { parachute, prescribed: parachute, next: None, last: None }
    }

    /// On the hook of a parachute whose canopy is a body of its own: the descent is prescribed until it has
    /// built up, with a swing that comes to be the two bodies' in pitch and rate. Also the time from then to
    /// the nominal release [s]; `None` where there is no hook, or no steady descent.
    pub(super) fn on_hook(
        parachute: Parachute,
        vehicle: &Vehicle,
        environment: &Environment,
    ) -> Option<(Self, f64)> {
        let (_, suspension) = parachute.hook.zip(parachute.suspension)?;
        let linear = parachute.linearised(vehicle, environment);
        let before_s = linear.built_up_before_s(environment.gravity_m_s2)?;
        let begun = CanopyFlight::begin(suspension, &parachute, vehicle, environment, before_s)?;
        let omega_rad_s = linear.pendulum.omega_rad_s;
        let (sin, rate) = (pitch(begun.0.q_ned_from_body), begun.0.omega_body.y);
        let cos = if omega_rad_s > 0.0 { rate / omega_rad_s } else { 0.0 };
        let pendulum = Pendulum {
            amplitude_rad: (sin * sin + cos * cos).sqrt(),
            phase_rad: math::atan2(sin, cos) + omega_rad_s * before_s,
            ..linear.pendulum
        };
        let prescribed = Parachute { pendulum, ..linear };
        Some((Self { parachute, prescribed, next: Some(Box::new(begun)), last: None }, before_s))
    }

    /// The canopy that takes over, above a vehicle in this state, which goes on as it moves.
    pub(super) fn take_over(&mut self, body: &BodyState) -> Option<CanopyFlight> {
        let (begun, mut canopy) = *self.next.take()?;
        canopy.state.p_ned += body.p_ned - begun.p_ned;
        canopy.state.v_ned += body.v_ned - begun.v_ned;
        Some(canopy)
    }

    /// The motion now, at a site in the wind that the canopy drifts with; its acceleration is kept.
    pub(super) fn go_on(&mut self, course: &Course, site: &Environment) -> BodyState {
        let (body, a_ned) = self.prescribed.hanging(course.since_nominal_s(), site);
        self.last = Some((course.clock.time_s, a_ned));
        body
    }

    /// Acceleration now, NED [m/s^2].
    pub(super) fn a_ned(&self, course: &Course, site: &Environment) -> Vector3<f64> {
        match self.last {
            Some((time_s, a_ned)) if time_s == course.clock.time_s => a_ned,
            _ => self.prescribed.hanging(course.since_nominal_s(), site).1,
        }
    }
}
