//! The prediction against closed forms, and the times of renewals.

use nalgebra::Vector3;

use super::*;
use crate::frames::{quaternion_from_euler, rotate_ned_from_body, yaw};
use crate::model::rigid_body::BodyState;
use crate::random::{Purpose, Stream};
use crate::sim::Start;
use crate::sim::test_site::{environment, vehicle};
use crate::trajectory::{Node, Trajectory};

fn plan() -> Trajectory {
    let nodes = vec![
        Node::level(0.0, Vector3::new(0.0, 0.0, 3.0)),
        Node::level(5.0, Vector3::x()),
        Node::level(10.0, Vector3::new(2.0, 0.0, 1.0)),
    ];
    Trajectory::new(nodes, 4).unwrap()
}

fn other_plan() -> Trajectory {
    Trajectory::new(vec![Node::level(0.0, Vector3::x()), Node::level(10.0, Vector3::y())], 4).unwrap()
}

fn state(v_ned: Vector3<f64>) -> BodyState {
    BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: [1.0, 0.0, 0.0, 0.0],
        v_ned,
        omega_body: Vector3::zeros(),
    }
}

fn solved(request: &ReplanRequest) -> ReplanAnswer {
    ReplanAnswer { number: request.number, found: Ok(other_plan()), iterations: 5 }
}

/// (44): in a vacuum the fall adds g t, and neither attitude nor rates change.
#[test]
fn closed_form_the_fall_of_the_study() {
    let (vehicle, environment) = (vehicle(), environment());
    let q = quaternion_from_euler(0.1, -0.2, 0.0);
    let seen = BodyState {
        q_ned_from_body: q,
        omega_body: Vector3::new(0.1, 0.2, 0.3),
        ..state(Vector3::new(1.0, 2.0, 3.0))
    };
    let site = (&*vehicle, &environment, Start::T0);
    let expected = expected_state(site, (-0.4, seen), &plan(), -0.1).unwrap();
    let v = seen.v_ned + Vector3::z() * (0.3 * environment.gravity_m_s2);
    assert!((expected.v_ned - v).norm() < 1e-15);
    assert_eq!((expected.q_ned_from_body, expected.omega_body), (q, seen.omega_body));
}

/// In next to no air a body that turns about a principal axis falls with g t and turns by omega t, before
/// t = 0 and, with rotors at rest, after it.
#[test]
fn closed_form_a_fall_in_no_air() {
    let (vehicle, mut environment) = (vehicle(), environment());
    environment.density_kg_m3 = 1e-12;
    let seen = BodyState { omega_body: Vector3::y() * 0.7, ..state(Vector3::new(1.0, 0.0, 3.0)) };
    let site = (&*vehicle, &environment, Start::Release);
    let expected = expected_state(site, (-0.3, seen), &plan(), 0.2).unwrap();
    let v = seen.v_ned + Vector3::z() * (0.5 * environment.gravity_m_s2);
    let q = quaternion_from_euler(0.0, 0.35, 0.0);
    assert!((expected.v_ned - v).norm() < 1e-9, "{:?}", expected.v_ned);
    let off = q.iter().zip(expected.q_ned_from_body).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-9, "{off}");
}

/// What is no number is not expected to be one.
#[test]
fn a_state_that_is_no_number_is_refused() {
    let (vehicle, environment) = (vehicle(), environment());
    let site = (&*vehicle, &environment, Start::Release);
    let seen = state(Vector3::new(f64::NAN, 0.0, 0.0));
    assert_eq!(expected_state(site, (-0.1, seen), &plan(), 0.0), None);
}

/// Without its heading a state has the up axis, its motion and the velocity that it had, and no yaw.
#[test]
fn prop_the_heading_is_taken_out_alone() {
    let mut random = Stream::new(1, Purpose::Dice, 1);
    for _ in 0..200 {
        let mut angle = |most: f64| random.between(-most, most);
        let q = quaternion_from_euler(angle(1.5), angle(1.4), angle(3.0));
        let omega = Vector3::new(angle(2.0), angle(2.0), angle(2.0));
        let given = BodyState { q_ned_from_body: q, omega_body: omega, ..state(Vector3::new(1.0, 2.0, 3.0)) };
        let north = nose_north(&given);
        let up = |s: &BodyState| rotate_ned_from_body(s.q_ned_from_body, Vector3::z());
        let turns = |s: &BodyState| rotate_ned_from_body(s.q_ned_from_body, s.omega_body).cross(&up(s));
        assert!((up(&north) - up(&given)).norm() < 1e-12);
        assert!((turns(&north) - turns(&given)).norm() < 1e-12);
        assert_eq!((north.v_ned, north.omega_body.z), (given.v_ned, 0.0));
        assert!(north.q_ned_from_body[3].abs() < 1e-12);
    }
    let planar = state(Vector3::x());
    let tipped = BodyState { q_ned_from_body: quaternion_from_euler(0.0, 0.4, 0.0), ..planar };
    assert!(yaw(nose_north(&tipped).q_ned_from_body).abs() < 1e-15);
}

