//! Convergence orders of the transcription.

use std::sync::Arc;

use nalgebra::SVector;
use samara::model::trim;
use samara::plan::dynamics::Dynamics;
use samara::plan::problem::Nodes;
use samara::plan::vehicle::transcribe;
use samara::trajectory::Trajectory;

use super::problems::{solve, titan, titan_problem};

/// Under a prescribed smooth input the Hermite-Simpson states converge with fourth order.
#[test]
fn closed_form_states_under_a_smooth_input_converge_with_fourth_order() {
    let (vehicle, environment) = titan();
    let problem = titan_problem(&vehicle, &environment, 38);
    let t = trim(&vehicle, &environment, problem.target_v_ned, 0.0).unwrap();
    let mut nlp = transcribe::<4>(&problem, &t.q_ned_from_body, &t.thrust_n).unwrap();
    let horizon = 6.0;
    // Front and rear thrusts differ by a slow sine: pitch swings by some degrees.
    let input = |t: f64| {
        let swing = 4.0 * (1.1 * t).sin();
        SVector::<f64, 4>::from([240.0 + swing, 250.0 - swing, 240.0 + swing, 250.0 - swing])
    };
    let mut end = |n: usize| {
        let dt = horizon / n as f64;
        (nlp.dt_s, nlp.intervals) = (dt, 1);
        let mut x = nlp.x_initial;
        for k in 0..n {
            let u = vec![input(k as f64 * dt), input((k + 1) as f64 * dt)];
            // One interval after the other: Newton's method on the defect, by the right state.
            let mut nodes = Nodes { x: vec![x, x + nlp.dynamics.value(&x, &u[0]) * dt], u };
            for _ in 0..20 {
                let (linearised, now) = nlp.linearise(&nodes);
                let j = linearised.defect_jacobian(0, dt);
                let step = j.x_right.lu().solve(&now.defects[0]).unwrap();
                nodes.x[1] -= step;
                if step.amax() < 1e-14 {
                    break;
                }
            }
            x = nodes.x[1];
        }
        x
    };
    // Inside an interval the transcription has the input linear, which alone would be of second order: what
    // the states are compared with is the flow under that same piecewise linear input.
    let exact = |n: usize| {
        let dt = horizon / n as f64;
        let substeps = 400;
        let mut x = SVector::<f64, 10>::from(problem.initial);
        let nlp = transcribe::<4>(&problem, &t.q_ned_from_body, &t.thrust_n).unwrap();
        for k in 0..n {
            let (u0, u1) = (input(k as f64 * dt), input((k + 1) as f64 * dt));
            let h = dt / substeps as f64;
            for i in 0..substeps {
                let u = |s: f64| u0 + (u1 - u0) * ((i as f64 + s) / substeps as f64);
                let f = |x: &SVector<f64, 10>, s: f64| nlp.dynamics.value(x, &u(s));
                let k1 = f(&x, 0.0);
                let k2 = f(&(x + k1 * (h / 2.0)), 0.5);
                let k3 = f(&(x + k2 * (h / 2.0)), 0.5);
                let k4 = f(&(x + k3 * h), 1.0);
                x += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0);
            }
        }
        x
    };
    let mut error = |n: usize| (end(n) - exact(n)).amax();
    let (coarse, fine) = (error(12), error(24));
    let order = (coarse / fine).log2();
    assert!((3.5..4.6).contains(&order), "order {order:.2}: {coarse:.2e} {fine:.2e}");
}

/// The optimum itself converges with about second order: piecewise linear inputs on their rate limits,
/// trapezoidal cost.
#[test]
fn closed_form_optimum_converges_with_about_second_order() {
    let (vehicle, environment) = titan();
    let plans: Vec<Arc<Trajectory>> = [38, 75, 149, 297]
        .iter()
        .map(|&n| Arc::new(solve(&titan_problem(&vehicle, &environment, n)).trajectory))
        .collect();
    // Every node of the coarsest grid is a node of the others.
    let error = |plan: &Trajectory| {
        plans[0].nodes().iter().fold(0.0f64, |m, node| {
            m.max((plan.velocity_ned(node.t_s) - plans[3].velocity_ned(node.t_s)).norm())
        })
    };
    let errors: Vec<f64> = plans[..3].iter().map(|p| error(p)).collect();
    let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
    assert!(orders.iter().all(|o| (1.4..3.2).contains(o)), "errors {errors:.2?} m/s, orders {orders:.2?}");
}
