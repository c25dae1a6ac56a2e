//! Setpoints through the wire, and the answer to the simulator.

use mavlink::MessageData as _;
use mavlink::dialects::common::*;
use samara::autopilot::FlightMode;
use samara::link::Link;

use super::bench::{Bench, STEP_US, VEHICLE, actuators, level_no_thrust, texts, velocity};

fn message(data: SET_POSITION_TARGET_LOCAL_NED_DATA) -> MavMessage {
    MavMessage::SET_POSITION_TARGET_LOCAL_NED(data)
}

#[test]
fn regress_each_sensor_message_gets_one_answer_of_its_time() {
    let mut bench = Bench::new();
    bench.drain();
    for armed in [false, true] {
        if armed {
            bench = Bench::engaged();
        }
        for _ in 0..50 {
            let sent = bench.step();
            assert_eq!(sent.iter().filter(|(_, f)| f.message_id == 93).count(), 1);
            let answer = actuators(&sent);
            assert_eq!(answer.time_usec, bench.now);
            assert_eq!(answer.flags.bits() & 1, 1, "lockstep");
            assert_eq!(answer.mode.bits(), if armed { 129 } else { 1 });
            assert_eq!(answer.controls, [0.0; 16], "no thrust asked for");
        }
    }
}

#[test]
fn regress_velocity_setpoints_turn_the_motors_within_range() {
    let mut bench = Bench::engaged();
    bench.state.vz = 3.675;
    bench.send(Link::Api, &message(velocity([4.0, 0.0, 4.0], 0x0DC7)));
    let controls = actuators(&bench.step()).controls;
    assert!(controls[..4].iter().all(|c| (0.0..=1.0).contains(c)) && controls[0] != controls[1]);
    assert_eq!(controls[4..], [0.0; 12]);
}

#[test]
fn regress_setpoints_to_other_systems_do_not_count() {
    let mut bench = Bench::engaged();
    for (system, component) in [(VEHICLE + 1, 1), (VEHICLE, 161)] {
        let stray = SET_POSITION_TARGET_LOCAL_NED_DATA {
            target_system: system,
            target_component: component,
            ..velocity([0.0, 0.0, -9.0], 0x0DC7)
        };
        assert!(bench.send(Link::Api, &message(stray)).is_empty());
        assert_eq!(actuators(&bench.step()).controls, [0.0; 16]);
    }
    let to_all = SET_POSITION_TARGET_LOCAL_NED_DATA {
        target_system: 0,
        target_component: 0,
        ..velocity([0.0, 0.0, -9.0], 0x0DC7)
    };
    bench.send(Link::Api, &message(to_all));
    assert_ne!(actuators(&bench.step()).controls, [0.0; 16]);
}

#[test]
fn regress_refused_setpoints_say_why_once_and_do_not_keep_offboard_alive() {
    let mut bench = Bench::engaged();
    let mut said = Vec::new();
    for _ in 0..75 {
        let nan = velocity([f32::NAN, 0.0, 0.0], 0x0DC7);
        let position = velocity([0.0; 3], 0x0DFC);
        for bad in [nan, position] {
            said.extend(texts(&bench.send(Link::Api, &message(bad)), Link::Api));
        }
        for _ in 0..5 {
            said.extend(texts(&bench.step(), Link::Api));
        }
    }
    let expected = [
        "setpoint refused: NaN or infinite",
        "setpoint refused: an axis has no setpoint",
        "OFFBOARD lost: no setpoint for 1 s",
        "Failsafe: HOLD",
    ];
    assert_eq!(said, expected);
    assert_eq!(bench.session.autopilot().mode(), FlightMode::AutoLoiter);
}

#[test]
fn regress_nan_in_ignored_fields_is_ignored() {
    let mut bench = Bench::engaged();
    let nan = f32::NAN;
    let setpoint = SET_POSITION_TARGET_LOCAL_NED_DATA {
        x: nan,
        y: nan,
        z: nan,
        afx: nan,
        afy: nan,
        afz: nan,
        yaw: nan,
        yaw_rate: nan,
        ..velocity([1.0, 0.0, 0.0], 0x0DC7)
    };
    assert!(bench.send(Link::Api, &message(setpoint)).is_empty());
    bench.step();
    assert_eq!(bench.session.autopilot().velocity_target().unwrap().v_ned.x, 1.0);
}

#[test]
fn regress_an_unknown_frame_is_refused_with_the_reason() {
    let mut bench = Bench::engaged();
    let mut payload = [0; 53];
    payload[48..50].copy_from_slice(&0x0DC7u16.to_le_bytes());
    (payload[50], payload[51], payload[52]) = (VEHICLE, 1, 200);
    let crc_extra = SET_POSITION_TARGET_LOCAL_NED_DATA::EXTRA_CRC;
    let bytes = bench.encoder(Link::Api).encode_payload(84, crc_extra, &payload);
    let sent = bench.send_bytes(Link::Api, &bytes);
    assert_eq!(texts(&sent, Link::Api), ["setpoint refused: frame must be 1 or 8"]);
}

#[test]
fn regress_offboard_ends_a_second_of_simulated_time_after_the_last_setpoint() {
    let mut bench = Bench::engaged();
    bench.send(Link::Api, &level_no_thrust());
    let begun = bench.now;
    while bench.session.autopilot().mode() == FlightMode::Offboard {
        bench.step();
    }
    assert_eq!(bench.now - begun, 1_000_000 + STEP_US);
}

#[test]
fn regress_a_gap_in_the_state_is_flown_through_and_a_long_one_said() {
    let mut bench = Bench::engaged();
    bench.send(Link::Api, &message(velocity([0.0; 3], 0x0DC7)));
    bench.step();
    let mut said = Vec::new();
    let mut controls = [0.0; 16];
    for _ in 0..50 {
        bench.now += STEP_US;
        let sent = bench.sensor();
        assert_eq!(actuators(&sent).time_usec, bench.now);
        controls = actuators(&sent).controls;
        said.extend(texts(&sent, Link::GroundStation));
    }
    assert_eq!(said, ["no ODOMETRY or HIL_STATE_QUATERNION: flying blind"]);
    assert!(controls[0] > 0.0);
}

#[test]
fn regress_a_simulator_that_starts_over_finds_a_disarmed_vehicle() {
    let mut bench = Bench::engaged();
    bench.run(0.5);
    bench.now = 0;
    let sent = bench.step();
    assert_eq!(actuators(&sent).mode.bits(), 1);
    assert!(texts(&sent, Link::Api).contains(&"simulated time started over: disarmed".to_owned()));
    assert!(sent.iter().any(|(link, f)| *link == Link::Api && f.message_id == 30), "telemetry goes on");
}
