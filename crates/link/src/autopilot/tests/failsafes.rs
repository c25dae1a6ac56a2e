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
    // PX4 v1.14.3, failsafe.cpp (checkModeFallback): the intended mode flies as soon as it can.
    bench.offer(velocity(2.0, YawSetpoint::Keep));
    bench.step();
    assert_eq!(bench.autopilot.mode(), FlightMode::Offboard);
    assert_eq!(bench.said(), ["Failsafe over: mode OFFBOARD"]);
    assert!(!bench.autopilot.in_failsafe());
}

/// A mode that was chosen meanwhile wins.
#[test]
fn reference_setpoints_that_come_back_take_no_mode_from_the_crew() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.run(1.5);
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter);
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoLand).unwrap();
    bench.said();
    bench.offer(velocity(0.0, YawSetpoint::Keep));
    bench.run(0.5);
    assert_eq!((bench.autopilot.mode(), bench.autopilot.in_failsafe()), (FlightMode::AutoLand, false));
    assert!(bench.said().is_empty());
    bench.autopilot.disarm(true).unwrap();
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLand);
}

/// Disarmed by a failsafe's landing the vehicle has the crew's mode again, which does not arm without
/// setpoints (PX4's UserModeIntention and modeCheck, v1.14.3).
#[test]
fn reference_a_disarmed_vehicle_has_the_mode_of_its_crew() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    assert!(bench.autopilot.settings.set("COM_OBL_RC_ACT", 4.0));
    bench.run(1.5);
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLand);
    bench.autopilot.disarm(true).unwrap();
    bench.step();
    assert_eq!(bench.autopilot.mode(), FlightMode::Offboard);
    assert_eq!(bench.autopilot.arm(bench.now_us, false), Err(ArmingRefusal::NoSetpoint));
}

#[test]
fn regress_setpoints_lost_under_the_canopy_still_brake_the_fall() {
    let mut bench = Bench::engaged(level(0.0));
    assert_eq!(bench.run(0.9), OFF);
    assert!(!bench.autopilot.is_flying());
    let throttle = bench.run(0.5);
    assert!(throttle[0] > 0.0);
}

/// The fence's HOLD takes a vehicle that lands, as PX4's does, until a mode is chosen: being inside again
/// does not end it.
#[test]
fn reference_a_fence_holds_until_a_mode_is_chosen() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.step();
    assert!(!bench.autopilot.settings.has_fence());
    assert!(bench.autopilot.settings.set("GF_MAX_HOR_DIST", 10.0));
    assert!(bench.autopilot.settings.has_fence() && !bench.autopilot.guard.fence_is_breached());
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoLand).unwrap();
    bench.step();
    bench.p_ned.x = 11.0;
    bench.autopilot.set_home(Vector3::zeros());
    bench.step();
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter);
    assert!(bench.autopilot.in_failsafe() && bench.autopilot.guard.fence_is_breached());
    bench.p_ned.x = 0.0;
    bench.step();
    assert!(bench.autopilot.in_failsafe() && !bench.autopilot.guard.fence_is_breached());
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoLand).unwrap();
    bench.step();
    assert_eq!((bench.autopilot.mode(), bench.autopilot.in_failsafe()), (FlightMode::AutoLand, false));
}

/// As PX4 (FailsafeBase: "Terminate never clears"; nav_state TERMINATION prevents arming): it stays armed
/// with its motors stopped, and nothing but a new start takes it out of that.
#[test]
fn regress_termination_lasts() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    assert!(bench.autopilot.settings.set("GF_MAX_HOR_DIST", 10.0));
    assert!(bench.autopilot.settings.set("GF_ACTION", 4.0));
    bench.autopilot.set_home(Vector3::zeros());
    bench.step();
    bench.p_ned.x = 11.0;
    bench.step();
    assert!(bench.said().contains(&"Failsafe: TERMINATE".into()));
    for back in [11.0, 0.0] {
        bench.p_ned.x = back;
        bench.offer(velocity(0.0, YawSetpoint::Keep));
        assert_eq!(bench.run(0.5), OFF);
        assert!(bench.autopilot.guard.is_terminated() && bench.autopilot.is_armed());
        assert_eq!(bench.autopilot.mode(), FlightMode::Manual);
        for mode in [FlightMode::Offboard, FlightMode::AutoLand] {
            let refused = bench.autopilot.request_mode(bench.now_us, mode);
            assert_eq!(refused, Err(ModeRefusal::Terminated(mode)));
        }
        assert!(bench.autopilot.take_off_to(bench.now_us, -5.0).is_err());
        assert!(bench.autopilot.reposition(bench.now_us, Vector3::zeros(), YawSetpoint::Keep).is_err());
    }
    bench.autopilot.disarm(true).unwrap();
    for force in [false, true] {
        assert_eq!(bench.autopilot.arm(bench.now_us, force), Err(ArmingRefusal::Terminated));
    }
    bench.autopilot.restart();
    assert!(!bench.autopilot.guard.is_terminated());
}

/// As PX4's FailsafeBase::inFailsafe, for which a warning is an action: it shows as long as it holds.
#[test]
fn regress_a_warning_shows_while_it_holds() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    assert!(bench.autopilot.settings.set("GF_MAX_HOR_DIST", 10.0));
    assert!(bench.autopilot.settings.set("GF_ACTION", 1.0));
    bench.autopilot.set_home(Vector3::zeros());
    bench.step();
    for (north_m, shows) in [(11.0, true), (9.0, false), (11.0, true)] {
        bench.p_ned.x = north_m;
        bench.step();
        assert_eq!(bench.autopilot.in_failsafe(), shows, "{north_m} m");
        assert_eq!(bench.autopilot.mode(), FlightMode::Offboard);
    }
    assert!(bench.autopilot.settings.set("GF_ACTION", 0.0));
    bench.step();
    assert!(!bench.autopilot.in_failsafe());
}