/// By hand: at the release and then twice a second, up to two fifths of the plan; each takes effect 20 ms
/// after its measurement, that of the fall at t = 0.
#[test]
fn closed_form_times_of_renewals() {
    let settings = ReplanSettings::default();
    let mut replanner = Replanner::new(plan(), Cadence::Hz(2.0), settings);
    let mut asked = Vec::new();
    for step in 0..2700 {
        let t_s = -0.5 + 0.004 * f64::from(step);
        if let Some(request) = replanner.poll(t_s, Some((t_s, state(Vector3::zeros())))) {
            asked.push((request.seen_s, request.takes_effect_s));
            assert!(replanner.take(t_s, solved(&request), None).is_some_and(|record| record.kept.is_none()));
        }
    }
    assert_eq!(asked.len(), 9, "{asked:?}");
    for (i, (seen_s, takes_effect_s)) in asked.iter().enumerate() {
        let due_s = -0.5 + 0.5 * i as f64;
        assert!((0.0..0.004 + 1e-9).contains(&(seen_s - due_s)), "{asked:?}");
        assert!((takes_effect_s - (seen_s + 0.02).max(0.0)).abs() < 1e-12);
    }
    let mut once = Replanner::new(plan(), Cadence::Release, settings);
    let polled = (0..2700).filter_map(|step| {
        let t_s = -0.5 + 0.004 * f64::from(step);
        let request = once.poll(t_s, Some((t_s, state(Vector3::zeros()))))?;
        once.take(t_s, solved(&request), None).cloned()
    });
    assert_eq!(polled.count(), 1);
}

/// A renewed plan is in force from its time on; one that comes later, or that was not asked for, never is;
/// and a state that is too old is asked for again, which is said once.
#[test]
fn a_late_plan_is_not_flown() {
    let mut replanner = Replanner::new(plan(), Cadence::Hz(1.0), ReplanSettings::default());
    let seen = |t_s: f64| Some((t_s, state(Vector3::zeros())));
    assert_eq!(replanner.poll(0.1, None), None);
    assert_eq!(replanner.poll(0.2, seen(0.1)), None);
    assert_eq!(replanner.records().len(), 1);
    assert_eq!(replanner.records()[0].kept, Some(Kept::NoState));
    let request = replanner.poll(1.0, seen(1.0)).unwrap();
    assert_eq!(replanner.poll(1.01, seen(1.01)), None, "one at a time");
    let unasked = ReplanAnswer { number: 7, ..solved(&request) };
    assert_eq!(replanner.take(1.01, unasked, None), None);
    let late = replanner.take(1.05, solved(&request), Some(0.05)).unwrap();
    assert!(matches!(late.kept, Some(Kept::Late { late_s }) if (late_s - 0.03).abs() < 1e-12));
    assert_eq!(late.to_string(), "plan kept at t = 1.020 s: late by 30.0 ms (5 iterations, 50.0 ms)");
    assert_eq!(replanner.in_force(2.0), &plan());
    let request = replanner.poll(2.1, seen(2.1)).unwrap();
    let record = replanner.take(2.11, solved(&request), None).unwrap();
    assert_eq!(record.to_string(), "plan renewed, from t = 2.120 s on (5 iterations)");
    assert_eq!(replanner.in_force(2.119), &plan());
    assert_eq!(replanner.in_force(2.12), &other_plan());
}

/// By hand: what can be typed.
#[test]
fn closed_form_cadences() {
    assert_eq!("release".parse(), Ok(Cadence::Release));
    assert_eq!("2.5".parse(), Ok(Cadence::Hz(2.5)));
    for wrong in ["", "0", "-1", "51", "nan", "inf", "often"] {
        let refused = wrong.parse::<Cadence>().unwrap_err();
        assert!(refused.contains("`release`, or a rate"), "{refused}");
    }
}
