//! QGroundControl's connect sequence, replayed: every question answered, nothing to complain about; and what
//! its buttons and its virtual joystick send, with the lines of its source (mavlink/qgroundcontrol, 2025)
//! that send it.

use mavlink::Message as _;
use mavlink::dialects::common::*;
use samara::autopilot::FlightMode;
use samara::link::{CommandAck, Link};

use super::bench::{Bench, GROUND, Sent, VEHICLE, acks, actuators, command, last, texts, velocity};
use super::parameters::{all_parameters, read, values};

/// What QGroundControl looks for before it calls a vehicle set up; `true`: it must not be zero.
const LOOKED_FOR: [(&str, bool); 34] = [
    ("SYS_AUTOSTART", true),
    ("SYS_AUTOCONFIG", false),
    ("MAV_SYS_ID", true),
    ("CAL_GYRO0_ID", true),
    ("CAL_ACC0_ID", true),
    ("CAL_MAG0_ID", true),
    ("CAL_MAG1_ID", false),
    ("CAL_MAG2_ID", false),
    ("COM_RC_IN_MODE", true),
    ("RC_MAP_ROLL", false),
    ("RC_MAP_PITCH", false),
    ("RC_MAP_YAW", false),
    ("RC_MAP_THROTTLE", false),
    ("RC_MAP_FLAPS", false),
    ("RC_MAP_AUX1", false),
    ("RC_MAP_AUX2", false),
    ("COM_FLTMODE1", false),
    ("COM_FLTMODE2", false),
    ("COM_FLTMODE3", false),
    ("COM_FLTMODE4", false),
    ("COM_FLTMODE5", false),
    ("COM_FLTMODE6", false),
    ("BAT1_SOURCE", false),
    ("RTL_RETURN_ALT", false),
    ("RTL_DESCEND_ALT", false),
    ("RTL_LAND_DELAY", false),
    ("NAV_DLL_ACT", false),
    ("NAV_RCL_ACT", false),
    ("COM_RC_LOSS_T", false),
    ("COM_LOW_BAT_ACT", false),
    ("COM_OF_LOSS_T", true),
    ("MIS_TAKEOFF_ALT", true),
    ("MPC_THR_HOVER", true),
    ("GF_ACTION", false),
];

fn requested(bench: &mut Bench, message_id: u32) -> (u8, Option<MavMessage>) {
    let ask = command(MavCmd::MAV_CMD_REQUEST_MESSAGE, &[message_id as f32, 0.0]);
    let sent = bench.send(Link::GroundStation, &ask);
    assert!(texts(&sent, Link::GroundStation).is_empty());
    let [ack] = acks(&sent)[..] else { panic!("{message_id}: one acknowledgement") };
    (ack.result, last(&sent, Link::GroundStation, message_id))
}

