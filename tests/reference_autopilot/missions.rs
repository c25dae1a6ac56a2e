//! Missions on the wire: uploaded, started, paused and gone on with as ground stations do it. The messages of
//! QGroundControl are those of commit 00d5b5e018e5 (src/MissionManager/PlanManager.cc,
//! src/FirmwarePlugin/PX4/PX4FirmwarePlugin.cc, src/Vehicle/Vehicle.cc); each is named by the function that
//! sends it.
#![expect(deprecated, reason = "what PX4 v1.14 asks with is deprecated in MAVLink")]

use mavlink::Message as _;
use mavlink::dialects::common::*;
use samara::autopilot::FlightMode;
use samara::link::{CommandAck, Link};

use super::bench::{Bench, GROUND, Sent, VEHICLE, acks, actuators, command, last, site, texts};
use super::closed_loop::{observe, under_the_canopy};

const STATION: Link = Link::GroundStation;
const MISSION_MODE: u32 = 4 << 24 | 4 << 16;

/// An item at a place: north and east of the local origin, and height above home [m].
fn item(seq: u16, command: MavCmd, [n, e, height_m]: [f64; 3], params: [f32; 4]) -> MISSION_ITEM_INT_DATA {
    let place = site().geo_point(&nalgebra::Vector3::new(n, e, 0.0));
    let [param1, param2, param3, param4] = params;
    MISSION_ITEM_INT_DATA {
        param1,
        param2,
        param3,
        param4,
        x: (place.latitude_deg * 1e7).round() as i32,
        y: (place.longitude_deg * 1e7).round() as i32,
        z: height_m as f32,
        seq,
        command,
        target_system: VEHICLE,
        target_component: 1,
        frame: MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT,
        current: u8::from(seq == 0),
        autocontinue: 1,
        ..Default::default()
    }
}

/// An item without a place.
fn order(seq: u16, command: MavCmd, params: [f32; 4]) -> MISSION_ITEM_INT_DATA {
    let item = item(seq, command, [0.0; 3], params);
    MISSION_ITEM_INT_DATA { x: 0, y: 0, z: 0.0, frame: MavFrame::MAV_FRAME_MISSION, ..item }
}

/// PlanManager::_writeMissionCount, then each item that the vehicle asks for
/// (PlanManager::_handleMissionRequest); what was acknowledged, and what else was sent with it.
fn upload(bench: &mut Bench, items: &[MISSION_ITEM_INT_DATA]) -> (MISSION_ACK_DATA, Vec<Sent>) {
    let count = MavMessage::MISSION_COUNT(MISSION_COUNT_DATA {
        count: items.len() as u16,
        target_system: VEHICLE,
        target_component: 1,
        ..Default::default()
    });
    let mut sent = bench.send(STATION, &count);
    for item in items {
        // PX4 v1.14 asks with the old message until the new item comes.
        let asked = match (item.seq, last(&sent, STATION, 40), last(&sent, STATION, 51)) {
            (0, Some(MavMessage::MISSION_REQUEST(m)), _) => (m.seq, m.target_system, m.target_component),
            (_, _, Some(MavMessage::MISSION_REQUEST_INT(m))) => (m.seq, m.target_system, m.target_component),
            _ => panic!("{sent:?}"),
        };
        assert_eq!(asked, (item.seq, GROUND.0, GROUND.1));
        sent = bench.send(STATION, &MavMessage::MISSION_ITEM_INT(item.clone()));
    }
    let Some(MavMessage::MISSION_ACK(ack)) = last(&sent, STATION, 47) else { panic!("{sent:?}") };
    (ack, sent)
}

/// Vehicle::setFlightMode: SET_MODE with PX4's number; its base mode names no MAV_MODE, so by bytes.
fn set_mode(bench: &mut Bench, custom_mode: u32) -> Vec<Sent> {
    let mut payload = [0; 6];
    payload[..4].copy_from_slice(&custom_mode.to_le_bytes());
    (payload[4], payload[5]) = (VEHICLE, 1);
    let bytes = bench.encoder(STATION).encode_payload(11, MavMessage::extra_crc(11), &payload);
    bench.send_bytes(STATION, &bytes)
}

fn current(sent: &[Sent], link: Link) -> MISSION_CURRENT_DATA {
    match last(sent, link, 42) {
        Some(MavMessage::MISSION_CURRENT(m)) => m,
        other => panic!("no MISSION_CURRENT but {other:?}"),
    }
}

