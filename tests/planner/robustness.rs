//! Releases far from nominal, and plans renewed in flight.

use std::ops::ControlFlow;

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use samara::plan::{Guess, SolverOptions, Status, plan};
use samara::units::RAD_PER_DEG;

use super::problems::{solve, state, titan, titan_problem};

fn uniform(rng: &mut ChaCha8Rng, half_width: f64) -> f64 {
    (2.0 * (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64 - 1.0) * half_width
}

/// 300 random releases: pitch +-25 deg, rate +-45 deg/s, velocity +-1.5 m/s, half of them with roll +-15 deg,
/// sideways speed +-1 m/s and roll rate +-0.3 rad/s. All converge, in under 20 iterations in the median.
#[test]
fn prop_random_releases_converge() {
    let (vehicle, environment) = titan();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut iterations = Vec::new();
    for i in 0..300 {
        let (pitch, rate) = (uniform(&mut rng, 25.0 * RAD_PER_DEG), uniform(&mut rng, 45.0 * RAD_PER_DEG));
        let (vn, vd) = (uniform(&mut rng, 1.5), 3.675 + uniform(&mut rng, 1.5));
        let lateral = [uniform(&mut rng, 15.0 * RAD_PER_DEG), uniform(&mut rng, 1.0), uniform(&mut rng, 0.3)];
        let [roll, ve, p] = if i % 2 == 1 { lateral } else { [0.0; 3] };
        let mut problem = titan_problem(&vehicle, &environment, 38);
        problem.initial = state([roll, pitch, 0.0], [vn, ve, vd], [p, rate, 0.0]);
        let plan = solve(&problem);
        assert_eq!(plan.status, Status::Converged, "release {i}: {:?}", plan.diagnosis);
        assert!(plan.kkt_residual <= 1e-8 && plan.defect_max <= 1e-8, "release {i}");
        iterations.push(plan.counts.iterations);
    }
    iterations.sort_unstable();
    let [median, most] = [150, 285].map(|i| iterations[i]);
    assert!(median < 20 && most < 40, "iterations: median {median}, 95 % {most}, worst {}", iterations[299]);
}

/// Plans renewed in flight, node by node: moved on, disturbed by up to 0.05 m/s and 0.02 rad/s, primal and
/// dual kept, to 1e-6. (The yaw rate is left alone: without reaction torques nothing on this vehicle can take
/// a yaw rate away again, and it would add up from plan to plan.)
#[test]
fn prop_warm_starts_converge_in_fewer_iterations() {
    let (vehicle, environment) = titan();
    let problem = titan_problem(&vehicle, &environment, 38);
    let options = SolverOptions { tolerance: 1e-6, ..SolverOptions::default() };
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let (mut warm, mut cold) = (Vec::new(), Vec::new());
    for _ in 0..3 {
        let mut current = solve(&problem);
        for _ in 0..24 {
            let node = current.trajectory.nodes()[1];
            let mut next = problem.clone();
            let (q, v, w) = (node.q_ned_from_body, node.v_ned, node.omega_body);
            next.initial = [q[0], q[1], q[2], q[3], v.x, v.y, v.z, w.x, w.y, w.z];
            for i in 4..9 {
                next.initial[i] += uniform(&mut rng, if i < 7 { 0.05 } else { 0.02 });
            }
            next.initial_thrust_n = node.thrust_n;
            let attempt = |guess: &Guess| {
                let plan = plan(&next, guess, &options, &mut |_| ControlFlow::Continue(())).unwrap();
                assert_eq!(plan.status, Status::Converged, "{:?}", plan.diagnosis);
                plan
            };
            cold.push(attempt(&Guess::StraightLine).counts.iterations);
            let plan = attempt(&current.moved_on(1));
            warm.push(plan.counts.iterations);
            current = plan;
        }
    }
    warm.sort_unstable();
    cold.sort_unstable();
    let (w, c) = (warm[warm.len() / 2], cold[cold.len() / 2]);
    assert!(w <= 6 && 2 * w <= c, "median iterations: warm {w}, cold {c}");
}
