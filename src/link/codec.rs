//! Bytes to frames and messages to bytes.
//!
//! Parsing and serialising the messages is the mavlink crate's; the framing is ours, because a session must resync in a
//! damaged stream, count what it drops by kind, and keep frames whose message does not parse.
//!
//! Signatures are not checked: there is no key, and a library without one accepts signed frames; they are counted.

use mavlink::dialects::common::MavMessage;
use mavlink::error::ParserError;
use mavlink::{MAV_STX, MAV_STX_V2, MavlinkVersion, Message as _, calculate_crc};

use super::frame::{COMMAND_ACK_ID, Frame, MAX_FRAME_LEN, Message};

/// MAVLink 2: a signature of 13 bytes follows the checksum.
const INCOMPATIBLE_SIGNED: u8 = 0x01;
const SIGNATURE_LEN: usize = 13;
const CHECKSUM_LEN: usize = 2;
const HEADER_LEN_V1: usize = 6;
const HEADER_LEN_V2: usize = 10;
/// Most bytes that a stream keeps while it waits for the rest of a frame; any frame is far shorter.
const MAX_BUFFERED: usize = 1 << 16;

/// What a decoder has seen, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Frames whose checksum was right.
    pub frames: u64,
    /// Bytes that belong to no frame.
    pub skipped_bytes: u64,
    /// Candidates with a wrong checksum.
    pub bad_crc: u64,
    /// Frames that a datagram (or a stream given up) ended inside of.
    pub truncated: u64,
    /// Frames of a message that the dialect does not have; their checksum cannot be checked.
    pub unknown_id: u64,
    /// Frames with MAVLink 2 incompatibility flags other than "signed"; a receiver must drop them.
    pub incompatible: u64,
    /// Sound frames with a value that the parser refuses, given out as [`Message::Unparsed`].
    pub unparsed: u64,
    /// Sound frames that were signed; the signature was not checked.
    pub signed: u64,
}

impl Faults {
    /// Everything that was dropped: candidates and stray bytes that gave no frame.
    pub fn dropped(&self) -> u64 {
        self.bad_crc + self.truncated + self.unknown_id + self.incompatible
    }
}

/// A frame's header and where its parts lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Header {
    pub system_id: u8,
    pub component_id: u8,
    pub sequence: u8,
    pub message_id: u32,
    pub payload_at: usize,
    pub payload_len: usize,
    version: MavlinkVersion,
    signed: bool,
    incompatible: bool,
}

impl Header {
    /// Reads a header at the start of `bytes`; `None` when there are too few.
    fn read(bytes: &[u8]) -> Option<Self> {
        match *bytes {
            [MAV_STX, len, sequence, system_id, component_id, id, ..] => Some(Self {
                system_id,
                component_id,
                sequence,
                message_id: u32::from(id),
                payload_at: HEADER_LEN_V1,
                payload_len: usize::from(len),
                version: MavlinkVersion::V1,
                signed: false,
                incompatible: false,
            }),
            [MAV_STX_V2, len, incompatible, _, sequence, system_id, component_id, a, b, c, ..] => {
                Some(Self {
                    system_id,
                    component_id,
                    sequence,
                    message_id: u32::from_le_bytes([a, b, c, 0]),
                    payload_at: HEADER_LEN_V2,
                    payload_len: usize::from(len),
                    version: MavlinkVersion::V2,
                    signed: incompatible & INCOMPATIBLE_SIGNED != 0,
                    incompatible: incompatible & !INCOMPATIBLE_SIGNED != 0,
                })
            }
            _ => None,
        }
    }

    fn checksum_at(&self) -> usize {
        self.payload_at + self.payload_len
    }

    fn frame_len(&self) -> usize {
        self.checksum_at() + CHECKSUM_LEN + if self.signed { SIGNATURE_LEN } else { 0 }
    }
}

/// What stands at the start of some bytes.
#[expect(clippy::large_enum_variant, reason = "lives for one call; boxing it would allocate per frame")]
enum Found {
    /// A frame of this length.
    Frame(Frame, usize),
    /// Nothing usable: skip so many bytes.
    Skip(usize),
    /// The beginning of a frame; the rest is missing.
    Incomplete,
}

/// Finds frames in bytes: in a stream (by [`Decoder::push`] and [`Decoder::next_frame`]) or in datagrams
/// ([`Decoder::datagram`]). After damage it looks for the next start marker inside what it held for a frame, so that
/// nothing sound is lost.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    buffer: Vec<u8>,
    start: usize,
    faults: Faults,
}

impl Decoder {
    /// With nothing seen yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// What has been seen so far.
    pub fn faults(&self) -> &Faults {
        &self.faults
    }