fn reached(sent: &[Sent], link: Link) -> Vec<u16> {
    let seq = |(l, frame): &Sent| match frame.known() {
        Some(MavMessage::MISSION_ITEM_REACHED(m)) if *l == link => Some(m.seq),
        _ => None,
    };
    sent.iter().filter_map(seq).collect()
}

fn ack_of(sent: &[Sent]) -> CommandAck {
    acks(sent)[0]
}

/// Puts the vehicle at a place, at rest.
fn put(bench: &mut Bench, [n, e, height_m]: [f32; 3]) {
    (bench.state.x, bench.state.y, bench.state.z) = (n, e, -height_m);
}

/// The Plan view's upload, "Start Mission", "Pause" and "Continue Mission", to the end.
#[test]
fn reference_qgroundcontrol_flies_a_plan() {
    let mut bench = Bench::running();
    let any = f32::NAN;
    let plan = [
        item(0, MavCmd::MAV_CMD_NAV_TAKEOFF, [0.0, 0.0, 20.0], [0.0, 0.0, 0.0, any]),
        item(1, MavCmd::MAV_CMD_NAV_WAYPOINT, [50.0, 0.0, 20.0], [0.0, 0.0, 0.0, any]),
        item(2, MavCmd::MAV_CMD_NAV_WAYPOINT, [50.0, 50.0, 20.0], [0.0, 0.0, 0.0, any]),
        order(3, MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH, [0.0; 4]),
    ];
    let (ack, _) = upload(&mut bench, &plan);
    assert_eq!(ack.mavtype, MavMissionResult::MAV_MISSION_ACCEPTED);
    let told = current(&bench.run(1.1), Link::Api);
    assert_eq!((told.total, told.seq, told.mission_id, told.mission_mode), (4, 0, ack.opaque_id, 2));
    assert_eq!(told.mission_state, MissionState::MISSION_STATE_NOT_STARTED);

    // PX4FirmwarePlugin::startMission: the mode, until the HEARTBEAT shows it, then arming.
    set_mode(&mut bench, MISSION_MODE);
    let Some(MavMessage::HEARTBEAT(heartbeat)) = last(&bench.run(1.1), STATION, 0) else { panic!() };
    assert_eq!(heartbeat.custom_mode, MISSION_MODE);
    let sent = bench.send(STATION, &command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]));
    assert_eq!(ack_of(&sent).result, 0);
    let sent = bench.run(0.5);
    assert!(texts(&sent, STATION).contains(&"Executing Mission".to_owned()));
    let told = current(&sent, STATION);
    assert_eq!((told.mission_state, told.mission_mode), (MissionState::MISSION_STATE_ACTIVE, 1));
    put(&mut bench, [0.0, 0.0, 10.0]);
    let Some(MavMessage::EXTENDED_SYS_STATE(state)) = last(&bench.run(1.1), STATION, 245) else { panic!() };
    assert_eq!(state.landed_state, MavLandedState::MAV_LANDED_STATE_TAKEOFF);

    // Each item is told when it is reached, and again once a second, ten times.
    put(&mut bench, [0.0, 0.0, 20.0]);
    let sent = bench.run(0.1);
    assert_eq!((reached(&sent, STATION), reached(&sent, Link::Api)), (vec![0], vec![0]));
    assert_eq!(current(&sent, STATION).seq, 1);
    assert_eq!(reached(&bench.run(20.0), STATION), [0; 10]);

    // PX4FirmwarePlugin::pauseVehicle: DO_REPOSITION with nothing given.
    let pause = command(MavCmd::MAV_CMD_DO_REPOSITION, &[-1.0, 1.0, 0.0, any, any, any, any]);
    assert_eq!(ack_of(&bench.send(STATION, &pause)).result, 0);
    put(&mut bench, [50.0, 0.0, 20.0]);
    let sent = bench.run(1.1);
    assert_eq!(bench.session.autopilot().mode(), FlightMode::AutoLoiter);
    let told = current(&sent, STATION);
    assert_eq!((told.seq, told.mission_state), (1, MissionState::MISSION_STATE_PAUSED));
    assert!(reached(&sent, STATION).is_empty(), "it is at the place, and no mission flies");

    // "Continue Mission" is startMission again, armed as it is.
    set_mode(&mut bench, MISSION_MODE);
    let sent = bench.run(0.5);
    assert_eq!((reached(&sent, STATION), current(&sent, STATION).seq), (vec![1], 2));

    // Vehicle::setCurrentMissionSequence: DO_SET_MISSION_CURRENT, else MISSION_SET_CURRENT.
    let select = command(MavCmd::MAV_CMD_DO_SET_MISSION_CURRENT, &[1.0]);
    assert_eq!(ack_of(&bench.send(STATION, &select)).result, 0);
    assert_eq!(current(&bench.run(0.1), STATION).seq, 2, "reached again at once, and on");
    let (target_system, target_component) = (VEHICLE, 1);
    #[expect(
        deprecated,
        reason = "deprecated in MAVLink, sent by ground stations to what has not the command"
    )]
    let far =
        MavMessage::MISSION_SET_CURRENT(MISSION_SET_CURRENT_DATA { seq: 9, target_system, target_component });
    let sent = bench.send(STATION, &far);
    assert_eq!(texts(&sent, STATION), ["there is no mission item 9"]);

    put(&mut bench, [50.0, 50.0, 20.0]);
    bench.run(0.5);
    assert_eq!(bench.session.autopilot().mode(), FlightMode::AutoRtl, "the last item");
}

