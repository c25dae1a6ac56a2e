//! Phases of the drop against closed forms, and what must hold in every phase.

use std::sync::Arc;

use nalgebra::Vector3;
use proptest::prelude::*;

use super::plant::Plant;
use super::{DropSimulation, Phase, PlantKind, PlantState, Start, nominal_state_at_t0};
use crate::control::test_vehicles::{GRAVITY_M_S2, MASS_KG, lander, quadrotor, site};
use crate::frames::{quaternion_from_euler, rotate_ned_from_body};
use crate::math;
use crate::model::environment::GeoPoint;
use crate::model::parachute::Pendulum;
use crate::model::rigid_body::BodyState;
use crate::model::{Atmosphere, Environment, MAX_ROTORS, Parachute, Vehicle, VehicleOptions};

const OFF: [f64; 8] = [0.0; 8];

fn airless() -> Vehicle {
    quadrotor([0.95, 1.1], [620.0, 890.0, 1160.0], [0.0; 3], VehicleOptions::default())
}

fn swinging() -> Parachute {
    let pendulum = Pendulum { amplitude_rad: 0.16, phase_rad: 0.9, omega_rad_s: 2.0, length_m: 1.0 };
    Parachute::new(3.0, 0.5, pendulum).unwrap()
}

fn drop_of(vehicle: Vehicle, start: Start) -> DropSimulation {
    DropSimulation::new(Arc::new(vehicle), site(), swinging(), 10.0, start)
}

/// Parabola and steady rotation; kinetic plus potential energy stays.
#[test]
fn closed_form_free_fall() {
    let mut sim = drop_of(airless(), Start::Release);
    sim.schedule_release(2.0);
    while sim.phase() == Phase::Hanging {
        sim.step(&OFF, 0.004);
    }
    let released = sim.state().body;
    assert_eq!(sim.release_time_s(), Some(2.0));
    let energy = |b: &BodyState| 0.5 * b.v_ned.norm_squared() - GRAVITY_M_S2 * b.p_ned.z;
    for _ in 0..124 {
        sim.step(&[1.0; 8], 0.004);
    }
    assert_eq!(sim.phase(), Phase::Falling);
    let (t, b) = (0.496, sim.state().body);
    let g = Vector3::new(0.0, 0.0, GRAVITY_M_S2);
    assert!((b.v_ned - released.v_ned - g * t).norm() < 1e-13);
    assert!((b.p_ned - released.p_ned - released.v_ned * t - g * (0.5 * t * t)).norm() < 1e-13);
    assert!((b.omega_body - released.omega_body).norm() < 1e-15);
    let turned = crate::frames::pitch(released.q_ned_from_body) + released.omega_body.y * t;
    assert!((crate::frames::pitch(b.q_ned_from_body) - turned).abs() < 1e-12);
    assert!((energy(&b) - energy(&released)).abs() < 1e-12);
    assert!(sim.specific_force_body().norm() < 1e-14, "an accelerometer in free fall reads nothing");
    assert_eq!(sim.state().rotor_speed, [0.0; 8], "locked, whatever the command");
}

/// The study's start holds at the end of the delay: attitude and rate of the release, `v_0 = v + g t_d`.
#[test]
fn paper_t0_start_has_the_state_of_44_when_the_rotors_are_freed() {
    let mut sim = drop_of(lander(true), Start::T0);
    sim.schedule_release(10.0);
    while sim.phase() != Phase::Powered {
        sim.step(&OFF, 0.004);
    }
    assert!(sim.time_powered_s().unwrap().abs() < 1e-12);
    let (found, wanted) = (sim.state().body, swinging().state_at_t0(GRAVITY_M_S2));
    assert!((found.v_ned - wanted.v_ned).norm() < 1e-12);
    assert!((found.omega_body - wanted.omega_body).norm() < 1e-12);
    assert!((0..4).all(|i| (found.q_ned_from_body[i] - wanted.q_ned_from_body[i]).abs() < 1e-12));
}

fn windy() -> Environment {
    Environment { wind_ned_m_s: Vector3::new(6.0, -2.0, 0.0), ..site() }
}

