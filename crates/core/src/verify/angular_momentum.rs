//! Rotors that speed up where there is no air turn the body the other way: together they keep their angular
//! momentum.

use std::sync::Arc;

use nalgebra::Vector3;

use super::motion::level;
use super::{Check, CheckGroup};
use crate::frames::rotate_ned_from_body;
use crate::model::{Environment, PerRotor, Vehicle, VehicleOptions};
use crate::sim::{DropSimulation, PlantKind, PlantState};

/// Angular momentum of body and rotors without air, for a turning quadrotor whose rotors are driven at unlike
/// speeds for a second.
pub fn without_air(vehicle: &Vehicle, environment: &Environment) -> CheckGroup {
    const THROTTLE: PerRotor = [0.9, 0.3, 0.5, 0.2, 0.7, 0.4, 0.8, 0.1];
    let options = VehicleOptions { reaction_torque: true, rotor_momentum: true };
    let vehicle = Arc::new(Vehicle { options, ..vehicle.clone() });
    let airless = Environment { density_kg_m3: 1e-30, ..environment.clone() };
    let start = level(Vector3::zeros(), Vector3::new(0.8, -0.5, 0.3));
    let mut sim = DropSimulation::at_t0(Arc::clone(&vehicle), airless, start, PlantKind::Actuator);
    let momentum = |state: &PlantState| {
        let rotors =
            vehicle.rotors.iter().zip(state.rotor_speed).fold(Vector3::zeros(), |sum, (rotor, speed)| {
                sum + rotor.axis_body * (rotor.spin.sign() * speed * vehicle.motor.rotor_inertia_kg_m2())
            });
        let body = vehicle.mass.inertia_kg_m2 * state.body.omega_body;
        rotate_ned_from_body(state.body.q_ned_from_body, body + rotors)
    };
    let before = momentum(sim.state());
    for _ in 0..4000 {
        sim.step(&THROTTLE, 0.000_25);
    }
    let after = momentum(sim.state());
    CheckGroup {
        title: "Quadrotor whose rotors speed up without air, 1 s",
        source: "(19)-(22): body and rotors keep their angular momentum in NED",
        checks: vec![Check::worst(
            "angular momentum, worst axis",
            "N m s",
            (0..3).map(|i| (after[i], before[i])),
            1e-12,
        )],
    }
}
