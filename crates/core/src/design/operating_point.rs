//! Rotor speeds that give wanted thrusts in a state, and what a plan takes of the shafts.

use nalgebra::Vector3;

use crate::model::rigid_body::BodyState;
use crate::model::{Environment, MAX_ROTORS, PerRotor, Vehicle};
use crate::plan::{PlanProblem, PlanState};
use crate::trajectory::{Node, Trajectory};

/// Halvings of the range of rotor speeds: to a billionth of it.
const HALVINGS: u32 = 30;

/// The state of a plan's node; where it is makes no difference.
pub fn body_of(node: &Node) -> BodyState {
    BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: node.q_ned_from_body,
        v_ned: node.v_ned,
        omega_body: node.omega_body,
    }
}

/// The state that a plan starts from; where it is makes no difference.
pub fn body_of_state(x: &PlanState) -> BodyState {
    BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: [x[0], x[1], x[2], x[3]],
        v_ned: Vector3::new(x[4], x[5], x[6]),
        omega_body: Vector3::new(x[7], x[8], x[9]),
    }
}

/// Speed of each rotor [rad/s] at which it gives the thrust [N] in this state, up to the motor's greatest;
/// by bisection, all rotors at once, so that each is in the wakes of the others as they are.
pub fn rotor_speeds(
    vehicle: &Vehicle,
    environment: &Environment,
    body: &BodyState,
    thrust_n: &PerRotor,
) -> PerRotor {
    let (mut low, mut high) = ([0.0; MAX_ROTORS], [vehicle.motor.omega_max_rad_s(); MAX_ROTORS]);
    for _ in 0..HALVINGS {
        let middle: PerRotor = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
        let rate = vehicle.powered_derivative(environment, body, &middle, &[0.0; MAX_ROTORS], true);
        for i in 0..vehicle.rotors.len() {
            let end = if rate.balance.thrust_n[i] < thrust_n[i] { &mut low[i] } else { &mut high[i] };
            *end = middle[i];
        }
    }
    let mut speeds = [0.0; MAX_ROTORS];
    for (i, speed) in speeds.iter_mut().enumerate().take(vehicle.rotors.len()) {
        *speed = 0.5 * (low[i] + high[i]);
    }
    speeds
}

/// Energy that a plan takes of the rotors' shafts [J]: `sum_i |Q_i| omega_i` by the trapezoid rule over its
/// nodes, with the rotors at the speeds that give the plan's thrusts there.
pub fn shaft_energy_j(problem: &PlanProblem<'_>, plan: &Trajectory) -> f64 {
    let power_w = |node: &Node| {
        let body = body_of(node);
        let speeds = rotor_speeds(problem.vehicle, problem.environment, &body, &node.thrust_n);
        let rate =
            problem.vehicle.powered_derivative(problem.environment, &body, &speeds, &[0.0; MAX_ROTORS], true);
        rate.balance.torque_nm.iter().zip(&speeds).map(|(torque, omega)| torque.abs() * omega).sum::<f64>()
    };
    let powers: Vec<(f64, f64)> = plan.nodes().iter().map(|node| (node.t_s, power_w(node))).collect();
    powers.windows(2).map(|pair| 0.5 * (pair[1].0 - pair[0].0) * (pair[0].1 + pair[1].1)).sum()
}
