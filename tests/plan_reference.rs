//! The planner against an independent implementation's optima.
#![cfg(feature = "files")]

use std::ops::ControlFlow;
use std::path::Path;

use nalgebra::Vector3;
use samara::config::load_vehicle;
use samara::model::{Environment, Vehicle, environment::GeoPoint};
use samara::plan::solver::{SolverOptions, Status};
use samara::plan::{Guess, InputReference, Plan, PlanProblem, plan};

fn reference() -> serde_json::Value {
    serde_json::from_str(include_str!("data/reference_plans.json")).unwrap()
}

fn environment(gravity: f64, density: f64) -> Environment {
    let anchor = GeoPoint { latitude_deg: 0.0, longitude_deg: 0.0, altitude_m: 0.0 };
    Environment::new(gravity, density, Vector3::zeros(), anchor).unwrap()
}

pub fn titan() -> (Vehicle, Environment) {
    (load_vehicle(Path::new("params/vehicles/titan.json")).unwrap().vehicle, environment(1.35, 5.4))
}

pub fn x500() -> (Vehicle, Environment) {
    (load_vehicle(Path::new("params/vehicles/x500.json")).unwrap().vehicle, environment(9.80665, 1.225))
}

/// Weights as printed, (27).
const WEIGHTS: [f64; 10] = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 10.0, 10.0, 10.0];

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
    }
}

pub fn solve(problem: &PlanProblem) -> Plan {
    let options = SolverOptions::default();
    plan(problem, &Guess::StraightLine, &options, &mut |p| {
        if std::env::var("SAMARA_TRACE").is_ok() {
            println!("{p:?}");
        }
        ControlFlow::Continue(())
    })
    .unwrap()
}

fn assert_optimum(plan: &Plan, objective: f64) {
    println!(
        "{:?} {} vs {objective} {:?} kkt {:e} defect {:e} compl {:e}",
        plan.status, plan.objective, plan.work, plan.kkt_residual, plan.defect_max, plan.complementarity
    );
    assert_eq!(plan.status, Status::Converged, "{:?}", plan.diagnosis);
    assert!(plan.kkt_residual <= 1e-8 && plan.defect_max <= 1e-8 && plan.complementarity <= 1e-8);
    let error = (plan.objective / objective - 1.0).abs();
    assert!(error <= 1e-8, "{} against {objective}: {error:.1e}", plan.objective);
}

#[test]
fn reference_nominal_objectives_of_titan() {
    let (vehicle, environment) = titan();
    let reference = reference();
    for nodes in [38, 75, 149] {
        let expected = reference["titan_nominal_objective"][nodes.to_string()].as_f64().unwrap();
        assert_optimum(&solve(&titan_problem(&vehicle, &environment, nodes)), expected);
    }
}

#[test]
fn reference_objectives_from_each_release_of_table_3() {
    let (vehicle, environment) = titan();
    let reference = reference();
    let cases = reference["titan_table3_cases_vn_vd_pitch_q"].as_array().unwrap();
    for (i, case) in cases.iter().enumerate() {
        let c: Vec<f64> = case.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        let mut problem = titan_problem(&vehicle, &environment, 38);
        let (s, co) = (0.5 * c[2]).sin_cos();
        problem.initial = [co, 0.0, s, 0.0, c[0], 0.0, c[1], 0.0, c[3], 0.0];
        assert_optimum(&solve(&problem), reference["titan_table3_objective"][i].as_f64().unwrap());
    }
}

#[test]
fn reference_objectives_of_the_x500() {
    let (vehicle, environment) = x500();
    let reference = reference();
    for nodes in [38, 51] {
        let mut problem = titan_problem(&vehicle, &environment, nodes);
        problem.initial[6] = 9.903324999999999;
        problem.target_v_ned = Vector3::new(2.0, 0.0, 1.0);
        problem.x_ss = None;
        problem.horizon_s = 5.0;
        problem.thrust_max_n = 8.54858;
        problem.thrust_rate_n_s = 40.0;
        problem.cost_input = 0.01231557090194623;
        assert_optimum(&solve(&problem), reference["x500_objective"][nodes.to_string()].as_f64().unwrap());
    }
}
