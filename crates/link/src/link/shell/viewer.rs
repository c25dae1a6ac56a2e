//! A viewer of the flight: the truth as HIL_STATE_QUATERNION to UDP 19410 + N, where PX4's Hawkeye listens.
//!
//! A HEARTBEAT now and then says what flies. Frames are sent where a flight keeps the pace of the clock; at
//! full speed there is nothing to be watched. Nobody has to be there.

use std::net::{SocketAddr, UdpSocket};

use mavlink::MessageData as _;
use mavlink::dialects::common::*;

use super::super::autopilot::AUTOPILOT_COMPONENT;
use super::super::encoder::Encoder;
use super::super::frame::message_id;
use super::super::session::{Link, Transmit};
use super::clock::Speed;
use super::ports::{Ports, loopback};

/// One HEARTBEAT for so many of them: about a second of flight, at the rate that autopilots ask for.
const PER_HEARTBEAT: u32 = 125;

/// The way to it, if there is one.
#[derive(Debug)]
pub(super) struct Viewer {
    socket: Option<UdpSocket>,
    at: SocketAddr,
    /// Encodes the HEARTBEAT, under the vehicle's address.
    encoder: Encoder,
    shown: u32,
}

impl Viewer {
    /// A system that gives no socket shows nothing: that is no reason not to fly.
    pub(super) fn open(system_id: u8, ports: &Ports, speed: Speed) -> Self {
        let socket = match speed {
            Speed::Factor(_) => UdpSocket::bind(loopback(0)).ok(),
            Speed::Max => None,
        };
        let socket = socket.filter(|socket| socket.set_nonblocking(true).is_ok());
        let encoder = Encoder::new(system_id, AUTOPILOT_COMPONENT);
        Self { socket, at: loopback(ports.viewer), encoder, shown: 0 }
    }

    /// Shows the frame, if it is for viewers.
    pub(super) fn show(&mut self, sent: &Transmit) {
        if let Some(socket) = &self.socket
            && sent.link == Link::Simulator
            && message_id(&sent.bytes) == Some(HIL_STATE_QUATERNION_DATA::ID)
        {
            if self.shown.is_multiple_of(PER_HEARTBEAT) {
                _ = socket.send_to(&self.encoder.encode(&heartbeat()), self.at);
            }
            self.shown = self.shown.wrapping_add(1);
            // Nobody there, or a full buffer: the next one comes.
            _ = socket.send_to(&sent.bytes, self.at);
        }
    }
}

fn heartbeat() -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA {
        mavtype: MavType::MAV_TYPE_QUADROTOR,
        autopilot: MavAutopilot::MAV_AUTOPILOT_PX4,
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
        ..HEARTBEAT_DATA::default()
    })
}