/// Adrift with the wind, the vehicle feels no wind: under the canopy and in the fall it is the calm day's
/// drop, carried along.
#[test]
fn closed_form_a_drop_in_wind_is_the_calm_drop_carried_along() {
    let drift = Vector3::new(6.0, -2.0, 0.0);
    for start in [Start::Release, Start::T0] {
        let [mut calm, mut wind] = [site(), windy()]
            .map(|site| DropSimulation::new(Arc::new(lander(true)), site, swinging(), 2.0, start));
        for sim in [&mut calm, &mut wind] {
            sim.schedule_release(2.0);
        }
        for _ in 0..1000 {
            for sim in [&mut calm, &mut wind] {
                sim.step(&[0.7; 8], 0.004);
            }
            let (a, b) = (calm.state().body, wind.state().body);
            let t = calm.time_s() - 2.0;
            assert!((b.v_ned - a.v_ned - drift).norm() < 1e-10, "{start:?} at {t} s");
            assert!((b.p_ned - a.p_ned - drift * t).norm() < 1e-9, "{start:?} at {t} s");
            assert!(
                (calm.balance(&OFF).canopy_force_ned - wind.balance(&OFF).canopy_force_ned).norm() < 1e-8
            );
        }
        assert_eq!(wind.phase(), Phase::Powered);
    }
}

/// What a plan starts from is what the drop comes to.
#[test]
fn closed_form_the_nominal_state_is_that_of_a_drop_released_in_time() {
    for start in [Start::Release, Start::T0] {
        let vehicle = Arc::new(lander(true));
        let mut sim = DropSimulation::new(vehicle.clone(), windy(), swinging(), 10.0, start);
        sim.schedule_release(10.0);
        while sim.phase() != Phase::Powered {
            sim.step(&OFF, 0.004);
        }
        let nominal = nominal_state_at_t0(vehicle, windy(), swinging(), start);
        let found = sim.state().body;
        assert!((found.v_ned - nominal.v_ned).norm() < 1e-11, "{} {}", found.v_ned, nominal.v_ned);
        assert!((found.omega_body - nominal.omega_body).norm() < 1e-11);
        assert!((0..4).all(|i| (found.q_ned_from_body[i] - nominal.q_ned_from_body[i]).abs() < 1e-11));
    }
    let v0 = swinging().state_at_t0(GRAVITY_M_S2).v_ned.z;
    let fallen = nominal_state_at_t0(Arc::new(lander(true)), site(), swinging(), Start::Release);
    assert!(fallen.v_ned.z < v0, "the air brakes the fall");
}

/// Ten thousand steps of 4 ms end at 40 s; the release and its delay lie on the grid.
#[test]
fn time_does_not_drift() {
    let mut sim = drop_of(lander(false), Start::Release);
    for k in 1..=11_250 {
        if k == 2501 {
            sim.release();
        }
        sim.step(&OFF, 0.004);
    }
    assert!((sim.time_s() - 45.0).abs() < 1e-12, "{}", sim.time_s());
    assert_eq!(sim.powered_from_s(), Some(10.5));
    assert!((sim.time_powered_s().unwrap() - 34.5).abs() < 1e-12);
}

#[test]
fn release_happens_once() {
    let mut sim = drop_of(lander(false), Start::Release);
    assert_eq!((sim.release_time_s(), sim.time_powered_s()), (None, None));
    sim.step(&OFF, 1.0);
    sim.release();
    assert_eq!(sim.phase(), Phase::Falling);
    sim.step(&OFF, 0.1);
    sim.release();
    sim.schedule_release(7.0);
    assert_eq!((sim.release_time_s(), sim.powered_from_s()), (Some(1.0), Some(1.5)));
}

/// One long step across release and end of delay is the same as steps that end there.
#[test]
fn closed_form_a_boundary_inside_a_step_splits_it() {
    let throttle = [0.9, 0.7, 0.8, 0.6, 0.0, 0.0, 0.0, 0.0];
    let (mut whole, mut split) =
        (drop_of(lander(true), Start::Release), drop_of(lander(true), Start::Release));
    for sim in [&mut whole, &mut split] {
        sim.schedule_release(0.0333);
    }
    whole.step(&throttle, 0.6);
    for dt in [0.0333, 0.5, 0.6 - 0.5333] {
        split.step(&throttle, dt);
    }
    assert_eq!(whole.phase(), Phase::Powered);
    assert!((whole.time_s() - 0.6).abs() < 1e-15);
    assert!(whole.state().rotor_speed[0] > 1.0);
    assert!((whole.state().body.v_ned - split.state().body.v_ned).norm() < 1e-12);
    assert!((whole.state().rotor_speed[0] - split.state().rotor_speed[0]).abs() < 1e-9);
}

