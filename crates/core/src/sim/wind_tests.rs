//! What wind that changes does to a vehicle: closed forms for the drift of a body that has only drag, and
//! signs.

use std::sync::Arc;

use nalgebra::Vector3;

use super::{DropSimulation, Phase, PlantKind, Start};
use crate::control::test_vehicles::{lander, quadrotor, site};
use crate::frames::LEVEL;
use crate::model::parachute::Pendulum;
use crate::model::rigid_body::BodyState;
use crate::model::wind::{Draw, Gust, GustLength, GustShape, Turbulence, TurbulenceScale, Wind, WindProfile};
use crate::model::{BodyAero, Environment, Parachute, Vehicle, VehicleOptions};

const OFF: [f64; 8] = [0.0; 8];
/// Mass, drag area and density of the body.
const DRAG_AREA_M2: f64 = 2.0;

/// A body with the same drag from all sides, without lift and moment.
fn drag_body() -> Vehicle {
    let mut vehicle = quadrotor([0.95, 1.1], [620.0, 890.0, 1160.0], [0.0; 3], VehicleOptions::default());
    let turn = [-180.0f64, -90.0, 0.0, 90.0, 180.0].map(f64::to_radians);
    let aero = BodyAero::new(DRAG_AREA_M2, 1.0, &turn, &[1.0; 5], &[0.0; 5], &[0.0; 5]).unwrap();
    vehicle.aero = aero.with_side_area(DRAG_AREA_M2).unwrap();
    vehicle
}

/// Hardly any gravity: what moves the body is the air.
fn weightless() -> Environment {
    Environment { gravity_m_s2: 1e-12, ..site() }
}

fn at_rest() -> BodyState {
    let zero = Vector3::zeros();
    BodyState { p_ned: zero, q_ned_from_body: LEVEL, v_ned: zero, omega_body: zero }
}

fn in_wind(environment: Environment, wind: &Wind) -> DropSimulation {
    let course = wind.uniform(&environment).course(&environment, 1);
    DropSimulation::at_t0(Arc::new(drag_body()), environment, at_rest(), PlantKind::Ideal).in_wind(course)
}

fn gust(shape: GustShape, length: GustLength, peak_ned_m_s: [f64; 3]) -> Wind {
    Wind { gusts: vec![Gust { shape, start_s: 1.0, length, peak_ned_m_s }], ..Wind::default() }
}

/// A body at rest in a wind W that sets in: its speed through the air falls as `u = W/(1 + k W t)`,
/// k = rho A/(2 m), so that its velocity over ground is W - u. In each direction the wind blows to: not
/// where it comes from.
#[test]
fn closed_form_a_drag_body_drifts_with_the_wind() {
    for peak in [
        [6.0, 0.0, 0.0],
        [-6.0, 0.0, 0.0],
        [0.0, 0.0, 6.0],
        [3.0, 0.0, -2.0],
        [0.0, -6.0, 0.0],
        [1.0, 5.0, -2.0],
    ] {
        let mut sim = in_wind(weightless(), &gust(GustShape::Step, GustLength::Time(f64::INFINITY), peak));
        let k = 0.5 * 5.4 * DRAG_AREA_M2 / sim.vehicle().mass.mass_kg;
        let wind = Vector3::from(peak);
        for step in 0..2_000 {
            let t = f64::from(step) * 0.01 - 1.0;
            let expected =
                if t > 0.0 { wind * (1.0 - 1.0 / (1.0 + k * wind.norm() * t)) } else { wind * 0.0 };
            assert!((sim.state().body.v_ned - expected).norm() < 1e-9, "{peak:?} at {t} s");
            sim.step(&OFF, 0.01);
        }
        assert!(sim.state().body.v_ned.dot(&wind) > 0.2 * wind.norm_squared());
    }
}

/// A gust by distance that the body meets standing never passes; flown through at 8 m/s, 20 m last 2.5 s.
#[test]
fn closed_form_a_gust_by_distance_lasts_as_long_as_the_flight_through_it() {
    let wind = gust(GustShape::OneMinusCosine, GustLength::Distance(20.0), [0.0, 0.0, 1e-6]);
    let environment = weightless();
    let heavy = {
        let mut vehicle = drag_body();
        vehicle.aero = vehicle.aero.scaled([0.0; 3]);
        Arc::new(vehicle)
    };
    for (speed_m_s, end_s) in [(8.0, Some(3.5)), (0.0, None)] {
        let start = BodyState { v_ned: Vector3::new(speed_m_s, 0.0, 0.0), ..at_rest() };
        let course = wind.course(&environment, 1);
        let sim = DropSimulation::at_t0(heavy.clone(), environment.clone(), start, PlantKind::Ideal);
        let mut sim = sim.in_wind(course);
        let mut blown = Vec::new();
        for _ in 0..500 {
            sim.step(&OFF, 0.01);
            blown.push(sim.environment().wind_ned_m_s.z / 1e-6);
        }
        let Some(end_s) = end_s else {
            assert!(blown.iter().all(|w| *w == 0.0), "no way into it");
            continue;
        };
        for (k, found) in blown.into_iter().enumerate() {
            let t = (k as f64 + 0.5) * 0.01;
            let inside = (1.0..end_s).contains(&t);
            let expected = if inside {
                0.5 * (1.0 - crate::math::cos(std::f64::consts::TAU * (t - 1.0) / 2.5))
            } else {
                0.0
            };
            assert!((found - expected).abs() < 1e-9, "{t} s: {found}, {expected}");
        }
    }
}

