//! The hand-written derivatives of the demands and of the extended dynamics against central differences, and
//! what the demands mean against closed forms.

use std::sync::Arc;

use nalgebra::{SVector, Vector3, Vector4};
use proptest::prelude::*;

use samara::config::load_vehicle;
use samara::frames::quaternion_from_euler;
use samara::model::environment::GeoPoint;
use samara::model::inflow::vortex_ring;
use samara::model::{Environment, Vehicle};
use samara::plan::dynamics::{Dynamics, VehicleDynamics};
use samara::plan::extended::{EXTENDED_STATES, ExtendedDynamics, PEAK, STRETCH};
use samara::plan::path::{PathConstraint, PathPlace, Point, PointCurvature};
use samara::plan::{Demands, FreeHorizon, MotionBounds, PeakCost, RingBounds};

type X = SVector<f64, EXTENDED_STATES>;
type U = SVector<f64, 4>;

fn site() -> Environment {
    let anchor = GeoPoint { latitude_deg: 0.0, longitude_deg: 0.0, altitude_m: 0.0 };
    Environment::new(1.35, 5.4, Vector3::new(0.4, -0.3, 0.2), anchor).unwrap()
}

/// The lander with known blades.
fn lander() -> Vehicle {
    load_vehicle(std::path::Path::new("params/vehicles/titan_bemt.json")).unwrap().vehicle
}

/// Everything that can be asked for.
fn all_demands() -> Demands {
    Demands {
        cost_final: None,
        peak: Some(PeakCost {
            weight: 100.0,
            alone: false,
            speed_m_s: 12.0,
            pitch_rad: 0.8,
            pitch_rate_rad_s: 1.6,
        }),
        motion: MotionBounds {
            speed_m_s: Some(7.0),
            pitch_rad: Some(0.4),
            pitch_rate_rad_s: Some(0.3),
            v_north_m_s: Some([-1.0, 4.0]),
            v_east_m_s: Some([-1.0, 1.0]),
            v_down_m_s: Some([2.0, 6.0]),
            altitude_lost_m: Some(130.0),
        },
        rotor_acceleration_rad_s2: Some(20.0),
        vortex_ring: Some(RingBounds { share: 0.9, from_s: 0.0, to_s: 30.0 }),
        horizon: Some(FreeHorizon { least_s: 10.0, greatest_s: 60.0, cost_per_s: 1.0 }),
    }
}

fn constraints(
    demands: &Demands,
    vehicle: &Vehicle,
    environment: &Environment,
) -> Vec<Arc<dyn PathConstraint<EXTENDED_STATES, 4>>> {
    demands.constraints::<4>(vehicle, environment, 60.0)
}

fn middle<'a>(x: &'a X, u: &'a U, u_dot: U) -> Point<'a, EXTENDED_STATES, 4> {
    Point { place: PathPlace { interval: 3, middle: true, t_s: 3.0, last: false }, x, u, u_dot }
}

