//! Cost of the batch engine: a generation of the swarm's flights (70 particles, 7 releases, 30 s at 100 Hz) on one thread, and eight
//! flights side by side. `benches/numba/run` puts the same beside numba.
#![expect(clippy::unwrap_used, reason = "a bench without its vehicle has nothing to measure")]

use divan::Bencher;
use samara::assess::Outcome;
use samara::sim::PlantKind;

mod swarm;

fn main() {
    divan::main();
}

#[divan::bench(args = [PlantKind::Ideal, PlantKind::Actuator])]
fn eight_flights(bencher: Bencher<'_, '_>, kind: PlantKind) {
    bench(bencher, kind, 8);
}

#[divan::bench(args = [PlantKind::Ideal, PlantKind::Actuator], sample_count = 20)]
fn generation_of_490_flights(bencher: Bencher<'_, '_>, kind: PlantKind) {
    bench(bencher, kind, 490);
}

fn bench(bencher: Bencher<'_, '_>, kind: PlantKind, n: usize) {
    let swarm = swarm::Swarm::new(kind, 4);
    let flights = swarm::flights(n);
    let mut outcomes = vec![Outcome::default(); n];
    bencher.bench_local(|| {
        swarm.fly(&flights, &mut outcomes, 1);
        outcomes[0]
    });
}
