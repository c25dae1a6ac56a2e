//! Vehicle and canopy as two bodies against closed forms: steady descent, the linearised double pendulum,
//! momentum, the gap that opens after the release, drift, a riser that goes slack.

use std::sync::Arc;

use nalgebra::Vector3;

use super::{DropSimulation, Phase, Start, nominal_state_at_t0};
use crate::control::test_vehicles::{GRAVITY_M_S2, J_YY, MASS_KG, lander, quadrotor, site};
use crate::frames::{pitch, rotate_body_from_ned, rotate_ned_from_body};
use crate::math;
use crate::model::canopy::{Canopy, Opening, Riser, SmallSwings, Suspension};
use crate::model::parachute::{Hook, Pendulum, TipOff};
use crate::model::wind::{Gust, GustLength, GustShape, Wind, WindProfile};
use crate::model::{Environment, Parachute, Vehicle, VehicleOptions};
use crate::sim::faults::{Fault, FaultKind};

const OFF: [f64; 8] = [0.0; 8];
const DT_S: f64 = 0.004;
/// Titan's canopy: 20 kg, 43.9 m^2, 250 kg of air; a riser of 10 m that stretches by 0.1 m.
const CANOPY_KG: f64 = 20.0;
const DRAG_AREA_M2: f64 = 43.9;
const APPARENT_KG: f64 = 250.0;
const DENSITY_KG_M3: f64 = 5.4;

fn airless() -> Vehicle {
    quadrotor([0.95, 1.1], [620.0, J_YY, 1160.0], [0.0; 3], VehicleOptions::default())
}

fn titan() -> Suspension {
    let riser = Riser::new(10.0, 1e4, 300.0, Vector3::new(0.0, 0.0, -1.0)).unwrap();
    Suspension { canopy: Canopy::new(CANOPY_KG, DRAG_AREA_M2, APPARENT_KG, None).unwrap(), riser }
}

/// A canopy so large that nothing which hangs from it changes its motion: it sinks at 3 m/s for ever.
fn held() -> Suspension {
    let mass_kg = 1e12;
    let drag_area_m2 = 2.0 * mass_kg * GRAVITY_M_S2 / (DENSITY_KG_M3 * 9.0);
    Suspension { canopy: Canopy::new(mass_kg, drag_area_m2, 0.0, None).unwrap(), ..titan() }
}

fn parachute(suspension: Suspension, amplitude_rad: f64, phase_rad: f64) -> Parachute {
    let pendulum = Pendulum { amplitude_rad, phase_rad, omega_rad_s: 2.0, length_m: 1.0 };
    Parachute { suspension: Some(suspension), ..Parachute::new(3.0, 2.5, pendulum).unwrap() }
}

fn drop_of(vehicle: Vehicle, parachute: Parachute, hang_s: f64) -> DropSimulation {
    let mut sim = DropSimulation::new(Arc::new(vehicle), site(), parachute, hang_s, Start::Release);
    sim.schedule_release(hang_s);
    sim
}

fn swings(suspension: &Suspension) -> SmallSwings {
    let vehicle = airless();
    let descent = suspension.steady_descent(&vehicle, &site()).unwrap();
    suspension.small_swings(&vehicle.mass, &site(), &descent)
}

/// Distance from the canopy to the vehicle's centre of mass [m].
fn distance_m(sim: &DropSimulation) -> f64 {
    (sim.state().body.p_ned - sim.canopy().unwrap().state.p_ned).norm()
}

