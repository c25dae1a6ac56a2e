//! One MAVLink frame as received.
//!
//! The mavlink crate's enums are strict: a COMMAND_LONG with a command number it does not know, or a
//! parameter type out of range, does not parse, though the frame is sound and an autopilot owes its sender an
//! answer. Such a frame has no [`Frame::message`]; the raw payload of every frame can be read by offset
//! ([`Payload`]), and the messages that must be answered whatever they hold have accessors that read the
//! payload itself ([`Frame::command`], [`Frame::set_mode`]).
//!
//! Offsets are those of the wire (fields sorted by size), beyond the end of a trimmed payload everything is
//! zero.

use mavlink::dialects::common::*;
use mavlink::{MAV_STX, MAV_STX_V2, MavlinkVersion, Message as _, MessageData as _};

use super::peer::PeerId;

/// MAVLink 2: a signature of 13 bytes follows the checksum.
pub(super) const INCOMPATIBLE_SIGNED: u8 = 0x01;
pub(super) const SIGNATURE_LEN: usize = 13;
pub(super) const CHECKSUM_LEN: usize = 2;
const HEADER_LEN_V1: usize = 6;
pub(super) const HEADER_LEN_V2: usize = 10;
/// Longest frame: MAVLink 2, 255 bytes of payload, signed.
pub const MAX_FRAME_LEN: usize = 280;

#[expect(deprecated, reason = "deprecated in MAVLink, still sent by ground stations")]
const SET_MODE_ID: u32 = SET_MODE_DATA::ID;

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

impl CommandAck {
    /// The answer to a command of the component `from` (system, component): a `MAV_RESULT`.
    pub fn new(command: &Command, result: u8, from: (u8, u8)) -> Self {
        Self {
            command: command.command,
            result,
            target_system: from.0,
            target_component: from.1,
            ..Self::default()
        }
    }
}

/// The message id of a MAVLink 2 frame given by its bytes; `None` when they are too few.
#[cfg(feature = "shell")]
pub(super) fn message_id(frame: &[u8]) -> Option<u32> {
    let [a, b, c] = *frame.get(7..HEADER_LEN_V2)? else { return None };
    Some(u32::from_le_bytes([a, b, c, 0]))
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
    pub version: MavlinkVersion,
    pub signed: bool,
    /// Has flags that a receiver must know and does not.
    pub incompatible: bool,
}

impl Header {
    /// Reads a header at the start of `bytes`; `None` when there are too few.
    pub(super) fn read(bytes: &[u8]) -> Option<Self> {
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

    pub(super) fn checksum_at(&self) -> usize {
        self.payload_at + self.payload_len
    }

    pub(super) fn frame_len(&self) -> usize {
        self.checksum_at() + CHECKSUM_LEN + if self.signed { SIGNATURE_LEN } else { 0 }
    }
}

/// A received frame whose checksum was right.
#[derive(Clone, PartialEq)]
pub struct Frame {
    /// System of the sender.
    pub system_id: u8,
    /// Component of the sender.
    pub component_id: u8,
    /// The sender's sequence number.
    pub sequence: u8,
    /// Number of the message.
    pub message_id: u32,
    /// The message, parsed; `None` where a field holds a value that the crate's enums do not know. It is
    /// then read through [`Frame::payload`].
    pub message: Option<MavMessage>,
    /// Peer that it came by; [`PeerId::ONLY`] unless the receiving side distinguishes its peers.
    pub peer: PeerId,
    bytes: [u8; MAX_FRAME_LEN],
    len: u16,
    payload_at: u8,
    payload_len: u8,
    signed: bool,
}

impl Frame {
    /// Cuts a frame, header to checksum or signature, that the decoder has checked.
    pub(super) fn from_checked(bytes: &[u8], header: Header, message: Option<MavMessage>) -> Self {
        let mut copy = [0; MAX_FRAME_LEN];
        let len = bytes.len().min(MAX_FRAME_LEN);
        copy[..len].copy_from_slice(&bytes[..len]);
        Self {
            system_id: header.system_id,
            component_id: header.component_id,
            sequence: header.sequence,
            message_id: header.message_id,
            message,
            peer: PeerId::ONLY,
            bytes: copy,
            len: len as u16,
            payload_at: header.payload_at as u8,
            payload_len: header.payload_len as u8,
            signed: header.signed,
        }
    }

    /// The whole frame as it was on the wire.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.len)]
    }

    /// Whether the frame ends in a signature.
    pub fn is_signed(&self) -> bool {
        self.signed
    }

    /// Whether the payload is longer than the message's fields: what a newer dialect has added is not read.
    pub fn has_excess(&self) -> bool {
        let Some(message) = self.known() else { return false };
        let mut payload = [0; 255];
        let read = message.ser(MavlinkVersion::V2, &mut payload);
        mavlink::utils::remove_trailing_zeroes(self.payload().as_slice()) > read
    }

