//! Vehicles for tests: a plain quadrotor whose parameters a test may vary.

use nalgebra::{Matrix3, Vector3};

use crate::control::{Airframe, Cascade, ControlLimits, Gains, Measurement};
use crate::frames::quaternion_from_euler;
use crate::math;
use crate::model::environment::GeoPoint;
use crate::model::rigid_body::MassProperties;
use crate::model::{
    BodyAero, Environment, Interference, Motor, RotationSense, Rotor, RotorMount, Vehicle, VehicleOptions,
};

pub(crate) const MASS_KG: f64 = 790.0;
pub(crate) const GRAVITY_M_S2: f64 = 1.35;
pub(crate) const J_YY: f64 = 890.0;
pub(crate) const ARM_M: f64 = 0.95;
pub(crate) const THRUST_LIMIT_N: f64 = 432.0;

pub(crate) fn site() -> Environment {
    let anchor = GeoPoint { latitude_deg: 0.0, longitude_deg: 0.0, altitude_m: 0.0 };
    Environment::new(GRAVITY_M_S2, 5.4, Vector3::zeros(), anchor).unwrap()
}

fn aero(coefficients: [f64; 3]) -> BodyAero {
    let alpha: Vec<f64> = (0..=8).map(|i| (f64::from(i) / 4.0 - 1.0) * std::f64::consts::PI).collect();
    let [drag, lift, pitch] = coefficients.map(|c| {
        let mut table: Vec<f64> = alpha.iter().map(|a| c * math::sin(2.0 * a)).collect();
        table[8] = table[0];
        table
    });
    let drag: Vec<f64> = drag.iter().map(|d| 2.0 * coefficients[0] + d).collect();
    BodyAero::new(2.0, 2.0, &alpha, &drag, &lift, &pitch).unwrap()
}

/// A quadrotor with rotors at +-arm, the given inertia and aerodynamic coefficients (drag, lift, pitch;
/// zeros: no air).
pub(crate) fn quadrotor(
    arm_m: [f64; 2],
    inertia_kg_m2: [f64; 3],
    coefficients: [f64; 3],
    options: VehicleOptions,
) -> Vehicle {
    let mount = |x: f64, y: f64, spin| RotorMount {
        position_body_m: Vector3::new(x * arm_m[0], y * arm_m[1], 0.0),
        axis_body: -Vector3::z(),
        spin,
        interference: Interference::NONE,
    };
    let rotors = vec![
        mount(1.0, 1.0, RotationSense::Ccw),
        mount(-1.0, -1.0, RotationSense::Ccw),
        mount(1.0, -1.0, RotationSense::Cw),
        mount(-1.0, 1.0, RotationSense::Cw),
    ];
    let inertia = Matrix3::from_diagonal(&inertia_kg_m2.into());
    let rotor = Rotor::Quadratic {
        thrust_n_per_rad2_s2: THRUST_LIMIT_N / (133.0 * 133.0),
        torque_per_thrust_m: 0.05,
        drag_n_s2_per_rad_m: 0.0,
        density_kg_m3: 5.4,
    };
    let motor = Motor::FirstOrder {
        omega_max_rad_s: 133.0,
        tau_up_s: 0.1,
        tau_down_s: 0.3,
        rotor_inertia_kg_m2: 0.09,
    };
    let mass = MassProperties::new(MASS_KG, inertia).unwrap();
    Vehicle::new(mass, rotors, aero(coefficients), rotor, motor, options).unwrap()
}

/// The lander of the tests, with reaction torques on (it yaws) or off (the paper's study).
pub(crate) fn lander(reaction_torque: bool) -> Vehicle {
    let options = VehicleOptions { reaction_torque, rotor_momentum: reaction_torque };
    quadrotor([ARM_M, 1.1], [620.0, J_YY, 1160.0], [0.3, 0.2, 0.05], options)
}

/// The lander with `n` rotors on an ellipse of half axes forward and right [m], some higher than others,
/// turning by turns, their axes leaning by `lean` so that it helps the reaction torque along.
pub(crate) fn ring(n: u32, [forward_m, right_m]: [f64; 2], lean: f64) -> Vehicle {
    let mut vehicle = lander(true);
    vehicle.rotors = (0..n)
        .map(|i| {
            let (sin, cos) = math::sin_cos(std::f64::consts::TAU * f64::from(i) / f64::from(n));
            let spin = if i % 2 == 0 { RotationSense::Cw } else { RotationSense::Ccw };
            let lean = -lean * spin.sign();
            RotorMount {
                position_body_m: Vector3::new(forward_m * cos, right_m * sin, 0.1 * cos),
                axis_body: Vector3::new(-lean * sin, lean * cos, -1.0).normalize(),
                spin,
                interference: Interference::NONE,
            }
        })
        .collect();
    vehicle
}

pub(crate) fn airframe(vehicle: &Vehicle) -> Airframe {
    Airframe::new(vehicle, &site()).unwrap()
}

pub(crate) fn cascade(vehicle: &Vehicle, gains: Gains) -> Cascade {
    Cascade::new(airframe(vehicle), gains, ControlLimits::default())
}

/// A measurement at roll, pitch, yaw [rad], at rest.
pub(crate) fn at_rest(roll: f64, pitch: f64, yaw: f64) -> Measurement {
    Measurement {
        q_ned_from_body: quaternion_from_euler(roll, pitch, yaw),
        v_ned: Vector3::zeros(),
        omega_body: Vector3::zeros(),
        bus_v: None,
        pack_a: None,
    }
}
