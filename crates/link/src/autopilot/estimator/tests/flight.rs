//! True flights for the estimator's tests: hang with a swing, fall, pull-out, flown on the truth, on Earth
//! and on Titan.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use crate::control::{Airframe, Cascade, ControlLimits, Controller as _, Gains, Measurement, Setpoint};
use crate::model::environment::GeoPoint;
use crate::model::parachute::Pendulum;
use crate::model::rigid_body::{BodyState, MassProperties};
use crate::model::{
    BodyAero, Environment, Interference, MAX_ROTORS, Motor, Parachute, RotationSense, Rotor, RotorMount,
    Vehicle, VehicleOptions,
};
use crate::sim::{DropSimulation, Start};

pub const STEP_US: u64 = 4_000;
pub const DT_S: f64 = 0.004;
pub const HANG_S: f64 = 8.0;
pub const DELAY_S: f64 = 0.5;

/// Gravity, density, latitude, and a thrust per weight of 2.2 whatever the gravity.
#[derive(Clone, Copy, Debug)]
pub struct Site {
    pub gravity_m_s2: f64,
    pub density_kg_m3: f64,
    pub field_ned_gauss: Vector3<f64>,
    pub descent_m_s: f64,
}

pub const EARTH: Site = Site {
    gravity_m_s2: 9.80665,
    density_kg_m3: 1.225,
    field_ned_gauss: Vector3::new(0.21, 0.01, 0.43),
    descent_m_s: 5.0,
};
pub const TITAN: Site = Site {
    gravity_m_s2: 1.35,
    density_kg_m3: 5.4,
    field_ned_gauss: Vector3::new(0.31, -0.02, 0.08),
    descent_m_s: 3.0,
};

/// The truth at a sample.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    pub at_us: u64,
    pub body: BodyState,
    pub specific_force_body: Vector3<f64>,
}

fn vehicle(site: &Site) -> Arc<Vehicle> {
    const MASS_KG: f64 = 2.0;
    const OMEGA_MAX_RAD_S: f64 = 800.0;
    let mounts = [
        (1.0, 1.0, RotationSense::Ccw),
        (-1.0, -1.0, RotationSense::Ccw),
        (1.0, -1.0, RotationSense::Cw),
        (-1.0, 1.0, RotationSense::Cw),
    ];
    let rotors = mounts.map(|(x, y, spin)| RotorMount {
        position_body_m: Vector3::new(0.2 * x, 0.2 * y, 0.0),
        axis_body: -Vector3::z(),
        spin,
        interference: Interference::NONE,
    });
    let turn = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|x| x * std::f64::consts::PI);
    let aero = BodyAero::new(0.05, 0.5, &turn, &[1.0; 5], &[0.0; 5], &[0.0; 5]).unwrap();
    let rotor = Rotor::Quadratic {
        thrust_n_per_rad2_s2: 2.2 * MASS_KG * site.gravity_m_s2 / (4.0 * OMEGA_MAX_RAD_S.powi(2)),
        torque_per_thrust_m: 0.016,
        drag_n_s2_per_rad_m: 0.0,
        density_kg_m3: site.density_kg_m3,
    };
    let motor = Motor::FirstOrder {
        omega_max_rad_s: OMEGA_MAX_RAD_S,
        tau_up_s: 0.05,
        tau_down_s: 0.05,
        rotor_inertia_kg_m2: 1e-5,
    };
    let inertia = Matrix3::from_diagonal(&Vector3::new(0.02, 0.02, 0.03));
    let mass = MassProperties::new(MASS_KG, inertia).unwrap();
    Arc::new(Vehicle::new(mass, rotors.to_vec(), aero, rotor, motor, VehicleOptions::default()).unwrap())
}

fn drop(site: &Site, vehicle: &Arc<Vehicle>, amplitude_rad: f64, phase_rad: f64) -> DropSimulation {
    let anchor = GeoPoint { latitude_deg: 47.0, longitude_deg: 8.0, altitude_m: 500.0 };
    let environment =
        Environment::new(site.gravity_m_s2, site.density_kg_m3, Vector3::new(0.5, -1.0, 0.0), anchor)
            .unwrap();
    let omega_rad_s = site.gravity_m_s2.sqrt();
    let pendulum = Pendulum { amplitude_rad, phase_rad, omega_rad_s, length_m: 1.0 };
    let parachute = Parachute::new(site.descent_m_s, DELAY_S, pendulum).unwrap();
    let mut sim = DropSimulation::new(vehicle.clone(), environment, parachute, HANG_S, Start::Release);
    sim.schedule_release(HANG_S);
    sim
}

/// A drop of `duration_s` [s], sampled every 4 ms from 4 ms on.
pub fn fly(site: &Site, amplitude_rad: f64, phase_rad: f64, duration_s: f64) -> Vec<Truth> {
    let vehicle = vehicle(site);
    let mut sim = drop(site, &vehicle, amplitude_rad, phase_rad);
    let airframe = Airframe::new(&vehicle, sim.environment()).unwrap();
    let mut cascade = Cascade::new(airframe, Gains::near_hover(), ControlLimits::default());
    let mut throttle = [0.0; MAX_ROTORS];
    let truth = |k: u64| {
        sim.step(&throttle, DT_S);
        let body = sim.state().body;
        if sim.time_powered_s().is_some_and(|t| t >= 0.0) {
            let (v_ned, a_ff_ned) = (Vector3::new(1.5, 1.0, 1.0), Vector3::zeros());
            let setpoint = Setpoint::Velocity { v_ned, a_ff_ned, yaw_rad: Some(0.0) };
            throttle = cascade.step(&Measurement::from(&body), &setpoint, DT_S).throttle;
        }
        Truth { at_us: k * STEP_US, body, specific_force_body: sim.specific_force_body() }
    };
    (1..=(duration_s / DT_S).round() as u64).map(truth).collect()
}
