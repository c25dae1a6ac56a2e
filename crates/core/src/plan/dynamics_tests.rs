//! The hand-written derivatives against dual numbers run through the code that flies.
use std::f64::consts::PI;

use proptest::prelude::*;

use super::dynamics::*;
use crate::math;
use crate::model::environment::GeoPoint;
use crate::model::rigid_body::{MassProperties, Motion};
use crate::model::{BodyAero, Environment, Vehicle};
use crate::model::{Interference, Motor, RotationSense, Rotor, RotorMount, VehicleOptions};
use crate::real::Dual;
use crate::vector::V3;
use nalgebra::{Matrix3, SVector, Vector3};

/// A vehicle that is symmetric about nothing, with a side force or without.
fn vehicle(side_area_m2: Option<f64>) -> Vehicle {
    let alpha: Vec<f64> = (0..=36).map(|i| PI * (f64::from(i) / 18.0 - 1.0)).collect();
    let table = |f: &dyn Fn(f64) -> f64| alpha.iter().map(|&a| f(a)).collect::<Vec<f64>>();
    let aero = BodyAero::new(
        2.0,
        1.5,
        &alpha,
        &table(&|a| 0.2 - 0.15 * math::cos(2.0 * a)),
        &table(&|a| 0.2 * math::sin(2.0 * a)),
        &table(&|a| 0.1 * math::sin(2.0 * a + 0.3)),
    );
    let aero = aero.unwrap();
    let aero = match side_area_m2 {
        Some(area_m2) => aero.with_side_area(area_m2).unwrap(),
        None => aero,
    };
    let inertia = Matrix3::new(6.0, 0.1, -0.3, 0.1, 8.0, 0.2, -0.3, 0.2, 11.0);
    let at = |x: f64, y: f64, spin| RotorMount {
        position_body_m: Vector3::new(x, y, -0.1),
        axis_body: Vector3::new(0.05, -0.02, -1.0).normalize(),
        spin,
        interference: Interference::NONE,
    };
    Vehicle::new(
        MassProperties::new(20.0, inertia).unwrap(),
        vec![
            at(0.9, 1.1, RotationSense::Ccw),
            at(-0.9, -1.0, RotationSense::Ccw),
            at(1.0, -1.1, RotationSense::Cw),
            at(-0.8, 1.0, RotationSense::Cw),
        ],
        aero,
        Rotor::Quadratic {
            thrust_n_per_rad2_s2: 1e-4,
            torque_per_thrust_m: 0.02,
            drag_n_s2_per_rad_m: 0.0,
            density_kg_m3: 1.2,
        },
        Motor::FirstOrder {
            omega_max_rad_s: 900.0,
            tau_up_s: 0.05,
            tau_down_s: 0.05,
            rotor_inertia_kg_m2: 0.0,
        },
        VehicleOptions { reaction_torque: true, rotor_momentum: false },
    )
    .unwrap()
}

fn site() -> Environment {
    let anchor = GeoPoint { latitude_deg: 0.0, longitude_deg: 0.0, altitude_m: 0.0 };
    Environment::new(9.8, 1.3, Vector3::new(0.5, -0.8, 0.3), anchor).unwrap()
}

/// A number with its first and second derivatives with respect to all states and thrusts.
type Twice = Dual<Dual<f64, 14>, 14>;

/// `f` with its derivatives.
fn dual_flight(vehicle: &Vehicle, site: &Environment, x: &[f64; 10], u: &[f64; 4]) -> [Twice; 10] {
    let seeded = |k: usize, value: f64| Dual::variable(Dual::variable(value, k), k);
    let z: [Twice; 10] = std::array::from_fn(|k| seeded(k, x[k]));
    let thrust: [Twice; 4] = std::array::from_fn(|k| seeded(10 + k, u[k]));
    let motion = Motion {
        q_ned_from_body: [z[0], z[1], z[2], z[3]],
        v_ned: V3::new(z[4], z[5], z[6]),
        omega_body: V3::new(z[7], z[8], z[9]),
    };
    let r = vehicle.thrust_rate(site, &motion, &thrust);
    let (v, w) = (r.v_dot_ned, r.omega_dot_body);
    [r.q_dot[0], r.q_dot[1], r.q_dot[2], r.q_dot[3], v.x, v.y, v.z, w.x, w.y, w.z]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn prop_derivatives_equal_those_of_dual_numbers_through_the_flying_code(
        q in prop::array::uniform4(-1.0f64..1.0), v in prop::array::uniform3(-9.0f64..9.0),
        w in prop::array::uniform3(-1.0f64..1.0), u in prop::array::uniform4(0.0f64..80.0),
        weights in prop::array::uniform10(-1.0f64..1.0), side_area_m2 in prop::option::of(0.5f64..4.0),
    ) {
        let (vehicle, site) = (vehicle(side_area_m2), site());
        let x = [q[0] + 1.5, q[1], q[2], q[3], v[0], v[1], v[2], w[0], w[1], w[2]];
        let dynamics = VehicleDynamics::<4>::new(&vehicle, &site).unwrap();
        let (xs, us) = (SVector::from(x), SVector::from(u));
        let l = dynamics.linearise(&xs, &us);
        let c = dynamics.curvature(&xs, &us, &SVector::from(weights));
        let dual = dual_flight(&vehicle, &site, &x, &u);
        for i in 0..14 {
            for j in 0..=i {
                let second = |f: &Twice| f.slope[i].slope[j];
                let exact: f64 = dual.iter().zip(weights).map(|(f, weight)| weight * second(f)).sum();
                let ours = match (i < 10, j < 10) {
                    (true, _) => c.xx[(i, j)],
                    (false, true) => c.ux[(i - 10, j)],
                    (false, false) => c.uu[(i - 10, j - 10)],
                };
                let off = (ours - exact).abs();
                prop_assert!(off < 1e-10 * (1.0 + exact.abs()), "({i}, {j}): {ours} {exact}");
                for (row, f) in dual.iter().enumerate() {
                    let first = f.value.slope[i];
                    let ours = if i < 10 { l.a[(row, i)] } else { l.b[(row, i - 10)] };
                    prop_assert!((ours - first).abs() < 1e-11 * (1.0 + first.abs()), "row {row} by {i}");
                }
            }
        }
    }
}
