//! What strangers send, in whoever's name, and what a mad simulator or autopilot sends: sound frames, without
//! a signature but for one.

use mavlink::dialects::common::*;
use samara::link::{Encoder, Hub, HubConfig, Link, Transmit};
use samara::random::Stream;

use super::process::key;

const VEHICLE: (u8, u8) = (1, 1);
const PARACHUTE: (u8, u8) = (1, 161);

/// A frame in the name of a system and component.
pub fn frame(from: (u8, u8), message: &MavMessage) -> Vec<u8> {
    Encoder::new(from.0, from.1).encode(message)
}

/// A HEARTBEAT of the autopilot, armed in OFFBOARD or at rest.
pub fn vehicle_heartbeat(armed: bool) -> Vec<u8> {
    let mut base_mode = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
    base_mode.set(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED, armed);
    // PX4's main modes: 6 OFFBOARD, 4 with submode 3 HOLD.
    let custom_mode = if armed { 6 << 16 } else { 3 << 24 | 4 << 16 };
    let mavtype = MavType::MAV_TYPE_QUADROTOR;
    let beat = HEARTBEAT_DATA { custom_mode, mavtype, base_mode, mavlink_version: 3, ..Default::default() };
    frame(VEHICLE, &MavMessage::HEARTBEAT(beat))
}

/// The vehicle's clock.
pub fn attitude(time_boot_ms: u32) -> Vec<u8> {
    frame(VEHICLE, &MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms, ..Default::default() }))
}

/// A HEARTBEAT of the parachute.
pub fn parachute_heartbeat() -> Vec<u8> {
    let mavtype = MavType::MAV_TYPE_PARACHUTE;
    frame(PARACHUTE, &MavMessage::HEARTBEAT(HEARTBEAT_DATA { mavtype, ..Default::default() }))
}

/// A number of the parachute's: `t_release`, `t_end` or `mute`.
pub fn parachute_value(name: &str, value: i32) -> Vec<u8> {
    let named = NAMED_VALUE_INT_DATA { time_boot_ms: 1, value, name: name.into() };
    frame(PARACHUTE, &MavMessage::NAMED_VALUE_INT(named))
}

/// A COMMAND_ACK "accepted" to the streamer.
pub fn ack(from: (u8, u8), command: MavCmd) -> Vec<u8> {
    let (target_system, target_component) = (245, 190);
    let ack = COMMAND_ACK_DATA { command, target_system, target_component, ..Default::default() };
    frame(from, &MavMessage::COMMAND_ACK(ack))
}

/// A command of a ground station of this system.
pub fn command(system: u8, command: MavCmd, to: (u8, u8), params: [f32; 3]) -> Vec<u8> {
    let [param1, param2, param3] = params;
    let (target_system, target_component) = to;
    frame(
        (system, 190),
        &MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
            command,
            target_system,
            target_component,
            param1,
            param2,
            param3,
            ..Default::default()
        }),
    )
}

/// A HEARTBEAT of a ground station.
pub fn station_heartbeat(system: u8) -> Vec<u8> {
    let mavtype = MavType::MAV_TYPE_GCS;
    frame((system, 190), &MavMessage::HEARTBEAT(HEARTBEAT_DATA { mavtype, ..Default::default() }))
}

/// Something to the streamer that would mislead it, in the vehicle's name.
pub fn misleading(dice: &mut Stream) -> Vec<u8> {
    let ms = dice.below(12_000) as i32;
    match dice.below(12) {
        0 => attitude(4_000_000_000),
        1 => attitude(0),
        2 => attitude(ms as u32),
        3 => parachute_value("t_end", ms),
        4 => parachute_value("t_release", ms),
        5 => parachute_value("mute", 1),
        6 => vehicle_heartbeat(false),
        7 => vehicle_heartbeat(true),
        8 => ack(PARACHUTE, MavCmd::MAV_CMD_DO_GRIPPER),
        9 => ack(VEHICLE, MavCmd::MAV_CMD_COMPONENT_ARM_DISARM),
        10 => ack(VEHICLE, MavCmd::MAV_CMD_DO_SET_MODE),
        _ => parachute_heartbeat(),
    }
}

/// A command to the vehicle that no drop wants, and where it is sent: the port of the autopilot or that of
/// the parachute.
pub fn meddling(dice: &mut Stream) -> (bool, Vec<u8>) {
    const ARM: MavCmd = MavCmd::MAV_CMD_COMPONENT_ARM_DISARM;
    match dice.below(5) {
        0 | 1 => (true, command(66, MavCmd::MAV_CMD_DO_GRIPPER, PARACHUTE, [0.0; 3])),
        2 => (false, command(66, ARM, VEHICLE, [0.0, 21_196.0, 0.0])),
        3 => (false, command(66, ARM, VEHICLE, [1.0, 21_196.0, 0.0])),
        _ => (false, command(66, MavCmd::MAV_CMD_DO_SET_MODE, VEHICLE, [1.0, 4.0, 3.0])),
    }
}

/// Opens an upload of three mission items and then holds it, with items that were not asked for.
pub fn mission_holding(system: u8, opens: bool) -> Vec<u8> {
    let (target_system, target_component) = VEHICLE;
    let message = if opens {
        MavMessage::MISSION_COUNT(MISSION_COUNT_DATA {
            count: 3,
            target_system,
            target_component,
            ..Default::default()
        })
    } else {
        let seq = 7;
        MavMessage::MISSION_ITEM_INT(MISSION_ITEM_INT_DATA {
            seq,
            target_system,
            target_component,
            ..Default::default()
        })
    };
    frame((system, 190), &message)
}

