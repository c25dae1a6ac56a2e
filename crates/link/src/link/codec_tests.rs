//! Decoder and encoder against each other, against pymavlink's bytes, and against damage.

use super::decoder::Decoder;
use super::encoder::Encoder;
use super::faults::Faults;
use super::frame::{CommandAck, Frame};
use mavlink::dialects::common::*;
use mavlink::{MAV_STX, MAV_STX_V2, MavlinkVersion, Message as _, calculate_crc};
use proptest::prelude::*;

fn heartbeat() -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA {
        custom_mode: 6 << 16,
        mavtype: MavType::MAV_TYPE_QUADROTOR,
        autopilot: MavAutopilot::MAV_AUTOPILOT_PX4,
        base_mode: MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    })
}

fn stream(bytes: &[u8]) -> (Vec<Frame>, Decoder) {
    let mut decoder = Decoder::new();
    decoder.push(bytes);
    let mut frames = Vec::new();
    while let Some(frame) = decoder.next_frame() {
        frames.push(frame);
    }
    (frames, decoder)
}

/// The frame that pymavlink 2.4.50 packs for this heartbeat from 1/1, sequence 7.
const PYMAVLINK_HEARTBEAT: &[u8] = &[
    0xFD, 0x09, 0x00, 0x00, 0x07, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x06, 0x00, 0x02, 0x0C, 0x01,
    0x04, 0x03, 0xFF, 0x0E,
];

#[test]
fn reference_heartbeat_is_pymavlinks() {
    let mut encoder = Encoder::new(1, 1);
    (0..7).for_each(|_| drop(encoder.encode(&heartbeat())));
    assert_eq!(encoder.encode(&heartbeat()), PYMAVLINK_HEARTBEAT);
}

#[test]
fn sequence_numbers_have_no_gaps_and_wrap() {
    let mut encoder = Encoder::new(3, 4);
    let mut decoder = Decoder::new();
    for n in 0..600u32 {
        decoder.push(&encoder.encode(&heartbeat()));
        let frame = decoder.next_frame().unwrap();
        assert_eq!((u32::from(frame.sequence), frame.system_id, frame.component_id), (n % 256, 3, 4));
    }
    assert_eq!(decoder.faults(), &Faults { frames: 600, ..Faults::default() });
}

#[test]
fn every_message_of_the_dialect_survives_the_round_trip() {
    let mut encoder = Encoder::new(1, 1);
    let mut seen = 0;
    for id in 0..13_000 {
        let Some(message) = MavMessage::default_message_from_id(id) else { continue };
        let (frames, _) = stream(&encoder.encode(&message));
        assert_eq!((frames.len(), frames[0].message_id), (1, id));
        assert_eq!(frames[0].known(), Some(&message), "{id}");
        seen += 1;
    }
    assert!(seen > 200, "{seen}");
}

#[test]
fn an_unknown_command_is_unparsed_and_readable() {
    let mut payload = [0; 33];
    payload[4..8].copy_from_slice(&2.5f32.to_le_bytes());
    payload[8..12].copy_from_slice(&f32::NAN.to_le_bytes());
    payload[28..30].copy_from_slice(&65_000u16.to_le_bytes());
    (payload[30], payload[31], payload[32]) = (1, 161, 2);
    let bytes = Encoder::new(255, 190).encode_payload(76, MavMessage::extra_crc(76), &payload);
    let (frames, decoder) = stream(&bytes);
    assert_eq!(frames[0].message, None);
    assert_eq!(decoder.faults().unparsed, 1);
    assert_eq!(frames[0].target(), (1, 161));
    let command = frames[0].command().unwrap();
    assert_eq!((command.command, command.confirmation), (65_000, 2));
    assert_eq!([command.param(1), command.param(2), command.param(3)], [Some(0.0), Some(2.5), None]);
    assert_eq!((command.param(0), command.param(8)), (None, None));
}

#[test]
fn an_ack_for_an_unknown_command_can_be_sent_and_read() {
    let ack = CommandAck {
        command: 65_000,
        result: 3,
        target_system: 255,
        target_component: 190,
        ..CommandAck::default()
    };
    let (frames, _) = stream(&Encoder::new(1, 1).encode_command_ack(&ack));
    assert_eq!(frames[0].command_ack(), Some(ack));
    assert_eq!(frames[0].target(), (255, 190));
}

#[test]
fn set_mode_with_the_bare_custom_bit_is_read() {
    let payload = [0, 0, 6, 0, 1, 1];
    let (frames, _) = stream(&Encoder::new(255, 190).encode_payload(11, MavMessage::extra_crc(11), &payload));
    let set_mode = frames[0].set_mode().unwrap();
    assert_eq!((set_mode.target_system, set_mode.base_mode, set_mode.custom_mode), (1, 1, 6 << 16));
}

#[test]
fn mavlink_1_is_understood() {
    let mut payload = [0; 255];
    let len = heartbeat().ser(MavlinkVersion::V1, &mut payload);
    let mut bytes = vec![MAV_STX, len as u8, 9, 2, 3, 0];
    bytes.extend_from_slice(&payload[..len]);
    let crc = calculate_crc(&bytes[1..], MavMessage::extra_crc(0));
    bytes.extend_from_slice(&crc.to_le_bytes());
    let (frames, _) = stream(&bytes);
    assert_eq!((frames[0].sequence, frames[0].system_id, frames[0].component_id), (9, 2, 3));
    assert_eq!(frames[0].known(), Some(&heartbeat()));
    assert_eq!(frames[0].bytes(), bytes);
}