    /// The payload as it was on the wire.
    pub fn payload(&self) -> Payload<'_> {
        let at = usize::from(self.payload_at);
        Payload(&self.bytes[at..at + usize::from(self.payload_len)])
    }

    /// The parsed message, if it parsed.
    pub fn known(&self) -> Option<&MavMessage> {
        self.message.as_ref()
    }

    /// COMMAND_LONG or COMMAND_INT, whatever its command number and frame.
    pub fn command(&self) -> Option<Command> {
        Command::read(self.message_id, self.payload())
    }

    /// SET_MODE, whatever its base mode.
    pub fn set_mode(&self) -> Option<SetMode> {
        let p = self.payload();
        (self.message_id == SET_MODE_ID).then(|| SetMode {
            target_system: p.u8(4),
            base_mode: p.u8(5),
            custom_mode: p.u32(0),
        })
    }

    /// COMMAND_ACK, whatever its command number and result.
    pub fn command_ack(&self) -> Option<CommandAck> {
        let p = self.payload();
        (self.message_id == COMMAND_ACK_DATA::ID).then(|| CommandAck {
            command: p.u16(0),
            result: p.u8(2),
            progress: p.u8(3),
            result_param2: p.i32(4),
            target_system: p.u8(8),
            target_component: p.u8(9),
        })
    }

    /// System and component that the message is addressed to; 0 means every one, and stands for what a
    /// message without target, or without a component in it, does not say.
    pub fn target(&self) -> (u8, u8) {
        let p = self.payload();
        match (self.known(), self.message_id) {
            // PX4 leaves these fields of its answers unset, and they hold whatever was there.
            (Some(MavMessage::TIMESYNC(m)), _) if m.tc1 != 0 => (0, 0),
            (Some(message), _) => {
                (message.target_system_id().unwrap_or(0), message.target_component_id().unwrap_or(0))
            }
            (None, COMMAND_INT_DATA::ID | COMMAND_LONG_DATA::ID) => (p.u8(30), p.u8(31)),
            (None, SET_MODE_ID) => (p.u8(4), 0),
            (None, PARAM_SET_DATA::ID) => (p.u8(4), p.u8(5)),
            (None, COMMAND_ACK_DATA::ID) => (p.u8(8), p.u8(9)),
            (None, _) => (0, 0),
        }
    }
}

impl std::fmt::Debug for Frame {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "#{} from {}/{} seq {}: {:?}",
            self.message_id, self.system_id, self.component_id, self.sequence, self.message
        )
    }
}

/// A payload read by wire offset, little-endian; zero beyond its end, as MAVLink 2 trims trailing zeros.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Payload<'a>(&'a [u8]);

impl<'a> Payload<'a> {
    /// The bytes as received.
    pub fn as_slice(self) -> &'a [u8] {
        self.0
    }

    fn array<const N: usize>(self, at: usize) -> [u8; N] {
        std::array::from_fn(|i| self.0.get(at + i).copied().unwrap_or(0))
    }

    /// Byte at `at`.
    pub fn u8(self, at: usize) -> u8 {
        self.0.get(at).copied().unwrap_or(0)
    }

    /// 16-bit unsigned number at `at`.
    pub fn u16(self, at: usize) -> u16 {
        u16::from_le_bytes(self.array(at))
    }

    /// 32-bit unsigned number at `at`.
    pub fn u32(self, at: usize) -> u32 {
        u32::from_le_bytes(self.array(at))
    }

    /// 32-bit signed number at `at`.
    pub fn i32(self, at: usize) -> i32 {
        i32::from_le_bytes(self.array(at))
    }

    /// 64-bit unsigned number at `at`.
    pub fn u64(self, at: usize) -> u64 {
        u64::from_le_bytes(self.array(at))
    }

    /// Single-precision number at `at`.
    pub fn f32(self, at: usize) -> f32 {
        f32::from_le_bytes(self.array(at))
    }

    /// Text of at most `N` bytes at `at`, up to its first zero; bytes that are not UTF-8 are replaced.
    pub fn text<const N: usize>(self, at: usize) -> String {
        let bytes: [u8; N] = self.array(at);
        let end = bytes.iter().position(|b| *b == 0).unwrap_or(N);
        String::from_utf8_lossy(&bytes[..end]).into_owned()
    }
}

/// A COMMAND_LONG or COMMAND_INT.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command {
    /// The command's number (`MAV_CMD`), known or not.
    pub command: u16,
    /// The seven parameters; of a COMMAND_INT, 5 and 6 are its integers x and y as they are on the wire.
    pub params: [f32; 7],
    /// x and y of a COMMAND_INT (degE7 or 1e4 m); `None` for a COMMAND_LONG.
    pub xy: Option<[i32; 2]>,
    /// Frame of a COMMAND_INT (`MAV_FRAME`); 0 for a COMMAND_LONG.
    pub frame: u8,
    /// Addressed system.
    pub target_system: u8,
    /// Addressed component.
    pub target_component: u8,
    /// 0 at the first transmission of a COMMAND_LONG, counted up with each repetition.
    pub confirmation: u8,
}

impl Command {
    fn read(message_id: u32, p: Payload<'_>) -> Option<Self> {
        if message_id != COMMAND_LONG_DATA::ID && message_id != COMMAND_INT_DATA::ID {
            return None;
        }
        let mut params: [f32; 7] = std::array::from_fn(|i| p.f32(4 * i));
        let mut xy = None;
        if message_id == COMMAND_INT_DATA::ID {
            let [x, y] = [p.i32(16), p.i32(20)];
            (params[4], params[5], xy) = (x as f32, y as f32, Some([x, y]));
        }
        Some(Self {
            command: p.u16(28),
            params,
            xy,
            frame: if xy.is_some() { p.u8(32) } else { 0 },
            target_system: p.u8(30),
            target_component: p.u8(31),
            confirmation: if xy.is_some() { 0 } else { p.u8(32) },
        })
    }

    /// Parameter `number` (1 to 7); `None` when it is NaN, which means "not given", or there is no such
    /// number.
    pub fn param(&self, number: usize) -> Option<f32> {
        let value = *self.params.get(number.checked_sub(1)?)?;
        (!value.is_nan()).then_some(value)
    }
}

/// A SET_MODE.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetMode {
    /// Addressed system.
    pub target_system: u8,
    /// `MAV_MODE_FLAG` bits; ground stations send the bare 1 (custom mode) that names no `MAV_MODE`.
    pub base_mode: u8,
    /// The autopilot's own mode.
    pub custom_mode: u32,
}
