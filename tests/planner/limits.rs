//! Problems without a solution, budgets, and what the problem's form has room for.

use std::ops::ControlFlow;

use nalgebra::Vector3;
use samara::plan::{Guess, InputReference, PlanError, SolverOptions, Status, plan};

use super::problems::{solve, titan, titan_problem, x500, x500_problem};

#[test]
fn closed_form_a_vehicle_too_weak_to_fly_is_infeasible() {
    let (vehicle, environment) = titan();
    let mut problem = titan_problem(&vehicle, &environment, 38);
    problem.thrust_max_n = 250.0; // trim needs 261 N of the rear rotors
    let plan = solve(&problem);
    assert_eq!(plan.status, Status::Infeasible);
    assert!(plan.diagnosis.unwrap().contains("too weak"), "says why");
}

#[test]
fn closed_form_a_terminal_set_out_of_reach_is_infeasible() {
    let (vehicle, environment) = titan();
    let mut problem = titan_problem(&vehicle, &environment, 8);
    problem.horizon_s = 1.0; // from 0 to 4 m/s forward in a second, at less than 0.4 m/s^2
    problem.terminal_velocity_tolerance_m_s = Some(0.05);
    let plan = solve(&problem);
    assert_eq!(plan.status, Status::Infeasible, "{:?}", plan.diagnosis);
}

#[test]
fn closed_form_a_terminal_set_within_reach_is_met() {
    let (vehicle, environment) = titan();
    let mut problem = titan_problem(&vehicle, &environment, 38);
    problem.terminal_velocity_tolerance_m_s = Some(0.03);
    let plan = solve(&problem);
    assert_eq!(plan.status, Status::Converged, "{:?}", plan.diagnosis);
    let end = plan.trajectory.nodes().last().unwrap().v_ned;
    assert!((end - problem.target_v_ned).amax() <= 0.03);
}

/// With the input cost about the trim, the target is the minimum of the cost: the plan comes to rest there.
#[test]
fn closed_form_an_input_cost_about_the_trim_ends_at_the_target() {
    let (vehicle, environment) = titan();
    let mut problem = titan_problem(&vehicle, &environment, 38);
    (problem.input_reference, problem.x_ss) = (InputReference::Trim, None);
    let plan = solve(&problem);
    assert_eq!(plan.status, Status::Converged);
    let end = plan.trajectory.nodes().last().unwrap();
    assert!((end.v_ned - problem.target_v_ned).norm() < 1e-3, "{}", end.v_ned);
}

#[test]
fn closed_form_bounds_hold_at_every_node() {
    let (vehicle, environment) = titan();
    let problem = titan_problem(&vehicle, &environment, 75);
    let plan = solve(&problem);
    for pair in plan.trajectory.nodes().windows(2) {
        let dt = pair[1].t_s - pair[0].t_s;
        for i in 0..4 {
            assert!((0.0..=300.0).contains(&pair[1].thrust_n[i]));
            assert!((pair[1].thrust_n[i] - pair[0].thrust_n[i]).abs() <= 60.0 * dt);
        }
    }
    assert_eq!(plan.trajectory.nodes()[0].thrust_n, [0.0; 8], "rotors start from rest");
}