#[test]
fn signed_frames_count_and_pass_and_other_incompatible_ones_are_dropped() {
    let good = Encoder::new(1, 1).encode(&heartbeat());
    let with_flags = |flags: u8| {
        let mut bytes = good[..good.len() - 2].to_vec();
        bytes[2] = flags;
        let crc = calculate_crc(&bytes[1..], MavMessage::extra_crc(0));
        bytes.extend_from_slice(&crc.to_le_bytes());
        bytes
    };
    let mut bytes = with_flags(1);
    bytes.extend_from_slice(&[0xFD; 13]);
    bytes.extend(with_flags(4));
    bytes.extend_from_slice(&good);
    let (frames, decoder) = stream(&bytes);
    assert_eq!(frames.len(), 2);
    assert_eq!((decoder.faults().signed, decoder.faults().incompatible), (1, 1));
}

#[test]
fn an_unknown_message_is_counted_and_the_next_one_found() {
    let mut encoder = Encoder::new(1, 1);
    let mut bytes = encoder.encode_payload(0x00AB_CDEF, 77, &[0xFD; 30]);
    bytes.extend(encoder.encode(&heartbeat()));
    let (frames, decoder) = stream(&bytes);
    assert_eq!((frames.len(), decoder.faults().unknown_id), (1, 1));
    assert_eq!((decoder.faults().unknown_bytes, decoder.faults().skipped_bytes), (42, 0), "a whole frame");
}

#[test]
fn a_stray_marker_holds_a_stream_back_only_until_it_is_given_up() {
    let mut bytes = vec![MAV_STX_V2, 255, 0];
    bytes.extend(Encoder::new(1, 1).encode(&heartbeat()));
    let (frames, mut decoder) = stream(&bytes);
    assert!(frames.is_empty() && decoder.pending() > 0);
    decoder.give_up();
    assert_eq!(decoder.next_frame().unwrap().known(), Some(&heartbeat()));
    assert_eq!((decoder.faults().truncated, decoder.pending()), (1, 0));
}

#[test]
fn a_cut_datagram_is_truncated_and_does_not_spoil_the_next() {
    let good = Encoder::new(1, 1).encode(&heartbeat());
    let mut decoder = Decoder::new();
    let mut frames = 0;
    decoder.datagram(&good[..good.len() - 1], |_| frames += 1);
    assert_eq!((frames, decoder.faults().truncated), (0, 1));
    decoder.datagram(&[&good[..], &good[..]].concat(), |_| frames += 1);
    assert_eq!(frames, 2);
}

proptest! {
    /// Whatever arrives and however it is cut, nothing panics, and every byte is accounted for.
    #[test]
    fn prop_garbage_is_survived(mut bytes in proptest::collection::vec(any::<u8>(), 0..900),
                                markers in proptest::collection::vec(0usize..900, 0..12), cut in 1usize..90) {
        for at in markers {
            if let Some(b) = bytes.get_mut(at) { *b = if at % 2 == 0 { MAV_STX } else { MAV_STX_V2 } }
        }
        let mut decoder = Decoder::new();
        let mut framed = 0;
        for chunk in bytes.chunks(cut) {
            decoder.push(chunk);
            while let Some(frame) = decoder.next_frame() { framed += frame.bytes().len() }
        }
        let faults = decoder.faults();
        let passed_over = (faults.skipped_bytes + faults.unknown_bytes) as usize;
        prop_assert_eq!(framed + passed_over + decoder.pending(), bytes.len());
        Decoder::new().datagram(&bytes, |_| ());
    }

    /// A damaged stretch costs at most the frames that it touches: those behind it come through.
    #[test]
    fn prop_damage_is_local(at in 0usize..210, with in any::<u8>(), n in 1usize..4) {
        let mut encoder = Encoder::new(1, 1);
        let frames: Vec<Vec<u8>> = (0..20).map(|_| encoder.encode(&heartbeat())).collect();
        let len = frames[0].len();
        let mut bytes = frames.concat();
        for b in &mut bytes[at..at + n] { *b = with }
        bytes.extend_from_slice(&[0; 300]);
        let mut sequences = Vec::new();
        let mut decoder = Decoder::new();
        decoder.push(&bytes);
        while let Some(frame) = decoder.next_frame() { sequences.push(usize::from(frame.sequence)) }
        for untouched in (0..20).filter(|i| (i + 1) * len <= at || i * len >= at + n) {
            prop_assert!(sequences.contains(&untouched), "{} lost of {:?}", untouched, sequences);
        }
    }

    /// Floats, NaN among them, come through bit by bit; trailing zeros are trimmed and restored.
    #[test]
    fn prop_setpoints_survive(
        vx in any::<u32>(), vy in any::<u32>(), yaw in any::<u32>(), t in any::<u32>(),
    ) {
        let message = MavMessage::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
            time_boot_ms: t, vx: f32::from_bits(vx), vy: f32::from_bits(vy), yaw: f32::from_bits(yaw),
            ..Default::default()
        });
        let (frames, _) = stream(&Encoder::new(1, 1).encode(&message));
        let Some(MavMessage::SET_POSITION_TARGET_LOCAL_NED(got)) = frames[0].known() else { panic!() };
        let bits = (got.vx.to_bits(), got.vy.to_bits(), got.yaw.to_bits(), got.time_boot_ms);
        prop_assert_eq!(bits, (vx, vy, yaw, t));
    }
}

/// Somebody who is not listened to in time: the oldest bytes go, and are counted.
#[test]
fn a_stream_that_nobody_reads_is_bounded() {
    let mut decoder = Decoder::new();
    for _ in 0..1_000 {
        decoder.push(&[0xFD; 4096]);
        assert!(decoder.pending() <= 65_536);
    }
    assert_eq!(decoder.faults().skipped_bytes as usize + decoder.pending(), 1_000 * 4096);
}
