//! A rigid body under a given force and moment, moved by the simulator's own equations and integrator.

use nalgebra::Vector3;

use crate::frames::{Turn, normalized};
use crate::model::MAX_ROTORS;
use crate::model::rigid_body::{BodyState, MassProperties, derivative};
use crate::sim::PlantState;
use crate::sim::integrator::{PlantRate, runge_kutta_4};

/// Forces and moment on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Gravity, along +down [m/s^2].
    pub gravity_m_s2: f64,
    /// Every other force [N], body axes.
    pub force_body: Vector3<f64>,
    /// Moment about the centre of mass [N m], body axes.
    pub moment_body: Vector3<f64>,
}

impl Load {
    /// Gravity alone, without other forces or moments.
    pub fn gravity(gravity_m_s2: f64) -> Self {
        Self { gravity_m_s2, force_body: Vector3::zeros(), moment_body: Vector3::zeros() }
    }
}

/// The state `dt_s` later: a step of the simulator for a body without rotors.
pub fn advance(
    mass: &MassProperties,
    state: &BodyState,
    dt_s: f64,
    load: impl Fn(&BodyState) -> Load,
) -> BodyState {
    let start = PlantState::rotors_at_rest(*state);
    let mut end = runge_kutta_4(&start, dt_s, |_, x| {
        let load = load(&x.body);
        let (motion, turn) = (x.body.motion(), Turn::of(x.body.q_ned_from_body));
        let (force, moment) = (load.force_body.into(), load.moment_body.into());
        let body = x.body.rate(&derivative(mass, load.gravity_m_s2, &motion, &turn, force, moment));
        PlantRate { body, rotor_acceleration: [0.0; MAX_ROTORS] }
    })
    .body;
    end.q_ned_from_body = normalized(end.q_ned_from_body);
    end
}

/// The state after `steps` steps of `dt_s`.
pub fn fly(
    mass: &MassProperties,
    start: BodyState,
    dt_s: f64,
    steps: u32,
    load: impl Fn(&BodyState) -> Load,
) -> BodyState {
    (0..steps).fold(start, |state, _| advance(mass, &state, dt_s, &load))
}

/// State at the origin, level, with this velocity NED [m/s] and these body rates [rad/s].
pub fn level(v_ned: Vector3<f64>, omega_body: Vector3<f64>) -> BodyState {
    BodyState { p_ned: Vector3::zeros(), q_ned_from_body: crate::frames::LEVEL, v_ned, omega_body }
}
