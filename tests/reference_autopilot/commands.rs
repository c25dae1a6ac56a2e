//! Commands: obeyed or refused, and acknowledged exactly once, to their sender.
#![expect(deprecated, reason = "deprecated commands are still sent and owed an answer")]

use mavlink::dialects::common::*;
use mavlink::{Message as _, MessageData as _};
use samara::autopilot::FlightMode;
use samara::link::{CommandAck, Decoder, Link, Session as _};

use super::bench::{
    Bench, COMPANION, GROUND, Sent, VEHICLE, acks, command, last, level_no_thrust, texts, velocity,
};

const ACCEPTED: u8 = 0;
const TEMPORARILY_REJECTED: u8 = 1;
const DENIED: u8 = 2;
const UNSUPPORTED: u8 = 3;

/// Sends a command from the companion; its one acknowledgement's result.
fn result(bench: &mut Bench, message: &MavMessage) -> u8 {
    let sent = bench.send(Link::Api, message);
    let acks = acks(&sent);
    assert_eq!(acks.len(), 1, "{message:?}");
    acks[0].result
}

#[test]
fn regress_every_command_number_gets_one_ack_to_its_sender() {
    let mut bench = Bench::running();
    for (link, peer) in [(Link::Api, COMPANION), (Link::GroundStation, GROUND)] {
        for number in (0u16..600).chain([2000, 2510, 31_010, 42_424, 65_535]) {
            for (message_id, crc_extra) in
                [(76, COMMAND_LONG_DATA::EXTRA_CRC), (75, COMMAND_INT_DATA::EXTRA_CRC)]
            {
                let mut payload = [0; 35];
                payload[28..30].copy_from_slice(&number.to_le_bytes());
                (payload[30], payload[31]) = (VEHICLE, 1);
                // An unknown frame in COMMAND_INT, many confirmations in COMMAND_LONG.
                payload[32] = 99;
                let len = if message_id == 76 { 33 } else { 35 };
                let bytes = bench.encoder(link).encode_payload(message_id, crc_extra, &payload[..len]);
                let mut sent = bench.send_bytes(link, &bytes);
                if is_passed_on(number) {
                    // Others' to answer: passed on, and the answer back.
                    assert!(acks(&sent).is_empty());
                    sent = answered_by_the_simulator(&mut bench, &sent);
                }
                let on_link: Vec<CommandAck> = acks(&sent);
                assert_eq!(on_link.len(), 1, "command {number}");
                assert!(sent.iter().all(|(l, f)| f.command_ack().is_none() || *l == link));
                let ack = &on_link[0];
                assert_eq!((ack.command, ack.target_system, ack.target_component), (number, peer.0, peer.1));
                assert!(number < 600 || ack.result == UNSUPPORTED, "command {number}");
            }
        }
    }
}

/// Whether a command, its parameters zero, is passed on to the simulator's end.
pub fn is_passed_on(number: u16) -> bool {
    number == MavCmd::MAV_CMD_INJECT_FAILURE as u16 || number == MavCmd::MAV_CMD_DO_GRIPPER as u16
}

/// Answers the command that was passed on to the simulator, or to its parachute, with UNSUPPORTED; what the
/// autopilot sends then.
pub fn answered_by_the_simulator(bench: &mut Bench, sent: &[Sent]) -> Vec<Sent> {
    let passed = |(link, frame): &Sent| (*link == Link::Simulator).then(|| frame.command()).flatten();
    let commands: Vec<_> = sent.iter().filter_map(passed).collect();
    assert_eq!(commands.len(), 1);
    let command = commands[0];
    let component = if command.command == 420 { 200 } else { 161 };
    assert_eq!((command.target_system, command.target_component), (VEHICLE, component));
    assert!(is_passed_on(command.command));
    let ack = CommandAck::new(&command, UNSUPPORTED, (VEHICLE, 1));
    let bytes = bench.encoder(Link::Simulator).encode_command_ack(&ack);
    bench.send_bytes(Link::Simulator, &bytes)
}

