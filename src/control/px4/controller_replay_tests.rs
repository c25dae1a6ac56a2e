//! The whole controller against what PX4 v1.12.0 logged of itself in lockstep (`tests/data/px4_law.csv`):
//! given PX4's own estimates sample by sample, the loops, their delays, the mixer and the outputs must give
//! PX4's own.

use nalgebra::Vector3;

use super::controller::Px4Controller;
use super::replay_tests::{SEVEN_DIGITS, rows, vector};
use super::{Parameters, mixer};
use crate::control::{Controller as _, Measurement, Setpoint};

const RECORDED: &str = include_str!("../../../tests/data/px4_law.csv");
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