#[test]
fn regress_qgroundcontrol_connects_without_a_complaint() {
    let mut bench = Bench::running();
    let gcs = Link::GroundStation;
    let (result, version) = requested(&mut bench, 148);
    let Some(MavMessage::AUTOPILOT_VERSION(version)) = version else { panic!() };
    assert_eq!(result, 0);
    // Mission and command by integers, bytewise parameters, files, MAVLink 2, fence, rally points.
    let wanted = MavProtocolCapability::from_bits_retain(4 | 8 | 16 | 32 | 0x2000 | 0x4000 | 0x8000);
    assert!(version.capabilities.contains(wanted));
    assert!(matches!(requested(&mut bench, 435), (0, Some(_))));
    assert!(matches!(requested(&mut bench, 397), (0, Some(_))));
    assert_eq!(requested(&mut bench, 395), (2, None), "the old twin of 397: denied, not silent");

    let hash = values(&bench.send(gcs, &read("_HASH_CHECK", -1)), gcs)[0].param_value.to_bits();
    let listed = all_parameters(&mut bench, gcs);
    assert_eq!(listed[0].param_value.to_bits(), hash);
    for (name, not_zero) in LOOKED_FOR {
        let found = listed.iter().find(|v| v.param_id.to_str() == Ok(name));
        let found = found.unwrap_or_else(|| panic!("{name} is missing"));
        assert!(!not_zero || found.param_value.to_bits() != 0, "{name}");
    }

    for (kind, mission_type) in [
        MavMissionType::MAV_MISSION_TYPE_MISSION,
        MavMissionType::MAV_MISSION_TYPE_FENCE,
        MavMissionType::MAV_MISSION_TYPE_RALLY,
    ]
    .into_iter()
    .enumerate()
    {
        let list = MavMessage::MISSION_REQUEST_LIST(MISSION_REQUEST_LIST_DATA {
            target_system: VEHICLE,
            target_component: 1,
            mission_type,
        });
        let sent = bench.send(gcs, &list);
        let Some(MavMessage::MISSION_COUNT(count)) = last(&sent, gcs, 44) else { panic!("{kind}") };
        assert_eq!((count.count, count.mission_type, count.target_system), (0, mission_type, 255));
        let done = MavMessage::MISSION_ACK(MISSION_ACK_DATA {
            target_system: VEHICLE,
            target_component: 1,
            mission_type,
            ..Default::default()
        });
        assert!(bench.send(gcs, &done).is_empty());
    }
    assert_eq!(requested(&mut bench, 280), (2, None), "no gimbal manager: denied, not silent");
    assert!(texts(&bench.run(2.0), gcs).is_empty());
}

const GCS: Link = Link::GroundStation;

/// MANUAL_CONTROL as `Vehicle::sendJoystickDataThreadSafe` packs it (src/Vehicle/Vehicle.cc): "Incoming
/// values are in the range -1:1", `pitch * axesScaling`, `roll * axesScaling`, `thrust * axesScaling`, `yaw *
/// axesScaling` with `axesScaling = 1.0 * 1000.0`, and `_systemID` for the target; the thrust of a multirotor
/// is 0..1.
fn joystick(roll: f32, pitch: f32, yaw: f32, thrust: f32) -> MANUAL_CONTROL_DATA {
    let [x, y, z, r] = [pitch, roll, thrust, yaw].map(|axis| (axis * 1000.0) as i16);
    MANUAL_CONTROL_DATA { x, y, z, r, target: VEHICLE, ..Default::default() }
}

/// The virtual joystick's 25 Hz (src/FlightMap/Widgets/VirtualJoystick.qml: `interval: 40 // 25Hz`).
fn hold(bench: &mut Bench, sticks: &MANUAL_CONTROL_DATA, seconds: f64) -> Vec<Sent> {
    (0..(seconds / 0.04).round() as usize)
        .flat_map(|_| {
            let mut sent = bench.send(GCS, &MavMessage::MANUAL_CONTROL(sticks.clone()));
            sent.extend(bench.run(0.04));
            sent
        })
        .collect()
}

/// `Vehicle::setFlightMode` (src/Vehicle/Vehicle.cc): SET_MODE with the base mode's bits and the custom mode
/// of `PX4FirmwarePlugin::setFlightMode`.
fn set_flight_mode(bench: &mut Bench, mode: FlightMode) -> Vec<Sent> {
    let mut payload = [0; 6];
    payload[..4].copy_from_slice(&mode.custom_mode().to_le_bytes());
    (payload[4], payload[5]) = (VEHICLE, 1);
    let bytes = bench.encoder(GCS).encode_payload(11, MavMessage::extra_crc(11), &payload);
    bench.send_bytes(GCS, &bytes)
}

fn custom_mode(sent: &[Sent]) -> u32 {
    match last(sent, GCS, 0) {
        Some(MavMessage::HEARTBEAT(m)) => m.custom_mode,
        other => panic!("no HEARTBEAT but {other:?}"),
    }
}

