//! Bytes to frames.
//!
//! Parsing the messages is the mavlink crate's; the framing is ours, because a session must resync in a
//! damaged stream, count what it drops by kind, and keep frames whose message does not parse.
//!
//! Signatures are not looked at here: that takes a key ([`super::signing`]).

use mavlink::dialects::common::MavMessage;
use mavlink::{MAV_STX, MAV_STX_V2, MavlinkVersion, Message as _, calculate_crc};

use super::faults::Faults;
use super::frame::{Frame, Header};

/// Most bytes that a stream keeps while it waits for the rest of a frame; any frame is far shorter.
const MAX_BUFFERED: usize = 1 << 16;

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
/// ([`Decoder::datagram`]). After damage it looks for the next start marker inside what it held for a frame,
/// so that nothing sound is lost.
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

    /// What has been seen since the last call.
    pub fn take_faults(&mut self) -> Faults {
        std::mem::take(&mut self.faults)
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
            match examine(&self.buffer[self.start..], End::MayGoOn, &mut self.faults) {
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

    /// Declares that the rest of the frame at the start will not come (the peer fell silent): it counts as
    /// truncated, and what stands behind its start marker is examined by the next [`Self::next_frame`]. A
    /// stray start marker cannot hold back the frames that follow it for longer than the caller is willing to
    /// wait.
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
            match examine(&bytes[at..], End::IsFinal, &mut self.faults) {
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

/// Meaning of the end of the bytes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    /// More will come.
    MayGoOn,
    /// A datagram is over.
    IsFinal,
}

fn examine(bytes: &[u8], end: End, faults: &mut Faults) -> Found {
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
    let Some((frame, rest)) = bytes.split_at_checked(header.frame_len()) else { return Found::Incomplete };
    examine_whole(frame, rest.first().copied(), end, header, faults)
}

/// Checks a candidate of full length; `next` is the byte behind it.
fn examine_whole(bytes: &[u8], next: Option<u8>, end: End, header: Header, faults: &mut Faults) -> Found {
    let crc_extra = MavMessage::extra_crc(header.message_id);
    if crc_extra == 0 && MavMessage::default_message_from_id(header.message_id).is_none() {
        // Without its checksum the only evidence for a frame is that another one begins right behind it. In a
        // stream one waits to see that, lest it depend on how the stream is cut.
        if next.is_none() && end == End::MayGoOn {
            return Found::Incomplete;
        }
        faults.unknown_id += 1;
        if next.is_none_or(|b| b == MAV_STX || b == MAV_STX_V2) {
            faults.unknown_bytes += bytes.len() as u64;
            return Found::Skip(bytes.len());
        }
        faults.skipped_bytes += 1;
        return Found::Skip(1);
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
    faults.mavlink1 += u64::from(matches!(header.version, MavlinkVersion::V1));
    let payload = &bytes[header.payload_at..at];
    let message = MavMessage::parse(header.version, header.message_id, payload).ok();
    faults.unparsed += u64::from(message.is_none());
    Found::Frame(Frame::from_checked(bytes, header, message), bytes.len())
}