#[test]
fn budgets_return_the_best_point() {
    let (vehicle, environment) = titan();
    let problem = titan_problem(&vehicle, &environment, 38);
    let options = SolverOptions { max_iterations: 6, ..SolverOptions::default() };
    let mut seen = Vec::new();
    let stopped = plan(&problem, &Guess::StraightLine, &options, &mut |p| {
        seen.push((p.defect_max, p.objective));
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(stopped.status, Status::IterationLimit);
    assert_eq!(stopped.counts.iterations, 6);
    let least = seen.iter().fold(f64::INFINITY, |m, s| m.min(s.0));
    assert_eq!(stopped.defect_max, least, "of {seen:?}");
    let by_observer = plan(&problem, &Guess::StraightLine, &SolverOptions::default(), &mut |p| {
        if p.iteration == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
    .unwrap();
    assert_eq!((by_observer.status, by_observer.counts.iterations), (Status::Stopped, 3));
}

#[test]
fn problems_that_cannot_be_posed_are_errors() {
    let (vehicle, environment) = titan();
    let attempt = |change: &dyn Fn(&mut samara::plan::PlanProblem)| {
        let mut problem = titan_problem(&vehicle, &environment, 38);
        change(&mut problem);
        plan(&problem, &Guess::StraightLine, &SolverOptions::default(), &mut |_| ControlFlow::Continue(()))
    };
    assert!(matches!(attempt(&|p| p.nodes = 2), Err(PlanError::Problem(_))));
    assert!(matches!(attempt(&|p| p.thrust_max_n = 0.0), Err(PlanError::Problem(_) | PlanError::Target(_))));
    assert!(matches!(attempt(&|p| p.initial[4] = f64::NAN), Err(PlanError::Problem(_))));
    assert!(matches!(
        attempt(&|p| p.target_v_ned = Vector3::new(400.0, 0.0, 0.0)),
        Err(PlanError::Target(_))
    ));
}

/// The first node's thrust is given: outside the bounds there is no plan, and that is the caller's mistake.
#[test]
fn an_initial_thrust_outside_its_bounds_is_refused() {
    let (vehicle, environment) = titan();
    for (thrust_n, says) in [(300.5, "found 300.5"), (-1.0, "found -1")] {
        let mut problem = titan_problem(&vehicle, &environment, 38);
        problem.initial_thrust_n[2] = thrust_n;
        let refused = plan(&problem, &Guess::StraightLine, &SolverOptions::default(), &mut |_| {
            ControlFlow::Continue(())
        });
        let text = refused.unwrap_err().to_string();
        assert!(
            text.contains("input 3 of the first node must lie from 0 to 300") && text.contains(says),
            "{text}"
        );
    }
}

/// Beyond the digits that the numbers have: no "diverged", but the solution with what is wrong with the
/// tolerance.
#[test]
fn a_tolerance_below_rounding_stalls_at_the_solution() {
    let (vehicle, environment) = titan();
    let problem = titan_problem(&vehicle, &environment, 38);
    let options = SolverOptions { tolerance: 1e-16, ..SolverOptions::default() };
    let stalled = plan(&problem, &Guess::StraightLine, &options, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(stalled.status, Status::Stalled, "{:?}", stalled.diagnosis);
    assert!(stalled.diagnosis.unwrap().contains("tolerance asks for more than rounding leaves"));
    let solution = solve(&problem);
    assert!((stalled.objective / solution.objective - 1.0).abs() < 1e-8, "{}", stalled.objective);
}

/// Six and eight rotors: the same body with its thrust spread over more rotors flies the same plan.
#[test]
fn closed_form_more_rotors_of_the_same_total_fly_the_same_plan() {
    let (vehicle, environment) = x500();
    let four = solve(&x500_problem(&vehicle, &environment, 38));
    let mut eight_rotors = vehicle.clone();
    eight_rotors.rotors.extend(vehicle.rotors.clone());
    let mut problem = x500_problem(&eight_rotors, &environment, 38);
    problem.thrust_max_n *= 0.5;
    problem.thrust_rate_n_s *= 0.5;
    // Each rotor carries half, so a sum of squares over twice as many is half: the weight doubles.
    problem.cost_input *= 2.0;
    let eight = solve(&problem);
    assert_eq!(eight.status, Status::Converged, "{:?}", eight.diagnosis);
    assert!((eight.objective / four.objective - 1.0).abs() < 1e-7, "{} {}", eight.objective, four.objective);
}

/// The envelope theorem: a bound costs the plan the sum of its multipliers. By plans whose bound on thrusts
/// is a thousandth more, and less.
#[test]
fn closed_form_multipliers_are_what_a_bound_costs() {
    let (vehicle, environment) = x500();
    let options = SolverOptions { tolerance: 1e-9, ..SolverOptions::default() };
    let planned = |share: f64| {
        let mut problem = x500_problem(&vehicle, &environment, 38);
        problem.thrust_max_n *= share;
        let found = plan(&problem, &Guess::StraightLine, &options, &mut |_| ControlFlow::Continue(()));
        (found.unwrap(), problem.thrust_max_n)
    };
    let [(less, least_n), (found, _), (more, most_n)] = [0.999, 1.0, 1.001].map(planned);
    let slope = (more.objective - less.objective) / (most_n - least_n);
    let multipliers = found.multipliers(4);
    let sum: f64 = multipliers.thrust_most.iter().sum();
    assert!(slope < -1.0 && (sum / slope + 1.0).abs() < 1e-4, "{sum} {slope}");
    assert_eq!((multipliers.thrust_most.len(), multipliers.defect.len()), (38 * 4, 37 * 10));
}
