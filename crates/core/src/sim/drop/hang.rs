//! Motion under a parachute that is prescribed, and what it takes.

use nalgebra::Vector3;

use super::course::Course;
use crate::model::rigid_body::BodyState;
use crate::model::{Environment, Parachute};

/// A parachute, whose motion is prescribed where it is no body of its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hang {
    pub(super) parachute: Parachute,
    /// Time [s] and acceleration, NED [m/s^2], of the last state under it.
    last: Option<(f64, Vector3<f64>)>,
}

impl Hang {
    /// Under a parachute.
    pub(super) fn under(parachute: Parachute) -> Self {
        Self { parachute, last: None }
    }

    /// The motion now, at a site in the wind that the canopy drifts with; its acceleration is kept.
    pub(super) fn go_on(&mut self, course: &Course, site: &Environment) -> BodyState {
        let (body, a_ned) = self.parachute.hanging(course.since_nominal_s(), site);
        self.last = Some((course.clock.time_s, a_ned));
        body
    }

    /// Acceleration now, NED [m/s^2].
    pub(super) fn a_ned(&self, course: &Course, site: &Environment) -> Vector3<f64> {
        match self.last {
            Some((time_s, a_ned)) if time_s == course.clock.time_s => a_ned,
            _ => self.parachute.hanging(course.since_nominal_s(), site).1,
        }
    }
}
