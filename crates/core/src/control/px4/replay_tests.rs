//! The source of truth is PX4 itself: what v1.12.0 estimated and wanted in a drop, from its log
//! (`tests/data/px4_replay.csv`).

use nalgebra::Vector3;

use super::Parameters;
use super::attitude::{attitude_for, rates_for};
use super::law::Law;
use super::velocity::VelocityLoop;
use crate::frames::{conjugate, product, rotation_vector};

const RECORDED: &str = include_str!("../../../../../tests/data/px4_replay.csv");

/// The numbers of the rows of a kind; NaN where there is none.
pub(super) fn rows<'a>(recorded: &'a str, kind: &'a str) -> impl Iterator<Item = Vec<f64>> + 'a {
    recorded.lines().filter_map(move |line| line.strip_prefix(kind)?.strip_prefix(',')).map(|numbers| {
        numbers.split(',').map(|x| if x.is_empty() { f64::NAN } else { x.parse().unwrap() }).collect()
    })
}

pub(super) fn vector(numbers: &[f64]) -> Vector3<f64> {
    Vector3::from_column_slice(&numbers[..3])
}

fn quaternion(numbers: &[f64]) -> [f64; 4] {
    numbers[..4].try_into().unwrap()
}

/// PX4 counts, and the file is written, in seven digits.
pub(super) const SEVEN_DIGITS: f64 = 5e-6;

#[test]
fn px4s_own_velocity_loop_gives_the_same_attitude_and_thrust() {
    let p = Parameters {
        thr_hover: 0.5919,
        thr_mdl_fac: 1.0,
        tiltmax_lnd_deg: 45.0,
        xy_vel_max: 20.0,
        z_vel_max_dn: 20.0,
        ..Parameters::default()
    };
    let mut velocity = VelocityLoop::new(&p, 10.0);
    for row in rows(RECORDED, "watch") {
        velocity.watch(&p, vector(&row[1..]), row[0]);
    }
    let (mut turned, mut pushed) = (0.0f64, 0.0f64);
    let mut count = 0;
    for row in rows(RECORDED, "velocity") {
        let v_sp = Vector3::new(2.0, 0.0, 1.0);
        let thrust = velocity.step(&p, &Law::V1_12, vector(&row[1..]), v_sp, Vector3::zeros(), row[0]);
        let q_sp = attitude_for(thrust, row[4]);
        turned = turned.max(rotation_vector(product(conjugate(q_sp), quaternion(&row[5..]))).norm());
        pushed = pushed.max((thrust.norm() - row[9]).abs());
        count += 1;
    }
    assert!(count == 60 && turned < 5e-5 && pushed < SEVEN_DIGITS, "{count} {turned:e} {pushed:e}");
}

#[test]
fn px4s_own_attitude_loop_gives_the_same_rates() {
    let p = Parameters::default();
    let (mut worst, mut largest) = (0.0f64, 0.0f64);
    for row in rows(RECORDED, "rates") {
        let rates = rates_for(&p, quaternion(&row), quaternion(&row[4..]), Vector3::zeros());
        worst = worst.max((rates - vector(&row[8..])).norm());
        largest = largest.max(rates.norm());
    }
    assert!(largest > 1.0, "the recording holds a manoeuvre: {largest}");
    assert!(worst < SEVEN_DIGITS, "{worst:e}");
}