/// Both bodies sink at `sqrt(2 (M + m) g/(rho CdS))` under a tension of M g, hang still, and the
/// accelerometer reads g; with air on the vehicle they sink more slowly and as steadily.
#[test]
fn closed_form_steady_descent() {
    let weight_n = (MASS_KG + CANOPY_KG) * GRAVITY_M_S2;
    let speed_m_s = (2.0 * weight_n / (DENSITY_KG_M3 * DRAG_AREA_M2)).sqrt();
    for (vehicle, speed_m_s) in [(airless(), Some(speed_m_s)), (lander(false), None)] {
        let is_airless = speed_m_s.is_some();
        let mut sim = drop_of(vehicle, parachute(titan(), 0.0, 0.0), 10.0);
        let begin = sim.state().body;
        let sinks_m_s = speed_m_s.unwrap_or(begin.v_ned.z);
        let released = loop {
            let s = sim.sample(&OFF, None);
            if s.phase != Phase::Hanging {
                break s;
            }
            assert!((s.state.body.v_ned - Vector3::new(0.0, 0.0, sinks_m_s)).norm() < 1e-9, "{}", s.t_s);
            assert!(s.a_ned.norm() < 1e-9);
            let canopy = s.canopy.unwrap();
            assert!((canopy.state.v_ned - s.state.body.v_ned).norm() < 1e-9);
            assert!((sim.specific_force_body() - Vector3::new(0.0, 0.0, -GRAVITY_M_S2)).norm() < 1e-9);
            if is_airless {
                assert!((canopy.tension_n - MASS_KG * GRAVITY_M_S2).abs() < 1e-6, "{}", canopy.tension_n);
            }
            sim.step(&OFF, DT_S);
        };
        assert!(is_airless || sinks_m_s < 3.02 && sinks_m_s > 2.9, "{sinks_m_s}");
        assert!(released.state.body.p_ned.norm() < 1e-8, "{:?}", released.state.body.p_ned);
    }
}

/// Frequencies of the linearised double pendulum, canopy held, no air, to 1e-6: the motion's share in each
/// mode is timed over many of its swings. The modes are orthogonal by the masses, so that the share is
/// `(M l x + ..)`: with rows (l, a) of the way of the centre of mass and (0, k) of the turning.
#[test]
fn closed_form_frequencies_of_the_double_pendulum() {
    let expected = swings(&held()).with_canopy_held().frequencies_rad_s();
    let (l, a) = (10.0 + MASS_KG * GRAVITY_M_S2 / 1e4, 1.0);
    // The vehicle swings; a push sideways stirs the slow mode too.
    let mut parachute = parachute(held(), 2e-4, 0.3);
    parachute.delay_s = 1e4;
    let mut sim = DropSimulation::new(Arc::new(airless()), site(), parachute, 0.0, Start::Release);
    sim.state.body.v_ned.x += 5e-4;
    // Shape (alpha, theta) of a mode: alpha = theta (1 - w^2/sigma).
    let sigma = MASS_KG * GRAVITY_M_S2 * a / J_YY;
    let shape = expected.map(|w| [1.0 - w * w / sigma, 1.0]);
    let share = |sim: &DropSimulation, [alpha_1, theta_1]: [f64; 2]| {
        let (body, canopy) = (&sim.state.body, &sim.canopy.unwrap());
        let (p_ned, _) = canopy.suspension.riser.confluence(body);
        let span = p_ned - canopy.state.p_ned;
        let (alpha, theta) = (math::atan2(span.x, span.z), pitch(body.q_ned_from_body));
        MASS_KG * (l * alpha + a * theta) * (l * alpha_1 + a * theta_1) + J_YY * theta * theta_1
    };
    let mut passages = [(0u32, 0.0, 0.0); 2];
    let mut before = shape.map(|s| share(&sim, s));
    let mut largest = [0.0f64; 2];
    while sim.time_s() < 400.0 {
        sim.step(&OFF, DT_S);
        let t_s = sim.time_s();
        for i in 0..2 {
            let now = share(&sim, shape[i]);
            largest[i] = largest[i].max(now.abs());
            if before[i] < 0.0 && now >= 0.0 {
                // The sine between two samples, to fourth order in the step: a straight line is enough, since
                // its error is the same at each passage but for the place in the step.
                let (n, first, _) = passages[i];
                let at = t_s - DT_S * now / (now - before[i]);
                passages[i] = (n + 1, if n == 0 { at } else { first }, at);
            }
            before[i] = now;
        }
    }
    assert!(largest.iter().all(|x| *x > 1e-2), "both modes move: {largest:?}");
    for (i, (n, first_s, last_s)) in passages.into_iter().enumerate() {
        let found = std::f64::consts::TAU * f64::from(n - 1) / (last_s - first_s);
        assert!((found / expected[i] - 1.0).abs() < 1e-6, "{found}, {}", expected[i]);
    }
}

