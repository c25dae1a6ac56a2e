//! The batch engine, on the Titan vehicle: against the code for flight in space, and against the reference's numbers.

use std::ops::ControlFlow;

use nalgebra::Vector3;
use samara::assess::tracking::control_period_s;
use samara::assess::{Outcome, Study, TrackingError, Verdict, VerdictBuilder, judge_flights};
use samara::control::{ControlLimits, Gains};
use samara::sim::planar::{Flight, Model, Release, Variation};
use samara::sim::{DropSimulation, FlightPlan, PlantKind, Reference, fly};
use samara::trajectory::Trajectory;
use samara::tune::release_cases::TABLE_3;
use samara::units::RAD_PER_DEG;

use crate::data::{
    NUMBERS, TITAN, cascade, flight_reference, gains, limits, numbers, plan, site, target_ned,
};

fn model(kind: PlantKind) -> Model {
    Model::new(&TITAN, &site(), &ControlLimits::default(), kind).unwrap()
}

fn flights(gains: Gains) -> Vec<Flight> {
    let flight = |case: &samara::tune::release_cases::ReleaseCase| Flight {
        gains,
        release: Release::of(&case.state()).unwrap(),
        variation: Variation::NONE,
    };
    TABLE_3.iter().map(flight).collect()
}

fn judged(kind: PlantKind, gains: Gains, plan: &FlightPlan<'_>, nodes: &Trajectory) -> Vec<Outcome> {
    let study = Study::new(plan, Some(nodes), limits(), [target_ned().x, target_ned().z]).unwrap();
    let flights = flights(gains);
    let mut outcomes = vec![Outcome::default(); flights.len()];
    judge_flights(&model(kind), &study, &flights, &mut outcomes);
    outcomes
}

fn in_space(
    kind: PlantKind,
    gains: Gains,
    plan: &FlightPlan<'_>,
    nodes: &Trajectory,
    case: usize,
) -> (f64, Verdict) {
    let mut sim = DropSimulation::at_t0(TITAN.clone(), site(), TABLE_3[case].state(), kind);
    let (mut error, mut verdict) = (TrackingError::new(nodes), VerdictBuilder::new(limits(), target_ned()));
    let _ = fly(&mut sim, &mut cascade(gains), plan, &mut |s| {
        verdict.observe(s);
        error.observe(s)
    });
    assert_eq!(ControlFlow::Continue(()), ControlFlow::<()>::Continue(()));
    (error.rms(), verdict.finish().unwrap())
}

/// Seven releases, three controllers, step and plan, both plants.
#[test]
fn prop_batch_flights_are_the_flights_in_space() {
    let (velocity, nodes) = (flight_reference(), plan());
    for kind in [PlantKind::Ideal, PlantKind::Actuator] {
        for name in ["near_hover", "paper_pso", "safety"] {
            for step in [false, true] {
                let reference = if step {
                    Reference::Step(target_ned())
                } else {
                    Reference::Plan {
                        trajectory: &velocity,
                        then_v_ned: Some(target_ned()),
                        feed_forward: false,
                    }
                };
                let flight = FlightPlan {
                    reference,
                    yaw_sp_rad: 0.0,
                    control_period_s: control_period_s(&nodes),
                    setpoint_period_s: None,
                    duration_s: nodes.end_s() + 4.0,
                };
                let found = judged(kind, gains(name), &flight, &nodes);
                for (case, found) in found.iter().enumerate() {
                    let (rms, verdict) = in_space(kind, gains(name), &flight, &nodes, case);
                    let what = format!("{kind:?} {name} step {step} case {case}");
                    println!("{what}: {:e} {:e}", found.rms - rms, found.j_tpf - verdict.j_tpf);
                }
            }
        }
    }
}
