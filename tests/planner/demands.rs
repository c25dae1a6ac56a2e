//! What a plan can be asked for: against optima of CasADi and IPOPT (`benches/casadi/demands.py`), closed
//! forms, and what each demand says.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use samara::config::{Mission, load_mission};
use samara::plan::{
    Demands, FreeHorizon, Guess, InputReference, MotionBounds, PeakCost, Plan, PlanProblem, SolverOptions,
    Status, plan,
};

use super::problems::{solve, solve_from, titan, titan_problem};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// The paper's mission with these keys of its plan.
fn mission(vehicle: &str, keys: &serde_json::Value) -> Mission {
    let text = std::fs::read_to_string(root().join("mission/titan_paper.json")).unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
    json["vehicle"] = root().join("params/vehicles").join(vehicle).to_str().unwrap().into();
    json["gains"] = root().join("params/gains/ours.json").to_str().unwrap().into();
    let plan = json["plan"].as_object_mut().unwrap();
    for (key, value) in keys.as_object().unwrap() {
        plan.insert(key.clone(), value.clone());
    }
    if keys.get("rotor_acceleration_rad_s2").is_some() && keys.get("thrust_slew_n_s").is_none() {
        plan.remove("thrust_slew_n_s");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mission.json");
    std::fs::write(&path, json.to_string()).unwrap();
    load_mission(&path).unwrap()
}

fn converged(plan: Plan) -> Plan {
    assert_eq!(plan.status, Status::Converged, "{:?}", plan.diagnosis);
    plan
}

/// Every demand alone and several together: the cost of another program's optimum, to 1e-6.
#[test]
fn reference_costs_of_plans_with_demands() {
    let reference: serde_json::Value =
        serde_json::from_str(include_str!("../data/casadi_demands.json")).unwrap();
    let problems = reference.as_object().unwrap();
    assert!(problems.len() >= 26, "all of them");
    for (name, problem) in problems {
        let mission = mission(problem["vehicle"].as_str().unwrap(), &problem["plan"]);
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let found = converged(mission.solve(&SolverOptions::default(), go_on).unwrap());
        let error = (found.objective / problem["objective"].as_f64().unwrap() - 1.0).abs();
        assert!(error <= 1e-6, "{name}: {} is {error:.1e} off", found.objective);
    }
}

fn peak(weight: f64, alone: bool) -> Demands {
    let deg = std::f64::consts::PI / 180.0;
    let peak =
        PeakCost { weight, alone, speed_m_s: 12.0, pitch_rad: 45.0 * deg, pitch_rate_rad_s: 90.0 * deg };
    Demands { peak: Some(peak), ..Demands::default() }
}

/// The least peak of J_state from rest is that of a level descent with the thrusts rising as fast as they
/// may: `m v' = m g - 240 t - D v^2`, integrated here; 0.5291 of 12 m/s. Between nodes a plan's thrust is
/// linear, so it meets the closed form to the collocation's error.
#[test]
fn closed_form_the_least_peak_is_that_of_the_level_descent() {
    let (vehicle, environment) = titan();
    let drag = {
        let descent = Vector3::new(0.0, 0.0, 1.0);
        -vehicle.aero.load(descent.into(), environment.density_kg_m3).force_body.z
    };
    let (m, g, dt) = (vehicle.mass.mass_kg, environment.gravity_m_s2, 1e-4);
    let (mut v, mut t, mut most) = (3.675f64, 0.0, 0.0f64);
    while t < 8.0 {
        let rate = |v: f64, t: f64| g - (240.0 * t + drag * v * v) / m;
        let half = v + 0.5 * dt * rate(v, t);
        v += dt * rate(half, t + 0.5 * dt);
        t += dt;
        most = most.max(v / 12.0);
    }
    for nodes in [38, 75] {
        let problem =
            PlanProblem { demands: peak(1.0, true), ..titan_problem(&vehicle, &environment, nodes) };
        let found = converged(solve(&problem)).objective;
        assert!((found - most).abs() < 1e-4, "{nodes} nodes: {found}, closed form {most}");
    }
}

/// A heavier weight makes the peak no larger, down to the least there is, 0.52906 (the closed form above).
#[test]
fn prop_a_heavier_weight_makes_a_smaller_peak() {
    let (vehicle, environment) = titan();
    let mut last = f64::INFINITY;
    for weight in [1.0, 30.0, 300.0, 3000.0] {
        let problem =
            PlanProblem { demands: peak(weight, false), ..titan_problem(&vehicle, &environment, 38) };
        let found = converged(solve(&problem));
        let nodes = found.trajectory.nodes();
        let speed = nodes.iter().map(|n| n.v_ned.norm() / 12.0).fold(0.0, f64::max);
        assert!(speed <= last + 1e-9, "{weight}: {speed} after {last}");
        last = speed;
    }
    assert!((0.529..0.5341).contains(&last), "{last}");
}

/// A bound on the motion holds at every node, and costs something.
#[test]
fn closed_form_bounds_on_the_motion_hold() {
    let (vehicle, environment) = titan();
    let free = converged(solve(&titan_problem(&vehicle, &environment, 75)));
    let motion = MotionBounds {
        speed_m_s: Some(6.5),
        pitch_rad: Some(0.3),
        altitude_lost_m: Some(135.0),
        ..MotionBounds::default()
    };
    let problem = PlanProblem {
        demands: Demands { motion, ..Demands::default() },
        ..titan_problem(&vehicle, &environment, 75)
    };
    let bounded = converged(solve(&problem));
    assert!(bounded.objective > free.objective);
    let nodes = bounded.trajectory.nodes();
    for node in nodes {
        assert!(node.v_ned.norm() <= 6.5 + 1e-7);
        assert!(samara::frames::pitch(node.q_ned_from_body).abs() <= 0.3 + 1e-7);
    }
    let lost: f64 =
        nodes.windows(2).map(|n| 0.5 * (n[0].v_ned.z + n[1].v_ned.z) * (n[1].t_s - n[0].t_s)).sum();
    assert!(lost <= 135.5, "{lost}");
}

/// A horizon that is free and costs more ends earlier, between its bounds, with the terminal set met.
#[test]
fn prop_a_second_that_costs_more_makes_a_shorter_horizon() {
    let (vehicle, environment) = titan();
    let mut last = f64::INFINITY;
    for cost_per_s in [0.1, 2.0, 20.0] {
        let horizon = FreeHorizon { least_s: 8.0, greatest_s: 80.0, cost_per_s };
        let problem = PlanProblem {
            demands: Demands { horizon: Some(horizon), ..Demands::default() },
            terminal_velocity_tolerance_m_s: Some(0.05),
            ..titan_problem(&vehicle, &environment, 38)
        };
        let found = converged(solve(&problem));
        let end = found.trajectory.nodes().last().unwrap();
        assert!((8.0..=80.0).contains(&end.t_s) && end.t_s <= last + 1e-6, "{}", end.t_s);
        assert!((end.v_ned - problem.target_v_ned).amax() <= 0.05 + 1e-7);
        for pair in found.trajectory.nodes().windows(2) {
            let most = 60.0 * (pair[1].t_s - pair[0].t_s) + 1e-6;
            assert!((0..4).all(|i| (pair[1].thrust_n[i] - pair[0].thrust_n[i]).abs() <= most));
        }
        last = end.t_s;
    }
}

/// A plan with demands, moved on by a node, is a start from which the renewed problem converges sooner.
#[test]
fn prop_plans_with_demands_start_warm() {
    let (vehicle, environment) = titan();
    let problem = PlanProblem { demands: peak(200.0, false), ..titan_problem(&vehicle, &environment, 38) };
    let cold = converged(solve(&problem));
    let node = &cold.trajectory.nodes()[3];
    let (q, v, w) = (node.q_ned_from_body, node.v_ned, node.omega_body);
    let later = PlanProblem {
        initial: [q[0], q[1], q[2], q[3], v.x, v.y, v.z + 0.02, w.x, w.y, w.z],
        initial_thrust_n: node.thrust_n,
        ..problem.clone()
    };
    let again = converged(solve_from(&later, &cold.moved_on(3)));
    let anew = converged(solve(&later));
    assert!((again.objective / anew.objective - 1.0).abs() < 1e-6, "{} {}", again.objective, anew.objective);
    assert!(again.counts.iterations <= anew.counts.iterations);
}

/// Costs in other units have the same optimum, found in about as many iterations.
#[test]
fn closed_form_costs_in_any_unit_converge_alike() {
    let (vehicle, environment) = titan();
    let as_it_is = converged(solve(&titan_problem(&vehicle, &environment, 38)));
    for exponent in -6..=8 {
        let factor = 10f64.powi(exponent);
        let usual = titan_problem(&vehicle, &environment, 38);
        let scaled = PlanProblem {
            cost_state: usual.cost_state.map(|w| w * factor),
            cost_input: usual.cost_input * factor,
            ..usual
        };
        let found = converged(solve(&scaled));
        let error = (found.objective / factor / as_it_is.objective - 1.0).abs();
        assert!(error < 1e-8, "1e{exponent}: {error:.1e}");
        assert!(found.counts.iterations <= as_it_is.counts.iterations + 10, "1e{exponent}");
    }
}

/// Terminal sets that no thrust reaches in time: from 0 to 4 m/s forward in 8 s takes 0.5 m/s^2, and the
/// thrust has to rise and the vehicle to pitch first.
#[test]
fn closed_form_terminal_sets_out_of_reach_in_the_horizon_are_infeasible() {
    let (vehicle, environment) = titan();
    for horizon_s in [3.0, 6.0, 8.0] {
        let problem = PlanProblem {
            horizon_s,
            terminal_velocity_tolerance_m_s: Some(0.05),
            x_ss: None,
            ..titan_problem(&vehicle, &environment, 38)
        };
        let found = solve(&problem);
        assert_eq!(found.status, Status::Infeasible, "{horizon_s} s: {:?}", found.diagnosis);
    }
}

/// Bounds that leave no room in the terminal set: said at once, with the bound.
#[test]
fn closed_form_bounds_that_contradict_the_terminal_set_are_infeasible() {
    let (vehicle, environment) = titan();
    let none = MotionBounds::default();
    for (motion, named) in [
        (
            MotionBounds { v_north_m_s: Some([-1.0, 3.0]), ..none },
            "the bounds on the velocity north, -1 to 3 m/s",
        ),
        (MotionBounds { v_north_m_s: Some([4.05, 9.0]), ..none }, "velocity north, 4.05 to 9 m/s"),
        (MotionBounds { v_east_m_s: Some([0.05, 1.0]), ..none }, "velocity east"),
        (MotionBounds { v_down_m_s: Some([-1.0, 3.0]), ..none }, "velocity down"),
        // sqrt(2) 3.96 m/s; beside a bound on the velocity north more.
        (MotionBounds { speed_m_s: Some(5.6), ..none }, "the bound on the speed, 5.6 m/s"),
        (
            MotionBounds { speed_m_s: Some(5.62), v_north_m_s: Some([4.02, 9.0]), ..none },
            "the bound on the speed, 5.62 m/s",
        ),
    ] {
        let problem = PlanProblem {
            terminal_velocity_tolerance_m_s: Some(0.04),
            demands: Demands { motion, ..Demands::default() },
            ..titan_problem(&vehicle, &environment, 38)
        };
        let found = solve(&problem);
        assert_eq!(found.status, Status::Infeasible, "{motion:?}: {:?}", found.diagnosis);
        let said = found.diagnosis.unwrap();
        assert!(said.contains(named) && said.contains("the end of the plan"), "{said}");
        // Without a terminal set there is nothing to contradict.
        let free = PlanProblem { terminal_velocity_tolerance_m_s: None, ..problem };
        assert!(solve(&free).diagnosis.is_none_or(|why| !why.contains("the end of the plan")));
    }
}

/// Without a cost of the state no thrust at all is best.
#[test]
fn closed_form_without_a_cost_of_the_state_the_rotors_stay_at_rest() {
    let (vehicle, environment) = titan();
    let problem = PlanProblem { cost_state: [0.0; 10], ..titan_problem(&vehicle, &environment, 38) };
    let found = converged(solve(&problem));
    assert!(found.objective < 1e-6, "{}", found.objective);
}

/// A cross wind that leans the vehicle far over.
#[test]
fn closed_form_a_cross_wind_of_10_m_s_has_a_plan() {
    let (vehicle, mut environment) = titan();
    environment.wind_ned_m_s = Vector3::new(0.0, 10.0, 0.0);
    let problem = PlanProblem {
        x_ss: None,
        input_reference: InputReference::Trim,
        ..titan_problem(&vehicle, &environment, 38)
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let found = converged(plan(&problem, &Guess::StraightLine, &SolverOptions::default(), go_on).unwrap());
    let end = found.trajectory.nodes().last().unwrap();
    assert!((end.v_ned - problem.target_v_ned).norm() < 0.05, "{}", end.v_ned);
}