/// The swing comes to the nominal release with the amplitude and the phase that it is to have, its decay
/// under the canopy's drag included: pitch and pitch rate are those of `theta_0 sin(w t + phi)`, within what
/// is not linear in the angle and the air on the vehicle, which are left out.
#[test]
fn closed_form_the_swing_comes_to_the_release_as_it_is_to() {
    let mode = swings(&titan()).swing();
    for phase_rad in [0.0, 0.7, 1.6, 2.9, -2.0] {
        let mut sim = drop_of(airless(), parachute(titan(), 1e-3, phase_rad), 10.0);
        let mut largest = 0.0f64;
        while sim.phase() == Phase::Hanging {
            largest = largest.max(pitch(sim.state().body.q_ned_from_body).abs());
            sim.step(&OFF, DT_S);
        }
        let body = sim.state().body;
        let (sin, cos) = math::sin_cos(phase_rad);
        let rate = 1e-3 * (mode.rate.im * cos + mode.rate.re * sin);
        assert!((pitch(body.q_ned_from_body) - 1e-3 * sin).abs() < 1e-8, "{phase_rad}");
        assert!((body.omega_body.y - rate).abs() < 1e-8, "{phase_rad}");
        assert!(largest > 1.05e-3, "it begins larger");
        assert!(body.p_ned.norm() < 1e-5, "released where the release is to be: {}", body.p_ned);
    }
}

/// What a plan starts from is near what the drop comes to.
#[test]
fn the_linearised_release_is_near_the_real_one() {
    let hang = parachute(titan(), 0.1, 0.8);
    let mut sim = drop_of(lander(false), hang, 10.0);
    while sim.phase() != Phase::Powered {
        sim.step(&OFF, DT_S);
    }
    let vehicle = Arc::new(lander(false));
    let expected = nominal_state_at_t0(vehicle, site(), hang, Start::Release);
    let found = sim.state().body;
    assert!((found.v_ned - expected.v_ned).norm() < 0.05, "{found:?} {expected:?}");
    assert!((pitch(found.q_ned_from_body) - pitch(expected.q_ned_from_body)).abs() < 0.03);
}

/// Momentum of vehicle, canopy and apparent mass less the impulse of weight and air, which is integrated in
/// the same stages, from 1 s before to 2 s after the release: 1e-9 of M v. In the wind, swinging, with air on
/// the vehicle, and while the canopy still fills.
#[test]
fn closed_form_momentum_of_both_bodies() {
    let opening = Some(Opening { duration_s: 5.5, descent_m_s: 9.0 });
    for opening in [None, opening] {
        let canopy = Canopy::new(CANOPY_KG, DRAG_AREA_M2, APPARENT_KG, opening).unwrap();
        let hang = parachute(Suspension { canopy, ..titan() }, 0.2, 1.0);
        let wind_ned_m_s = Vector3::new(2.0, -3.0, 0.5);
        let environment = Environment { wind_ned_m_s, ..site() };
        let mut sim = DropSimulation::new(Arc::new(lander(false)), environment, hang, 5.0, Start::Release);
        sim.schedule_release(5.0);
        let unbalanced = |sim: &DropSimulation| {
            let two = sim.canopy().unwrap();
            let inertia_kg = two.suspension.canopy.inertia_kg(sim.time_s());
            sim.state().body.v_ned * MASS_KG + two.state.v_ned * inertia_kg - two.impulse_ned
        };
        while sim.time_s() < 4.0 - 1e-9 {
            sim.step(&OFF, DT_S);
        }
        let (at_first, momentum) = (unbalanced(&sim), MASS_KG * sim.state().body.v_ned.norm());
        while sim.time_s() < 7.0 - 1e-9 {
            sim.step(&OFF, DT_S);
            let miss = (unbalanced(&sim) - at_first).norm();
            assert!(miss < 1e-9 * momentum, "{} s: {miss} of {momentum} kg m/s", sim.time_s());
        }
        assert_eq!(sim.phase(), Phase::Falling);
        assert!((sim.canopy().unwrap().impulse_ned).norm() > 1e3, "something acts");
    }
}

