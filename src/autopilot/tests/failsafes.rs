//! What is flown when setpoints are lost or the fence is breached.

use super::*;

#[test]
fn regress_loss_of_setpoints_leads_to_zero_velocity_and_is_said_once() {
    let mut bench = Bench::engaged(velocity(2.0, YawSetpoint::Keep));
    bench.measurement.v_ned = Vector3::new(0.0, 0.0, 2.0);
    bench.run(1.0);
    assert_eq!(bench.autopilot.velocity_target().unwrap().v_ned.z, 2.0);
    bench.said();
    let throttle = bench.run(0.5);
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter);
    assert!(bench.autopilot.in_failsafe() && bench.autopilot.is_armed());
    assert_eq!(bench.said(), ["OFFBOARD lost: no setpoint for 1 s", "Failsafe: HOLD"]);
    assert_eq!(bench.autopilot.velocity_target().unwrap().v_ned, Vector3::zeros());
    assert!(throttle[0] > 0.0, "the fall is braked");
    bench.offer(velocity(2.0, YawSetpoint::Keep));
    bench.step();
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter, "OFFBOARD has to be asked for again");
    bench.autopilot.request_mode(bench.now_us, FlightMode::Offboard).unwrap();
    assert!(!bench.autopilot.in_failsafe());
}

#[test]
fn regress_setpoints_lost_under_the_canopy_still_brake_the_fall() {
    let mut bench = Bench::engaged(level(0.0));
    assert_eq!(bench.run(0.9), OFF);
    assert!(!bench.autopilot.is_flying());
    let throttle = bench.run(0.5);
    assert!(throttle[0] > 0.0);
}

/// A failsafe takes nothing milder than what is flown, and a terminated vehicle is disarmed.
#[test]
fn regress_failsafes_do_not_soften() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.step();
    assert!(!bench.autopilot.settings().has_fence());
    assert!(bench.autopilot.settings_mut().set("GF_MAX_HOR_DIST", 10.0));
    assert!(bench.autopilot.settings().has_fence() && !bench.autopilot.fence_is_breached());
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoLand).unwrap();
    bench.p_ned.x = 11.0;
    bench.autopilot.set_home(Vector3::zeros());
    bench.step();
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLand, "HOLD is milder than LAND");
    assert!(!bench.autopilot.in_failsafe() && bench.autopilot.fence_is_breached());
    bench.p_ned.x = 0.0;
    bench.step();
    assert!(!bench.autopilot.fence_is_breached());
    assert!(bench.autopilot.settings_mut().set("GF_ACTION", 4.0));
    bench.p_ned.x = 11.0;
    bench.step();
    assert!(!bench.autopilot.is_armed() && bench.said().contains(&"Failsafe: TERMINATE".into()));
}
