//! Cost of the batch engine: a generation of the swarm's flights (70 particles, 7 releases, 30 s at 100 Hz) on one thread, and eight
//! flights side by side. `benches/numba/run` puts the same beside numba.
#![expect(clippy::unwrap_used, reason = "a bench without its vehicle has nothing to measure")]

use divan::Bencher;
use samara::assess::BatchFlight;
use samara::sim::PlantKind;

mod swarm;

fn main() {
    divan::main();
}

#[divan::bench(args = [PlantKind::Ideal, PlantKind::Actuator])]
fn eight_flights(bencher: Bencher<'_, '_>, kind: PlantKind) {
    bench(bencher, &swarm::Swarm::new(kind, 4), 8);
}

#[divan::bench(args = [PlantKind::Ideal, PlantKind::Actuator])]
fn eight_flights_in_turbulence(bencher: Bencher<'_, '_>, kind: PlantKind) {
    bench(bencher, &swarm::Swarm::in_air(kind, 4, &swarm::turbulent(), "titan"), 8);
}

#[divan::bench(args = [PlantKind::Ideal, PlantKind::Actuator], sample_count = 20)]
fn generation_of_490_flights(bencher: Bencher<'_, '_>, kind: PlantKind) {
    bench(bencher, &swarm::Swarm::new(kind, 4), 490);
}

fn bench(bencher: Bencher<'_, '_>, swarm: &swarm::Swarm, n: usize) {
    let flights = swarm::flights(n);
    let mut outcomes = vec![BatchFlight::default(); n];
    bencher.bench_local(|| {
        swarm.fly(&flights, &mut outcomes, 1);
        outcomes[0]
    });
}
