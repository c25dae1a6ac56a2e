//! The estimator against what PX4 v1.16.0 believed in a drop, by its own log
//! (`tests/data/px4_estimate_v1_16.csv`), and what it makes of sensors without errors, of noise and of age.

use super::*;
use crate::control::px4::replay_tests::vector;
use crate::random::{Purpose, Stream};

const RECORDED: &str = include_str!("../../../../../../tests/data/px4_estimate_v1_16.csv");
/// Steps of the recorded accelerometer [m/s^2] and gyroscope [rad/s].
const STEPS: [f64; 2] = [0.004788403, 0.001065264];
/// The receiver that PX4 was told of.
const RECEIVER: Receiver =
    Receiver { horizontal_m: 0.9, vertical_m: 1.2, told_delay_us: 110_000, window_us: 200_000 };

fn estimator(receiver: &Receiver, field_ned_gauss: Vector3<f64>) -> Estimator {
    Estimator::new(&Parameters::default(), &Law::V1_16, receiver, field_ned_gauss)
}

fn readings(force_body: Vector3<f64>, omega_body: Vector3<f64>) -> Readings {
    Readings { force_body, omega_body, field_body: None, altitude_m: None, fix: None }
}

/// RMS of a column of differences.
fn rms(differences: &[Vector3<f64>]) -> Vector3<f64> {
    let squares: Vector3<f64> = differences.iter().map(|d| d.component_mul(d)).sum();
    (squares / differences.len() as f64).map(f64::sqrt)
}

/// Given PX4's own readings, the velocity is PX4's within 2 cm/s, and one sample of a fall, 4 cm/s, down:
/// much nearer than the truth is, sideways and ahead.
#[test]
fn reference_px4s_own_readings_give_its_own_velocity() {
    let mut estimator = estimator(&RECEIVER, Vector3::zeros());
    let mut next = readings(Vector3::zeros(), Vector3::zeros());
    let (mut off, mut of_the_truth) = (Vec::new(), Vec::new());
    for line in RECORDED.lines().filter(|line| !line.starts_with('#')) {
        let (kind, numbers) = line.split_once(',').unwrap();
        let all = if kind.parse::<f64>().is_ok() { line } else { numbers };
        let n: Vec<f64> = all.split(',').map(|x| x.parse().unwrap()).collect();
        match kind {
            "field" => estimator.field_ned_gauss = vector(&n),
            "mag" => next.field_body = Some(vector(&n) * 1e-4),
            "baro" => next.altitude_m = Some(n[0] * 1e-2),
            "fix" => next.fix = Some(Fix { p_ned: vector(&n) * 1e-2, v_ned: vector(&n[3..]) * 1e-2 }),
            "px4" => {
                let px4s = vector(&n) * 1e-3;
                off.push(estimator.estimate().unwrap().v_ned - px4s);
                of_the_truth.push(vector(&n[3..]) * 1e-3 - px4s);
            }
            _ => {
                (next.force_body, next.omega_body) = (vector(&n) * STEPS[0], vector(&n[3..]) * STEPS[1]);
                estimator.take(&next);
                next = readings(Vector3::zeros(), Vector3::zeros());
            }
        }
    }
    let (off, of_the_truth) = (rms(&off), rms(&of_the_truth));
    assert!(off.x < 0.02 && off.y < 0.02 && off.z < 0.04, "{off:?}");
    assert!(2.0 * off.xy().norm() < of_the_truth.xy().norm(), "{off:?} {of_the_truth:?}");
}

/// Northward acceleration of a vehicle that is level [m/s^2], whose integrals are known.
fn pushed(t_s: f64) -> (f64, f64, f64) {
    let rest = (t_s - 8.0).max(0.0);
    let (sin, cos) = math::sin_cos(2.0 * rest);
    (2.0 * sin, 1.0 - cos, rest - 0.5 * sin)
}

/// Flies [`pushed`] for 14 s with fixes that are so old, noisy by so much and so believed; the error of the
/// velocity at each step of the last six seconds.
fn errors(age_us: u64, told_us: u64, noise_m_s: f64) -> Vec<Vector3<f64>> {
    let field_ned = Vector3::new(0.2, 0.0, 0.4);
    let mut estimator = estimator(&Receiver { told_delay_us: told_us, ..RECEIVER }, field_ned);
    let mut dice = Stream::new(1, Purpose::Dice, 0);
    let mut errors = Vec::new();
    for i in 1..=3_500u64 {
        let t_s = i as f64 * SAMPLE_S;
        let (a, v, _) = pushed(t_s);
        let mut read = readings(Vector3::new(a, 0.0, -G0), Vector3::zeros());
        if i % 5 == 1 {
            (read.field_body, read.altitude_m) = (Some(field_ned), Some(0.0));
        }
        if i % 25 == 1 {
            let (_, v, p) = pushed(t_s - age_us as f64 / US_PER_S);
            let v_ned = Vector3::x() * v + dice.normals::<3>() * noise_m_s;
            read.fix = Some(Fix { p_ned: Vector3::x() * p, v_ned });
        }
        estimator.take(&read);
        if t_s > 8.0 {
            errors.push(estimator.estimate().unwrap().v_ned - Vector3::x() * v);
        }
    }
    errors
}

/// Sensors without errors, and an age that PX4 is told, give the truth, within what a step of the filter, 8
/// ms, changes it by at 2 m/s^2.
#[test]
fn prop_without_errors_it_believes_the_truth() {
    let worst = errors(110_000, 110_000, 0.0).iter().map(|e| e.norm()).fold(0.0, f64::max);
    assert!(worst < 0.016, "{worst}");
}

/// Errors are in proportion to the noise, of the same dice; and an age that PX4 is not told is an error too.
#[test]
fn prop_errors_grow_with_noise_and_with_an_age_that_is_not_told() {
    let none = rms(&errors(110_000, 110_000, 0.0));
    let [little, more] = [0.05, 0.1].map(|noise| rms(&errors(110_000, 110_000, noise)));
    let ratio = more.y / little.y;
    assert!((ratio - 2.0).abs() < 0.05, "{ratio}");
    let untold = rms(&errors(110_000, 10_000, 0.0));
    assert!(untold.x > 3.0 * none.x && untold.x > 0.01, "{untold:?} {none:?}");
}

/// A PX4 that nothing carries does not align, and what is missing is waited for.
#[test]
fn it_begins_when_it_is_carried_and_all_has_been_heard() {
    let field_ned = Vector3::new(0.2, 0.0, 0.4);
    let fix = Some(Fix { p_ned: Vector3::zeros(), v_ned: Vector3::zeros() });
    let whole =
        Readings { field_body: Some(field_ned), fix, ..readings(-Vector3::z() * G0, Vector3::zeros()) };
    let begins = |readings: &Readings| {
        let mut estimator = estimator(&RECEIVER, field_ned);
        (0..10).for_each(|_| estimator.take(readings));
        estimator.estimate().is_some()
    };
    assert!(begins(&whole));
    for wanting in [
        Readings { fix: None, ..whole },
        Readings { field_body: None, ..whole },
        Readings { force_body: Vector3::zeros(), ..whole },
        Readings { omega_body: Vector3::x(), ..whole },
    ] {
        assert!(!begins(&wanting), "{wanting:?}");
    }
}
