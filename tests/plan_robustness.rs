//! The planner from releases that are far from nominal, and warm-started.
#![cfg(feature = "files")]

#[path = "plan_reference.rs"]
mod reference;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use samara::frames::quaternion_from_euler;
use samara::plan::solver::Status;

fn uniform(rng: &mut ChaCha8Rng, half_width: f64) -> f64 {
    (2.0 * (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64 - 1.0) * half_width
}

/// 300 random releases: pitch +-25 deg, rate +-45 deg/s, velocity +-1.5 m/s, half of them with roll +-15 deg,
/// sideways speed +-1 m/s and roll rate +-0.3 rad/s. All converge, in under 20 iterations in the median.
#[test]
fn prop_random_releases_converge() {
    let (vehicle, environment) = reference::titan();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let deg = samara::units::RAD_PER_DEG;
    let mut iterations = Vec::new();
    let mut failures = Vec::new();
    for i in 0..300 {
        let (pitch, rate) = (uniform(&mut rng, 25.0 * deg), uniform(&mut rng, 45.0 * deg));
        let (vn, vd) = (uniform(&mut rng, 1.5), 3.675 + uniform(&mut rng, 1.5));
        let lateral = [uniform(&mut rng, 15.0 * deg), uniform(&mut rng, 1.0), uniform(&mut rng, 0.3)];
        let [roll, ve, p] = if i % 2 == 1 { lateral } else { [0.0; 3] };
        let q = quaternion_from_euler(roll, pitch, 0.0);
        let mut problem = reference::titan_problem(&vehicle, &environment, 38);
        problem.initial = [q[0], q[1], q[2], q[3], vn, ve, vd, p, rate, 0.0];
        let plan = reference::solve(&problem);
        iterations.push(plan.work.iterations);
        if plan.status != Status::Converged || plan.kkt_residual > 1e-8 || plan.defect_max > 1e-8 {
            failures.push(format!("{i}: {:?} {:?}", plan.status, plan.diagnosis));
        }
        if plan.work.iterations > 40 {
            println!("{i} {:?} {}", plan.work, plan.objective);
        }
    }
    iterations.sort_unstable();
    println!("iterations: median {}, 95 % {}, worst {}", iterations[150], iterations[285], iterations[299]);
    assert!(failures.is_empty(), "{} failures: {failures:#?}", failures.len());
    assert!(iterations[150] < 20);
}
