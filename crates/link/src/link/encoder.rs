//! Messages to bytes: MAVLink 2 frames of one component.
//!
//! Serialising is the mavlink crate's; the frame around it is written here, so that values which the crate's
//! enums cannot hold (an acknowledgement of a command nobody knows) can be sent as well.

use mavlink::dialects::common::{COMMAND_ACK_DATA, MavMessage};
use mavlink::{MAV_STX_V2, MavlinkVersion, Message as _, MessageData as _, calculate_crc};

use super::frame::{CHECKSUM_LEN, CommandAck, HEADER_LEN_V2};
use super::froude::Froude;

/// Makes the MAVLink 2 frames of one component on one link: sequence numbers without gaps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Encoder {
    system_id: u8,
    component_id: u8,
    sequence: u8,
    froude: Option<Froude>,
}

impl Encoder {
    /// For the component `component_id` of system `system_id`, from sequence number 0.
    pub fn new(system_id: u8, component_id: u8) -> Self {
        Self { system_id, component_id, sequence: 0, froude: None }
    }

    /// For a wire of that scale: messages are given in the site's units and time.
    pub fn scaled(self, froude: Option<Froude>) -> Self {
        Self { froude, ..self }
    }

    /// The system.
    pub fn system_id(&self) -> u8 {
        self.system_id
    }

    /// The frame of `message`.
    pub fn encode(&mut self, message: &MavMessage) -> Vec<u8> {
        let scaled = self.froude.map(|froude| froude.wire_message(message));
        let message = scaled.as_ref().unwrap_or(message);
        let mut payload = [0; 255];
        let len = message.ser(MavlinkVersion::V2, &mut payload);
        let id = message.message_id();
        self.encode_payload(id, MavMessage::extra_crc(id), &payload[..len])
    }

    /// The frame of a COMMAND_ACK for any command number.
    pub fn encode_command_ack(&mut self, ack: &CommandAck) -> Vec<u8> {
        let CommandAck { command, result, progress, result_param2, target_system, target_component } = *ack;
        let ([a, b], [c, d, e, f]) = (command.to_le_bytes(), result_param2.to_le_bytes());
        let payload = [a, b, result, progress, c, d, e, f, target_system, target_component];
        self.encode_payload(COMMAND_ACK_DATA::ID, MavMessage::extra_crc(COMMAND_ACK_DATA::ID), &payload)
    }

    /// The frame of a message given by its number, its CRC_EXTRA and its payload in wire order; bytes beyond
    /// 255 are cut off. For messages and values that the crate cannot express.
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
        bytes
    }
}
