//! Drafted vehicles: where PX4 has the rotors of each frame, and what they do.

use nalgebra::Vector3;

use super::*;
use crate::draft::{DraftRotors, DraftThrust, Frame, VehicleDraft, vehicle_draft_json};
use crate::foreign::KnownVehicle;
use samara_core::control::Airframe;
use samara_core::model::environment::GeoPoint;
use samara_core::model::{Environment, RotationSense, Vehicle};

const ARM_M: f64 = 0.5;
const THRUST_N: f64 = 30.0;

fn draft(frame: Frame, cant_deg: f64) -> VehicleDraft {
    VehicleDraft {
        name: "drafted".to_owned(),
        mass_kg: 6.0,
        mass_by: None,
        rotors: DraftRotors::Frame { frame, cant_deg, arm_m: ARM_M },
        propeller_m: Some(0.3),
        thrust: DraftThrust::AtFullThrottle { thrust_n: THRUST_N },
        density_kg_m3: 1.225,
        inertia_kg_m2: None,
        motor_tau_s: None,
        known: KnownVehicle::default(),
        schema: None,
    }
}

fn drafted(frame: Frame, cant_deg: f64) -> Vehicle {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("drafted.json");
    std::fs::write(&file, vehicle_draft_json(&draft(frame, cant_deg)).unwrap()).unwrap();
    load_vehicle(&file).unwrap().vehicle
}

/// CA_ROTORn_PX, PY and PZ (0 of frames whose rotors are in one plane) and the sign of KM (positive:
/// counter-clockwise) of PX4's airframes 6001, 8001, 11001 and 12001, in the order of the motors.
#[test]
fn reference_rotors_are_where_px4_has_them() {
    type Geometry = &'static [([f64; 3], f64)];
    let airframes: [(Frame, Geometry); 4] = [
        (
            Frame::HexaX,
            &[
                ([0.0, 0.5, 0.0], -1.0),
                ([0.0, -0.5, 0.0], 1.0),
                ([0.43, -0.25, 0.0], -1.0),
                ([-0.43, 0.25, 0.0], 1.0),
                ([0.43, 0.25, 0.0], 1.0),
                ([-0.43, -0.25, 0.0], -1.0),
            ],
        ),
        (
            Frame::OctoX,
            &[
                ([0.46, 0.19, 0.0], -1.0),
                ([-0.46, -0.19, 0.0], -1.0),
                ([0.19, 0.46, 0.0], 1.0),
                ([-0.46, 0.19, 0.0], 1.0),
                ([0.46, -0.19, 0.0], 1.0),
                ([-0.19, -0.46, 0.0], 1.0),
                ([0.19, -0.46, 0.0], -1.0),
                ([-0.19, 0.46, 0.0], -1.0),
            ],
        ),
        (
            Frame::Y6,
            &[
                ([0.25, 0.433, -0.05], -1.0),
                ([0.25, 0.433, 0.05], 1.0),
                ([-0.5, 0.0, -0.05], -1.0),
                ([-0.5, 0.0, 0.05], 1.0),
                ([0.25, -0.433, -0.05], -1.0),
                ([0.25, -0.433, 0.05], 1.0),
            ],
        ),
        (
            Frame::X8,
            &[
                ([0.35, 0.35, -0.05], 1.0),
                ([0.35, -0.35, -0.05], -1.0),
                ([-0.35, -0.35, -0.05], 1.0),
                ([-0.35, 0.35, -0.05], -1.0),
                ([0.35, -0.35, 0.05], 1.0),
                ([0.35, 0.35, 0.05], -1.0),
                ([-0.35, 0.35, 0.05], 1.0),
                ([-0.35, -0.35, 0.05], -1.0),
            ],
        ),
    ];
    for (frame, rotors) in airframes {
        let vehicle = drafted(frame, 0.0);
        assert_eq!(vehicle.rotors.len(), rotors.len());
        for (mount, ([x, y, z], spin)) in vehicle.rotors.iter().zip(rotors) {
            let found = mount.position_body_m;
            // PX4 rounds; how far a pair is apart is not PX4's to say.
            assert!((found.x - x).abs() < 0.006 && (found.y - y).abs() < 0.006, "{frame:?}: {found}");
            assert!(found.z == 0.0 && *z == 0.0 || found.z * z > 0.0, "{frame:?}: {found}");
            assert_eq!(mount.spin.sign(), *spin, "{frame:?}: {found}");
            let is_lower = mount.interference.thrust < 1.0;
            assert_eq!(is_lower, *z > 0.0, "{frame:?}: {found}");
        }
    }
}

