//! The problems that the tests share: the missions' data as the reference has them.

use std::ops::ControlFlow;
use std::path::Path;

use nalgebra::Vector3;
use samara::config::load_vehicle;
use samara::frames::quaternion_from_euler;
use samara::model::environment::GeoPoint;
use samara::model::{Environment, Vehicle};
use samara::plan::{Demands, Guess, InputReference, Plan, PlanProblem, PlanState, SolverOptions, plan};

fn environment(gravity: f64, density: f64) -> Environment {
    let anchor = GeoPoint { latitude_deg: 0.0, longitude_deg: 0.0, altitude_m: 0.0 };
    Environment::new(gravity, density, Vector3::zeros(), anchor).unwrap()
}

pub fn titan() -> (Vehicle, Environment) {
    (load_vehicle(Path::new("params/vehicles/titan.json")).unwrap().vehicle, environment(1.35, 5.4))
}

/// The quadrotor as the reference has it, with 16 mm of torque per thrust: that of version 0.1.
pub fn x500() -> (Vehicle, Environment) {
    let path = Path::new("tests/data/v0.1/params/vehicles/x500.json");
    (load_vehicle(path).unwrap().vehicle, environment(9.80665, 1.225))
}

/// Weights as printed, (27).
const WEIGHTS: PlanState = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 10.0, 10.0, 10.0];

pub fn titan_problem<'a>(
    vehicle: &'a Vehicle,
    environment: &'a Environment,
    nodes: usize,
) -> PlanProblem<'a> {
    PlanProblem {
        vehicle,
        environment,
        initial: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.675, 0.0, 0.0, 0.0],
        initial_thrust_n: [0.0; 8],
        target_v_ned: Vector3::new(4.0, 0.0, 4.0),
        x_ss: Some([1.0, 0.0, -0.0026, 0.0, 4.0, 0.0, 4.0, 0.0, 0.0, 0.0]),
        horizon_s: 30.0,
        nodes,
        thrust_max_n: 300.0,
        thrust_rate_n_s: 60.0,
        cost_state: WEIGHTS,
        cost_input: 1e-5,
        input_reference: InputReference::Zero,
        terminal_velocity_tolerance_m_s: None,
        demands: Demands::default(),
    }
}

pub fn x500_problem<'a>(vehicle: &'a Vehicle, environment: &'a Environment, nodes: usize) -> PlanProblem<'a> {
    PlanProblem {
        initial: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 9.903324999999999, 0.0, 0.0, 0.0],
        target_v_ned: Vector3::new(2.0, 0.0, 1.0),
        x_ss: None,
        horizon_s: 5.0,
        thrust_max_n: 8.54858,
        thrust_rate_n_s: 40.0,
        cost_input: 0.01231557090194623,
        ..titan_problem(vehicle, environment, nodes)
    }
}

/// A state from Euler angles [rad], velocity [m/s] and body rates [rad/s].
pub fn state(euler: [f64; 3], v_ned: [f64; 3], omega: [f64; 3]) -> PlanState {
    let q = quaternion_from_euler(euler[0], euler[1], euler[2]);
    [q[0], q[1], q[2], q[3], v_ned[0], v_ned[1], v_ned[2], omega[0], omega[1], omega[2]]
}

pub fn solve_from(problem: &PlanProblem, guess: &Guess) -> Plan {
    plan(problem, guess, &SolverOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap()
}

pub fn solve(problem: &PlanProblem) -> Plan {
    solve_from(problem, &Guess::StraightLine)
}
