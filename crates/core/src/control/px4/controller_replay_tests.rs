//! The whole controller against what PX4 v1.12.0, v1.14.3, v1.16.0 and v1.18.0-beta1 logged of themselves in
//! lockstep (`tests/data/px4_law.csv`, `px4_law_v1_14.csv`, ..): given PX4's own estimates sample by sample,
//! the loops, their delays, the mixer and the outputs must give PX4's own.

use nalgebra::Vector3;

use super::controller::Px4Controller;
use super::replay_tests::{SEVEN_DIGITS, rows, vector};
use super::{Law, Parameters, mixer};
use crate::control::test_vehicles::quadrotor;
use crate::control::{Controller as _, Measurement, Setpoint};
use crate::model::VehicleOptions;

const RECORDED: &str = include_str!("../../../../../tests/data/px4_law.csv");
const DT_S: f64 = 0.004;
/// How long that PX4 was in HOLD.
const RECORDED_HOLD_S: f64 = 0.06;

fn recorded_with() -> Parameters {
    Parameters {
        thr_hover: 0.5919,
        thr_mdl_fac: 1.0,
        tiltmax_lnd_deg: 45.0,
        xy_vel_max: 20.0,
        z_vel_max_dn: 20.0,
        gyro_cutoff_hz: 0.0,
        dgyro_cutoff_hz: 0.0,
        ..Parameters::default()
    }
}

/// The controller as PX4 is at the first row: armed long ago, its derivative filled with the velocities
/// before.
fn until_the_first_row() -> Px4Controller {
    let mut controller = Px4Controller::held_for(recorded_with(), 1.0, 1.0, RECORDED_HOLD_S);
    let watch = Setpoint::MOTORS_OFF;
    let first = rows(RECORDED, "law").next().unwrap();
    let mut m = Measurement {
        q_ned_from_body: first[..4].try_into().unwrap(),
        v_ned: Vector3::zeros(),
        omega_body: vector(&first[4..]),
        bus_v: None,
        pack_a: None,
    };
    // The velocity loop runs after 8 and 12 ms by turns.
    let velocities: Vec<Vec<f64>> = rows(RECORDED, "watch").collect();
    let long_before = std::iter::repeat_n((0.02, &velocities[0]), 50);
    for (dt_s, row) in long_before.chain(velocities.iter().map(|row| (row[0], row))) {
        m.v_ned = vector(&row[1..]);
        for _ in 0..(dt_s / DT_S).round() as usize {
            controller.step(&m, &watch, DT_S);
        }
    }
    controller
}

/// PX4's arc cosine of a small tilt is good to 2e-5 rad in single precision; MC_PITCH_P makes 1.3e-4 rad/s of
/// it, and MC_PITCHRATE_P 2e-5.
const OF_A_SMALL_TILT: [f64; 2] = [1.5e-4, 2.5e-5];

#[test]
fn px4s_own_loops_mixer_and_outputs_give_the_same_in_the_same_sample() {
    let mut controller = until_the_first_row();
    let mut setpoint = Setpoint::MOTORS_OFF;
    let mut v_ned = Vector3::zeros();
    let (mut turned, mut twisted, mut pushed) = (0.0f64, 0.0f64, 0.0f64);
    let mut count = 0;
    for row in rows(RECORDED, "law") {
        if row[7].is_finite() {
            v_ned = vector(&row[7..]);
        }
        if row[10].is_finite() {
            let v_sp = vector(&row[10..]);
            setpoint = Setpoint::Velocity { v_ned: v_sp, a_ff_ned: Vector3::zeros(), yaw_rad: None };
        }
        let m = Measurement {
            q_ned_from_body: row[..4].try_into().unwrap(),
            v_ned,
            omega_body: vector(&row[4..]),
            bus_v: None,
            pack_a: None,
        };
        // What the mixer is given came with the rates of the sample before.
        pushed = pushed.max((controller.trace().rate_thrust_sp - row[19]).abs());
        let commands = controller.step(&m, &setpoint, DT_S).throttle;
        let trace = controller.trace();
        turned = turned.max((trace.rate_sp_body - vector(&row[13..])).norm());
        if count > 0 {
            // The first one's angular acceleration needs a sample that is not there.
            twisted = twisted.max((trace.torque - vector(&row[16..])).norm());
        }
        let pulses_us = commands[..mixer::MOTORS].iter().map(|u| (1000.0 + 1000.0 * u).round());
        assert!(pulses_us.eq(row[20..].iter().copied()), "sample {count}: {commands:?} {row:?}");
        count += 1;
    }
    assert_eq!(count, 64);
    assert!(pushed < SEVEN_DIGITS, "{pushed:e}");
    assert!(turned < OF_A_SMALL_TILT[0] && twisted < OF_A_SMALL_TILT[1], "{turned:e} {twisted:e}");
}

