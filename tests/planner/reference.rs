//! Optima of an independent implementation (another program, another solver, the same equations).

use std::ops::ControlFlow;
use std::sync::Arc;

use nalgebra::{SVector, Vector3};
use samara::control::{Airframe, Cascade, ControlLimits, Gains};
use samara::model::{Environment, Vehicle, trim};
use samara::plan::problem::Nodes;
use samara::plan::vehicle::transcribe;
use samara::plan::{Guess, Plan, PlanProblem, Status};
use samara::sim::{DropSimulation, FlightPlan, PlantKind, Reference, fly};
use samara::trajectory::{Node, Trajectory};

use super::problems::{solve, solve_from, state, titan, titan_problem, x500, x500_problem};

fn reference() -> serde_json::Value {
    serde_json::from_str(include_str!("../data/reference_plans.json")).unwrap()
}

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn assert_optimum(plan: &Plan, objective: f64) {
    assert_eq!(plan.status, Status::Converged, "{:?}", plan.diagnosis);
    assert!(plan.kkt_residual <= 1e-8 && plan.defect_max <= 1e-8 && plan.complementarity <= 1e-8);
    let error = (plan.objective / objective - 1.0).abs();
    assert!(error <= 1e-8, "{} against {objective}: {error:.1e}", plan.objective);
}

fn table_3(i: usize) -> [f64; 10] {
    let c = numbers(&reference()["titan_table3_cases_vn_vd_pitch_q"][i]);
    state([0.0, c[2], 0.0], [c[0], 0.0, c[1]], [0.0, c[3], 0.0])
}

#[test]
fn reference_nominal_objectives_of_titan() {
    let (vehicle, environment) = titan();
    for nodes in [38, 75, 149] {
        let expected = reference()["titan_nominal_objective"][nodes.to_string()].as_f64().unwrap();
        assert_optimum(&solve(&titan_problem(&vehicle, &environment, nodes)), expected);
    }
}

#[test]
fn reference_objectives_from_each_release_of_table_3() {
    let (vehicle, environment) = titan();
    for i in 0..7 {
        let mut problem = titan_problem(&vehicle, &environment, 38);
        problem.initial = table_3(i);
        assert_optimum(&solve(&problem), reference()["titan_table3_objective"][i].as_f64().unwrap());
    }
}

#[test]
fn reference_objectives_of_the_x500() {
    let (vehicle, environment) = x500();
    for nodes in [38, 51] {
        let expected = reference()["x500_objective"][nodes.to_string()].as_f64().unwrap();
        assert_optimum(&solve(&x500_problem(&vehicle, &environment, nodes)), expected);
    }
}

/// The paper's own guess: a near-hover flight to the step command, thrusts clipped to the planner's bounds.
fn flown(vehicle: &Vehicle, environment: &Environment, problem: &PlanProblem, case: [f64; 10]) -> Trajectory {
    let airframe = Airframe::new(vehicle, environment).unwrap();
    let mut cascade = Cascade::new(airframe, Gains::near_hover(), ControlLimits::default());
    let initial = samara::model::rigid_body::BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: [case[0], case[1], case[2], case[3]],
        v_ned: Vector3::new(case[4], case[5], case[6]),
        omega_body: Vector3::new(case[7], case[8], case[9]),
    };
    let mut sim =
        DropSimulation::at_t0(Arc::new(vehicle.clone()), environment.clone(), initial, PlantKind::Ideal);
    let mut nodes = Vec::new();
    let flight = FlightPlan::new(Reference::Step(problem.target_v_ned), 0.01, problem.horizon_s);
    let _ = fly(&mut sim, &mut cascade, &flight, &mut |s| {
        nodes.push(Node {
            t_s: s.t_powered_s.unwrap(),
            q_ned_from_body: s.state.body.q_ned_from_body,
            v_ned: s.state.body.v_ned,
            omega_body: s.state.body.omega_body,
            thrust_n: s.balance.thrust_n,
            a_ned: s.a_ned,
        });
        ControlFlow::Continue(())
    });
    Trajectory::new(nodes, vehicle.rotors.len()).unwrap()
}

#[test]
fn reference_objectives_from_flown_guesses() {
    let (vehicle, environment) = titan();
    for i in 0..7 {
        let mut problem = titan_problem(&vehicle, &environment, 38);
        problem.initial = table_3(i);
        let guess = flown(&vehicle, &environment, &problem, problem.initial);
        let plan = solve_from(&problem, &Guess::Flown(&guess));
        assert_optimum(&plan, reference()["titan_table3_objective"][i].as_f64().unwrap());
    }
    let (vehicle, environment) = x500();
    let problem = x500_problem(&vehicle, &environment, 38);
    let guess = flown(&vehicle, &environment, &problem, problem.initial);
    let expected = reference()["x500_objective"]["38"].as_f64().unwrap();
    assert_optimum(&solve_from(&problem, &Guess::Flown(&guess)), expected);
}

/// Another program's solution in our defects: what shows a sign error that is consistent in value and
/// derivative.
#[test]
fn reference_nodes_satisfy_our_defects() {
    let check = |name: &str, problem: &PlanProblem, objective: f64| {
        let data = &reference()[name];
        let t = trim(problem.vehicle, problem.environment, problem.target_v_ned, 0.0).unwrap();
        let nlp = transcribe::<4>(problem, &t.q_ned_from_body, &t.thrust_n).unwrap();
        let rows = |key: &str| data[key].as_array().unwrap().iter().map(numbers).collect::<Vec<_>>();
        let nodes = Nodes {
            x: rows("x").iter().map(|r| SVector::from_column_slice(r)).collect(),
            u: rows("thrust_n").iter().map(|r| SVector::from_column_slice(r)).collect(),
        };
        let evaluation = nlp.evaluate(&nodes);
        assert!(evaluation.defect_max < 1e-12, "{name}: {:e}", evaluation.defect_max);
        assert!((evaluation.objective / objective - 1.0).abs() < 1e-13, "{name}: {}", evaluation.objective);
    };
    let (vehicle, environment) = titan();
    let expected = reference()["titan_nominal_objective"]["38"].as_f64().unwrap();
    check("titan_nominal_38", &titan_problem(&vehicle, &environment, 38), expected);
    let (vehicle, environment) = x500();
    let expected = reference()["x500_objective"]["38"].as_f64().unwrap();
    check("x500_38", &x500_problem(&vehicle, &environment, 38), expected);
}