/// A drop whose bridle hangs up by a leg in front and to the right, from the release at 5 s until 3 s after
/// t = 0, under half throttle.
fn hung_up(attachment_body_m: Vector3<f64>) -> DropSimulation {
    let hang = Parachute { delay_s: 0.5, ..parachute(titan(), 0.05, 1.0) };
    let kind = FaultKind::RiserHungUp { attachment_body_m };
    let fault = Fault { kind, at_s: -2.0, until_s: Some(3.0) };
    drop_of(lander(false), hang, 5.0).with_faults(&[fault])
}

/// A riser that hangs up by one leg goes on pulling at the leg's end, as long as it and the leg together:
/// momentum of both bodies less the impulse of weight, air and rotors holds to 1e-9 of M v with the rotors
/// locked and free, the moment is that of the leg's end, and once it has come free nothing pulls.
#[test]
fn closed_form_a_riser_that_hangs_up() {
    let fixed = Vector3::new(0.6, 0.4, -0.5);
    let mut sim = hung_up(fixed);
    let half = [0.5; 8];
    let leg_m = (fixed - titan().riser.attachment_body_m).norm();
    let unbalanced = |sim: &DropSimulation| {
        let two = sim.canopy().unwrap();
        let inertia_kg = two.suspension.canopy.inertia_kg(sim.time_s());
        sim.state().body.v_ned * MASS_KG + two.state.v_ned * inertia_kg - two.impulse_ned
    };
    let (at_first, momentum) = (unbalanced(&sim), MASS_KG * sim.state().body.v_ned.norm());
    let (mut pulled, mut turned) = (0, 0.0f64);
    while sim.time_s() < 8.5 - 1e-9 {
        let s = sim.advance_sampled(&half, None, DT_S);
        let miss = (unbalanced(&sim) - at_first).norm();
        assert!(miss < 1e-9 * momentum, "{} s: {miss} of {momentum} kg m/s", s.t_s);
        if s.phase != Phase::Hanging && s.canopy.unwrap().tension_n > 0.0 {
            pulled += 1;
            let force_body = rotate_body_from_ned(s.state.body.q_ned_from_body, s.balance.canopy_force_ned);
            assert!((s.balance.canopy_moment_body - fixed.cross(&force_body)).norm() < 1e-9);
            let end = s.state.body.p_ned + rotate_ned_from_body(s.state.body.q_ned_from_body, fixed);
            let stretch_m = (end - s.canopy.unwrap().state.p_ned).norm() - (10.0 + leg_m);
            let missed_n = s.balance.canopy_force_ned.norm() - s.canopy.unwrap().tension_n;
            assert!(stretch_m > 0.0 && missed_n.abs() < 1e-9, "{stretch_m} {missed_n}");
            turned = turned.max(s.state.body.omega_body.norm());
        }
    }
    assert_eq!(sim.phase(), Phase::Powered);
    assert!(pulled > 100 && turned > 0.1, "it pulls in {pulled} steps and turns the vehicle at {turned}");
    while sim.time_s() < 9.5 {
        let s = sim.advance_sampled(&half, None, DT_S);
        assert_eq!((s.canopy.unwrap().tension_n, s.balance.canopy_force_ned), (0.0, Vector3::zeros()));
    }
}

