//! The problems that the benches solve: the nominal drop on Titan, and its plan renewed in flight.

use std::ops::ControlFlow;
use std::path::Path;

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use samara::config::{Mission, load_mission};
use samara::plan::{Guess, Plan, PlanProblem, SolverOptions, plan};

/// The Titan mission as shipped.
pub fn titan() -> Mission {
    load_mission(&Path::new(env!("CARGO_MANIFEST_DIR")).join("mission/titan_paper.json")).unwrap()
}

/// Cold, to 1e-8.
pub fn solve_cold(problem: &PlanProblem<'_>) -> Plan {
    plan(problem, &Guess::StraightLine, &SolverOptions::default(), &mut |_| ControlFlow::Continue(()))
        .unwrap()
}

/// A node after `earlier` was made, from where it leads; to 1e-6.
pub fn solve_warm(problem: &PlanProblem<'_>, earlier: &Plan) -> Plan {
    let options = SolverOptions { tolerance: 1e-6, ..SolverOptions::default() };
    let guess = earlier.moved_on(1);
    plan(problem, &guess, &options, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// Problems met in flight: the nominal plan renewed at each of its nodes 1 to 24, each time from a state that is off by
/// up to 0.05 m/s and 0.02 rad/s, with the plan that each starts from.
pub fn in_flight(mission: &Mission, seed: u64) -> Vec<(PlanProblem<'_>, Plan)> {
    let nominal = mission.plan_problem();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut current = solve_cold(&nominal);
    let mut met = Vec::new();
    for _ in 0..24 {
        let node = current.trajectory.nodes()[1];
        let mut problem = nominal.clone();
        let (q, v, w) = (node.q_ned_from_body, node.v_ned, node.omega_body);
        problem.initial = [q[0], q[1], q[2], q[3], v.x, v.y, v.z, w.x, w.y, w.z];
        for i in 4..10 {
            let within = 2.0 * (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64 - 1.0;
            problem.initial[i] += within * if i < 7 { 0.05 } else { 0.02 };
        }
        problem.initial_thrust_n = node.thrust_n;
        let next = solve_warm(&problem, &current);
        met.push((problem, std::mem::replace(&mut current, next)));
    }
    met
}
