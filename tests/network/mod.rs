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
//! cargo run --release --example network -- --seeds 100000     prints the seeds that fail, and why
//! cargo run --release --example network -- --seed 17          one run, with what was seen of it
//! ```
//!
//! A seed that fails becomes a fixed test in `tests`.

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

pub use trouble::{KINDS, Trouble};

/// The mission of 10 s, with its plan.
pub struct Flight {
    pub mission: Mission,
    pub plan: Trajectory,
}

/// What every run flies.
pub static FLIGHT: LazyLock<Flight> = LazyLock::new(|| {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/network_drop.json");
    let mission = load_mission(&file).unwrap();
    let options = SolverOptions::default();
    let solved = plan(&mission.plan_problem(), &Guess::StraightLine, &options, &mut |_| {
        std::ops::ControlFlow::Continue(())
    });
    Flight { plan: solved.unwrap().trajectory, mission }
});

/// Runs a seed: what came of it, and the properties that it breaks, in words.
pub fn run(seed: u64) -> (Trouble, Outcome, Vec<String>) {
    run_trouble(Trouble::of(seed))
}

/// Runs a trouble.
pub fn run_trouble(trouble: Trouble) -> (Trouble, Outcome, Vec<String>) {
    let outcome = world::World::new(&trouble).run();
    let broken = judge::broken(&trouble, &outcome);
    (trouble, outcome, broken)
}