/// A leg that has come free before the release, or hangs up after it, changes nothing.
#[test]
fn prop_a_riser_that_comes_free_in_time_is_none() {
    let kind = FaultKind::RiserHungUp { attachment_body_m: Vector3::new(0.6, 0.4, -0.5) };
    let flown = |faults: &[Fault]| {
        let mut sim = drop_of(lander(false), parachute(titan(), 0.05, 1.0), 2.0).with_faults(faults);
        while sim.time_s() < 6.0 {
            sim.step(&[0.5; 8], DT_S);
        }
        (*sim.state(), sim.canopy().unwrap().state)
    };
    let clean = flown(&[]);
    // The nominal t = 0 is 2.5 s after the release.
    assert_eq!(flown(&[Fault { kind, at_s: -4.0, until_s: Some(-2.6) }]), clean);
    assert_eq!(flown(&[Fault { kind, at_s: -2.0, until_s: None }]), clean);
    assert_ne!(flown(&[Fault { kind, at_s: -2.6, until_s: None }]), clean);
}

/// Steps of the caller do not show: a step of 20 ms is divided for a stiff riser.
#[test]
fn prop_a_stiff_riser_is_integrated_in_short_steps() {
    let riser = Riser::new(10.0, 1e7, 1e4, Vector3::new(0.1, 0.0, -1.0)).unwrap();
    let after = |dt_s: f64| {
        let mut sim = drop_of(lander(false), parachute(Suspension { riser, ..titan() }, 0.2, 1.0), 4.0);
        while sim.time_s() < 3.98 - 1e-9 {
            sim.step(&OFF, dt_s);
        }
        sim.state().body
    };
    let (coarse, fine) = (after(0.02), after(0.001));
    assert!((coarse.v_ned - fine.v_ned).norm() < 1e-5, "{coarse:?} {fine:?}");
    assert!((coarse.omega_body - fine.omega_body).norm() < 1e-5);
}

/// A canopy that keeps its speed and a vehicle without drag: the gap opens as g t^2/2, 0.169 and 0.675 m
/// after 0.5 and 1 s.
#[test]
fn closed_form_gap_below_a_canopy_that_keeps_its_speed() {
    let mut sim = drop_of(airless(), parachute(held(), 0.0, 0.0), 2.0);
    while sim.phase() == Phase::Hanging {
        sim.step(&OFF, DT_S);
    }
    let hung_m = distance_m(&sim);
    for (t_s, printed) in [(0.5, "0.169"), (1.0, "0.675")] {
        while sim.time_s() < 2.0 + t_s - 1e-9 {
            sim.step(&OFF, DT_S);
        }
        let gap_m = distance_m(&sim) - hung_m;
        assert!((gap_m - 0.5 * GRAVITY_M_S2 * t_s * t_s).abs() < 1e-6, "{gap_m}");
        assert_eq!(format!("{gap_m:.3}"), printed);
    }
}