#[test]
fn accelerometer_under_a_still_canopy_reads_gravity_upwards() {
    let still = Pendulum { amplitude_rad: 0.0, ..swinging().pendulum };
    let parachute = Parachute { pendulum: still, ..swinging() };
    let sim = DropSimulation::new(Arc::new(lander(false)), site(), parachute, 10.0, Start::Release);
    assert!((sim.specific_force_body() - Vector3::new(0.0, 0.0, -GRAVITY_M_S2)).norm() < 1e-12);
    let canopy = sim.balance(&OFF).canopy_force_ned;
    assert!(canopy.z < 0.0 && canopy.z > -MASS_KG * GRAVITY_M_S2, "the air carries a part: {canopy}");
}

#[test]
fn rotors_come_to_rest_and_never_turn_backwards() {
    let body = swinging().state_at_t0(GRAVITY_M_S2);
    let mut sim = DropSimulation::at_t0(Arc::new(lander(true)), site(), body, PlantKind::Actuator);
    for k in 0..2000 {
        let throttle = if k < 100 { [0.8; 8] } else { [f64::NAN, 0.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0] };
        sim.step(&throttle, 0.01);
        assert!(sim.state().rotor_speed.iter().all(|w| *w >= 0.0));
    }
    assert!(sim.state().rotor_speed[0] < 1e-9, "{:?}", sim.state().rotor_speed);
    let before = *sim.state();
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        sim.step(&[0.5; 8], dt);
    }
    assert_eq!(*sim.state(), before, "a step that is no time does nothing");
}

/// Halving the step divides the error by sixteen, with everything switched on.
#[test]
fn closed_form_integration_is_of_fourth_order() {
    let body = BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: quaternion_from_euler(0.1, -0.2, 0.3),
        v_ned: Vector3::new(1.0, -0.5, 3.7),
        omega_body: Vector3::new(0.2, -0.3, 0.4),
    };
    for kind in [PlantKind::Actuator, PlantKind::Ideal] {
        let end = |steps: u32| {
            let mut sim = DropSimulation::at_t0(Arc::new(lander(true)), site(), body, kind);
            // The ideal plant ramps within its first step: let that be over before the steps are compared.
            sim.step(&[0.8, 0.75, 0.79, 0.77, 0.0, 0.0, 0.0, 0.0], 1e-4);
            for _ in 0..steps {
                sim.step(&[0.8, 0.75, 0.79, 0.77, 0.0, 0.0, 0.0, 0.0], 0.4 / f64::from(steps));
            }
            sim.state().body.v_ned
        };
        let exact = end(512);
        let order = math::log2((end(8) - exact).norm() / (end(16) - exact).norm());
        assert!((3.7..4.6).contains(&order), "{kind:?}: order {order}");
    }
}

/// The ideal plant's thrust runs linearly from the last command to the new one: over the first step its mean
/// is half.
#[test]
fn closed_form_ideal_plant_ramps_from_zero() {
    let body = BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: crate::frames::LEVEL,
        v_ned: Vector3::zeros(),
        omega_body: Vector3::zeros(),
    };
    let mut sim = DropSimulation::at_t0(Arc::new(airless()), site(), body, PlantKind::Ideal);
    let hover = MASS_KG * GRAVITY_M_S2 / (4.0 * sim.vehicle().static_thrust_n(5.4));
    let throttle = [hover.sqrt(); 8];
    sim.step(&throttle, 0.01);
    assert!((sim.state().body.v_ned.z - 0.5 * 0.01 * GRAVITY_M_S2).abs() < 1e-15);
    sim.step(&throttle, 0.01);
    assert!((sim.state().body.v_ned.z - 0.5 * 0.01 * GRAVITY_M_S2).abs() < 1e-15);
    assert!(sim.loads().a_ned.norm() < 1e-12);
}

