//! Solves the planner's problems a given number of times and prints one line of JSON: what `benches/instructions` counts
//! instructions of and `benches/casadi/run` compares with IPOPT.
//!
//! `solves cold|warm|none [ROUNDS]`: a round is the nominal cold solve, or the 24 warm solves of one flight; `none` only
//! prepares. CPU time is the thread's own as Linux counts it, in steps of some milliseconds: only the mean over many
//! solves says anything.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a bench: without its problem there is nothing to measure"
)]

#[path = "mod.rs"]
mod nominal;

use samara::plan::{Plan, Status};

/// CPU time of this thread [ms]; `None` where there is no such file.
#[expect(clippy::disallowed_methods, reason = "the kernel's count of CPU time is a file")]
fn cpu_ms() -> Option<f64> {
    let counts = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(counts.split_whitespace().next()?.parse::<f64>().ok()? * 1e-6)
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let what = arguments.next().unwrap_or_default();
    let rounds: usize = arguments.next().map_or(1, |n| n.parse().unwrap());
    let mission = nominal::titan();
    let nominal = mission.plan_problem();
    let met = nominal::in_flight(&mission, 2);
    let mut iterations = Vec::new();
    let mut objective = f64::NAN;
    let mut done = |plan: Plan| {
        assert_eq!(plan.status, Status::Converged);
        iterations.push(plan.counts.iterations);
        objective = plan.objective;
    };
    let before = cpu_ms();
    for _ in 0..rounds {
        match what.as_str() {
            "cold" => done(nominal::solve_cold(&nominal)),
            "warm" => met.iter().for_each(|(problem, earlier)| done(nominal::solve_warm(problem, earlier))),
            _ => {}
        }
    }
    let spent = cpu_ms().zip(before).map_or(f64::NAN, |(after, before)| after - before);
    iterations.sort_unstable();
    if let Some(worst) = iterations.last() {
        println!(
            "{{\"solves\": {n}, \"cpu_ms_mean\": {:.4}, \"iterations_median\": {}, \"iterations_worst\": {worst}, \"objective\": {objective:.9}}}",
            spent / iterations.len() as f64,
            iterations[iterations.len() / 2],
            n = iterations.len(),
        );
    }
}
