//! Telemetry: rates, contents, sequence numbers.

use mavlink::dialects::common::*;
use samara::link::{Frame, Link, Session as _};

use super::bench::{Bench, Sent, VEHICLE, command, last, level_no_thrust};

#[test]
fn regress_the_simulator_is_greeted_as_px4_does() {
    let mut bench = Bench::new();
    let greeting = bench.drain();
    assert!(greeting.iter().all(|(link, _)| *link == Link::Simulator));
    let ids: Vec<u32> = greeting.iter().map(|(_, f)| f.message_id).collect();
    assert_eq!(ids, [0, 76, 76]);
    let asked: Vec<f32> = greeting.iter().filter_map(|(_, f)| f.command()).map(|c| c.params[0]).collect();
    assert_eq!(asked, [115.0, 331.0]);
    bench.session.simulator_connected();
    assert_eq!(bench.drain().len(), 3, "and again after a reconnect");
}

#[test]
fn regress_heartbeats_run_before_the_simulator_does() {
    let mut bench = Bench::new();
    bench.drain();
    for now in (0..3_000_000).step_by(10_000) {
        bench.session.handle_time(now);
    }
    let sent = bench.drain();
    assert_eq!(sent.iter().filter(|(link, f)| *link == Link::Api && f.message_id == 0).count(), 3);
    assert!(sent.iter().all(|(link, _)| *link != Link::Simulator));
}

/// By PX4 v1.14's tables and its simulation's start script, in which ground stations have 50 Hz of these.
#[test]
fn regress_rates_are_px4s() {
    let mut bench = Bench::running();
    let mut sent = Vec::new();
    for _ in 0..500 {
        bench.send(Link::Api, &level_no_thrust());
        sent.extend(bench.run(0.02));
    }
    let count =
        |link, message_id| sent.iter().filter(|(l, f)| *l == link && f.message_id == message_id).count();
    for (message_id, ground, api) in [
        (0, 10, 10),
        (1, 10, 50),
        (4, 1, 10),
        (29, 10, 10),
        (30, 500, 1000),
        (31, 500, 500),
        (32, 500, 300),
        (33, 500, 500),
        (36, 500, 100),
        (74, 40, 100),
        (141, 10, 100),
        (241, 1, 5),
        (245, 10, 50),
        (340, 5, 10),
        (105, 0, 500),
        (331, 0, 300),
    ] {
        assert!(count(Link::GroundStation, message_id).abs_diff(ground) <= 1, "{message_id}");
        assert!(count(Link::Api, message_id).abs_diff(api) <= 1, "{message_id}");
    }
    assert_eq!(count(Link::Simulator, 0), 10, "the simulator is told the mode");
}

#[test]
fn regress_the_simulator_hears_of_a_change_of_mode_at_once() {
    let mut bench = Bench::engaged();
    let Some(MavMessage::HEARTBEAT(m)) = last(&bench.step(), Link::Simulator, 0) else { panic!() };
    assert_eq!((m.custom_mode, m.base_mode.bits()), (0x0006_0000, 129));
    assert_eq!(last(&bench.step(), Link::Simulator, 0), None);
}

#[test]
fn regress_sequence_numbers_have_no_gaps_on_any_link() {
    let mut bench = Bench::new();
    let mut sent = bench.drain();
    sent.extend(bench.run(5.0));
    for link in [Link::Simulator, Link::GroundStation, Link::Api] {
        let frames: Vec<_> = sent.iter().filter(|(l, _)| *l == link).map(|(_, f)| f).collect();
        assert!(frames.len() > 10);
        for (n, frame) in frames.iter().enumerate() {
            assert_eq!(usize::from(frame.sequence), n % 256);
            assert_eq!((frame.system_id, frame.component_id), (VEHICLE, 1));
        }
    }
}

