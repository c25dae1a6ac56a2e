//! Packets of MAVLink FTP, 251 bytes: sequence (2), session, opcode, size, opcode asked for, burst complete,
//! padding, offset (4), data (239). An answer carries the session, the request's sequence + 1 and ACK or NAK.

/// Payload of FILE_TRANSFER_PROTOCOL.
pub(in crate::link::autopilot) type Packet = [u8; 251];

pub(super) const HEADER_LEN: usize = 12;
pub(super) const DATA_LEN: usize = 251 - HEADER_LEN;

/// Opcodes.
pub(super) mod op {
    pub const NONE: u8 = 0;
    pub const TERMINATE_SESSION: u8 = 1;
    pub const RESET_SESSIONS: u8 = 2;
    pub const LIST_DIRECTORY: u8 = 3;
    pub const OPEN_FILE_RO: u8 = 4;
    pub const READ_FILE: u8 = 5;
    /// CreateFile to RenameFile, but for those above and below.
    pub const WRITING: std::ops::RangeInclusive<u8> = 6..=13;
    pub const CALC_FILE_CRC32: u8 = 14;
    pub const BURST_READ_FILE: u8 = 15;
    pub const ACK: u8 = 128;
    pub const NAK: u8 = 129;
}

/// Why not, by the protocol's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Nak {
    InvalidDataSize = 3,
    InvalidSession = 4,
    NoSessionsAvailable = 5,
    EndOfFile = 6,
    UnknownCommand = 7,
    FileProtected = 9,
    FileNotFound = 10,
}

/// What an answer holds: its session and its data.
pub(super) type Answer = Result<(u8, Vec<u8>), Nak>;

/// How much a read gives: all that fits, unless less is asked for.
pub(super) fn piece(size: usize) -> usize {
    if size == 0 { DATA_LEN } else { size.min(DATA_LEN) }
}

/// A path up to its first zero, without slashes at its ends; empty when it is no text.
pub(super) fn path_of(data: &[u8]) -> &str {
    let end = data.iter().position(|b| *b == 0).unwrap_or(data.len());
    std::str::from_utf8(&data[..end]).unwrap_or("?").trim_matches('/')
}

pub(super) fn packet(sequence: u16, asked: u8, opcode: u8, offset: usize, answer: Answer) -> Packet {
    let mut packet = [0; 251];
    packet[..2].copy_from_slice(&sequence.to_le_bytes());
    packet[5] = opcode;
    packet[8..HEADER_LEN].copy_from_slice(&(offset as u32).to_le_bytes());
    let nak;
    let (session, kind, data) = match &answer {
        Ok((session, data)) => (*session, op::ACK, data.as_slice()),
        Err(reason) => {
            nak = [*reason as u8];
            (asked, op::NAK, nak.as_slice())
        }
    };
    (packet[2], packet[3], packet[4]) = (session, kind, data.len() as u8);
    packet[HEADER_LEN..HEADER_LEN + data.len()].copy_from_slice(data);
    packet
}
