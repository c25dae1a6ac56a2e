//! What the streamer says to the vehicle: frames, heartbeats, and the command that waits for its answer.

use std::collections::VecDeque;

use mavlink::dialects::common::{MavCmd, MavMessage, MavType};

use super::config::{STREAMER_COMPONENT, STREAMER_SYSTEM, StreamerConfig};
use super::patience::Wire;
use super::request::{Request, RequestStep};
use crate::link::encoder::Encoder;
use crate::link::frame::CommandAck;
use crate::link::wire::{heartbeat_after, heartbeat_of};
use crate::time::TimeUs;

/// Frames that wait to be fetched, and what waits for an answer.
#[derive(Clone, Debug)]
pub(super) struct Outbox {
    vehicle_system: u8,
    encoder: Encoder,
    frames: VecDeque<Vec<u8>>,
    /// What the host tells of the wire.
    pub wire: Wire,
    /// The command of the present state.
    pub request: Option<Request>,
    next_heartbeat: TimeUs,
    /// Nothing is sent, by a fault of the simulator's.
    pub is_mute: bool,
}

impl Outbox {
    /// An empty outbox.
    pub(super) fn new(config: &StreamerConfig) -> Self {
        Self {
            vehicle_system: config.vehicle_system,
            encoder: Encoder::new(STREAMER_SYSTEM, STREAMER_COMPONENT).scaled(config.froude),
            frames: VecDeque::new(),
            wire: Wire::default(),
            request: None,
            next_heartbeat: 0,
            is_mute: false,
        }
    }

    /// Begins again: the vehicle's time has started over.
    pub(super) fn restart(&mut self) {
        (self.request, self.next_heartbeat, self.is_mute) = (None, 0, false);
    }

    /// Takes the next frame to send.
    pub(super) fn poll(&mut self) -> Option<Vec<u8>> {
        self.frames.pop_front()
    }

    pub(super) fn send(&mut self, message: &MavMessage) {
        if !self.is_mute {
            let bytes = self.encoder.encode(message);
            self.frames.push_back(bytes);
        }
    }

    pub(super) fn send_heartbeat(&mut self) {
        self.send(&heartbeat_of(MavType::MAV_TYPE_GCS));
    }

    /// Sends the heartbeat that is due.
    pub(super) fn beat(&mut self, now: TimeUs) {
        if now >= self.next_heartbeat {
            self.next_heartbeat = heartbeat_after(now);
            self.send_heartbeat();
        }
    }

    /// Asks for a message at an interval. Only before anything waits for the vehicle's answer: PX4's receiver
    /// sleeps in simulated time until its sender has taken the wish.
    pub(super) fn wish_for(&mut self, now: TimeUs, message_id: u32, interval_us: TimeUs) {
        let interval = [message_id as f32, interval_us as f32, 0.0];
        self.wish(now, MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, interval);
    }

    /// Sends the autopilot a command whose answer does not matter.
    pub(super) fn wish(&mut self, now: TimeUs, command: MavCmd, params: [f32; 3]) {
        let mut wish = Request::to_autopilot(self.vehicle_system, command, params, "a message", 1);
        if let RequestStep::Send(m) = wish.poll(now, &self.wire) {
            self.send(&MavMessage::COMMAND_LONG(m));
        }
    }

    /// Works at the request under way, or at the one that is made; what it sends is sent.
    pub(super) fn pursue(&mut self, now: TimeUs, make: impl FnOnce() -> Request) -> RequestStep {
        match self.request.get_or_insert_with(make).poll(now, &self.wire) {
            RequestStep::Send(message) => {
                self.send(&MavMessage::COMMAND_LONG(message));
                RequestStep::Pending
            }
            progress => progress,
        }
    }

    /// Drops the request under way.
    pub(super) fn drop_request(&mut self) {
        self.request = None;
    }

    /// Takes an acknowledgement that came from `from`; whether there is a request that it may be for.
    pub(super) fn take_ack(&mut self, ack: &CommandAck, from: (u8, u8)) -> bool {
        let Some(request) = &mut self.request else { return false };
        request.take_ack(ack, from, (STREAMER_SYSTEM, STREAMER_COMPONENT));
        true
    }
}
