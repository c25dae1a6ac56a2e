//! The session's links: what goes out by which, with which sequence number.

use mavlink::Message as _;
use mavlink::dialects::common::{MESSAGE_INTERVAL_DATA, MavMessage};

use super::super::{CommandAck, Encoder, Link, Recipient, Transmit};
use super::AutopilotSession;
use super::parameters::Listings;
use super::services::Peer;
use super::streams::Schedule;

/// Most frames that wait to be fetched before further answers are dropped.
const MAX_QUEUED: usize = 4096;

/// One of the session's links: its sequence numbers and its streams.
#[derive(Clone, Debug)]
pub(super) struct Port {
    pub encoder: Encoder,
    pub schedule: Schedule,
    pub listings: Listings,
}

impl AutopilotSession {
    pub(super) fn port(&mut self, link: Link) -> &mut Port {
        match link {
            Link::Simulator => &mut self.ports[0],
            Link::GroundStation => &mut self.ports[1],
            Link::Api | Link::Parachute => &mut self.ports[2],
        }
    }

    /// To every peer of a link.
    pub(super) fn send(&mut self, link: Link, message: &MavMessage) {
        self.push(link, Recipient::All, |encoder| encoder.encode(message));
    }

    /// To the peer that asked, and to nobody else.
    pub(super) fn reply(&mut self, peer: Peer, message: &MavMessage) {
        self.push(peer.link, Recipient::Peer(peer.id), |encoder| encoder.encode(message));
    }

    /// To the peer that asked, a message given by its number and payload in wire order.
    pub(super) fn reply_payload(&mut self, peer: Peer, message_id: u32, payload: &[u8]) {
        let extra_crc = MavMessage::extra_crc(message_id);
        self.push(peer.link, Recipient::Peer(peer.id), |encoder| {
            encoder.encode_payload(message_id, extra_crc, payload)
        });
    }

    pub(super) fn reply_command_ack(&mut self, peer: Peer, ack: &CommandAck) {
        self.push(peer.link, Recipient::Peer(peer.id), |encoder| encoder.encode_command_ack(ack));
    }

    pub(super) fn reply_message_interval(&mut self, peer: Peer, message_id: u16, interval_us: i32) {
        let message = MESSAGE_INTERVAL_DATA { interval_us, message_id };
        self.reply(peer, &MavMessage::MESSAGE_INTERVAL(message));
    }

    /// Answers that nobody fetches as fast as they are asked for are not kept without end; the simulator's and what is
    /// for everybody always are.
    fn push(&mut self, link: Link, to: Recipient, encode: impl FnOnce(&mut Encoder) -> Vec<u8>) {
        if link != Link::Simulator && to != Recipient::All && self.out.len() >= MAX_QUEUED {
            self.unanswered += 1;
            return;
        }
        let bytes = encode(&mut self.port(link).encoder);
        self.out.push_back(Transmit { link, to, bytes });
    }

    /// Answers that were not given because too many were asked for at once.
    pub fn unanswered(&self) -> u64 {
        self.unanswered
    }
}
