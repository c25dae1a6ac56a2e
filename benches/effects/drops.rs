//! Whole drops of a mission with none or all of its effects, flown and timed: for counting instructions.
//!
//!   drops MISSION CAMPAIGN DROPS [one]
//!
//! The campaign is `none`, `all`, or the name of an effect, or `without_` it.
//! Eight side by side, or with `one` one after the other. Prints the seconds of the wall and the last J_TPF.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a program for measuring")]
#![expect(clippy::disallowed_methods, clippy::disallowed_types, reason = "a clock is what it is for")]

use std::ops::ControlFlow;

use samara::config::Mission;
use samara::plan::SolverOptions;
use samara::study::effects::{EffectFlights, EffectsOn};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mission = Mission::shipped(&arguments[0]).unwrap();
    let campaigns = EffectsOn::campaigns(&mission.effects());
    let on = campaigns.into_iter().find(|on| on.name() == arguments[1]).unwrap();
    let plan = mission.solve(&SolverOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
    let flights = EffectFlights::new(&mission, &on.kept(&mission.effects()), &plan.trajectory).unwrap();
    let start = std::time::Instant::now();
    let count: u64 = arguments[2].parse().unwrap();
    let drops: Vec<f64> = if arguments.len() > 3 {
        (0..count).map(|trial| flights.fly(trial).outcome.j_tpf).collect()
    } else {
        flights.fly_all(0..count).into_iter().map(|drop| drop.outcome.j_tpf).collect()
    };
    println!("seconds {:.6}, J_TPF {:?}", start.elapsed().as_secs_f64(), drops.last());
}
