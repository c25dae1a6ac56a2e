//! OFFBOARD: when it is entered, and how setpoints are flown.

use super::*;

#[test]
fn regress_wakes_up_disarmed_in_hold_with_motors_off() {
    let mut bench = Bench::new();
    assert_eq!((bench.autopilot.mode(), bench.autopilot.is_armed()), (FlightMode::AutoLoiter, false));
    bench.offer(velocity(-5.0, YawSetpoint::Keep));
    assert_eq!(bench.run(1.0), OFF);
    assert_eq!(bench.autopilot.arm(bench.now_us, false), Ok(()));
    assert_eq!(bench.run(1.0), OFF, "armed in HOLD, never in OFFBOARD: waits");
}

/// PX4 v1.14.3, UserModeIntention.cpp: disarmed every mode may be chosen; armed, and to arm, it needs
/// setpoints.
#[test]
fn reference_offboard_needs_a_setpoint_of_the_last_second() {
    let mut bench = Bench::new();
    bench.step();
    assert_eq!(bench.autopilot.request_mode(bench.now_us, FlightMode::Offboard), Ok(()));
    assert_eq!(bench.autopilot.arm(bench.now_us, false), Err(ArmingRefusal::NoSetpoint));
    assert_eq!(bench.said(), ["mode OFFBOARD", "Arming denied: no offboard signal"]);
    bench.offer(level(0.0));
    bench.run(1.0);
    assert_eq!(bench.autopilot.arm(bench.now_us, false), Ok(()));
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoLoiter).unwrap();
    bench.step();
    let refused = Err(ModeRefusal::NoSetpoint { timeout_us: 1_000_000 });
    assert_eq!(bench.autopilot.request_mode(bench.now_us, FlightMode::Offboard), refused);
    assert!(bench.said().contains(&"OFFBOARD refused: no setpoint in the last 1 s".to_owned()));
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter, "a step later the setpoint is too old");
}

#[test]
fn regress_modes_that_are_not_flown_are_refused_by_name() {
    let mut bench = Bench::new();
    for mode in FlightMode::all().filter(|m| !m.is_flown()) {
        assert_eq!(bench.autopilot.request_mode(0, mode), Err(ModeRefusal::NotFlown(mode)));
        assert!(bench.said()[0].starts_with(mode.name()));
    }
}

#[test]
fn regress_integrators_start_from_zero_with_the_first_velocity_setpoint() {
    let mut bench = Bench::engaged(level(0.4));
    bench.measurement.omega_body = Vector3::new(0.0, 0.3, 0.0);
    bench.measurement.v_ned = Vector3::new(0.0, 0.0, 3.0);
    for _ in 0..500 {
        bench.offer(level(0.4));
        bench.step();
    }
    assert_ne!(bench.integrals(), integrals_of(&cascade(), &bench.measurement));
    bench.offer(velocity(1.0, YawSetpoint::Keep));
    let throttle = bench.step();
    let mut fresh = cascade();
    let down = |v_m_s: f64| north_facing(v_m_s * Vector3::z());
    let first = fresh.step(&bench.measurement, &down(1.0), 0.004);
    assert_eq!(throttle, first.throttle);
    assert_eq!(bench.integrals(), integrals_of(&fresh, &bench.measurement));
    // A later setpoint of the same kind does not reset them.
    bench.offer(velocity(0.5, YawSetpoint::Keep));
    bench.step();
    let second = fresh.step(&bench.measurement, &down(0.5), 0.004);
    assert_eq!(bench.autopilot.output().throttle, second.throttle);
    assert_eq!(bench.integrals(), integrals_of(&fresh, &bench.measurement));
}

#[test]
fn regress_heading_is_kept_set_and_turned() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.measurement.q_ned_from_body = quaternion_from_euler(0.0, 0.0, 0.7);
    bench.step();
    let yaw_now = |bench: &Bench| bench.autopilot.velocity_target().unwrap().yaw_rad;
    assert!((yaw_now(&bench) - 0.7).abs() < 1e-12, "kept as found");
    bench.offer(velocity(0.0, YawSetpoint::Angle(-0.2)));
    bench.step();
    bench.offer(velocity(0.0, YawSetpoint::Keep));
    bench.step();
    assert_eq!(yaw_now(&bench), -0.2, "kept as last commanded");
    bench.offer(velocity(0.0, YawSetpoint::Rate(0.5)));
    bench.run(0.5);
    assert!((yaw_now(&bench) - 0.05).abs() < 1e-9);
}

/// Position, velocity and acceleration mixed: each axis flies what it was given.
#[test]
fn closed_form_a_place_is_flown_axis_by_axis() {
    let setpoint =
        |p, v, a| OffboardSetpoint::Place { frame: VelocityFrame::Ned, p, v, a, yaw: YawSetpoint::Keep };
    let none = [None; 3];
    let mut bench = Bench::engaged(setpoint([None, None, Some(-2.0)], [Some(3.0), Some(0.0), None], none));
    bench.measurement.v_ned = Vector3::new(0.5, 0.0, 0.0);
    bench.step();
    let k_pz = bench.autopilot.settings.position.k_pz;
    assert_eq!(bench.autopilot.velocity_target().unwrap().v_ned, Vector3::new(3.0, 0.0, -2.0 * k_pz));
    // An acceleration alone asks for nothing of the velocity loop.
    let mut bench = Bench::engaged(setpoint(none, none, [Some(1.0), Some(0.0), Some(-0.5)]));
    bench.measurement.v_ned = Vector3::new(5.0, 1.0, 2.0);
    bench.step();
    let wanted = bench.autopilot.output().acceleration_sp_ned;
    assert!((wanted - Vector3::new(1.0, 0.0, -0.5)).norm() < 1e-12, "{wanted}");
    assert_eq!(bench.integrals().acceleration_sp_ned, Vector3::zeros());
}