/// A simulator that says nothing is not waited for longer than a second, and no more than sixteen commands
/// wait for it.
#[test]
fn failure_injection_without_an_answer_has_failed() {
    let mut bench = Bench::running();
    let message = MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
        command: MavCmd::MAV_CMD_INJECT_FAILURE,
        param1: 101.0,
        param2: 1.0,
        target_system: VEHICLE,
        target_component: 1,
        ..Default::default()
    });
    for _ in 0..16 {
        assert!(acks(&bench.send(Link::Api, &message)).is_empty());
    }
    assert_eq!(result(&mut bench, &message), TEMPORARILY_REJECTED);
    let now = bench.now;
    bench.session.handle_time(now);
    bench.session.handle_time(now + 2_000_000);
    let mut failed = 0;
    let mut decoder = Decoder::new();
    while let Some(sent) = bench.session.poll_output() {
        decoder.datagram(&sent.bytes, |frame| {
            failed += usize::from(frame.command_ack().is_some_and(|ack| ack.result == 4));
        });
    }
    assert_eq!(failed, 16);
}

/// PX4's documents and MAVSDK: SYS_FAILURE_EN, 0 by default, guards the command.
#[test]
fn reference_failures_are_injected_only_where_that_is_enabled() {
    let mut bench = Bench::new();
    bench.step();
    let sent = bench.send(Link::Api, &command(MavCmd::MAV_CMD_INJECT_FAILURE, &[101.0, 1.0]));
    assert_eq!(acks(&sent)[0].result, DENIED);
    assert_eq!(texts(&sent, Link::Api), ["failure injection refused: SYS_FAILURE_EN is 0"]);
}

#[test]
fn regress_commands_to_others_are_neither_obeyed_nor_acknowledged() {
    let mut bench = Bench::running();
    for (system, component) in [(VEHICLE + 1, 1), (VEHICLE + 1, 0), (VEHICLE, 161), (VEHICLE, 2), (1, 1)] {
        let message = MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
            command: MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
            param1: 1.0,
            target_system: system,
            target_component: component,
            ..Default::default()
        });
        assert!(bench.send(Link::Api, &message).is_empty(), "{system}/{component}");
    }
    assert!(!bench.session.autopilot().is_armed());
    for (system, component) in [(0, 0), (VEHICLE, 0), (0, 1)] {
        let message = MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
            command: MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
            param1: 0.0,
            target_system: system,
            target_component: component,
            ..Default::default()
        });
        assert_eq!(result(&mut bench, &message), ACCEPTED, "{system}/{component}");
    }
}

#[test]
fn regress_the_parachutes_commands_to_everybody_are_left_to_the_parachute() {
    let mut bench = Bench::running();
    let to = |command, target_component| {
        MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
            command,
            target_system: VEHICLE,
            target_component,
            ..Default::default()
        })
    };
    for command in [MavCmd::MAV_CMD_DO_GRIPPER, MavCmd::MAV_CMD_DO_PARACHUTE] {
        assert!(bench.send(Link::Api, &to(command, 0)).is_empty());
    }
    assert_eq!(result(&mut bench, &to(MavCmd::MAV_CMD_DO_PARACHUTE, 1)), UNSUPPORTED);
}

