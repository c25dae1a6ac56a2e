//! The swarm's problem, flown and timed: for counting instructions, and for comparison with the same in numba.
//!
//!   flights ideal|actuator FLIGHTS THREADS [ROUNDS [ROTORS [turbulent|VEHICLE]]]
//!
//! Prints per round the seconds of the wall, at the end the costs of the first 490 flights.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a program for measuring")]
#![expect(clippy::disallowed_methods, clippy::disallowed_types, reason = "a clock is what it is for")]

#[path = "../swarm/mod.rs"]
mod swarm;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize| arguments.get(i).map_or(1, |a| a.parse().unwrap());
    let kind = match arguments[0].as_str() {
        "ideal" => samara::sim::PlantKind::Ideal,
        _ => samara::sim::PlantKind::Actuator,
    };
    let rotors = arguments.get(4).map_or(4, |a| a.parse().unwrap());
    let swarm = match arguments.get(5).map(String::as_str) {
        None => swarm::Swarm::new(kind, rotors),
        Some("turbulent") => swarm::Swarm::in_air(kind, rotors, &swarm::turbulent(), "titan"),
        Some(vehicle) => swarm::Swarm::in_air(kind, rotors, &Default::default(), vehicle),
    };
    let flights = swarm::flights(number(1));
    let mut outcomes = vec![samara::assess::BatchFlight::default(); flights.len()];
    for _ in 0..number(3) {
        let start = std::time::Instant::now();
        swarm.fly(&flights, &mut outcomes, number(2));
        println!("seconds {:.6}", start.elapsed().as_secs_f64());
    }
    for o in outcomes.iter().take(490) {
        println!("cost {:?} {:?}", o.rms, o.outcome.j_tpf);
    }
}