/// Level, still and at the weight, the rotors turn nothing and push nothing aside, whatever a lower rotor
/// loses. Canted ones of a hexacopter push nothing aside either when they turn the vehicle.
#[test]
fn closed_form_every_frame_hovers_without_moment() {
    for (frame, cant_deg) in Frame::ALL.map(|frame| (frame, 0.0)).into_iter().chain([
        (Frame::QuadX, 20.0),
        (Frame::HexaX, 20.0),
        (Frame::OctoPlus, 30.0),
    ]) {
        let vehicle = drafted(frame, cant_deg);
        let anchor = GeoPoint { latitude_deg: 0.0, longitude_deg: 0.0, altitude_m: 0.0 };
        let site = Environment::new(9.8, 1.225, Vector3::zeros(), anchor).unwrap();
        let airframe = Airframe::new(&vehicle, &site).unwrap();
        let made = |lift_n: f64, moment: Vector3<f64>| {
            let mut force = Vector3::zeros();
            let mut turning = Vector3::zeros();
            for (i, alone_n) in airframe.mixer.thrusts(lift_n, &moment).iter().enumerate() {
                let Some(mount) = vehicle.rotors.get(i) else { break };
                let thrust_n = alone_n * mount.interference.thrust;
                force += mount.axis_body * thrust_n;
                turning += vehicle.moment_per_thrust(i, 1.225) * thrust_n;
            }
            (force, turning)
        };
        let weight_n = 6.0 * 9.8;
        let (force, turning) = made(weight_n, Vector3::zeros());
        assert!((force + Vector3::z() * weight_n).norm() < 1e-3, "{frame:?}: {force}");
        assert!(turning.norm() < 1e-3, "{frame:?}: {turning}");
        let wanted = Vector3::new(0.5, -0.7, 0.1);
        let (force, turning) = made(weight_n, wanted);
        assert!((turning - wanted).norm() < 1e-3, "{frame:?}: {turning}");
        if frame == Frame::HexaX {
            assert!(force.xy().norm() < 1e-3, "{frame:?}: {force}");
        }
    }
}

/// Turned by c about its arm, a rotor at l turns the vehicle about the vertical axis by l sin c + k cos c per
/// newton, k its torque per thrust; the lift is cos c of the thrust. The vector of the thrust has no part
/// along the arm.
#[test]
fn closed_form_cant_adds_to_the_rotors_own_torque() {
    let cant: f64 = 20.0;
    let (sin, cos) = (0.342_020_143_325_669, 0.939_692_620_785_908);
    for frame in [Frame::QuadX, Frame::QuadPlus, Frame::HexaX, Frame::HexaPlus, Frame::OctoX, Frame::OctoPlus]
    {
        let vehicle = drafted(frame, cant);
        let k = vehicle.torque_per_thrust_m(1.225);
        for (i, mount) in vehicle.rotors.iter().enumerate() {
            let about_z = vehicle.moment_per_thrust(i, 1.225).z;
            let clockwise = if mount.spin == RotationSense::Ccw { 1.0 } else { -1.0 };
            assert!((about_z - clockwise * (ARM_M * sin + k * cos)).abs() < 1e-5, "{frame:?}: {about_z}");
            assert!((mount.axis_body.z + cos).abs() < 1e-8);
            assert!(mount.axis_body.dot(&mount.position_body_m).abs() < 1e-5);
        }
        let lift_n = vehicle.static_lift_n(1.225);
        assert!((lift_n / (vehicle.rotors.len() as f64 * THRUST_N * cos) - 1.0).abs() < 1e-6, "{frame:?}");
    }
}

/// A pair lifts 1.67 of a lone rotor; a frame of pairs cannot be canted, and nothing further than 45 deg.
#[test]
fn closed_form_a_pair_lifts_less_than_two_rotors() {
    for (frame, pairs) in [(Frame::Y6, 3.0), (Frame::X8, 4.0)] {
        let lift_n = drafted(frame, 0.0).static_lift_n(1.225);
        assert!((lift_n / (1.67 * pairs * THRUST_N) - 1.0).abs() < 1e-6, "{frame:?}");
        assert!(vehicle_draft_json(&draft(frame, 10.0)).is_err());
    }
    for cant_deg in [-1.0, 45.1, f64::NAN] {
        assert!(vehicle_draft_json(&draft(Frame::HexaX, cant_deg)).is_err());
    }
}

/// By hand: a sphere of 0.35 arm lengths with 70 % of 6 kg and 30 % at hubs 0.5 m away, four fifths of both;
/// 0.3 of the circle through the hubs from all sides; rotor drag 0.011 rho D^3.
#[test]
fn closed_form_estimates_are_on_the_safe_side() {
    let vehicle = drafted(Frame::QuadX, 0.0);
    let body = 0.4 * 0.7 * 6.0 * (0.35f64 * 0.5).powi(2);
    let xx = 0.8 * (body + 0.3 * 6.0 * 0.125);
    assert!((vehicle.mass.inertia_kg_m2[(0, 0)] / xx - 1.0).abs() < 1e-3);
    let wanted_n = 0.5 * 1.225 * 0.3 * std::f64::consts::PI * 0.25 * 25.0;
    for v in [Vector3::x(), -Vector3::y(), Vector3::z()].map(|along| along * 5.0) {
        let force = Vector3::from(vehicle.aero.load(v.into(), 1.225).force_body);
        assert!((force + v / 5.0 * wanted_n).norm() < 2e-3 * wanted_n, "{v}: {force}");
    }
    let samara_core::model::Rotor::Quadratic { drag_n_s2_per_rad_m, .. } = vehicle.rotor else { panic!() };
    assert!((drag_n_s2_per_rad_m / (0.011 * 1.225 * 0.027) - 1.0).abs() < 1e-3);
}