/// MISSION_CLEAR_ALL.
pub fn mission_clear(system: u8) -> Vec<u8> {
    let (target_system, target_component) = VEHICLE;
    let clear = MISSION_CLEAR_ALL_DATA { target_system, target_component, ..Default::default() };
    frame((system, 190), &MavMessage::MISSION_CLEAR_ALL(clear))
}

/// MAVLink FTP: opens the parameters' metadata.
pub fn file_open(system: u8, sequence: u16) -> Vec<u8> {
    let path = b"/etc/extras/parameters.json";
    let mut payload = [0; 251];
    payload[..2].copy_from_slice(&sequence.to_le_bytes());
    (payload[3], payload[4]) = (MavFtpOpcode::MAV_FTP_OPCODE_OPENFILERO as u8, path.len() as u8);
    payload[12..12 + path.len()].copy_from_slice(path);
    let (target_system, target_component) = VEHICLE;
    let open = FILE_TRANSFER_PROTOCOL_DATA { target_network: 0, target_system, target_component, payload };
    frame((system, 190), &MavMessage::FILE_TRANSFER_PROTOCOL(open))
}

/// What a radio on the way reports, which has no key.
pub fn radio_status() -> Vec<u8> {
    frame(
        (51, 68),
        &MavMessage::RADIO_STATUS(RADIO_STATUS_DATA { rssi: 1, remrssi: 1, ..Default::default() }),
    )
}

/// A HEARTBEAT of somebody who has the key and a clock that shows the last moment that stamps can.
pub fn far_stamp(unix_us: u64) -> Vec<u8> {
    // 48 bits of 10 us, since 2015.
    stamped(unix_us, 1_420_070_400_000_000 + ((1 << 48) - 2) * 10)
}

/// A HEARTBEAT of somebody who has the key, and whose clock shows `stamp_us`.
pub fn stamped(unix_us: u64, stamp_us: u64) -> Vec<u8> {
    let config = HubConfig { own: (254, 190), memory_us: u64::MAX, forwards: false, key: Some(key()) };
    let (mut hub, mut signed) = (Hub::new(config), Vec::new());
    let endpoint = hub.add_endpoint(Link::GroundStation);
    hub.keep(unix_us, endpoint, ());
    let beat = Transmit::to_all(Link::GroundStation, station_heartbeat(254));
    hub.send(stamp_us, &beat, |_, (), bytes| signed = bytes.to_vec());
    signed
}

/// Pieces of a text that does not end, in the vehicle's name, and would act on a terminal.
pub fn endless_text(pieces: usize) -> Vec<u8> {
    let mut vehicle = Encoder::new(VEHICLE.0, VEHICLE.1);
    let piece = |i: usize| {
        let (id, chunk_seq) = (7, (i % 200) as u8);
        let text = "\u{1b}[2J\u{1b}[1;1Hreleased\r\n\u{9b}31m and all is well, and so on ".into();
        vehicle.encode(&MavMessage::STATUSTEXT(STATUSTEXT_DATA { id, chunk_seq, text, ..Default::default() }))
    };
    (0..pieces).flat_map(piece).collect()
}

/// Nobody's bytes, with the starts of frames among them.
pub fn junk(dice: &mut Stream) -> Vec<u8> {
    (0..1 + dice.below(300)).map(|_| [0xFD, 0xFE, dice.below(256) as u8][dice.below(3)]).collect()
}

/// SET_MESSAGE_INTERVAL of a stranger: ATTITUDE every microsecond.
pub fn every_microsecond() -> Vec<u8> {
    command(66, MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, VEHICLE, [30.0, 1.0, 0.0])
}

/// An autopilot's commands on the simulator's link, with no motor running.
pub fn actuators(time_usec: u64, mode: MavModeFlag) -> Vec<u8> {
    let controls = HIL_ACTUATOR_CONTROLS_DATA { time_usec, mode, ..Default::default() };
    frame(VEHICLE, &MavMessage::HIL_ACTUATOR_CONTROLS(controls))
}

/// What a simulator sends whose time jumps to and fro: so many steps.
pub fn rewinding(dice: &mut Stream, steps: usize) -> Vec<u8> {
    let mut mad = Encoder::new(1, 200);
    let mut bytes = Vec::new();
    for n in 0..steps as u64 {
        let time_usec = [n * 4_000, 0, 1 << 63, u64::MAX][dice.below(4)];
        let attitude_quaternion = [1.0, 0.0, 0.0, 0.0];
        let state = HIL_STATE_QUATERNION_DATA { time_usec, attitude_quaternion, ..Default::default() };
        let fields_updated = HilSensorUpdatedFlags::from_bits_retain(0x1FFF);
        let sensor = HIL_SENSOR_DATA { time_usec, zacc: -9.8, fields_updated, ..Default::default() };
        bytes.extend(mad.encode(&MavMessage::HIL_STATE_QUATERNION(state)));
        bytes.extend(mad.encode(&MavMessage::HIL_SENSOR(sensor)));
    }
    bytes
}