/// Titan's canopy, relieved of its load, slows down: with `m' = m + m_a`, `v_e^2 = 2 m g/(rho CdS)` and
/// `k = m g/(m' v_e)` its speed is `v_e coth(k t + c)`, its way `(v_e/k) ln(sinh(k t + c)/sinh c)`, and the
/// gap is 0.515 and 1.751 m after 0.5 and 1 s.
#[test]
fn closed_form_gap_below_a_relieved_canopy() {
    let mut sim = drop_of(airless(), parachute(titan(), 0.0, 0.0), 2.0);
    while sim.phase() == Phase::Hanging {
        sim.step(&OFF, DT_S);
    }
    let (hung_m, v_m_s) = (distance_m(&sim), sim.state().body.v_ned.z);
    let v_e = (2.0 * CANOPY_KG * GRAVITY_M_S2 / (DENSITY_KG_M3 * DRAG_AREA_M2)).sqrt();
    let k = CANOPY_KG * GRAVITY_M_S2 / ((CANOPY_KG + APPARENT_KG) * v_e);
    let c = math::atanh(v_e / v_m_s);
    let sinh = |x: f64| 0.5 * (math::exp(x) - math::exp(-x));
    let mut gaps = Vec::new();
    for t_s in [0.5, 1.0, 2.0] {
        while sim.time_s() < 2.0 + t_s - 1e-9 {
            sim.step(&OFF, DT_S);
        }
        let way_m = v_e / k * math::ln(sinh(k * t_s + c) / sinh(c));
        let gap_m = v_m_s * t_s + 0.5 * GRAVITY_M_S2 * t_s * t_s - way_m;
        assert!((distance_m(&sim) - hung_m - gap_m).abs() < 1e-6, "{t_s}: {gap_m}");
        gaps.push(format!("{gap_m:.3}"));
    }
    assert_eq!(gaps, ["0.515", "1.751", "5.713"]);
}

/// In a steady wind both bodies move as in calm air, carried along; a wind that sets in carries them along
/// once its gust has been followed; where the wind changes with altitude each meets its own.
#[test]
fn closed_form_two_bodies_drift_with_the_wind() {
    let fly = |wind_ned_m_s: Vector3<f64>, wind: &Wind, hang_s: f64| {
        let environment = Environment { wind_ned_m_s, ..site() };
        let course = wind.course(&environment, 1);
        let hang = parachute(titan(), 0.1, 0.4);
        let sim = DropSimulation::new(Arc::new(airless()), environment, hang, hang_s, Start::Release);
        let mut sim = sim.in_wind(course);
        sim.schedule_release(hang_s);
        while sim.time_s() < hang_s + 1.0 {
            sim.step(&OFF, DT_S);
        }
        sim
    };
    let w = Vector3::new(3.0, -2.0, 0.5);
    let (calm, windy) = (fly(w * 0.0, &Wind::default(), 6.0), fly(w, &Wind::default(), 6.0));
    let carried = w * (calm.time_s() - 6.0);
    let [a, b] = [&calm, &windy].map(|sim| (sim.state().body, sim.canopy().unwrap().state));
    assert!(
        (b.0.p_ned - a.0.p_ned - carried).norm() < 1e-8 && (b.1.p_ned - a.1.p_ned - carried).norm() < 1e-8
    );
    assert!((b.0.v_ned - a.0.v_ned - w).norm() < 1e-9 && (b.1.v_ned - a.1.v_ned - w).norm() < 1e-9);

    let (shape, length) = (GustShape::Step, GustLength::Time(f64::INFINITY));
    let gust = Gust { shape, start_s: -1e3, length, peak_ned_m_s: [0.0, 4.0, 0.0] };
    let gusty = fly(w * 0.0, &Wind { gusts: vec![gust], ..Wind::default() }, 200.0);
    let canopy_m_s = gusty.canopy().unwrap().state.v_ned.y;
    assert!((canopy_m_s - 4.0).abs() < 1e-3, "{canopy_m_s}");

    // 1 m/s more per metre up: the canopy, 11 m above the vehicle, meets 11 m/s more.
    let at = |altitude_m: f64, north: f64| (altitude_m, Vector3::new(north, 0.0, 0.0));
    let profile = WindProfile::new(vec![at(-100.0, -100.0), at(100.0, 100.0)]).unwrap();
    let sheared = fly(w * 0.0, &Wind { profile: Some(profile), ..Wind::default() }, 0.0);
    let two = sheared.canopy().unwrap();
    let below_m = sheared.state().body.p_ned.z - two.state.p_ned.z;
    let more = two.wind_ned - sheared.environment().wind_ned_m_s;
    assert!((more - Vector3::new(below_m, 0.0, 0.0)).norm() < 0.05, "{more} {below_m}");
}