/// The controller as PX4 v1.14 or v1.16 is at the first row of a recording.
fn allocating(recorded: &str, law: Law) -> Px4Controller {
    let mut parameters = Parameters::default();
    for line in recorded.lines().filter_map(|line| line.strip_prefix("parameter,")) {
        let (name, value) = line.split_once(',').unwrap();
        parameters.set(name, value.parse().unwrap()).unwrap();
    }
    // Places of the rotors; what they make of yaw torque falls out of the allocator's units.
    let vehicle = quadrotor([0.174; 2], [0.02; 3], [0.0; 3], VehicleOptions::default());
    let mut controller = Px4Controller::new(parameters, 1.0, 1.0).with_law(law, &vehicle, 1.2);
    let first = rows(recorded, "law").next().unwrap();
    let mut m = Measurement {
        q_ned_from_body: first[..4].try_into().unwrap(),
        v_ned: Vector3::zeros(),
        omega_body: vector(&first[4..]),
        bus_v: None,
        pack_a: None,
    };
    for row in rows(recorded, "watch") {
        m.v_ned = vector(&row[1..]);
        for _ in 0..2 {
            controller.step(&m, &Setpoint::MOTORS_OFF, DT_S);
        }
    }
    let held = rows(recorded, "integral").next().unwrap();
    let asked_before_s = rows(recorded, "asked").next().map_or(0.0, |row| row[0]);
    controller.hold(vector(&held), held[3], asked_before_s);
    controller
}

/// By how much rate setpoint [rad/s], torque, thrust and pulses [us] are off at the most, in all rows of a
/// recording.
fn worst(recorded: &str, law: Law) -> [f64; 4] {
    let mut controller = allocating(recorded, law);
    let asked = |row: &[f64]| {
        let (v_sp, a_ff) = (vector(&row[10..]), vector(&row[13..]));
        Setpoint::Velocity { v_ned: v_sp, a_ff_ned: a_ff, yaw_rad: None }
    };
    let mut setpoint = rows(recorded, "law").find(|row| row[10].is_finite()).map(|row| asked(&row)).unwrap();
    let mut v_ned = Vector3::zeros();
    let mut worst = [0.0f64; 4];
    for (count, row) in rows(recorded, "law").enumerate() {
        if row[7].is_finite() {
            v_ned = vector(&row[7..]);
        }
        if row[10].is_finite() {
            setpoint = asked(&row);
        }
        let q_ned_from_body = row[..4].try_into().unwrap();
        let m =
            Measurement { q_ned_from_body, v_ned, omega_body: vector(&row[4..]), bus_v: None, pack_a: None };
        let pushed = (controller.trace().rate_thrust_sp - row[22]).abs();
        let commands = controller.step(&m, &setpoint, DT_S).throttle;
        let trace = controller.trace();
        let turned = (trace.rate_sp_body - vector(&row[16..])).norm();
        let twisted = (trace.torque - vector(&row[19..])).norm();
        let pulses = commands[..mixer::MOTORS].iter().zip(&row[23..]);
        let pulsed = pulses.map(|(u, us)| (1000.0 + 1000.0 * u - us).abs()).fold(0.0, f64::max);
        // The first rows' rates and angular acceleration need samples that are not there.
        if count > usize::from(law.estimates_the_sample_before) {
            let off = [turned, twisted, pushed, pulsed];
            worst = std::array::from_fn(|i| worst[i].max(off[i]));
        }
    }
    worst
}

#[test]
fn px4_v1_16s_own_loops_allocator_and_outputs_give_the_same_in_the_same_sample() {
    let off = worst(include_str!("../../../../../tests/data/px4_law_v1_16.csv"), Law::V1_16);
    // Its derivative's filter is set to an interval that PX4 has measured, which the log does not have.
    assert!(off[0] < 3e-4 && off[1] < 1e-4 && off[2] < SEVEN_DIGITS && off[3] < 1.5, "{off:?}");
}

/// The recording was made on a busy machine, where PX4's estimator is done with a sample before the next one
/// comes, of v1.16 as well. Its vertical velocity is off by what `z_deriv` is from what PX4 took.
#[test]
fn px4_v1_18s_own_loops_reference_model_and_outputs_give_the_same_in_the_same_sample() {
    let law = Law { estimates_the_sample_before: false, ..Law::V1_18 };
    let recorded = include_str!("../../../../../tests/data/px4_law_v1_18.csv");
    let off = worst(recorded, law);
    assert!(off[0] < OF_A_SMALL_TILT[0] && off[1] < 1e-4 && off[2] < 1e-3 && off[3] < 0.5, "{off:?}");
    // What is new in it counts in the recording.
    let without = worst(recorded, Law { follows_a_reference: false, ..law });
    let rounded = worst(recorded, Law { rounding: Law::V1_16.rounding, ..law });
    assert!(without[0] > 100.0 * off[0] && rounded[3] > off[3], "{without:?} {rounded:?}");
}

#[test]
fn px4_v1_14s_own_loops_allocator_and_outputs_give_the_same_in_the_same_sample() {
    let off = worst(include_str!("../../../../../tests/data/px4_law_v1_14.csv"), Law::V1_14);
    assert!(off[0] < OF_A_SMALL_TILT[0] && off[1] < OF_A_SMALL_TILT[1] && off[2] < SEVEN_DIGITS, "{off:?}");
    assert!(off[3] < 0.5, "{off:?}");
}