prop_compose! {
    /// A state near flight, attitude not of unit length; inputs and their rates.
    fn anywhere()(
        q in prop::array::uniform4(-0.4f64..0.4), v in prop::array::uniform3(-6.0f64..6.0),
        w in prop::array::uniform3(-1.0f64..1.0), rest in prop::array::uniform3(0.3f64..2.0),
        u in prop::array::uniform4(20.0f64..300.0), u_dot in prop::array::uniform4(-60.0f64..60.0),
    ) -> (X, U, U) {
        let x = X::from([
            q[0] + 1.1, q[1], q[2], q[3], v[0], v[1], v[2], w[0], w[1], w[2],
            100.0 * rest[0], rest[1], rest[2],
        ]);
        (x, U::from(u), U::from(u_dot))
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn prop_gradients_of_the_demands_match_central_differences((x, u, u_dot) in anywhere()) {
        let (vehicle, site) = (lander(), site());
        for constraint in constraints(&all_demands(), &vehicle, &site) {
            let value = |x: &X, u: &U, u_dot: &U| constraint.value(&middle(x, u, *u_dot));
            let gradient = constraint.gradient(&middle(&x, &u, u_dot));
            let close = |plus: f64, minus: f64, h: f64, found: f64| {
                ((plus - minus) / (2.0 * h) - found).abs() < 1e-6 * (1.0 + found.abs())
            };
            for j in 0..EXTENDED_STATES {
                let d = X::ith(j, 1e-5);
                let (plus, minus) = (value(&(x + d), &u, &u_dot), value(&(x - d), &u, &u_dot));
                prop_assert!(close(plus, minus, 1e-5, gradient.x[j]), "{constraint:?} by state {j}");
            }
            for j in 0..4 {
                let d = U::ith(j, 1e-3);
                let (plus, minus) = (value(&x, &(u + d), &u_dot), value(&x, &(u - d), &u_dot));
                prop_assert!(close(plus, minus, 1e-3, gradient.u[j]), "{constraint:?} by input {j}");
                let (plus, minus) = (value(&x, &u, &(u_dot + d)), value(&x, &u, &(u_dot - d)));
                prop_assert!(close(plus, minus, 1e-3, gradient.u_dot[j]), "{constraint:?} by rate {j}");
            }
        }
    }

    #[test]
    fn prop_curvatures_of_the_demands_match_differences_of_the_gradients((x, u, u_dot) in anywhere()) {
        let (vehicle, site) = (lander(), site());
        for constraint in constraints(&all_demands(), &vehicle, &site) {
            let gradient = |x: &X, u: &U, u_dot: &U| constraint.gradient(&middle(x, u, *u_dot));
            let mut sum = PointCurvature::zero();
            constraint.add_curvature(&middle(&x, &u, u_dot), 0.7, &mut sum);
            let close = |plus: f64, minus: f64, h: f64, found: f64| {
                (0.7 * (plus - minus) / (2.0 * h) - found).abs() < 2e-6 * (1.0 + found.abs())
            };
            for j in 0..EXTENDED_STATES {
                let d = X::ith(j, 1e-5);
                let (plus, minus) = (gradient(&(x + d), &u, &u_dot), gradient(&(x - d), &u, &u_dot));
                for i in 0..EXTENDED_STATES {
                    prop_assert!(close(plus.x[i], minus.x[i], 1e-5, sum.states.xx[(i, j)]), "{constraint:?} xx {i} {j}");
                }
                for i in 0..4 {
                    prop_assert!(close(plus.u[i], minus.u[i], 1e-5, sum.states.ux[(i, j)]), "{constraint:?} ux {i} {j}");
                    prop_assert!(close(plus.u_dot[i], minus.u_dot[i], 1e-5, sum.moves.wx[(i, j)]), "{constraint:?} wx {i} {j}");
                }
            }
            for j in 0..4 {
                let d = U::ith(j, 1e-3);
                let (plus, minus) = (gradient(&x, &(u + d), &u_dot), gradient(&x, &(u - d), &u_dot));
                let (faster, slower) = (gradient(&x, &u, &(u_dot + d)), gradient(&x, &u, &(u_dot - d)));
                for i in 0..4 {
                    prop_assert!(close(plus.u[i], minus.u[i], 1e-3, sum.states.uu[(i, j)]), "{constraint:?} uu {i} {j}");
                    prop_assert!(close(plus.u_dot[i], minus.u_dot[i], 1e-3, sum.moves.wu[(i, j)]), "{constraint:?} wu {i} {j}");
                    prop_assert!(close(faster.u_dot[i], slower.u_dot[i], 1e-3, sum.moves.ww[(i, j)]), "{constraint:?} ww {i} {j}");
                }
            }
        }
    }

    /// Value, Jacobians and curvature of the dynamics with three more states.
    #[test]
    fn prop_derivatives_of_the_extended_dynamics_match_differences(
        (x, u, _) in anywhere(), weights in prop::collection::vec(-1.0f64..1.0, EXTENDED_STATES),
    ) {
        let dynamics = ExtendedDynamics(VehicleDynamics::<4>::new(&lander(), &site()).unwrap());
        let weights = X::from_column_slice(&weights);
        let l = dynamics.linearise(&x, &u);
        let c = dynamics.curvature(&x, &u, &weights);
        prop_assert!((l.f - dynamics.value(&x, &u)).amax() <= 1e-12 * (1.0 + l.f.amax()));
        let gradient = |x: &X, u: &U| {
            let l = dynamics.linearise(x, u);
            (l.a.tr_mul(&weights), l.b.tr_mul(&weights))
        };
        let (h, scale) = (1e-6, 1.0 + c.xx.amax());
        for j in 0..EXTENDED_STATES {
            let (right, left) = (x + X::ith(j, h), x - X::ith(j, h));
            let by = (dynamics.value(&right, &u) - dynamics.value(&left, &u)) / (2.0 * h);
            prop_assert!((by - l.a.column(j)).amax() < 1e-6 * (1.0 + by.amax()), "state {j}");
            let (plus, minus) = (gradient(&right, &u), gradient(&left, &u));
            prop_assert!(((plus.0 - minus.0) / (2.0 * h) - c.xx.column(j)).amax() < 2e-6 * scale, "xx {j}");
            prop_assert!(((plus.1 - minus.1) / (2.0 * h) - c.ux.column(j)).amax() < 2e-6 * scale, "ux {j}");
        }
    }
}

/// One constraint that is asked for, at a state.
fn value_of(demands: &Demands, index: usize, x: &X, u: &U, u_dot: U) -> f64 {
    let (vehicle, mut site) = (lander(), site());
    site.wind_ned_m_s = Vector3::zeros();
    constraints(demands, &vehicle, &site)[index].value(&middle(x, u, u_dot))
}

fn state(roll: f64, pitch: f64, v: [f64; 3]) -> X {
    let q = quaternion_from_euler(roll, pitch, 0.7);
    let mut x = X::zeros();
    x.fixed_rows_mut::<4>(0).copy_from(&Vector4::from(q));
    x.fixed_rows_mut::<3>(4).copy_from(&Vector3::from(v));
    (x[PEAK], x[STRETCH]) = (1.0, 1.0);
    x
}

/// Pitch as an angle of the plane, past the vertical too; beside roll its tangent over the cosine of the
/// roll, never less than the pitch.
#[test]
fn closed_form_the_pitch_that_is_bounded() {
    let demands = Demands {
        motion: MotionBounds { pitch_rad: Some(1.0), ..MotionBounds::default() },
        ..Demands::default()
    };
    let bounded = |roll: f64, pitch: f64| {
        value_of(&demands, 0, &state(roll, pitch, [0.0; 3]), &U::zeros(), U::zeros()) + 1.0
    };
    for pitch in [-1.4, -0.3, 0.0, 0.8, 1.5, 2.4, 3.1] {
        let flat = Vector4::new((0.5f64 * pitch).cos(), 0.0, (0.5f64 * pitch).sin(), 0.0);
        let mut x = state(0.0, 0.0, [0.0; 3]);
        x.fixed_rows_mut::<4>(0).copy_from(&(flat * 1.3));
        let found = value_of(&demands, 0, &x, &U::zeros(), U::zeros()) + 1.0;
        assert!((found - pitch).abs() < 1e-12, "{pitch}: {found}");
    }
    for (roll, pitch) in [(0.3f64, 0.5f64), (-0.8, 0.2), (0.6, -0.9)] {
        let expected = (pitch.tan() / roll.cos()).atan();
        assert!((bounded(roll, pitch) - expected).abs() < 1e-12 && expected.abs() >= pitch.abs());
    }
}

/// Straight descent meets the ellipse where it meets Johnson's boundary, at N and X; level flight at the
/// greatest edgewise velocity, in the descent of the middle.
#[test]
fn closed_form_the_ring_that_is_kept_out_of() {
    let demands = Demands {
        vortex_ring: Some(RingBounds { share: 1.0, from_s: 0.0, to_s: 30.0 }),
        ..Demands::default()
    };
    let u = U::from_element(250.0);
    let hover_n = 790.0 * 1.35 / 4.0;
    let v_h = ((250.0 + 1e-3 * hover_n) / (2.0 * 5.4 * std::f64::consts::PI * 0.65 * 0.65)).sqrt();
    let value = |climb: f64, edge: f64| {
        let mut x = state(0.0, 0.0, [edge * v_h, 0.0, -climb * v_h]);
        x.fixed_rows_mut::<4>(0).copy_from(&Vector4::new(1.0, 0.0, 0.0, 0.0));
        value_of(&demands, 0, &x, &u, U::zeros())
    };
    let [n, x] = vortex_ring(0.0).unwrap();
    for (climb, edge) in [(n, 0.0), (x, 0.0), (0.5 * (n + x), 0.95)] {
        assert!(value(climb, edge).abs() < 1e-3, "{climb} {edge}: {}", value(climb, edge));
    }
    assert!(value(-0.975, 0.0) > 0.5 && value(-0.3, 0.0) < 0.0 && value(-2.0, 0.0) < 0.0);
}

/// A rotor at constant angular acceleration `a`, `T = k (w + a t)^2`, is on its limit at the middle of a
/// short interval.
#[test]
fn closed_form_the_rotor_acceleration_that_is_bounded() {
    let (a, vehicle, site) = (20.0, lander(), site());
    let demands = Demands { rotor_acceleration_rad_s2: Some(a), ..Demands::default() };
    let omega = vehicle.motor.omega_max_rad_s();
    let k = vehicle.rotor.static_load(omega, site.density_kg_m3).thrust_n / (omega * omega);
    let at = |w: f64| (U::from_element(k * w * w), U::from_element(2.0 * k * w * a));
    for w in [5.0, 40.0, 100.0] {
        let (u, u_dot) = at(w);
        let value = value_of(&demands, 0, &state(0.0, 0.0, [0.0; 3]), &u, u_dot);
        assert!(value.abs() < 1e-12, "{w}: {value}");
        assert!(value_of(&demands, 0, &state(0.0, 0.0, [0.0; 3]), &u, u_dot * 0.9) < 0.0);
    }
}