#[test]
fn regress_heartbeat_shows_type_mode_and_arming() {
    let mut bench = Bench::engaged();
    bench.send(Link::Api, &level_no_thrust());
    let heartbeat = |sent: Vec<Sent>| last(&sent, Link::GroundStation, 0);
    let Some(MavMessage::HEARTBEAT(m)) = heartbeat(bench.run(1.0)) else { panic!() };
    assert_eq!((m.custom_mode, m.system_status), (0x0006_0000, MavState::MAV_STATE_ACTIVE));
    let Some(MavMessage::HEARTBEAT(m)) = heartbeat(bench.run(1.0)) else { panic!() };
    assert_eq!(m.mavtype, MavType::MAV_TYPE_QUADROTOR);
    assert_eq!(m.autopilot, MavAutopilot::MAV_AUTOPILOT_PX4);
    assert_eq!((m.base_mode.bits(), m.mavlink_version), (129, 3));
    // The last setpoint is over a second old by now.
    assert_eq!((m.custom_mode, m.system_status), (0x0304_0000, MavState::MAV_STATE_CRITICAL));
}

#[test]
fn closed_form_position_attitude_and_time_are_the_simulators() {
    let mut bench = Bench::new();
    let (half_sin, half_cos) = 0.1f32.sin_cos();
    bench.state.q = [half_cos, 0.0, half_sin, 0.0];
    (bench.state.x, bench.state.y, bench.state.z) = (1000.0, -500.0, 250.0);
    bench.state.vx = 2.0;
    let sent = bench.run(1.0);
    let Some(MavMessage::ATTITUDE(attitude)) = last(&sent, Link::Api, 30) else { panic!() };
    assert!((attitude.pitch - 0.2).abs() < 1e-6);
    assert_eq!(attitude.time_boot_ms, 1000);
    let Some(MavMessage::LOCAL_POSITION_NED(local)) = last(&sent, Link::Api, 32) else { panic!() };
    assert_eq!((local.x, local.y, local.z), (1000.0, -500.0, 250.0));
    assert!((local.vx - 2.0 * 0.2f32.cos()).abs() < 1e-6 && (local.vz + 2.0 * 0.2f32.sin()).abs() < 1e-6);
    let Some(MavMessage::GLOBAL_POSITION_INT(global)) = last(&sent, Link::Api, 33) else { panic!() };
    // A metre north is 8.9932e-6 deg.
    assert!((f64::from(global.lat) - (12.5 + 1000.0 * 8.993_216e-6) * 1e7).abs() < 2.0, "{}", global.lat);
    // It has not been armed and has not moved: it is at home.
    assert_eq!((global.alt, global.relative_alt), (1_250_000, 0));
    let Some(MavMessage::HOME_POSITION(home)) = last(&sent, Link::Api, 242) else { panic!() };
    assert_eq!((home.latitude, home.longitude, home.altitude), (global.lat, global.lon, global.alt));
    assert_eq!((home.x, home.y, home.z), (1000.0, -500.0, 250.0));
    let Some(MavMessage::SYSTEM_TIME(time)) = last(&sent, Link::Api, 2) else { panic!() };
    assert_eq!(time.time_unix_usec - 1_600_000_000_000_000, u64::from(time.time_boot_ms) * 1000);
}

#[test]
fn regress_health_and_landed_state_show_what_mavsdk_waits_for() {
    let mut bench = Bench::new();
    let landed = |sent: &[Sent]| match last(sent, Link::Api, 245) {
        Some(MavMessage::EXTENDED_SYS_STATE(m)) => m.landed_state,
        other => panic!("{other:?}"),
    };
    let sent = bench.run(1.0);
    let Some(MavMessage::SYS_STATUS(status)) = last(&sent, Link::Api, 1) else { panic!() };
    for bits in [status.onboard_control_sensors_present, status.onboard_control_sensors_enabled] {
        assert_eq!(bits.bits(), 0x1000_002F);
    }
    // Without the fence's bit MAVProxy cries "fence breach".
    assert_eq!(status.onboard_control_sensors_health.bits(), 0x1010_002F);
    assert_eq!(landed(&sent), MavLandedState::MAV_LANDED_STATE_ON_GROUND);
    bench.state.vz = 3.0;
    assert_eq!(landed(&bench.run(1.0)), MavLandedState::MAV_LANDED_STATE_IN_AIR, "under the canopy");
}