#[test]
fn regress_offboard_and_arming_as_px4_has_them() {
    let mut bench = Bench::new();
    let offboard = command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 6.0]);
    let arm = command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]);
    let disarm = command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[0.0]);
    let sent = bench.send(Link::Api, &arm);
    assert_eq!(acks(&sent)[0].result, TEMPORARILY_REJECTED);
    for link in [Link::Api, Link::GroundStation] {
        assert_eq!(texts(&sent, link), ["Arming denied: no attitude and velocity yet"]);
    }
    bench.step();
    // Disarmed, any mode may be chosen (PX4 v1.14.3, UserModeIntention.cpp); it arms with setpoints.
    assert_eq!(result(&mut bench, &offboard), ACCEPTED);
    let sent = bench.send(Link::Api, &arm);
    assert_eq!(acks(&sent)[0].result, TEMPORARILY_REJECTED);
    assert_eq!(texts(&sent, Link::Api), ["Arming denied: no offboard signal"]);
    bench.send(Link::Api, &level_no_thrust());
    assert_eq!(result(&mut bench, &arm), ACCEPTED);
    assert_eq!(result(&mut bench, &arm), ACCEPTED, "again");
    assert_eq!(bench.session.autopilot().mode(), FlightMode::Offboard);
    assert!(bench.session.autopilot().is_armed());
    bench.send(Link::Api, &MavMessage::SET_POSITION_TARGET_LOCAL_NED(velocity([0.0; 3], 0x0DC7)));
    bench.step();
    assert_eq!(result(&mut bench, &disarm), TEMPORARILY_REJECTED, "in flight");
    let forced = command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[0.0, 21196.0]);
    assert_eq!(result(&mut bench, &forced), ACCEPTED);
    assert!(!bench.session.autopilot().is_armed());
    for nonsense in [f32::NAN, 2.0, -1.0, 0.5] {
        let message = command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[nonsense]);
        assert_eq!(result(&mut bench, &message), DENIED, "{nonsense}");
    }
}

#[test]
fn regress_modes_by_command_and_by_message() {
    let mut bench = Bench::running();
    for (params, expected) in [
        (&[1.0, 4.0, 3.0][..], ACCEPTED),
        (&[f32::NAN, 4.0, 3.0], ACCEPTED),
        // PX4 rejects for the time being what it knows and does not enter, and any AUTO that it does not
        // know.
        (&[1.0, 5.0], TEMPORARILY_REJECTED),
        // Disarmed, PX4 enters modes that need sticks without them.
        (&[1.0, 7.0], ACCEPTED),
        (&[1.0, 3.0], ACCEPTED),
        (&[1.0, 4.0, 5.0], ACCEPTED),
        (&[1.0, 4.0, 2.0], ACCEPTED),
        (&[1.0, 4.0, 6.0], ACCEPTED),
        (&[1.0, 4.0, 3.0], ACCEPTED),
        (&[1.0, 4.0, 4.0], TEMPORARILY_REJECTED),
        (&[1.0, 4.0, 9.0], TEMPORARILY_REJECTED),
        (&[1.0, 99.0], DENIED),
        (&[1.0, f32::INFINITY], DENIED),
        (&[1.0], DENIED),
        (&[0.0, 4.0, 3.0], DENIED),
    ] {
        let message = command(MavCmd::MAV_CMD_DO_SET_MODE, params);
        assert_eq!(result(&mut bench, &message), expected, "{params:?}");
    }
    // Standard modes by MAVLink's numbers: 1 position hold, 4 altitude hold, 5 safe recovery, 7 land, 8
    // takeoff.
    for (number, expected) in [
        (5.0, ACCEPTED),
        (7.0, ACCEPTED),
        (8.0, ACCEPTED),
        (1.0, ACCEPTED),
        (4.0, ACCEPTED),
        (2.0, DENIED),
        (0.0, DENIED),
        (99.0, DENIED),
        (f32::NAN, DENIED),
    ] {
        let message = command(MavCmd::MAV_CMD_DO_SET_STANDARD_MODE, &[number]);
        assert_eq!(result(&mut bench, &message), expected, "{number}");
    }
    let hold = command(MavCmd::MAV_CMD_DO_SET_MODE, &[1.0, 4.0, 3.0]);
    assert_eq!(result(&mut bench, &hold), ACCEPTED);
    bench.send(Link::Api, &level_no_thrust());
    // QGroundControl's SET_MODE: base mode 1, which names no MAV_MODE.
    for (target, custom_mode, expected) in [
        (VEHICLE + 1, 6 << 16, FlightMode::AutoLoiter),
        (VEHICLE, 6 << 16, FlightMode::Offboard),
        (VEHICLE, 3 << 24 | 4 << 16, FlightMode::AutoLoiter),
        (VEHICLE, 0xFFFF_FFFF, FlightMode::AutoLoiter),
    ] {
        let mut payload = [0; 6];
        payload[..4].copy_from_slice(&u32::to_le_bytes(custom_mode));
        (payload[4], payload[5]) = (target, 1);
        let bytes =
            bench.encoder(Link::GroundStation).encode_payload(11, MavMessage::extra_crc(11), &payload);
        let sent = bench.send_bytes(Link::GroundStation, &bytes);
        assert_eq!(bench.session.autopilot().mode(), expected, "{custom_mode:#x}");
        assert!(acks(&sent).is_empty());
    }
}