    /// Appends bytes of a stream. Call [`Self::next_frame`] until `None` afterwards.
    pub fn push(&mut self, bytes: &[u8]) {
        self.buffer.drain(..self.start);
        self.start = 0;
        let excess = (self.buffer.len() + bytes.len()).saturating_sub(MAX_BUFFERED);
        let excess = excess.min(self.buffer.len());
        self.faults.skipped_bytes += excess as u64;
        self.buffer.drain(..excess);
        self.buffer.extend_from_slice(bytes);
    }

    /// The next frame of the stream, `None` when more bytes are needed.
    pub fn next_frame(&mut self) -> Option<Frame> {
        loop {
            match examine(&self.buffer[self.start..], &mut self.faults) {
                Found::Frame(frame, len) => {
                    self.start += len;
                    return Some(frame);
                }
                Found::Skip(len) => self.start += len,
                Found::Incomplete => return None,
            }
        }
    }

    /// Bytes of the stream that wait for the rest of their frame.
    pub fn pending(&self) -> usize {
        self.buffer.len() - self.start
    }

    /// Declares that the rest of the frame at the start will not come (the peer fell silent): it counts as truncated,
    /// and what stands behind its start marker is examined by the next [`Self::next_frame`]. A stray start marker
    /// cannot hold back the frames that follow it for longer than the caller is willing to wait.
    pub fn give_up(&mut self) {
        if self.pending() > 0 {
            self.faults.truncated += 1;
            self.faults.skipped_bytes += 1;
            self.start += 1;
        }
    }

    /// The frames of one datagram, in order; a frame does not continue in the next datagram.
    pub fn datagram(&mut self, bytes: &[u8], mut each: impl FnMut(Frame)) {
        let mut at = 0;
        while at < bytes.len() {
            match examine(&bytes[at..], &mut self.faults) {
                Found::Frame(frame, len) => {
                    at += len;
                    each(frame);
                }
                Found::Skip(len) => at += len,
                Found::Incomplete => {
                    self.faults.truncated += 1;
                    self.faults.skipped_bytes += 1;
                    at += 1;
                }
            }
        }
    }
}

fn examine(bytes: &[u8], faults: &mut Faults) -> Found {
    let Some(marker) = bytes.iter().position(|b| *b == MAV_STX || *b == MAV_STX_V2) else {
        faults.skipped_bytes += bytes.len() as u64;
        return if bytes.is_empty() { Found::Incomplete } else { Found::Skip(bytes.len()) };
    };
    if marker > 0 {
        faults.skipped_bytes += marker as u64;
        return Found::Skip(marker);
    }
    let Some(header) = Header::read(bytes) else { return Found::Incomplete };
    if header.incompatible {
        faults.incompatible += 1;
        faults.skipped_bytes += 1;
        return Found::Skip(1);
    }
    let Some(bytes) = bytes.get(..header.frame_len()).map(|frame| (frame, bytes.get(header.frame_len())))
    else {
        return Found::Incomplete;
    };
    examine_whole(bytes.0, bytes.1.copied(), header, faults)
}

/// Checks a candidate of full length; `next` is the byte behind it.
fn examine_whole(bytes: &[u8], next: Option<u8>, header: Header, faults: &mut Faults) -> Found {
    let crc_extra = MavMessage::extra_crc(header.message_id);
    if crc_extra == 0 && MavMessage::default_message_from_id(header.message_id).is_none() {
        faults.unknown_id += 1;
        // Without its checksum the only evidence for a frame is that another one begins right behind it.
        let len = if next.is_none_or(|b| b == MAV_STX || b == MAV_STX_V2) { bytes.len() } else { 1 };
        faults.skipped_bytes += len as u64;
        return Found::Skip(len);
    }
    let at = header.checksum_at();
    let crc = u16::from_le_bytes([bytes[at], bytes[at + 1]]);
    if crc != calculate_crc(&bytes[1..at], crc_extra) {
        faults.bad_crc += 1;
        faults.skipped_bytes += 1;
        return Found::Skip(1);
    }
    faults.frames += 1;
    faults.signed += u64::from(header.signed);
    let message = match MavMessage::parse(header.version, header.message_id, &bytes[header.payload_at..at]) {
        Ok(message) => Message::Known(message),
        Err(
            ParserError::InvalidEnum { .. }
            | ParserError::UnknownMessage { .. }
            | ParserError::InvalidPayloadSize { .. }
            | ParserError::BytesError(_),
        ) => {
            faults.unparsed += 1;
            Message::Unparsed
        }
    };
    Found::Frame(Frame::from_checked(bytes, header, message), bytes.len())
}

