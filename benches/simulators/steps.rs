//! Steps of a quadrotor in six degrees of freedom, for comparing their cost with those of other simulators:
//! `steps ideal|actuator COUNT`.
#![expect(clippy::unwrap_used, clippy::print_stderr, reason = "a program for measuring")]

use samara::config::load_mission;
use samara::model::rigid_body::BodyState;
use samara::sim::{DropSimulation, PlantKind};

/// Length of a step [s].
const STEP_S: f64 = 0.004;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let kind = if arguments[1] == "ideal" { PlantKind::Ideal } else { PlantKind::Actuator };
    let count: u64 = arguments[2].parse().unwrap();
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("mission/x500_drop.json");
    let mission = load_mission(&file).unwrap();
    let release = mission.study.cases[2].state();
    let (vehicle, site) = (mission.vehicle, mission.site.environment);
    let mut flown = DropSimulation::at_t0(vehicle.clone(), site.clone(), release, kind);
    for step in 0..count {
        // Anew before it is far away, so that the air is that of a drop.
        if step % 5_000 == 4_999 {
            flown = DropSimulation::at_t0(vehicle.clone(), site.clone(), release, kind);
        }
        flown.step(&[0.55; samara::model::MAX_ROTORS], STEP_S);
    }
    let BodyState { p_ned, .. } = flown.state().body;
    // What is printed must be computed.
    eprintln!("{:.3} m down", p_ned.z);
}