/// Thrown up, the vehicle slackens its riser, falls back and is caught: no force while it is slack, and the
/// energy of both bodies and the spring never grows; without damping it stays.
#[test]
fn prop_a_slack_riser_catches_without_a_gain_of_energy() {
    for damping_n_s_m in [0.0, 300.0] {
        let riser = Riser { damping_n_s_m, ..titan().riser };
        let mut sim = drop_of(airless(), parachute(Suspension { riser, ..held() }, 0.1, 0.3), 60.0);
        sim.state.body.v_ned.z -= 3.0;
        // In the frame of the canopy, which keeps its 3 m/s.
        let energy_j = |sim: &DropSimulation| {
            let (body, two) = (&sim.state.body, sim.canopy.unwrap());
            let v = body.v_ned - two.state.v_ned;
            let below_m = body.p_ned.z - two.state.p_ned.z;
            let stretch_m = (riser.confluence(body).0 - two.state.p_ned).norm() - riser.length_m;
            let spring = 0.5 * riser.stiffness_n_m * stretch_m.max(0.0).powi(2);
            let inertia = sim.vehicle().mass.inertia_kg_m2;
            0.5 * MASS_KG * v.norm_squared()
                + 0.5 * body.omega_body.dot(&(inertia * body.omega_body))
                + spring
                - MASS_KG * GRAVITY_M_S2 * below_m
        };
        let begin_j = energy_j(&sim);
        let (mut before_j, mut slack, mut caught_n) = (begin_j, 0, 0.0f64);
        while sim.time_s() < 20.0 {
            let tension_n = sim.sample(&OFF, None).canopy.unwrap().tension_n;
            slack += u32::from(tension_n == 0.0);
            caught_n = caught_n.max(tension_n);
            if tension_n == 0.0 {
                assert_eq!(sim.sample(&OFF, None).balance.canopy_force_ned, Vector3::zeros());
            }
            sim.step(&OFF, DT_S);
            let now_j = energy_j(&sim);
            assert!(now_j < before_j + 0.5, "{} s: {before_j} {now_j} J", sim.time_s());
            before_j = now_j;
        }
        assert!(slack > 500 && caught_n > 3.0 * MASS_KG * GRAVITY_M_S2, "{slack} {caught_n}");
        match damping_n_s_m == 0.0 {
            true => assert!((before_j - begin_j).abs() < 1.0, "{begin_j} {before_j}"),
            false => assert!(before_j < begin_j - 100.0, "{begin_j} {before_j}"),
        }
    }
}

/// Under a canopy that fills, both bodies first fall nearly freely, are then slowed down harder than their
/// weight, and come to the steady descent.
#[test]
fn an_opening_canopy_slows_both_bodies_to_the_steady_descent() {
    let opening = Some(Opening { duration_s: 2.0, descent_m_s: 12.0 });
    let canopy = Canopy::new(CANOPY_KG, DRAG_AREA_M2, APPARENT_KG, opening).unwrap();
    let mut sim = drop_of(lander(false), parachute(Suspension { canopy, ..titan() }, 0.0, 0.0), 20.0);
    assert!((sim.state().body.v_ned.z - 12.0).abs() < 1e-12);
    let mut snatch_n = 0.0f64;
    while sim.phase() == Phase::Hanging {
        snatch_n = snatch_n.max(sim.sample(&OFF, None).canopy.unwrap().tension_n);
        sim.step(&OFF, DT_S);
    }
    assert!(snatch_n > 2.0 * MASS_KG * GRAVITY_M_S2, "{snatch_n}");
    let steady = titan().steady_descent(&lander(false), &site()).unwrap();
    assert!((sim.state().body.v_ned.z - steady.speed_m_s).abs() < 1e-3);
}