#[test]
fn regress_what_is_not_flown_is_refused_with_a_reason() {
    let mut bench = Bench::running();
    for (number, word, expected) in [
        (MavCmd::MAV_CMD_DO_REPOSITION, "REPOSITION", TEMPORARILY_REJECTED),
        (MavCmd::MAV_CMD_MISSION_START, "No valid mission", DENIED),
    ] {
        let sent = bench.send(Link::GroundStation, &command(number, &[]));
        assert_eq!(acks(&sent)[0].result, expected);
        assert!(texts(&sent, Link::GroundStation).concat().contains(word));
    }
}

/// The buttons of a ground station enter their modes; a place in a COMMAND_INT is in degE7, its height by its
/// frame.
#[test]
fn regress_navigation_commands() {
    let mut bench = Bench::running();
    for (number, mode) in [
        (MavCmd::MAV_CMD_NAV_TAKEOFF, FlightMode::AutoTakeoff),
        (MavCmd::MAV_CMD_NAV_LAND, FlightMode::AutoLand),
        (MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH, FlightMode::AutoRtl),
    ] {
        assert_eq!(result(&mut bench, &command(number, &[])), ACCEPTED);
        assert_eq!(bench.session.autopilot().mode(), mode);
    }
    let home = |x: i32, y: i32, z: f32, frame: MavFrame| {
        MavMessage::COMMAND_INT(COMMAND_INT_DATA {
            param1: 0.0,
            param2: 0.0,
            param3: 0.0,
            param4: f32::NAN,
            x,
            y,
            z,
            command: MavCmd::MAV_CMD_DO_SET_HOME,
            target_system: VEHICLE,
            target_component: 1,
            frame,
            current: 0,
            autocontinue: 0,
        })
    };
    let there = home(125_000_100, -342_500_000, 1490.0, MavFrame::MAV_FRAME_GLOBAL);
    assert_eq!(result(&mut bench, &there), ACCEPTED);
    let sent = bench.run(2.1);
    let Some(MavMessage::HOME_POSITION(m)) = last(&sent, Link::GroundStation, 242) else { panic!() };
    assert!((m.latitude - 125_000_100).abs() <= 1 && (m.altitude - 1_490_000).abs() <= 1);
    // 10 m below the local origin.
    assert!((m.z - 10.0).abs() < 1e-3 && (m.x - 1.112).abs() < 1e-2, "{} {}", m.x, m.z);
    for (x, frame) in [
        (950_000_000, MavFrame::MAV_FRAME_GLOBAL),
        (1, MavFrame::MAV_FRAME_LOCAL_NED),
        (i32::MAX, MavFrame::MAV_FRAME_LOCAL_NED),
    ] {
        assert_eq!(result(&mut bench, &home(x, 0, 1.0, frame)), DENIED);
    }
}

