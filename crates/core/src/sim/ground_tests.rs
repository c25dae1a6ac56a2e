//! The ground against closed forms.

use std::sync::Arc;

use nalgebra::Vector3;

use super::ground::{CONTACT_FREQUENCY_RAD_S, FRICTION, Ground};
use super::{DropSimulation, PlantKind};
use crate::control::test_vehicles::{quadrotor, site};
use crate::frames::{LEVEL, quaternion_from_euler, roll};
use crate::math;
use crate::model::rigid_body::BodyState;
use crate::model::{Environment, MAX_ROTORS, Vehicle, VehicleOptions};

const OFF: [f64; MAX_ROTORS] = [0.0; MAX_ROTORS];
const STEP_S: f64 = 0.004;
const GROUND: Ground = Ground { down_m: 20.0 };

fn vehicle() -> Arc<Vehicle> {
    Arc::new(quadrotor([0.9, 1.1], [250.0, 300.0, 400.0], [0.0; 3], VehicleOptions::default()))
}

/// Hardly any air, so that the closed forms hold.
fn thin_air() -> Environment {
    Environment::new(site().gravity_m_s2, 1e-9, Vector3::zeros(), site().anchor).unwrap()
}

fn falling(height_m: f64, v_ned: [f64; 3], q: [f64; 4]) -> DropSimulation {
    let state = BodyState {
        p_ned: Vector3::new(0.0, 0.0, GROUND.down_m - height_m),
        q_ned_from_body: q,
        v_ned: v_ned.into(),
        omega_body: Vector3::zeros(),
    };
    DropSimulation::at_t0(vehicle(), thin_air(), state, PlantKind::Actuator).above(GROUND)
}

#[test]
fn closed_form_what_stands_weighs_its_weight_and_stays() {
    let mut sim = DropSimulation::standing(vehicle(), thin_air(), GROUND);
    let before = *sim.state();
    for _ in 0..2500 {
        sim.step(&OFF, STEP_S);
    }
    let weight = sim.vehicle().mass.mass_kg * sim.environment().gravity_m_s2;
    let balance = sim.balance(&OFF);
    assert!((balance.ground_force_ned - Vector3::new(0.0, 0.0, -weight)).norm() < 1e-9 * weight);
    assert!(balance.ground_moment_body.norm() < 1e-9 * weight);
    assert!((sim.state().body.p_ned - before.body.p_ned).norm() < 1e-9);
    assert!(sim.on_ground());
    let specific = sim.specific_force_body();
    assert!((specific.z + sim.environment().gravity_m_s2).abs() < 1e-9, "an accelerometer at rest");
}

/// From a height h it arrives at sqrt(2 g h) and goes `v/(e w)` deep; where the spring would begin to pull,
/// 2/w later, it leaves with `v e^-2`; in the end it rests. (Gravity changes that but a little at such a
/// speed.)
#[test]
fn closed_form_a_fall_arrives_at_its_speed_and_comes_to_rest() {
    let mut sim = falling(5.0, [0.0; 3], LEVEL);
    let g = sim.environment().gravity_m_s2;
    let mut fastest: f64 = 0.0;
    while !sim.on_ground() {
        fastest = sim.state().body.v_ned.z;
        sim.step(&OFF, STEP_S);
    }
    let arrives = (2.0 * g * 5.0).sqrt();
    assert!((fastest - arrives).abs() < 1.5 * g * STEP_S, "{fastest} {arrives}");
    let (mut deepest, mut leaves) = (0.0f64, 0.0f64);
    for _ in 0..5000 {
        sim.step(&OFF, STEP_S);
        deepest = deepest.max(sim.state().body.p_ned.z - GROUND.down_m);
        leaves = leaves.max(-sim.state().body.v_ned.z);
    }
    let closed = arrives / (std::f64::consts::E * CONTACT_FREQUENCY_RAD_S);
    assert!((deepest / closed - 1.0).abs() < 0.1, "{deepest} {closed}");
    assert!((leaves / (arrives * math::exp(-2.0f64)) - 1.0).abs() < 0.1, "{leaves} {arrives}");
    assert!(sim.state().body.v_ned.norm() < 1e-6);
}

/// Sliding at v it comes to rest after v^2/(2 mu g).
#[test]
fn closed_form_friction_stops_a_slide() {
    let g = site().gravity_m_s2;
    let mut sim = falling(-g / CONTACT_FREQUENCY_RAD_S.powi(2), [3.0, 0.0, 0.0], LEVEL);
    for _ in 0..2500 {
        sim.step(&OFF, STEP_S);
    }
    let way = 9.0 / (2.0 * FRICTION * g);
    let slid = sim.state().body.p_ned.x;
    assert!((slid / way - 1.0).abs() < 0.02, "{slid} {way}");
    assert!(sim.state().body.v_ned.norm() < 1e-6);
}

#[test]
fn closed_form_what_lands_on_one_foot_comes_to_stand_level() {
    let mut sim = falling(1.5, [0.3, 0.2, 0.0], quaternion_from_euler(0.3, -0.2, 1.0));
    for _ in 0..5000 {
        sim.step(&OFF, STEP_S);
    }
    let body = &sim.state().body;
    assert!(roll(body.q_ned_from_body).abs() < 1e-6 && body.omega_body.norm() < 1e-6);
    assert!((body.p_ned.z - GROUND.standing_down_m(site().gravity_m_s2)).abs() < 1e-6);
}

/// However it arrives, it comes to lie or slides on.
#[test]
fn prop_hard_impacts_in_any_attitude_stay_bounded() {
    for (i, speed) in [5.0, 15.0, 40.0].into_iter().enumerate() {
        for angle in [0.0, 1.0, 2.0, 3.0] {
            let mut sim =
                falling(1.0, [speed, 0.0, speed], quaternion_from_euler(angle, 0.3 * i as f64, 0.0));
            for _ in 0..2500 {
                sim.step(&OFF, STEP_S);
            }
            let body = &sim.state().body;
            assert!(
                body.v_ned.z.abs() < 1.0 && body.v_ned.norm() < 0.5 * speed,
                "{speed} {angle}: {}",
                body.v_ned
            );
            assert!((body.p_ned.z - GROUND.down_m).abs() < 3.0);
        }
    }
}
