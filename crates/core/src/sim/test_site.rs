//! A small quadrotor under a canopy on Earth, for the tests of a drop and of the sessions that fly one.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use crate::model::environment::GeoPoint;
use crate::model::parachute::Pendulum;
use crate::model::rigid_body::MassProperties;
use crate::model::{
    BodyAero, Environment, Interference, Motor, Parachute, RotationSense, Rotor, RotorMount, Vehicle,
    VehicleOptions,
};
use crate::sim::{DropSimulation, Start};

pub const HANG_S: f64 = 2.0;
pub const DELAY_S: f64 = 0.5;

pub fn vehicle() -> Arc<Vehicle> {
    let mount = |x: f64, y: f64, spin| RotorMount {
        position_body_m: Vector3::new(x, y, 0.0),
        axis_body: Vector3::new(0.0, 0.0, -1.0),
        spin,
        interference: Interference::NONE,
    };
    let rotors = vec![
        mount(0.17, 0.17, RotationSense::Ccw),
        mount(-0.17, -0.17, RotationSense::Ccw),
        mount(0.17, -0.17, RotationSense::Cw),
        mount(-0.17, 0.17, RotationSense::Cw),
    ];
    let alpha: Vec<f64> = (0..=36).map(|i| (f64::from(i) * 10.0 - 180.0).to_radians()).collect();
    let (flat, none) = (vec![1.0; 37], vec![0.0; 37]);
    let aero = BodyAero::new(0.05, 0.5, &alpha, &flat, &none, &none).unwrap();
    let rotor = Rotor::Quadratic {
        thrust_n_per_rad2_s2: 1e-5,
        torque_per_thrust_m: 0.016,
        drag_n_s2_per_rad_m: 0.0,
        density_kg_m3: 1.225,
    };
    let motor = Motor::FirstOrder {
        omega_max_rad_s: 1_000.0,
        tau_up_s: 0.05,
        tau_down_s: 0.05,
        rotor_inertia_kg_m2: 1e-5,
    };
    let inertia = Matrix3::from_diagonal(&Vector3::new(0.02, 0.02, 0.03));
    let mass = MassProperties::new(2.0, inertia).unwrap();
    Arc::new(Vehicle::new(mass, rotors, aero, rotor, motor, VehicleOptions::default()).unwrap())
}

pub fn environment() -> Environment {
    let anchor = GeoPoint { latitude_deg: 47.4, longitude_deg: 8.5, altitude_m: 600.0 };
    Environment::new(9.80665, 1.225, Vector3::zeros(), anchor).unwrap()
}

pub fn drop_simulation() -> DropSimulation {
    drop_simulation_at(environment(), HANG_S)
}

pub fn drop_simulation_at(environment: Environment, hang_s: f64) -> DropSimulation {
    let pendulum = Pendulum { amplitude_rad: 0.0, phase_rad: 0.0, omega_rad_s: 2.0, length_m: 1.0 };
    let parachute = Parachute::new(5.0, DELAY_S, pendulum).unwrap();
    DropSimulation::new(vehicle(), environment, parachute, hang_s, Start::Release)
}