/// Turbulence acts along and across the mean wind at the site: with given noise in one filter only, each
/// moves the air in its own direction.
#[test]
fn turbulence_is_in_the_axes_of_the_mean_wind() {
    let mean = Vector3::new(-3.0, 4.0, 0.5);
    for (k, direction) in
        [(0, Vector3::new(-0.6, 0.8, 0.0)), (1, Vector3::new(-0.8, -0.6, 0.0)), (3, Vector3::z())]
    {
        let mut first: Draw = [0.0; 5];
        first[k] = 1.0;
        let turbulence = Turbulence {
            sigma_m_s: [2.0; 3],
            scale: TurbulenceScale::Fixed([50.0; 3]),
            seed: 0,
            follows_mission: true,
            noise: Some([first].into()),
        };
        let wind = Wind { turbulence: Some(turbulence), ..Wind::default() };
        let environment = Environment { wind_ned_m_s: mean, ..weightless() };
        let mut sim = in_wind(environment, &wind);
        sim.step(&OFF, 0.01);
        let gust = sim.environment().wind_ned_m_s - mean;
        assert!(gust.norm() > 0.5 && (gust.normalize() - direction).norm() < 1e-12, "{k}: {gust}");
    }
}

/// Turbulence keeps its axes where the mean wind by altitude passes through zero and turns about: eddies of
/// 1000 km do not change on the way.
#[test]
fn turbulence_does_not_turn_about_where_the_mean_wind_does() {
    let mut environment = weightless();
    environment.anchor.altitude_m = 600.0;
    let east = |e: f64| Vector3::new(0.0, e, 0.0);
    // 0.1 m/s to the east at the site, none 1 m below it, to the west further down.
    let profile = WindProfile::new(vec![(500.0, east(-9.9)), (700.0, east(10.1))]).unwrap();
    environment.wind_ned_m_s = profile.at(600.0);
    let turbulence = Turbulence {
        sigma_m_s: [2.0; 3],
        scale: TurbulenceScale::Fixed([1e6; 3]),
        seed: 0,
        follows_mission: true,
        noise: Some([[1.0, 0.0, 0.0, 0.0, 0.0]].into()),
    };
    let wind = Wind { turbulence: Some(turbulence), profile: Some(profile.clone()), ..Wind::default() };
    let falling = BodyState { v_ned: Vector3::new(0.0, 0.0, 4.0), ..at_rest() };
    let course = wind.course(&environment, 1);
    let sim = DropSimulation::at_t0(Arc::new(drag_body()), environment, falling, PlantKind::Ideal);
    let mut sim = sim.in_wind(course);
    for _ in 0..100 {
        let mean = profile.at(600.0 - sim.state().body.p_ned.z);
        sim.step(&OFF, 0.01);
        let gust = sim.environment().wind_ned_m_s - mean;
        assert!((gust - east(2.0)).norm() < 1e-3, "{gust} where the mean wind is {mean}");
    }
    assert!(sim.state().body.p_ned.z > 2.0, "the mean wind did not turn");
}

/// Under the canopy the vehicle drifts with the mean wind at the site's altitude whatever blows; the wind by
/// altitude is that of where it is.
#[test]
fn closed_form_the_canopy_drifts_with_the_mean_wind_and_the_fall_meets_that_of_its_altitude() {
    let still = Pendulum { amplitude_rad: 0.0, phase_rad: 0.0, omega_rad_s: 0.0, length_m: 0.0 };
    let parachute = Parachute::new(5.0, 0.5, still).unwrap();
    let mut environment = site();
    environment.anchor.altitude_m = 600.0;
    environment.wind_ned_m_s = Vector3::new(2.0, 0.0, 0.0);
    let wind_at = |n: f64| Vector3::new(n, 0.0, 0.0);
    // 2 m/s at 600 m, 0.04 m/s more per metre.
    let profile = WindProfile::new(vec![(500.0, wind_at(-2.0)), (700.0, wind_at(6.0))]).unwrap();
    let wind = Wind {
        profile: Some(profile),
        gusts: vec![Gust {
            shape: GustShape::Step,
            start_s: -2.0,
            length: GustLength::Time(1.0),
            peak_ned_m_s: [0.0, 9.0, 0.0],
        }],
        ..Wind::default()
    };
    let course = wind.course(&environment, 0);
    let sim = DropSimulation::new(Arc::new(lander(false)), environment, parachute, 4.0, Start::Release);
    let mut sim = sim.in_wind(course);
    sim.schedule_release(4.0);
    while sim.phase() == Phase::Hanging {
        let t = sim.time_s();
        assert!((sim.state().body.v_ned - Vector3::new(2.0, 0.0, 5.0)).norm() < 1e-12, "{t} s");
        let altitude_m = 600.0 + 5.0 * (4.0 - t);
        sim.step(&OFF, 0.01);
        let found = sim.environment().wind_ned_m_s;
        assert!((found.x - (2.0 + 0.04 * (altitude_m - 600.0))).abs() < 1e-9, "{t} s: {found}");
        // t = 0 is at 4.5 s: the gust blows from 2.5 to 3.5 s.
        assert_eq!(found.y != 0.0, (2.499..3.499).contains(&t), "{t} s");
    }
}
