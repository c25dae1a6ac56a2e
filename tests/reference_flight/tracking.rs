//! RMS distance from the plan, (45), on both plants.

use samara::assess::TrackingError;
use samara::assess::tracking::{DIVERGED, control_period_s};
use samara::control::Gains;
use samara::sim::{DropSimulation, FlightPlan, PlantKind, Reference, fly};
use samara::tune::release_cases::TABLE_3;

use crate::data::{NUMBERS, TITAN, cascade, flight_reference, number, numbers, plan, safety_gains, site};

fn rms(gains: Gains, kind: PlantKind, case: usize) -> f64 {
    let (velocity, plan) = (flight_reference(), plan());
    let flight = FlightPlan {
        reference: Reference::Plan { trajectory: &velocity, then_v_ned: None, feed_forward: false },
        yaw_sp_rad: 0.0,
        control_period_s: control_period_s(&plan),
        setpoint_period_s: None,
        duration_s: plan.end_s(),
    };
    let mut sim = DropSimulation::at_t0(TITAN.clone(), site(), TABLE_3[case].state(), kind);
    let mut error = TrackingError::new(&plan);
    let _ = fly(&mut sim, &mut cascade(gains), &flight, &mut |s| error.observe(s));
    error.rms()
}

/// The reference's plan here is one solved to an IPOPT default tolerance; its attitudes are known to 3e-6.
const BAR: f64 = 3e-7;

#[test]
fn reference_tracking_rms_on_both_plants() {
    for (key, kind) in [("ideal_plant", PlantKind::Ideal), ("actuator_plant", PlantKind::Actuator)] {
        for (name, gains) in [("NH", Gains::near_hover()), ("PSO", Gains::paper_pso())] {
            for (case, wanted) in numbers(&NUMBERS["tracking_rms"][key][name]).iter().enumerate() {
                let found = rms(gains, kind, case);
                assert!((found - wanted).abs() < BAR, "{key} {name} case {case}: {:.2e}", found - wanted);
            }
        }
    }
}

#[test]
fn reference_tracking_rms_of_tuned_gains() {
    for (key, kind) in
        [("ideal_plant_best_knife_edge", PlantKind::Ideal), ("actuator_plant_best", PlantKind::Actuator)]
    {
        let table = &NUMBERS["tracking_rms"][key];
        let gains = Gains::longitudinal(numbers(&table["gains"]).try_into().unwrap());
        for (case, wanted) in numbers(&table["per_case"]).iter().enumerate() {
            let found = rms(gains, kind, case);
            assert!((found - wanted).abs() < BAR, "{key} case {case}: {:.2e}", found - wanted);
        }
    }
    let worst = (0..7).map(|case| rms(safety_gains(), PlantKind::Actuator, case)).fold(0.0, f64::max);
    let wanted = number(&NUMBERS["safety_gains_rms_worst_actuator_plant"]);
    assert!((worst - wanted).abs() < BAR, "{:.2e}", worst - wanted);
}

/// A controller that lets the vehicle tumble is given up, not followed to the end.
#[test]
fn diverged_flight_costs_a_thousand() {
    let gains = Gains { k_pq: 0.0, k_iq: 5.0, ..Gains::near_hover() };
    assert_eq!(rms(gains, PlantKind::Actuator, 1), DIVERGED);
}
