//! What leaves the session: frames by its three links, each with its sequence numbers, and entries of the
//! flight log.

use std::collections::VecDeque;

use mavlink::Message as _;
use mavlink::dialects::common::{MavMessage, MavSeverity, STATUSTEXT_DATA};
use num_traits::FromPrimitive as _;

use super::logging::LogQueue;
use crate::autopilot::Event;
use crate::autopilot::flight_log::LogEntry;
use crate::link::statustext::TextWriter;
use crate::link::{CommandAck, Encoder, Frame, Link, PeerId, Recipient, Transmit};
use crate::params::file::AUTOPILOT_COMPONENT;
use crate::time::TimeUs;

/// The links that an autopilot serves.
pub(super) const LINKS: [Link; 3] = [Link::Simulator, Link::GroundStation, Link::Api];

/// Place of a link in [`LINKS`].
pub(super) fn index_of(link: Link) -> usize {
    match link {
        Link::Simulator => 0,
        Link::GroundStation => 1,
        Link::Api | Link::Parachute => 2,
    }
}

/// The sender of a message, to whom alone its answer goes. Several components behind one peer differ in
/// system and component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Peer {
    pub link: Link,
    /// The link's number of the connection.
    pub id: PeerId,
    pub system: u8,
    pub component: u8,
}

impl Peer {
    /// The sender of a frame that came by `link`.
    pub(super) fn of(link: Link, frame: &Frame) -> Self {
        Self { link, id: frame.peer, system: frame.system_id, component: frame.component_id }
    }
}

/// Most frames that wait to be fetched before further answers are dropped.
const MAX_QUEUED: usize = 4096;

/// Frames and log entries that wait to be fetched.
#[derive(Clone, Debug)]
pub(super) struct Outbox {
    encoders: [Encoder; LINKS.len()],
    frames: VecDeque<Transmit>,
    texts: TextWriter,
    /// Number of answers that were dropped because too many were asked for at once.
    pub unanswered: u64,
    pub log: LogQueue,
}

impl Outbox {
    /// An empty outbox of the autopilot of a MAVLink system.
    pub(super) fn new(system_id: u8) -> Self {
        Self {
            encoders: LINKS.map(|_| Encoder::new(system_id, AUTOPILOT_COMPONENT)),
            frames: VecDeque::new(),
            texts: TextWriter::default(),
            unanswered: 0,
            log: LogQueue::default(),
        }
    }

    /// Takes the next frame to send.
    pub(super) fn poll(&mut self) -> Option<Transmit> {
        self.frames.pop_front()
    }

    /// Drops the frames that wait for a simulator.
    pub(super) fn forget_simulator(&mut self) {
        self.frames.retain(|transmit| transmit.link != Link::Simulator);
    }

    /// Sends a message to every peer of a link.
    pub(super) fn send(&mut self, link: Link, message: &MavMessage) {
        self.push(link, Recipient::All, |encoder| encoder.encode(message));
    }

    /// Sends a message to all ground stations and companions.
    pub(super) fn broadcast(&mut self, message: &MavMessage) {
        self.send(Link::GroundStation, message);
        self.send(Link::Api, message);
    }

    /// Sends a message to the peer that asked, and to nobody else.
    pub(super) fn reply(&mut self, peer: Peer, message: &MavMessage) {
        self.push(peer.link, Recipient::Peer(peer.id), |encoder| encoder.encode(message));
    }

    /// Sends the peer that asked a message given by its number and payload in wire order.
    pub(super) fn reply_payload(&mut self, peer: Peer, message_id: u32, payload: &[u8]) {
        let extra_crc = MavMessage::extra_crc(message_id);
        self.push(peer.link, Recipient::Peer(peer.id), |encoder| {
            encoder.encode_payload(message_id, extra_crc, payload)
        });
    }

    /// Acknowledges a command to the peer that gave it.
    pub(super) fn reply_command_ack(&mut self, peer: Peer, ack: &CommandAck) {
        self.push(peer.link, Recipient::Peer(peer.id), |encoder| encoder.encode_command_ack(ack));
    }

    /// Reports an event as STATUSTEXT to ground stations and companions, and logs it.
    pub(super) fn report(&mut self, now: TimeUs, event: Event) {
        let severity = MavSeverity::from_u8(event.severity as u8).unwrap_or(MavSeverity::MAV_SEVERITY_INFO);
        for message in self.texts.messages(severity, &event.text) {
            self.broadcast(&MavMessage::STATUSTEXT(message));
        }
        self.log.push(LogEntry::Said(now, event));
    }

    /// The messages of a notice.
    pub(super) fn notices(&mut self, text: &str) -> Vec<STATUSTEXT_DATA> {
        self.texts.messages(MavSeverity::MAV_SEVERITY_NOTICE, text)
    }

    /// Answers that nobody fetches as fast as they are asked for are not kept without end; the simulator's
    /// and what is for everybody always are.
    fn push(&mut self, link: Link, to: Recipient, encode: impl FnOnce(&mut Encoder) -> Vec<u8>) {
        if link != Link::Simulator && to != Recipient::All && self.frames.len() >= MAX_QUEUED {
            self.unanswered += 1;
            return;
        }
        let bytes = encode(&mut self.encoders[index_of(link)]);
        self.frames.push_back(Transmit { link, to, bytes });
    }
}
