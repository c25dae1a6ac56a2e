//! The whole drop in a seeded network, in memory: simulator with parachute, autopilot, streamer and an
//! operator, the real sessions behind the real hubs, with a key or without, and between them a network that
//! loses, doubles, delays, reorders and holds up, with stalled and restarted parties, strangers, clocks that
//! differ and a second vehicle. One seed is one run.
//!
//! | file | holds |
//! |---|---|
//! | `world` | everything together: events in the order of virtual wall time, and how acts are done |
//! | `wire` | addresses, hosts, what is on its way |
//! | `process` | a session with its sockets |
//! | `turns` | what a host does when it has its turn |
//! | `operator` | a ground station that speaks and wants something |
//! | `trouble` | what a seed brings: what the wire does, and who does what when |
//! | `frames` | what strangers and mad parties send |
//! | `seen` | what was seen of a run |
//! | `judge` | what must hold in every run |
//!
//! ```sh
//! # the seeds that fail, and why
//! cargo run --release --package samara-network --example network -- --seeds 100000
//! # one run, with what was seen of it
//! cargo run --release --package samara-network --example network -- --seed 17
//! ```
//!
//! A seed that fails becomes a fixed test in `tests`.
#![expect(clippy::print_stdout, clippy::unwrap_used, reason = "a program of the tests")]

mod frames;
mod judge;
mod operator;
mod process;
mod seen;
mod trouble;
mod turns;
mod wire;
mod world;

#[cfg(test)]
mod tests;

use std::path::Path;
use std::sync::LazyLock;

use samara::config::{Mission, load_mission};
use samara::plan::{Guess, SolverOptions, plan};
use samara::trajectory::Trajectory;

use seen::Outcome;

use trouble::{KINDS, Trouble};

/// The mission of 10 s, with its plan.
struct Flight {
    mission: Mission,
    plan: Trajectory,
}

/// What every run flies.
static FLIGHT: LazyLock<Flight> = LazyLock::new(|| {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/network_drop.json");
    let mission = load_mission(&file).unwrap();
    let options = SolverOptions::default();
    let solved = plan(&mission.plan_problem(), &Guess::StraightLine, &options, &mut |_| {
        std::ops::ControlFlow::Continue(())
    });
    Flight { plan: solved.unwrap().trajectory, mission }
});

/// Runs a seed: what came of it, and the properties that it breaks, in words.
fn run(seed: u64) -> (Trouble, Outcome, Vec<String>) {
    run_trouble(Trouble::of(seed))
}

/// Runs a trouble.
fn run_trouble(trouble: Trouble) -> (Trouble, Outcome, Vec<String>) {
    let outcome = world::World::new(&trouble).run();
    let broken = judge::broken(&trouble, &outcome);
    (trouble, outcome, broken)
}

fn main() -> std::process::ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize| arguments.get(i).and_then(|text| text.parse::<u64>().ok());
    match (arguments.first().map(String::as_str), number(1)) {
        (Some("--seed"), Some(seed)) => one(seed),
        (Some("--seeds"), Some(seeds)) => many(number(2).unwrap_or(0), seeds),
        _ => {
            println!("expected --seed NUMBER, or --seeds HOW_MANY [FIRST]");
            std::process::ExitCode::from(2)
        }
    }
}

/// One run with its story.
fn one(seed: u64) -> std::process::ExitCode {
    let (trouble, mut seen, broken) = run(seed);
    for line in std::mem::take(&mut seen.story) {
        println!("{line}");
    }
    println!("seed {seed}: {:?} at speed {}, {:?}", trouble.kind, trouble.speed, trouble.trigger);
    println!("{seen:#?}");
    println!("broken: {broken:#?}");
    std::process::ExitCode::from(u8::from(!broken.is_empty()))
}

/// Many runs, those that fail, and how many there are of each kind.
fn many(first: u64, seeds: u64) -> std::process::ExitCode {
    let mut counts = KINDS.map(|kind| (kind, 0, 0, 0));
    let mut failed = false;
    for seed in first..first + seeds {
        let result = std::panic::catch_unwind(|| run(seed));
        let Ok((trouble, seen, broken)) = result else {
            println!("seed {seed}: a panic");
            failed = true;
            continue;
        };
        let count = counts.iter_mut().find(|c| c.0 == trouble.kind).unwrap();
        count.1 += 1;
        count.2 += u64::from(seen.simulator_yes);
        count.3 += u64::from(!broken.is_empty());
        if !broken.is_empty() {
            failed = true;
            println!("seed {seed} {:?}: {}", trouble.kind, broken.join("; "));
        }
    }
    for (kind, runs, good, failing) in counts {
        println!("{kind:?}: {runs} runs, {good} good drops, {failing} seeds fail");
    }
    std::process::ExitCode::from(u8::from(failed))
}