#[test]
fn reference_the_virtual_joystick_flies_the_manual_modes() {
    let mut bench = Bench::running();
    let centred = joystick(0.0, 0.0, 0.0, 0.5);
    let others = MANUAL_CONTROL_DATA { target: VEHICLE + 1, ..centred.clone() };
    assert_eq!(custom_mode(&hold(&mut bench, &others, 1.2)), 0x0304_0000, "another vehicle's");
    assert_eq!(custom_mode(&hold(&mut bench, &centred, 1.2)), 3 << 16, "Position, as PX4 does at first");
    for (mode, custom) in [
        (FlightMode::Altctl, 2 << 16),
        (FlightMode::Stabilized, 7 << 16),
        (FlightMode::Manual, 1 << 16),
        (FlightMode::Posctl, 3 << 16),
    ] {
        assert!(acks(&set_flight_mode(&mut bench, mode)).is_empty(), "SET_MODE is not acknowledged");
        let sent = hold(&mut bench, &centred, 2.2);
        assert_eq!(custom_mode(&sent), custom);
        let Some(MavMessage::CURRENT_MODE(m)) = last(&sent, GCS, 436) else { panic!("no CURRENT_MODE") };
        assert_eq!((m.custom_mode, m.intended_custom_mode), (custom, custom));
    }
    let arm = command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]);
    hold(&mut bench, &joystick(0.0, 0.0, 0.0, 0.7), 0.04);
    let sent = bench.send(GCS, &arm);
    assert_eq!(
        (acks(&sent)[0].result, texts(&sent, GCS).concat()),
        (1, "Arming denied: throttle above center".into())
    );
    hold(&mut bench, &centred, 0.04);
    assert_eq!(acks(&bench.send(GCS, &arm))[0].result, 0);
    assert_eq!(
        actuators(&hold(&mut bench, &centred, 1.0)).controls,
        [0.0; 16],
        "until the throttle stick says so"
    );
    let climbing = actuators(&hold(&mut bench, &joystick(0.0, 0.0, 0.0, 1.0), 0.2)).controls;
    assert!(climbing[..4].iter().all(|&throttle| throttle > 0.0));
}