/// The cut adds the rates and the velocity that it is to, in body axes, once.
#[test]
fn closed_form_tip_off() {
    let tip_off = TipOff { omega_body: Vector3::new(0.1, -0.2, 0.3), v_body: Vector3::new(0.5, 0.0, -0.4) };
    for suspension in [None, Some(titan())] {
        let plain = Parachute { suspension, ..parachute(titan(), 0.1, 0.9) };
        let fly = |parachute| {
            let mut sim = drop_of(lander(false), parachute, 2.0);
            while sim.phase() == Phase::Hanging {
                sim.step(&OFF, 2.0);
            }
            sim.state().body
        };
        let (with, without) = (fly(Parachute { tip_off, ..plain }), fly(plain));
        assert_eq!(with.omega_body, without.omega_body + tip_off.omega_body);
        let more = rotate_ned_from_body(without.q_ned_from_body, tip_off.v_body);
        assert!((with.v_ned - without.v_ned - more).norm() < 1e-15);
        let (a, b) =
            (plain.state_at_t0(GRAVITY_M_S2), Parachute { tip_off, ..plain }.state_at_t0(GRAVITY_M_S2));
        assert_eq!(b.omega_body, a.omega_body + tip_off.omega_body);
    }
}

/// A property: a hook holds the vehicle at rest; let go, it comes to the release as a drop does that began
/// there in steady descent with the drawn swing, to a twentieth of it and 1 % of the descent, and nothing of
/// its motion jumps where the two bodies take over.
#[test]
fn prop_two_bodies_take_over_from_a_hook() {
    let (hang_s, lets_go_before_s) = (40.0, 30.0);
    let (amplitude_rad, phase_rad) = (0.1, 1.0);
    let swinging = parachute(titan(), amplitude_rad, phase_rad);
    let hooked = swinging.on_hook(Hook { lets_go_before_s });
    let before_s = hooked.linearised(&lander(false), &site()).built_up_before_s(GRAVITY_M_S2).unwrap();
    assert!((23.0..24.0).contains(&before_s), "3 v/g of the 30 s: {before_s}");
    let mut sim = drop_of(lander(false), hooked, hang_s);
    let mut begun = drop_of(lander(false), swinging, before_s);
    while sim.phase() == Phase::Hanging {
        let (body, a_ned, had) = (sim.state().body, sim.sample(&OFF, None).a_ned, sim.canopy().is_some());
        if sim.time_s() <= hang_s - lets_go_before_s {
            assert_eq!((body.v_ned, body.omega_body), (Vector3::zeros(), Vector3::zeros()));
        }
        let lets_go = (sim.time_s() - (hang_s - lets_go_before_s)).abs() < 2.0 * DT_S;
        sim.step(&OFF, DT_S);
        // What lets go falls.
        let jump = sim.state().body.v_ned - body.v_ned - a_ned * DT_S;
        assert!(lets_go || jump.norm() < 0.02 * GRAVITY_M_S2 * DT_S, "{} s: {jump:?}", sim.time_s());
        let turned = sim.state().body.omega_body - body.omega_body;
        assert!(turned.norm() < 2.0 * amplitude_rad * 4.0 * DT_S, "{} s: {turned:?}", sim.time_s());
        if sim.canopy().is_some() != had && !had {
            assert!((sim.time_s() - (hang_s - before_s)).abs() < DT_S, "{}", sim.time_s());
        }
    }
    while begun.phase() == Phase::Hanging {
        begun.step(&OFF, DT_S);
    }
    let [found, wanted] = [&sim, &begun].map(|sim| sim.state().body);
    let apart = pitch(found.q_ned_from_body) - pitch(wanted.q_ned_from_body);
    assert!(apart.abs() < 0.05 * amplitude_rad, "{apart}");
    assert!((found.v_ned - wanted.v_ned).norm() < 0.03, "{:?} {:?}", found.v_ned, wanted.v_ned);
    assert!(found.p_ned.norm() < 0.5, "{:?}", found.p_ned);
}
