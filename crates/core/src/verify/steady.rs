//! Steady states: trim at the target, motors under a constant command.

use std::f64::consts::E;

use nalgebra::Vector3;

use super::motion::level;
use super::{Check, CheckGroup};
use crate::frames::rotate_ned_from_body;
use crate::math;
use crate::model::rigid_body::{BodyRate, BodyState};
use crate::model::{MAX_ROTORS, Motor, TrimError, trim};
use crate::plan::PlanProblem;
use crate::sim::PlantState;
use crate::sim::integrator::{PlantRate, runge_kutta_4};
use crate::units::DEG_PER_RAD;

/// Steps of a motor's run-up, short against every time constant.
const STEPS: u32 = 4000;

/// Forces and moments at the trim, which was solved for zero accelerations, from the force balance of the
/// flight log.
///
/// # Errors
/// [`TrimError`] when there is no steady flight at a target.
pub fn trim_at_target(
    lander: &PlanProblem<'_>,
    quadrotor: &PlanProblem<'_>,
) -> Result<CheckGroup, TrimError> {
    let mut checks = Vec::new();
    for (name, problem) in [("lander", lander), ("quadrotor", quadrotor)] {
        let trim = trim(problem.vehicle, problem.environment, problem.target_v_ned, 0.0)?;
        let state =
            BodyState { q_ned_from_body: trim.q_ned_from_body, ..level(trim.v_ned, Vector3::zeros()) };
        let balance = problem.vehicle.thrust_balance(problem.environment, &state, &trim.thrust_n);
        let weight = balance.gravity_force_ned;
        let force = rotate_ned_from_body(state.q_ned_from_body, balance.force_body()) + weight;
        let share = force.norm() / weight.norm();
        checks.push(Check::new(format!("{name}: unbalanced force over weight"), "", share, 0.0, 1e-10));
        let moment = balance.moment_body().norm();
        checks.push(Check::new(format!("{name}: unbalanced moment"), "N m", moment, 0.0, 1e-8));
    }
    if let Some(x_ss) = lander.x_ss {
        let trim = trim(lander.vehicle, lander.environment, lander.target_v_ned, 0.0)?;
        // The paper prints two digits of q2.
        let printed = 2.0 * math::asin(x_ss[2]) * DEG_PER_RAD;
        checks.push(Check::new("lander: pitch", "deg", trim.pitch_rad * DEG_PER_RAD, printed, 1e-4));
    }
    Ok(CheckGroup {
        title: "Trim at the target velocity",
        source: "forces (9), (17), weight and moments (6), (18) add up to zero; the lander's pitch is that of (31)",
        checks,
    })
}

/// Steady speeds and run-ups of the motors of both vehicles in still air.
pub fn motors(lander: &PlanProblem<'_>, quadrotor: &PlanProblem<'_>) -> CheckGroup {
    let mut checks = of_motor("lander", lander);
    checks.extend(of_motor("quadrotor", quadrotor));
    CheckGroup {
        title: "Motors in still air",
        source: "speed controller and DC motor, III.B: steady where K_t I = Q; first order: 1 - 1/e after tau",
        checks,
    }
}

fn of_motor(name: &str, problem: &PlanProblem<'_>) -> Vec<Check> {
    let (rotor, motor) = (&problem.vehicle.rotor, &problem.vehicle.motor);
    let law = motor.law();
    let torque_nm = |omega: f64| rotor.static_load(omega, problem.environment.density_kg_m3).torque_nm;
    let turned = |from: f64, throttle: f64, time_s: f64| {
        speed_after(time_s, from, |omega| law.acceleration(throttle, omega, torque_nm(omega)))
    };
    let said = |what: &str| format!("{name}: {what}");
    match *motor {
        Motor::EscDc(m) => {
            // I = (K_e + K_esc)(omega_c - omega)/R carries Q/K_t: the command that holds a speed.
            let omega = 0.8 * m.omega_max_rad_s;
            let lag = torque_nm(omega) / m.torque_constant_nm_a * m.resistance_ohm
                / (m.back_emf_constant_v_s_rad + m.esc_gain_v_s_rad);
            let throttle = (omega + lag) / m.omega_max_rad_s;
            let at_the_limit = m.torque_constant_nm_a * m.current_max_a / m.rotor_inertia_kg_m2;
            vec![
                Check::new(said("steady speed"), "rad/s", turned(0.0, throttle, 10.0), omega, 1e-9),
                Check::new(
                    said("from rest at the current limit"),
                    "rad/s^2",
                    law.acceleration(1.0, 0.0, 0.0),
                    at_the_limit,
                    1e-9,
                ),
            ]
        }
        Motor::FirstOrder { omega_max_rad_s, tau_up_s, tau_down_s, .. } => {
            let top = 0.8 * omega_max_rad_s;
            vec![
                Check::new(said("steady speed"), "rad/s", turned(0.0, 0.8, 40.0 * tau_up_s), top, 1e-9),
                Check::new(
                    said("speed after tau, up"),
                    "rad/s",
                    turned(0.0, 0.8, tau_up_s),
                    top * (1.0 - 1.0 / E),
                    1e-9,
                ),
                Check::new(
                    said("speed after tau, down"),
                    "rad/s",
                    turned(top, 0.0, tau_down_s),
                    top / E,
                    1e-9,
                ),
            ]
        }
    }
}

/// Speed of a rotor [rad/s] after a time [s], from a speed [rad/s] and under an angular acceleration
/// [rad/s^2] that depends on the speed, by the simulator's integrator.
fn speed_after(time_s: f64, from: f64, acceleration: impl Fn(f64) -> f64) -> f64 {
    let mut state = PlantState::rotors_at_rest(level(Vector3::zeros(), Vector3::zeros()));
    state.rotor_speed[0] = from;
    for _ in 0..STEPS {
        state = runge_kutta_4(&state, time_s / f64::from(STEPS), |_, x| {
            let mut rotor_acceleration = [0.0; MAX_ROTORS];
            rotor_acceleration[0] = acceleration(x.rotor_speed[0]);
            PlantRate { body: STILL, rotor_acceleration }
        });
    }
    state.rotor_speed[0]
}

/// The rates of a body at rest.
const STILL: BodyRate = {
    const ZERO: Vector3<f64> = Vector3::new(0.0, 0.0, 0.0);
    BodyRate { p_dot_ned: ZERO, q_dot: [0.0; 4], v_dot_ned: ZERO, omega_dot_body: ZERO }
};
