//! Cost of planning: whole solves, cold and warm, by the number of nodes, and one evaluation of dynamics and derivatives.
#![expect(clippy::unwrap_used, reason = "a bench without its vehicle has nothing to measure")]

mod nominal;

use divan::{Bencher, black_box};
use nalgebra::SVector;
use samara::model::trim;
use samara::plan::dynamics::{Dynamics, VehicleDynamics};
use samara::plan::problem::Nodes;
use samara::plan::vehicle::transcribe;

fn main() {
    divan::main();
}

#[divan::bench(args = [38, 75, 149])]
fn cold(bencher: Bencher<'_, '_>, nodes: usize) {
    let mission = nominal::titan();
    let mut problem = mission.plan_problem();
    problem.nodes = nodes;
    bencher.bench_local(|| nominal::solve_cold(black_box(&problem)));
}

/// Renewed a node later from a disturbed state, to 1e-6: in turn each of the problems met in a flight.
#[divan::bench(sample_size = 24)]
fn warm(bencher: Bencher<'_, '_>) {
    let mission = nominal::titan();
    let met = nominal::in_flight(&mission, 2);
    let mut turn = met.iter().cycle();
    bencher.bench_local(|| turn.next().map(|(problem, earlier)| nominal::solve_warm(problem, earlier)));
}

type X = SVector<f64, 10>;
type U = SVector<f64, 4>;

/// A state off every symmetry.
fn point() -> (VehicleDynamics<4>, X, U) {
    let mission = nominal::titan();
    let dynamics = VehicleDynamics::<4>::new(&mission.vehicle, &mission.site.environment).unwrap();
    (
        dynamics,
        X::from([0.99, 0.05, -0.08, 0.03, 2.0, -0.3, 4.1, 0.02, -0.1, 0.01]),
        U::from([210.0, 225.0, 215.0, 230.0]),
    )
}

#[divan::bench]
fn dynamics_value(bencher: Bencher<'_, '_>) {
    let (dynamics, x, u) = point();
    bencher.bench_local(|| dynamics.value(black_box(&x), black_box(&u)));
}

#[divan::bench]
fn dynamics_jacobian(bencher: Bencher<'_, '_>) {
    let (dynamics, x, u) = point();
    bencher.bench_local(|| dynamics.linearise(black_box(&x), black_box(&u)));
}

#[divan::bench]
fn dynamics_hessian(bencher: Bencher<'_, '_>) {
    let (dynamics, x, u) = point();
    let weights = X::from_fn(|i, _| 0.3 - 0.1 * i as f64);
    bencher.bench_local(|| dynamics.curvature(black_box(&x), black_box(&u), black_box(&weights)));
}

/// All defects with their Jacobians, and without.
#[divan::bench(args = [true, false])]
fn defects_with_jacobian(bencher: Bencher<'_, '_>, jacobian: bool) {
    let mission = nominal::titan();
    let problem = mission.plan_problem();
    let t = trim(&mission.vehicle, &mission.site.environment, problem.target_v_ned, 0.0).unwrap();
    let nlp = transcribe::<4>(&problem, &t.q_ned_from_body, &t.thrust_n).unwrap();
    let (_, x, u) = point();
    let nodes = Nodes { x: vec![x; problem.nodes], u: vec![u; problem.nodes] };
    if jacobian {
        bencher.bench_local(|| nlp.linearise(black_box(&nodes)));
    } else {
        bencher.bench_local(|| nlp.evaluate(black_box(&nodes)));
    }
}