/// PX4 sets home where it first knows its position and again at each arming, in mid-air too.
#[test]
fn reference_home_is_where_the_vehicle_was_first_seen_then_where_it_was_armed() {
    let mut bench = Bench::new();
    let ask = command(MavCmd::MAV_CMD_REQUEST_MESSAGE, &[242.0]);
    let denied = bench.send(Link::Api, &ask);
    assert!(last(&denied, Link::Api, 242).is_none(), "no state, no home");
    let home = |bench: &mut Bench| match last(&bench.send(Link::Api, &ask), Link::Api, 242) {
        Some(MavMessage::HOME_POSITION(m)) => m,
        other => panic!("{other:?}"),
    };
    bench.state.z = -50.0;
    bench.step();
    assert_eq!((home(&mut bench).z, home(&mut bench).altitude), (-50.0, 1_550_000));
    (bench.state.x, bench.state.z, bench.state.vz) = (3.0, -30.0, 5.0);
    bench.step();
    assert_eq!(home(&mut bench).z, -50.0, "a vehicle that hangs stands on nothing");
    let (half_sin, half_cos) = 0.25f32.sin_cos();
    bench.state.q = [half_cos, 0.0, 0.0, half_sin];
    bench.send(Link::Api, &command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]));
    bench.step();
    let armed = home(&mut bench);
    assert_eq!((armed.x, armed.z, armed.altitude), (3.0, -30.0, 1_530_000));
    assert!((armed.q[0] - half_cos).abs() < 1e-6 && (armed.q[3] - half_sin).abs() < 1e-6, "{:?}", armed.q);
    assert_eq!(armed.time_usec, bench.now);
    bench.state.z = -10.0;
    let sent = bench.run(1.0);
    let Some(MavMessage::GLOBAL_POSITION_INT(global)) = last(&sent, Link::Api, 33) else { panic!() };
    let Some(MavMessage::ALTITUDE(altitude)) = last(&sent, Link::Api, 141) else { panic!() };
    assert_eq!((global.alt, global.relative_alt), (1_510_000, -20_000));
    assert_eq!((altitude.altitude_local, altitude.altitude_relative), (10.0, -20.0));
    assert_eq!(home(&mut bench).z, -30.0);
}

/// Calibrated airspeed: TAS sqrt(rho / 1.225), in Titan's air of 5.4 kg/m^3.
#[test]
fn closed_form_airspeed_is_calibrated() {
    let mut bench = Bench::new();
    bench.state.vx = 2.0;
    let sent = bench.run(1.0);
    let Some(MavMessage::VFR_HUD(m)) = last(&sent, Link::Api, 74) else { panic!() };
    assert!((f64::from(m.airspeed) - 2.0 * (5.4f64 / 1.225).sqrt()).abs() < 1e-6, "{}", m.airspeed);
    assert_eq!(m.groundspeed, 2.0);
}

#[test]
fn regress_the_simulator_hears_of_a_failsafe_and_of_its_end() {
    let mut bench = Bench::engaged();
    bench.step();
    let beats = |sent: Vec<Sent>| -> Vec<MavState> {
        let status = |f: &Frame| match f.known() {
            Some(MavMessage::HEARTBEAT(m)) => Some(m.system_status),
            _ => None,
        };
        let simulators = sent.iter().filter(|(link, _)| *link == Link::Simulator);
        simulators.filter_map(|(_, f)| status(f)).collect()
    };
    assert!(beats(bench.run(1.1)).contains(&MavState::MAV_STATE_CRITICAL));
    // HOLD is where it is already: only the failsafe ends.
    bench.send(Link::Api, &command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 4.0, 3.0]));
    assert_eq!(beats(bench.step()), [MavState::MAV_STATE_ACTIVE]);
}

/// The simulator was killed in mid-flight; the next one has a vehicle hanging, and may release on "armed in
/// OFFBOARD".
#[test]
fn regress_a_new_simulator_is_not_greeted_with_the_old_flight() {
    let mut bench = Bench::engaged();
    bench.step();
    bench.session.simulator_connected();
    let sent = bench.drain();
    let Some(MavMessage::HEARTBEAT(m)) = last(&sent, Link::Simulator, 0) else { panic!() };
    assert_eq!((m.custom_mode, m.base_mode.bits()), (0x0304_0000, 1));
    assert_eq!(bench.session.time(), None);
    bench.now = 0;
    bench.step();
    assert_eq!((bench.session.time(), bench.session.autopilot().is_armed()), (Some(4_000), false));
}
