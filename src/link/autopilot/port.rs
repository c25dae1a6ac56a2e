//! The session's links: what goes out by which, with which sequence number.

use mavlink::Message as _;
use mavlink::dialects::common::{MESSAGE_INTERVAL_DATA, MavMessage};

use super::super::{CommandAck, Encoder, Link, Transmit};
use super::AutopilotSession;
use super::parameters::Listing;
use super::streams::Schedule;

/// One of the session's links: its sequence numbers and its streams.
#[derive(Clone, Debug)]
pub(super) struct Port {
    pub encoder: Encoder,
    pub schedule: Schedule,
    pub listing: Listing,
}

impl AutopilotSession {
    pub(super) fn port(&mut self, link: Link) -> &mut Port {
        match link {
            Link::Simulator => &mut self.ports[0],
            Link::GroundStation => &mut self.ports[1],
            Link::Api | Link::Parachute => &mut self.ports[2],
        }
    }

    pub(super) fn send(&mut self, link: Link, message: &MavMessage) {
        let bytes = self.port(link).encoder.encode(message);
        self.out.push_back(Transmit { link, bytes });
    }

    /// A message given by its number and payload in wire order.
    pub(super) fn send_payload(&mut self, link: Link, message_id: u32, payload: &[u8]) {
        let extra_crc = MavMessage::extra_crc(message_id);
        let bytes = self.port(link).encoder.encode_payload(message_id, extra_crc, payload);
        self.out.push_back(Transmit { link, bytes });
    }

    pub(super) fn send_command_ack(&mut self, link: Link, ack: &CommandAck) {
        let bytes = self.port(link).encoder.encode_command_ack(ack);
        self.out.push_back(Transmit { link, bytes });
    }

    pub(super) fn send_message_interval(&mut self, link: Link, message_id: u16, interval_us: i32) {
        let message = MESSAGE_INTERVAL_DATA { interval_us, message_id };
        self.send(link, &MavMessage::MESSAGE_INTERVAL(message));
    }
}