proptest! {
    /// In every phase and on both plants the forces of the record add up to mass times acceleration.
    #[test]
    fn prop_forces_add_up_to_mass_times_acceleration(
        steps in 1usize..40, dt in 0.001f64..0.08, throttle in prop::array::uniform8(0.0f64..1.0),
        release in 0.0f64..1.0, start in prop::sample::select(vec![Start::Release, Start::T0]),
        rates in prop::array::uniform3(-1.0f64..1.0), ideal in prop::bool::ANY,
    ) {
        let hanging = {
            let mut sim = drop_of(lander(true), start);
            sim.schedule_release(release);
            sim
        };
        let mut body = swinging().state_at_t0(GRAVITY_M_S2);
        body.omega_body = rates.into();
        let kind = if ideal { PlantKind::Ideal } else { PlantKind::Actuator };
        let flying = DropSimulation::at_t0(Arc::new(lander(true)), site(), body, kind);
        for mut sim in [hanging, flying] {
            for _ in 0..steps {
                sim.step(&throttle, dt);
                let s = sim.sample(&throttle, None);
                let b = &s.balance;
                let in_ned = rotate_ned_from_body(s.state.body.q_ned_from_body, b.force_body());
                let sum = in_ned + b.gravity_force_ned + b.canopy_force_ned;
                prop_assert!((sum - s.a_ned * MASS_KG).norm() < 1e-9 * MASS_KG, "{:?}", s.phase);
                prop_assert!(b.canopy_force_ned.norm() == 0.0 || s.phase == Phase::Hanging);
                prop_assert!((sim.loads().a_ned - s.a_ned).norm() < 1e-12);
            }
        }
    }

    /// The recorded acceleration is the slope of the recorded velocity.
    #[test]
    fn prop_acceleration_is_the_slope_of_velocity(
        throttle in prop::array::uniform8(0.3f64..0.9), release in 0.0f64..0.5, steps in 1usize..400,
    ) {
        let mut sim = drop_of(lander(true), Start::Release);
        sim.schedule_release(release);
        for _ in 0..steps {
            sim.step(&throttle, 0.004);
        }
        let h = 1e-5;
        let before: PlantState = *sim.state();
        let phase = sim.phase();
        sim.step(&throttle, h);
        let a_ned = sim.loads().a_ned;
        sim.step(&throttle, h);
        if sim.phase() == phase {
            let slope = (sim.state().body.v_ned - before.body.v_ned) / (2.0 * h);
            prop_assert!((slope - a_ned).norm() < 1e-6, "{phase:?}: {slope} against {a_ned}");
        }
    }
}

/// In an atmosphere a vehicle high above the anchor has the loads of a site whose gravity and density are
/// those of that altitude; in flights of the study those of the anchor.
#[test]
fn closed_form_the_air_is_that_of_the_altitude() {
    let vehicle = Arc::new(lander(true));
    let anchor = GeoPoint { altitude_m: 1_000.0, ..GeoPoint::default() };
    let at = |altitude_m: f64| Atmosphere::Us1976.at(altitude_m).unwrap();
    let flat = |altitude_m: f64| {
        let air = at(altitude_m);
        Environment::new(air.gravity_m_s2, air.density_kg_m3, Vector3::zeros(), anchor).unwrap()
    };
    let site = flat(1_000.0).within(Atmosphere::Us1976).unwrap();
    let mut state = PlantState::rotors_at_rest(BodyState {
        p_ned: Vector3::new(10.0, 20.0, -3_000.0),
        q_ned_from_body: [1.0, 0.0, 0.0, 0.0],
        v_ned: Vector3::new(5.0, 1.0, 30.0),
        omega_body: Vector3::new(0.1, 0.2, 0.3),
    });
    state.rotor_speed = [50.0; MAX_ROTORS];
    let loads = |environment: Environment| {
        Plant::new(vehicle.clone(), environment, PlantKind::Actuator).loads(&state, &[0.5; MAX_ROTORS], false)
    };
    let (found, wanted) = (loads(site.clone()), loads(flat(4_000.0)));
    assert!((found.a_ned - wanted.a_ned).norm() < 1e-12, "{found:?} {wanted:?}");
    assert!((found.balance.thrust_n[0] / wanted.balance.thrust_n[0] - 1.0).abs() < 1e-12);
    assert!((found.a_ned - loads(flat(1_000.0)).a_ned).norm() > 0.1);
    let study = DropSimulation::at_t0(vehicle.clone(), site.clone(), state.body, PlantKind::Actuator);
    assert_eq!(*study.environment(), site.clone().uniform());
    assert!(flat(1_000.0).within(Atmosphere::Titan).is_ok());
    let above = Environment { anchor: GeoPoint { altitude_m: 11_000.0, ..anchor }, ..flat(1_000.0) };
    assert!(above.within(Atmosphere::Titan).is_err());
}