/// The button is there when `PX4FirmwarePlugin::hasGripper` (src/FirmwarePlugin/PX4/PX4FirmwarePlugin.cc)
/// finds PD_GRIPPER_EN `->rawValue().toInt()) != 0`, in newer ones PD_GRIPPER_TYPE not negative. It sends, by
/// `Vehicle::sendGripperAction` (src/Vehicle/Vehicle.cc), MAV_CMD_DO_GRIPPER to `_defaultComponentId` with
/// `0, // Param1: Gripper ID (Always set to 0)` and `gripperAction); // Param2: Gripper Action`.
#[test]
fn reference_the_gripper_button_is_passed_on_to_the_parachute() {
    let mut bench = Bench::running();
    let of = |bench: &mut Bench, name: &str| {
        values(&bench.send(GCS, &read(name, -1)), GCS)[0].param_value.to_bits()
    };
    assert_eq!((of(&mut bench, "PD_GRIPPER_EN"), of(&mut bench, "PD_GRIPPER_TYPE")), (1, 0));
    let action = |action: f32| command(MavCmd::MAV_CMD_DO_GRIPPER, &[0.0, action, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let sent = bench.send(GCS, &action(0.0));
    assert!(acks(&sent).is_empty());
    let passed: Vec<_> = sent.iter().filter(|(link, _)| *link == Link::Simulator).collect();
    let [(_, frame)] = passed[..] else { panic!("{passed:?}") };
    let passed = frame.command().unwrap();
    assert_eq!((passed.command, passed.target_system, passed.target_component), (211, VEHICLE, 161));
    assert_eq!((frame.system_id, frame.component_id, passed.param(2)), (VEHICLE, 1, Some(0.0)));
    // The parachute's answer is the autopilot's: accepted, or for the time being not.
    for result in [0, 1] {
        if result == 1 {
            bench.send(GCS, &action(0.0));
        }
        let ack = CommandAck::new(&passed, result, (VEHICLE, 1));
        let bytes = bench.encoder(Link::Simulator).encode_command_ack(&ack);
        let sent = bench.send_bytes(Link::Simulator, &bytes);
        let answers: Vec<_> = sent.iter().filter(|(_, f)| f.command_ack().is_some()).collect();
        let [(link, frame)] = answers[..] else { panic!("{sent:?}") };
        let ack = frame.command_ack().unwrap();
        assert_eq!((*link, frame.component_id, ack.command, ack.result), (GCS, 1, 211, result));
        assert_eq!((ack.target_system, ack.target_component), GROUND);
    }
    for grab in [1.0, 2.0, f32::NAN] {
        let sent = bench.send(GCS, &action(grab));
        assert_eq!(acks(&sent)[0].result, 2);
        assert_eq!(texts(&sent, GCS), ["gripper refused: it can only release"]);
        assert!(sent.iter().all(|(link, _)| *link != Link::Simulator));
    }
    // A simulator that does not answer within a second.
    bench.send(GCS, &action(0.0));
    let now = bench.now;
    bench.now = now + 2_000_000;
    assert_eq!(acks(&bench.wait())[0].result, 4);
}

/// In the air: `guidedModeChangeGroundSpeedMetersSecond` sends DO_CHANGE_SPEED with `1, // 0: airspeed, 1:
/// groundspeed`, the speed, `-1, // throttle` and `0, // 0: absolute speed`; `guidedModeChangeHeading` sends
/// DO_REPOSITION with `-1.0f, // no change in ground speed`, MAV_DO_REPOSITION_FLAGS_CHANGE_MODE, `0.0f`,
/// `radians, // change heading` and `NAN, NAN, NAN // no change lat, lon, alt` (PX4FirmwarePlugin.cc).
#[test]
fn reference_change_speed_and_change_heading() {
    let mut bench = Bench::engaged();
    bench.send(Link::Api, &MavMessage::SET_POSITION_TARGET_LOCAL_NED(velocity([0.0; 3], 0x0DC7)));
    bench.run(0.1);
    let nan = f32::NAN;
    let speed = command(MavCmd::MAV_CMD_DO_CHANGE_SPEED, &[1.0, 3.0, -1.0, 0.0, nan, nan, nan]);
    let heading = command(MavCmd::MAV_CMD_DO_REPOSITION, &[-1.0, 1.0, 0.0, 1.2, nan, nan, nan]);
    for message in [heading, speed] {
        let sent = bench.send(GCS, &message);
        assert_eq!(acks(&sent)[0].result, 0, "{message:?}");
    }
    bench.run(0.1);
    assert_eq!(bench.session.autopilot().mode(), FlightMode::AutoLoiter);
    let target = bench.session.autopilot().velocity_target().unwrap();
    assert!((target.yaw_rad - 1.2).abs() < 1e-6, "{target:?}");
}

/// QGroundControl offers both for every PX4 multirotor (`PX4FirmwarePlugin::isCapable`: ROIModeCapability,
/// OrbitModeCapability). `Vehicle::guidedModeOrbit` sends a COMMAND_INT with the radius, `qQNaN()), // Use
/// default velocity`, ORBIT_YAW_BEHAVIOUR_UNCHANGED, `qQNaN()), // Use vehicle default num of orbits
/// behavior`, the centre and the altitude.
#[test]
fn reference_orbit_and_region_of_interest_are_refused_once_in_words() {
    let mut bench = Bench::running();
    let to_place = |command, params: [f32; 4]| {
        let [param1, param2, param3, param4] = params;
        MavMessage::COMMAND_INT(COMMAND_INT_DATA {
            param1,
            param2,
            param3,
            param4,
            x: 125_000_000,
            y: -342_500_000,
            z: 1510.0,
            command,
            target_system: VEHICLE,
            target_component: 1,
            frame: MavFrame::MAV_FRAME_GLOBAL,
            current: 0,
            autocontinue: 0,
        })
    };
    let orbit = to_place(MavCmd::MAV_CMD_DO_ORBIT, [20.0, f32::NAN, 5.0, f32::NAN]);
    let region = to_place(MavCmd::MAV_CMD_DO_SET_ROI_LOCATION, [f32::NAN; 4]);
    for (message, words) in [
        (&orbit, "orbits are not flown here"),
        (&region, "there is no region of interest here: the heading stays"),
    ] {
        let sent = bench.send(GCS, message);
        assert_eq!((acks(&sent)[0].result, texts(&sent, GCS).concat()), (3, words.to_owned()));
        let sent = bench.send(GCS, message);
        assert_eq!((acks(&sent)[0].result, texts(&sent, GCS).len()), (3, 0), "said once");
    }
}

/// The log page sends LOG_REQUEST_LIST 0 to 0xFFFF and takes LOG_ENTRY with `num_logs` 0 for an empty list
/// (src/AnalyzeView/LogDownloadController.cc, `_logEntry`); the console sends SERIAL_CONTROL for
/// SERIAL_CONTROL_DEV_SHELL and shows what comes from it (MAVLinkConsoleController.cc); MAVLink's events
/// protocol answers REQUEST_EVENT with RESPONSE_EVENT_ERROR.
#[test]
fn reference_logs_console_and_events_are_refused_in_their_own_way() {
    let mut bench = Bench::running();
    let list = MavMessage::LOG_REQUEST_LIST(LOG_REQUEST_LIST_DATA {
        start: 0,
        end: 0xFFFF,
        target_system: VEHICLE,
        target_component: 1,
    });
    let sent = bench.send(GCS, &list);
    let Some(MavMessage::LOG_ENTRY(entry)) = last(&sent, GCS, 118) else { panic!("{sent:?}") };
    assert_eq!((entry.num_logs, entry.size), (0, 0));
    assert!(texts(&sent, GCS).concat().contains("no logs over MAVLink"));

    let mut typed = SERIAL_CONTROL_DATA {
        device: SerialControlDev::SERIAL_CONTROL_DEV_SHELL,
        flags: SerialControlFlag::from_bits_retain(2 | 4 | 16),
        count: 5,
        target_system: VEHICLE,
        target_component: 1,
        ..Default::default()
    };
    typed.data[..5].copy_from_slice(b"help\n");
    let sent = bench.send(GCS, &MavMessage::SERIAL_CONTROL(typed.clone()));
    let Some(MavMessage::SERIAL_CONTROL(m)) = last(&sent, GCS, 126) else { panic!("{sent:?}") };
    assert_eq!((m.device, m.flags.bits()), (SerialControlDev::SERIAL_CONTROL_DEV_SHELL, 1));
    assert_eq!(&m.data[..usize::from(m.count)], b"there is no console here\r\n");
    assert_eq!(texts(&sent, GCS), ["there is no console here"]);
    // A reply, or a farewell that wants no answer, gets none.
    for flags in [1 | 2, 0] {
        typed.flags = SerialControlFlag::from_bits_retain(flags);
        assert!(bench.send(GCS, &MavMessage::SERIAL_CONTROL(typed.clone())).is_empty());
    }

    let events = MavMessage::REQUEST_EVENT(REQUEST_EVENT_DATA {
        first_sequence: 3,
        last_sequence: 7,
        target_system: VEHICLE,
        target_component: 1,
    });
    let sent = bench.send(GCS, &events);
    let Some(MavMessage::RESPONSE_EVENT_ERROR(m)) = last(&sent, GCS, 413) else { panic!("{sent:?}") };
    assert_eq!((m.sequence, m.target_system, m.target_component), (3, GROUND.0, GROUND.1));
    assert!(texts(&sent, GCS).concat().contains("there are no events here"));
}