/// MISSION_START begins with its item and arms; DO_PAUSE_CONTINUE pauses and goes on.
#[test]
fn reference_started_and_paused_by_command() {
    let mut bench = Bench::running();
    let start = |first: f32| command(MavCmd::MAV_CMD_MISSION_START, &[first, 0.0]);
    let sent = bench.send(Link::Api, &start(0.0));
    assert_eq!(ack_of(&sent).result, 2);
    assert_eq!(texts(&sent, Link::Api), ["Mission start denied! No valid mission"]);
    let places = [[0.0, 0.0, 20.0], [30.0, 0.0, 20.0]];
    let plan = [0, 1].map(|seq| {
        item(seq, MavCmd::MAV_CMD_NAV_WAYPOINT, places[usize::from(seq)], [0.0, 0.0, 0.0, f32::NAN])
    });
    upload(&mut bench, &plan);
    for nonsense in [2.0, -2.0, 0.5, f32::NAN] {
        assert_eq!(ack_of(&bench.send(Link::Api, &start(nonsense))).result, 2, "{nonsense}");
    }
    assert_eq!(ack_of(&bench.send(Link::Api, &start(1.0))).result, 0);
    assert!(bench.session.autopilot().is_armed());
    assert_eq!(
        (bench.session.autopilot().mode(), current(&bench.run(0.1), STATION).seq),
        (FlightMode::AutoMission, 1)
    );
    for (param, mode) in [(0.0, FlightMode::AutoLoiter), (1.0, FlightMode::AutoMission)] {
        let sent = bench.send(Link::Api, &command(MavCmd::MAV_CMD_DO_PAUSE_CONTINUE, &[param]));
        assert_eq!((ack_of(&sent).result, bench.session.autopilot().mode()), (0, mode));
    }
    let sent = bench.send(Link::Api, &command(MavCmd::MAV_CMD_DO_PAUSE_CONTINUE, &[2.0]));
    assert_eq!(ack_of(&sent).result, 2);
}

/// What is not flown is refused where it shows: by MISSION_ACK at the upload what PX4's protocol does not
/// take, by STATUSTEXT what its check does not.
#[test]
fn reference_what_is_not_flown_is_refused() {
    let mut bench = Bench::running();
    let turns = item(0, MavCmd::MAV_CMD_NAV_LOITER_TURNS, [10.0, 0.0, 20.0], [2.0, 0.0, 5.0, 0.0]);
    let (ack, sent) = upload(&mut bench, &[turns]);
    assert_eq!(ack.mavtype, MavMissionResult::MAV_MISSION_UNSUPPORTED);
    assert_eq!(texts(&sent, STATION), ["mission refused: item 0 (command 18)"]);
    let (ack, sent) = upload(&mut bench, &[order(0, MavCmd::MAV_CMD_CONDITION_DELAY, [1.0; 4])]);
    assert_eq!(ack.mavtype, MavMissionResult::MAV_MISSION_ACCEPTED);
    assert_eq!(texts(&sent, STATION).concat(), "Mission rejected: item 1: unsupported cmd: 112");
    set_mode(&mut bench, MISSION_MODE);
    assert_eq!(bench.session.autopilot().mode(), FlightMode::AutoLoiter);
}

