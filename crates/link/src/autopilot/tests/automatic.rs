//! HOLD, TAKEOFF and LAND, each by where it takes a point mass.

use super::*;

/// HOLD brakes, and its place is where it came to a stop.
#[test]
fn closed_form_hold_keeps_the_place_where_it_stopped() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.measurement.v_ned = Vector3::new(4.0, 0.0, 0.0);
    bench.step();
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoLoiter).unwrap();
    drift(&mut bench, 0.5);
    assert_eq!(bench.autopilot.velocity_target().unwrap().p_ned, [None; 3], "braking");
    drift(&mut bench, 60.0);
    let target = *bench.autopilot.velocity_target().unwrap();
    assert!(target.p_ned[0].is_some_and(|north| north > 1.0 && (north - bench.p_ned.x).abs() < 0.05));
    // Pushed away it comes back, at K e.
    bench.p_ned.x += 2.0;
    bench.step();
    let k = bench.autopilot.settings.position.k_pxy;
    let north = target.p_ned[0].unwrap();
    let v = bench.autopilot.velocity_target().unwrap().v_ned.x;
    assert!((v - k * (north - bench.p_ned.x)).abs() < 0.02, "{v}");
}

/// TAKEOFF waits for arming, climbs at its speed to its height above home, and leads to HOLD there.
#[test]
fn closed_form_takeoff_climbs_to_its_height_above_home() {
    let mut bench = Bench::new();
    bench.p_ned = Vector3::new(1.0, 2.0, 5.0);
    bench.step();
    bench.autopilot.set_home(bench.p_ned);
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoTakeoff).unwrap();
    assert_eq!(bench.run(1.0), OFF, "not armed");
    bench.autopilot.arm(bench.now_us, false).unwrap();
    drift(&mut bench, 0.1);
    let up = bench.autopilot.velocity_target().unwrap().v_ned.z;
    // 2.5 m above home are 0.4 m/s by a position loop of a quarter of 0.675 1/s.
    assert!((up + 2.5 * bench.autopilot.settings.position.k_pz).abs() < 0.02, "{up}");
    assert!(bench.autopilot.settings.set("MIS_TAKEOFF_ALT", 30.0));
    bench.step();
    assert_eq!(bench.autopilot.velocity_target().unwrap().v_ned.z, -1.5, "MPC_TKO_SPEED");
    assert!(bench.autopilot.settings.set("MIS_TAKEOFF_ALT", 2.5));
    drift(&mut bench, 60.0);
    assert_eq!(bench.autopilot.mode(), FlightMode::AutoLoiter);
    assert!((bench.p_ned - Vector3::new(1.0, 2.0, 2.5)).norm() < 0.1, "{}", bench.p_ned);
}

/// LAND sinks at its speed as long as nothing stops it; stopped for a second it has landed, and disarms two
/// seconds later.
#[test]
fn closed_form_land_sinks_until_stopped_and_disarms() {
    let mut bench = Bench::engaged(velocity(0.0, YawSetpoint::Keep));
    bench.step();
    bench.autopilot.request_mode(bench.now_us, FlightMode::AutoLand).unwrap();
    drift(&mut bench, 120.0);
    assert!((bench.measurement.v_ned.z - 0.7).abs() < 0.02, "{}", bench.measurement.v_ned);
    assert!(bench.autopilot.is_landing() && bench.autopilot.is_in_air());
    bench.measurement.v_ned = Vector3::zeros();
    bench.run(1.1);
    assert!(!bench.autopilot.is_in_air());
    assert_eq!(bench.autopilot.output().throttle, OFF, "nothing to carry any more");
    bench.run(1.8);
    assert!(bench.autopilot.is_armed());
    bench.run(0.2);
    assert!(!bench.autopilot.is_armed());
    assert!(bench.said().ends_with(&[
        "Landing detected".into(),
        "Disarmed by landing".into(),
        "disarmed".into()
    ]));
}