/// A COMMAND_ACK in plain numbers: the command may be one that the crate's enum does not have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CommandAck {
    /// The command answered (`MAV_CMD`).
    pub command: u16,
    /// `MAV_RESULT`.
    pub result: u8,
    /// Progress in percent when the result is IN_PROGRESS, 255 when unknown; otherwise 0.
    pub progress: u8,
    /// Further detail of the result.
    pub result_param2: i32,
    /// System that the command came from.
    pub target_system: u8,
    /// Component that the command came from.
    pub target_component: u8,
}

/// Makes the MAVLink 2 frames of one component on one link: sequence numbers without gaps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Encoder {
    system_id: u8,
    component_id: u8,
    sequence: u8,
}

impl Encoder {
    /// For the component `component_id` of system `system_id`, from sequence number 0.
    pub fn new(system_id: u8, component_id: u8) -> Self {
        Self { system_id, component_id, sequence: 0 }
    }

    /// The system.
    pub fn system_id(&self) -> u8 {
        self.system_id
    }

    /// The component.
    pub fn component_id(&self) -> u8 {
        self.component_id
    }

    /// The frame of `message`.
    pub fn encode(&mut self, message: &MavMessage) -> Vec<u8> {
        let mut payload = [0; 255];
        let len = message.ser(MavlinkVersion::V2, &mut payload);
        let id = message.message_id();
        self.encode_payload(id, MavMessage::extra_crc(id), &payload[..len])
    }

    /// The frame of a COMMAND_ACK for any command number.
    pub fn encode_command_ack(&mut self, ack: &CommandAck) -> Vec<u8> {
        let mut payload = [0; 10];
        payload[..2].copy_from_slice(&ack.command.to_le_bytes());
        payload[2] = ack.result;
        payload[3] = ack.progress;
        payload[4..8].copy_from_slice(&ack.result_param2.to_le_bytes());
        payload[8] = ack.target_system;
        payload[9] = ack.target_component;
        self.encode_payload(COMMAND_ACK_ID, MavMessage::extra_crc(COMMAND_ACK_ID), &payload)
    }

    /// The frame of a message given by its number, its CRC_EXTRA and its payload in wire order; bytes beyond 255 are
    /// cut off. For messages and values that the crate cannot express.
    pub fn encode_payload(&mut self, message_id: u32, crc_extra: u8, payload: &[u8]) -> Vec<u8> {
        let payload = &payload[..payload.len().min(255)];
        let len = mavlink::utils::remove_trailing_zeroes(payload);
        let [a, b, c, _] = message_id.to_le_bytes();
        let header = [MAV_STX_V2, len as u8, 0, 0, self.sequence, self.system_id, self.component_id, a, b, c];
        self.sequence = self.sequence.wrapping_add(1);
        let mut bytes = Vec::with_capacity(HEADER_LEN_V2 + len + CHECKSUM_LEN);
        bytes.extend_from_slice(&header);
        bytes.extend_from_slice(&payload[..len]);
        let crc = calculate_crc(&bytes[1..], crc_extra);
        bytes.extend_from_slice(&crc.to_le_bytes());
        debug_assert!(bytes.len() <= MAX_FRAME_LEN);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink::dialects::common::*;
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
        let mut encoder = Encoder { sequence: 7, ..Encoder::new(1, 1) };
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
        assert_eq!(frames[0].message, Message::Unparsed);
        assert_eq!(decoder.faults().unparsed, 1);
        assert_eq!((frames[0].target_system(), frames[0].target_component()), (Some(1), Some(161)));
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
        assert_eq!(frames[0].target_system(), Some(255));
    }

    #[test]
    fn set_mode_with_the_bare_custom_bit_is_read() {
        let payload = [0, 0, 6, 0, 1, 1];
        let (frames, _) =
            stream(&Encoder::new(255, 190).encode_payload(11, MavMessage::extra_crc(11), &payload));
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
            prop_assert_eq!(framed + decoder.faults().skipped_bytes as usize + decoder.pending(), bytes.len());
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
        fn prop_setpoints_survive(vx in any::<u32>(), vy in any::<u32>(), yaw in any::<u32>(), t in any::<u32>()) {
            let message = MavMessage::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
                time_boot_ms: t, vx: f32::from_bits(vx), vy: f32::from_bits(vy), yaw: f32::from_bits(yaw),
                ..Default::default()
            });
            let (frames, _) = stream(&Encoder::new(1, 1).encode(&message));
            let Some(MavMessage::SET_POSITION_TARGET_LOCAL_NED(got)) = frames[0].known() else { panic!() };
            prop_assert_eq!((got.vx.to_bits(), got.vy.to_bits(), got.yaw.to_bits(), got.time_boot_ms), (vx, vy, yaw, t));
        }
    }
}