#[test]
fn regress_requested_messages_come_or_are_denied() {
    let mut bench = Bench::running();
    let request = |message_id: f32| command(MavCmd::MAV_CMD_REQUEST_MESSAGE, &[message_id]);
    for message_id in
        [0u32, 1, 2, 30, 31, 32, 33, 36, 74, 42, 105, 141, 147, 148, 230, 242, 245, 331, 397, 435, 436, 437]
    {
        let sent = bench.send(Link::GroundStation, &request(message_id as f32));
        assert_eq!(acks(&sent)[0].result, ACCEPTED, "{message_id}");
        assert!(last(&sent, Link::GroundStation, message_id).is_some(), "{message_id}");
        assert!(sent.iter().all(|(link, _)| *link == Link::GroundStation));
    }
    // Not ours, nothing to tell yet (24: no HIL_GPS came), nonsense.
    for message_id in [24.0, 85.0, 280.0, 395.0, 411.0, 70_000.0, -1.0, 0.5, f32::NAN, f32::INFINITY] {
        let sent = bench.send(Link::GroundStation, &request(message_id));
        assert_eq!((sent.len(), acks(&sent)[0].result), (1, DENIED), "{message_id}");
    }
    for number in [MavCmd::MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, MavCmd::MAV_CMD_GET_HOME_POSITION] {
        assert_eq!(bench.send(Link::Api, &command(number, &[1.0])).len(), 2);
    }
}

#[test]
fn regress_before_there_is_a_state_its_messages_are_denied() {
    let mut bench = Bench::new();
    bench.drain();
    for (message_id, expected) in [(30.0, DENIED), (33.0, DENIED), (148.0, ACCEPTED), (242.0, DENIED)] {
        let message = command(MavCmd::MAV_CMD_REQUEST_MESSAGE, &[message_id]);
        assert_eq!(result(&mut bench, &message), expected, "{message_id}");
    }
}

#[test]
fn regress_message_intervals_are_per_link() {
    let mut bench = Bench::running();
    let count = |bench: &mut Bench, link| {
        let sent = bench.run(2.0);
        sent.iter().filter(|(l, f)| *l == link && f.message_id == 30).count()
    };
    assert!(count(&mut bench, Link::GroundStation).abs_diff(100) <= 1);
    let slower = command(MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, &[30.0, 100_000.0]);
    assert_eq!(acks(&bench.send(Link::GroundStation, &slower))[0].result, ACCEPTED);
    assert!(count(&mut bench, Link::GroundStation).abs_diff(20) <= 1);
    assert!(count(&mut bench, Link::Api).abs_diff(200) <= 1, "the other link keeps its own");
    let ask = command(MavCmd::MAV_CMD_GET_MESSAGE_INTERVAL, &[30.0]);
    let sent = bench.send(Link::GroundStation, &ask);
    let Some(MavMessage::MESSAGE_INTERVAL(interval)) = last(&sent, Link::GroundStation, 244) else {
        panic!()
    };
    assert_eq!((interval.message_id, interval.interval_us), (30, 100_000));
    for (message_id, interval_us) in
        [(9999.0, 1000.0), (30.0, f32::NAN), (30.0, -5.0), (f32::NAN, 0.0), (30.0, f32::INFINITY)]
    {
        let message = command(MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, &[message_id, interval_us]);
        assert_eq!(result(&mut bench, &message), DENIED, "{message_id} {interval_us}");
    }
}

#[test]
fn regress_a_mode_that_is_not_entered_is_refused_with_the_reason() {
    let mut bench = Bench::running();
    for (params, reason) in [
        (&[1.0, 5.0][..], "ACRO is not flown here"),
        (&[1.0, 4.0, 4.0], "AUTO.MISSION refused: no valid mission"),
        (&[1.0, 4.0, 1.0], "AUTO.READY is not flown here"),
        (&[1.0, 4.0, 9.0], "mode refused: unsupported auto mode"),
        (&[1.0, 9.0], "mode refused: no such mode"),
    ] {
        let sent = bench.send(Link::Api, &command(MavCmd::MAV_CMD_DO_SET_MODE, params));
        // Long reasons come in pieces.
        assert_eq!(texts(&sent, Link::Api).concat(), reason);
    }
}
