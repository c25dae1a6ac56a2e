//! The peers of a hub: where they are, when they were heard, how their frames are numbered.

use mavlink::dialects::common::MavMessage;
use mavlink::{Message as _, calculate_crc};

use super::super::decoder::Decoder;
use super::super::faults::Faults;
use super::super::frame::{HEADER_LEN_V2, INCOMPATIBLE_SIGNED};
use super::super::peer::PeerId;
use super::super::signing::Signing;

/// Most components of one peer that are remembered for routes and sequence numbers; what more there are is
/// heard all the same.
const MAX_COMPONENTS: usize = 16;

/// An endpoint, by the order in which they were added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EndpointId(pub u8);

/// A component that was heard by a peer, or one of ours that speaks to it.
#[derive(Clone, Copy, Debug)]
struct Numbered {
    component: (u8, u8),
    sequence: u8,
}

/// One peer.
#[derive(Clone, Debug)]
pub(super) struct Peer<A> {
    pub(super) id: PeerId,
    pub(super) endpoint: EndpointId,
    pub(super) address: A,
    /// Served until forgotten, though it be silent: a default remote, a connection.
    pub(super) kept: bool,
    /// A connection that somebody else has made, and has not spoken by.
    pub(super) is_listener: bool,
    /// When it was admitted first, though it may have been silent since: who came earlier goes before.
    pub(super) since: u64,
    pub(super) heard_at: Option<u64>,
    /// The last that has come by it, as it came.
    pub(super) heartbeat: Option<Vec<u8>>,
    /// Of a stream.
    pub(super) decoder: Decoder,
    heard: Vec<Numbered>,
    sent: Vec<Numbered>,
}

impl<A> Peer<A> {
    pub(super) fn new(id: PeerId, endpoint: EndpointId, address: A, since: u64) -> Self {
        let (kept, is_listener, heard_at, heartbeat) = (false, false, None, None);
        let (decoder, heard, sent) = (Decoder::new(), Vec::new(), Vec::new());
        Self { id, endpoint, address, kept, is_listener, since, heard_at, heartbeat, decoder, heard, sent }
    }

    pub(super) fn is_served(&self, now: u64, memory: u64) -> bool {
        self.kept || self.is_heard(now, memory)
    }

    /// Whether it has spoken within `memory`.
    pub(super) fn is_heard(&self, now: u64, memory: u64) -> bool {
        self.heard_at.is_some_and(|at| now.saturating_sub(at) <= memory)
    }

    /// Systems and components heard by this peer.
    pub(super) fn components(&self) -> impl Iterator<Item = (u8, u8)> {
        self.heard.iter().map(|n| n.component)
    }

    /// Notes a frame's sender and sequence number, and counts what does not follow the last. What others than
    /// the first say through a peer may have been thinned on the way: nothing of it is missed.
    pub(super) fn note_sequence(&mut self, component: (u8, u8), sequence: u8, faults: &mut Faults) {
        let is_first = self.heard.first().is_none_or(|n| n.component == component);
        let Some(last) = self.heard.iter_mut().find(|n| n.component == component) else {
            if self.heard.len() < MAX_COMPONENTS {
                self.heard.push(Numbered { component, sequence });
            }
            return;
        };
        match sequence.wrapping_sub(last.sequence) {
            0 => faults.repeated += 1,
            // More than half way round: it is older.
            129.. => {
                faults.late += 1;
                return;
            }
            ahead if is_first => faults.missed += u64::from(ahead - 1),
            _ => {}
        }
        last.sequence = sequence;
    }

    /// The number of the next frame of a component of ours.
    fn next_sequence(&mut self, component: (u8, u8)) -> u8 {
        match self.sent.iter_mut().find(|n| n.component == component) {
            Some(last) => {
                last.sequence = last.sequence.wrapping_add(1);
                last.sequence
            }
            None => {
                self.sent.push(Numbered { component, sequence: 0 });
                0
            }
        }
    }

    /// One of our frames as this peer gets it: with a sequence number of its own, so that a frame for another
    /// peer is no gap to this one, and signed if there is a key.
    pub(super) fn seal(&mut self, frame: &[u8], signing: Option<&mut Signing>, now: u64) -> Vec<u8> {
        let mut bytes = frame.to_vec();
        let Some(&[_, len, _, _, _, system, component, a, b, c]) = frame.first_chunk::<HEADER_LEN_V2>()
        else {
            return bytes;
        };
        let checksum_at = HEADER_LEN_V2 + usize::from(len);
        bytes.truncate(checksum_at);
        bytes[4] = self.next_sequence((system, component));
        if signing.is_some() {
            bytes[2] |= INCOMPATIBLE_SIGNED;
        }
        let crc_extra = MavMessage::extra_crc(u32::from_le_bytes([a, b, c, 0]));
        let crc = calculate_crc(&bytes[1..], crc_extra);
        bytes.extend_from_slice(&crc.to_le_bytes());
        if let Some(signing) = signing {
            signing.append(&mut bytes, self.endpoint.0, now);
        }
        bytes
    }
}
