//! RMS distance from the plan, (45), on both plants.

use samara::assess::TrackingError;
use samara::assess::tracking::control_period_s;
use samara::control::Gains;
use samara::sim::{DropSimulation, FlightPlan, PlantKind, Reference, fly};

use super::data::{NUMBERS, TABLE_3, TITAN, cascade, flight_reference, gains, number, numbers, plan, site};

fn rms(gains: Gains, kind: PlantKind, case: usize) -> f64 {
    let (velocity, plan) = (flight_reference(), plan());
    let flight = FlightPlan::new(
        Reference::Plan { trajectory: &velocity, then_v_ned: None, feed_forward: false },
        control_period_s(&plan),
        plan.end_s(),
    );
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
        for (name, file) in [("NH", "near_hover"), ("PSO", "paper_pso")] {
            for (case, wanted) in numbers(&NUMBERS["tracking_rms"][key][name]).iter().enumerate() {
                let found = rms(gains(file), kind, case);
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
        let tuned = Gains::longitudinal(numbers(&table["gains"]).try_into().unwrap());
        for (case, wanted) in numbers(&table["per_case"]).iter().enumerate() {
            let found = rms(tuned, kind, case);
            assert!((found - wanted).abs() < BAR, "{key} case {case}: {:.2e}", found - wanted);
        }
    }
    let worst = (0..7).map(|case| rms(gains("safety"), PlantKind::Actuator, case)).fold(0.0, f64::max);
    let wanted = number(&NUMBERS["safety_gains_rms_worst_actuator_plant"]);
    assert!((worst - wanted).abs() < BAR, "{:.2e}", worst - wanted);
}
