//! Arming and disarming, and what is left without a state or after a new start.

use super::*;

#[test]
fn regress_arming_is_checked_unless_forced() {
    let mut bench = Bench::new();
    assert_eq!(bench.autopilot.arm(0, false), Err(ArmingRefusal::NoState));
    bench.measurement.q_ned_from_body = quaternion_from_euler(1.2, 0.0, 0.0);
    bench.step();
    assert_eq!(bench.autopilot.arm(bench.now_us, false), Err(ArmingRefusal::Tilted));
    assert_eq!(bench.said().len(), 2);
    assert_eq!(bench.autopilot.arm(bench.now_us, true), Ok(()));
    assert_eq!(bench.said(), ["armed (forced)"]);
}

#[test]
fn regress_disarming_in_flight_needs_force_and_stops_the_motors() {
    let mut bench = Bench::engaged(level(0.0));
    bench.step();
    assert_eq!(bench.autopilot.disarm(false), Ok(()), "no thrust yet");
    bench.autopilot.arm(bench.now_us, false).unwrap();
    bench.offer(velocity(0.0, YawSetpoint::Keep));
    assert_ne!(bench.step(), OFF);
    bench.said();
    assert_eq!(bench.autopilot.disarm(false), Err(DisarmingRefusal::Flying));
    assert_eq!(bench.said(), ["Disarming denied: flying (force with 21196)"]);
    assert_eq!(bench.autopilot.disarm(true), Ok(()));
    assert_eq!(bench.step(), OFF);
    assert_eq!(bench.autopilot.disarm(false), Ok(()), "twice is nothing");
    assert_eq!(bench.said(), ["disarmed in flight (forced)"]);
}

#[test]
fn regress_without_a_state_the_last_commands_stay() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    let last = bench.step();
    assert_eq!(bench.autopilot.coast(bench.now_us + STEP_US), last);
    bench.autopilot.disarm(true).unwrap();
    assert_eq!(bench.autopilot.coast(bench.now_us + 2 * STEP_US), OFF);
}

#[test]
fn regress_a_simulator_that_starts_over_finds_it_disarmed() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.run(0.5);
    bench.autopilot.restart();
    bench.now_us = 0;
    assert_eq!(bench.step(), OFF);
    assert!(!bench.autopilot.is_armed());
    assert_eq!(bench.integrals().acceleration_sp_ned, Vector3::zeros());
    assert_eq!(bench.said().last().map(String::as_str), Some("simulated time started over: disarmed"));
}
