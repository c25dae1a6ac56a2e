//! A fleet against its vehicles one by one.

use super::fleet::{Fleet, FleetState};
use super::limits::{SafetyLimits, StateCost};
use super::{DropSimulation, PlantKind, test_site};
use crate::frames::quaternion_from_euler;
use crate::model::rigid_body::BodyState;
use crate::model::{MAX_ROTORS, PerRotor};
use nalgebra::Vector3;

const LIMITS: SafetyLimits =
    SafetyLimits { speed_m_s: 20.0, pitch_rad: 0.8, pitch_rate_rad_s: 4.0, vertical_acceleration_m_s2: 20.0 };

const DT_S: f64 = 0.004;
const STEPS: usize = 500;

/// A vehicle at t = 0, a little otherwise for each number.
fn vehicle(number: usize) -> DropSimulation {
    let x = number as f64;
    let body = BodyState {
        p_ned: Vector3::zeros(),
        v_ned: Vector3::new(0.1 * x, -0.05 * x, 9.0),
        q_ned_from_body: quaternion_from_euler(0.02 * x, -0.03 * x, 0.1 * x),
        omega_body: Vector3::new(0.1, -0.02 * x, 0.0),
    };
    DropSimulation::at_t0(test_site::vehicle(), test_site::environment(), body, PlantKind::Actuator)
}

/// Throttles of a vehicle at a step: those of the last vehicles turn them over.
fn throttle(number: usize, step: usize) -> PerRotor {
    let mut throttle = [0.0; MAX_ROTORS];
    for (rotor, share) in throttle.iter_mut().enumerate().take(4) {
        let wave = ((7 * number + 3 * rotor + step / 20) % 11) as f64 / 11.0;
        let lift = if rotor == 0 && number >= 6 { 0.5 } else { 0.0 };
        *share = 0.4 + 0.1 * wave + lift;
    }
    throttle
}

fn one_by_one(count: usize) -> Vec<FleetState> {
    let fly = |number: usize| {
        let mut vehicle = vehicle(number);
        (0..STEPS).for_each(|step| {
            vehicle.step(&throttle(number, step), DT_S);
        });
        let state = *vehicle.state();
        let cost = StateCost::of(&state.body, &LIMITS);
        let over = vehicle.has_turned_over();
        let cost = if over { cost.turned_over(&LIMITS) } else { cost };
        FleetState { state, j_state: cost.max(), bus_v: None }
    };
    (0..count).map(fly).collect()
}

#[test]
fn reference_a_fleet_flies_as_its_vehicles_do_one_by_one() {
    for count in [1, 2, 3, 8, 11] {
        let mut fleet = Fleet::new((0..count).map(vehicle).collect());
        for step in 0..STEPS {
            let throttle: Vec<PerRotor> = (0..count).map(|number| throttle(number, step)).collect();
            fleet.step(&throttle, DT_S);
        }
        let mut seen = Vec::new();
        fleet.look(&LIMITS, &mut |number, state| {
            assert_eq!(number, seen.len());
            seen.push(*state);
        });
        assert_eq!(seen, one_by_one(count));
        let turned = |state: &FleetState| state.j_state >= std::f64::consts::PI / LIMITS.pitch_rad;
        assert_eq!(seen.iter().any(turned), count > 6);
    }
}

#[test]
fn vehicles_without_throttles_stand_their_motors() {
    let mut fleet = Fleet::new((0..9).map(vehicle).collect());
    fleet.step(&[], DT_S);
    let mut alone = vehicle(8);
    alone.step(&[0.0; MAX_ROTORS], DT_S);
    fleet.look(&LIMITS, &mut |number, seen| {
        assert!(number != 8 || seen.state == *alone.state());
    });
}
