//! The state at which a renewed plan begins: what was measured, moved on to when the plan takes effect.
//!
//! Before t = 0 the vehicle falls with its rotors at rest, as the mission's drops do ([`Start`]); from then
//! on it flies by the thrusts of the plan in force, as the planner thinks of it. What a controller adds to
//! those thrusts within the latency, and what the wind does, is not known.

use nalgebra::Vector3;

use crate::frames::{Quaternion, conjugate, normalized, product, rotate_ned_from_body};
use crate::model::rigid_body::{BodyRate, BodyState};
use crate::model::{Environment, MAX_ROTORS, Vehicle};
use crate::sim::integrator::{PlantRate, runge_kutta_4, steps_in};
use crate::sim::{PlantState, Start};
use crate::trajectory::Trajectory;

/// Longest step of the integration [s].
const STEP_S: f64 = 0.01;

/// The state at `until_s` of a vehicle that was seen in `state` at `seen_s`, times since the rotors are freed
/// [s] (negative before), with the thrusts of `in_force` from t = 0 on; `None` where it is no number.
pub fn expected_state(
    (vehicle, environment, start): (&Vehicle, &Environment, Start),
    (seen_s, state): (f64, BodyState),
    in_force: &Trajectory,
    until_s: f64,
) -> Option<BodyState> {
    let mut body = state;
    let fall_s = until_s.min(0.0) - seen_s;
    if fall_s > 0.0 {
        body = match start {
            // (44): in a vacuum, without turning.
            Start::T0 => BodyState { v_ned: body.v_ned + environment.gravity_ned() * fall_s, ..body },
            Start::Release => integrated(body, fall_s, |_, body| {
                let rest = [0.0; MAX_ROTORS];
                vehicle.powered_derivative(environment, body, &rest, &rest, true).body
            }),
        };
    }
    let from_s = seen_s.max(0.0);
    if until_s > from_s {
        let rotors = vehicle.rotors.len();
        body = integrated(body, until_s - from_s, |t_s, body| {
            vehicle.thrust_derivative(environment, body, &in_force.thrust_n(from_s + t_s)[..rotors])
        });
    }
    let mut all = body.q_ned_from_body.iter().chain(body.v_ned.iter()).chain(body.omega_body.iter());
    all.all(|x| x.is_finite()).then_some(body)
}

/// The state after `dt_s` [s] under a rate that depends on the time since the beginning [s] and the state.
fn integrated(body: BodyState, dt_s: f64, rate: impl Fn(f64, &BodyState) -> BodyRate) -> BodyState {
    let steps = steps_in(dt_s, STEP_S);
    let h = dt_s / f64::from(steps);
    let mut state = PlantState::rotors_at_rest(body);
    for step in 0..steps {
        let begin_s = f64::from(step) * h;
        state = runge_kutta_4(&state, h, |share, state| PlantRate {
            body: rate(begin_s + share * h, &state.body),
            rotor_acceleration: [0.0; MAX_ROTORS],
        });
        state.body.q_ned_from_body = normalized(state.body.q_ned_from_body);
    }
    state.body
}

/// The state with the heading taken out: the body's up axis and the velocity are what they were, the twist
/// about the up axis and the rate about it are zero. A plan steers velocities with the nose north; the
/// heading is the autopilot's.
pub fn nose_north(state: &BodyState) -> BodyState {
    let q = state.q_ned_from_body;
    let length = (q[0] * q[0] + q[3] * q[3]).sqrt();
    // Upside down there is no twist to tell from the tilt.
    let twist: Quaternion =
        if length > 1e-6 { [q[0] / length, 0.0, 0.0, q[3] / length] } else { [1.0, 0.0, 0.0, 0.0] };
    let untwisted = normalized(product(q, conjugate(twist)));
    // Components in the axes that the body's are twisted against.
    let omega = rotate_ned_from_body(twist, state.omega_body);
    BodyState { q_ned_from_body: untwisted, omega_body: Vector3::new(omega.x, omega.y, 0.0), ..*state }
}