/// DO_GRIPPER as an item goes to the parachute (component 161) by the simulator's link, and its
/// acknowledgement lets the mission go on; that of something else does not.
#[test]
fn reference_a_release_is_passed_on_to_the_parachute() {
    let mut bench = Bench::running();
    let plan = [
        order(0, MavCmd::MAV_CMD_DO_GRIPPER, [1.0, 0.0, 0.0, 0.0]),
        order(1, MavCmd::MAV_CMD_NAV_DELAY, [60.0, 0.0, 0.0, 0.0]),
    ];
    upload(&mut bench, &plan);
    assert_eq!(ack_of(&bench.send(Link::Api, &command(MavCmd::MAV_CMD_MISSION_START, &[0.0]))).result, 0);
    let sent = bench.run(0.5);
    let passed =
        |(link, frame): &Sent| frame.command().filter(|c| *link == Link::Simulator && c.command == 211);
    let passed: Vec<_> = sent.iter().filter_map(passed).collect();
    assert_eq!(passed.len(), 1);
    let release = passed[0];
    assert_eq!((release.target_system, release.target_component, release.params[1]), (VEHICLE, 161, 0.0));
    for (number, seq) in [(420, 0), (211, 1)] {
        let (target_system, target_component) = (VEHICLE, 1);
        let answer = CommandAck { command: number, target_system, target_component, ..Default::default() };
        let bytes = bench.encoder(Link::Simulator).encode_command_ack(&answer);
        bench.send_bytes(Link::Simulator, &bytes);
        bench.run(0.1);
        assert_eq!(bench.session.autopilot().mission().current(), seq);
    }
    assert!(bench.session.autopilot().is_armed() && !bench.session.autopilot().is_flying());
}

/// A mission under the canopy: it lets go, waits until the rotors are free, and flies to a place, at which
/// the lander comes to rest.
#[test]
fn closed_form_a_mission_releases_the_drop_and_flies_on() {
    let (mut sim, mut bench) = (under_the_canopy(), Bench::running());
    bench.run(0.1);
    let plan = [
        order(0, MavCmd::MAV_CMD_DO_GRIPPER, [1.0, 0.0, 0.0, 0.0]),
        order(1, MavCmd::MAV_CMD_NAV_DELAY, [0.5, 0.0, 0.0, 0.0]),
        item(2, MavCmd::MAV_CMD_NAV_WAYPOINT, [10.0, 5.0, -40.0], [0.0, 0.0, 0.0, f32::NAN]),
    ];
    upload(&mut bench, &plan);
    let mut released = None;
    for step in 0..(100.0 * 250.0) as u64 {
        observe(&mut bench, &sim);
        if step == 500 {
            let start = command(MavCmd::MAV_CMD_MISSION_START, &[0.0]);
            assert_eq!(ack_of(&bench.send(STATION, &start)).result, 0);
        }
        let sent = bench.step();
        let asked = sent.iter().any(|(link, frame)| {
            *link == Link::Simulator
                && frame.command().is_some_and(|c| (c.command, c.target_component) == (211, 161))
        });
        if asked {
            assert!(released.replace(step).is_none(), "once");
            sim.release();
            let (target_system, target_component) = (VEHICLE, 1);
            let ack = CommandAck { command: 211, target_system, target_component, ..Default::default() };
            let bytes = bench.encoder(Link::Simulator).encode_command_ack(&ack);
            bench.send_bytes(Link::Simulator, &bytes);
        }
        let controls = actuators(&sent).controls;
        let throttle = std::array::from_fn(|i| f64::from(controls[i]));
        if released.is_none_or(|at| step <= at + 125) {
            assert_eq!(throttle, [0.0; 8], "nothing turns before the place, at {step}");
        }
        sim.step(&throttle, 0.004);
    }
    assert!(released.is_some_and(|at| at >= 500));
    let body = &sim.state().body;
    assert!(body.v_ned.norm() < 0.05, "{}", body.v_ned);
    assert!((body.p_ned.xy() - nalgebra::Vector2::new(10.0, 5.0)).norm() < 0.5, "{}", body.p_ned);
    assert_eq!(bench.session.autopilot().mode(), FlightMode::AutoLoiter, "at its end");
}

/// DO_CHANGE_SPEED: a ground speed is taken, an airspeed a multirotor has not.
#[test]
fn reference_speeds_are_ground_speeds() {
    let mut bench = Bench::running();
    for (kind, result) in [(1.0, 0), (f32::NAN, 0), (0.0, 3), (2.0, 3), (3.0, 3)] {
        let sent = bench.send(Link::Api, &command(MavCmd::MAV_CMD_DO_CHANGE_SPEED, &[kind, 4.0, -1.0]));
        assert_eq!(ack_of(&sent).result, result, "{kind}");
    }
}
