//! What ground stations ask for besides telemetry and commands, handed to those who know: clocks here, parameters, missions and
//! files in files of their own. Each question gets its answer, so that nobody waits.
//!
//! An answer goes to the peer that asked and to nobody else, also where MAVLink gives it no address (PARAM_VALUE); several
//! components behind one peer are told apart by system and component.

use mavlink::MessageData as _;
use mavlink::dialects::common::*;

use super::super::frame::PARAM_SET_ID;
use super::super::{Frame, Link, PeerId, TimeUs};
use super::AutopilotSession;
use super::missions::Request;

/// Who asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Peer {
    /// By which link.
    pub link: Link,
    /// As which of the link's peers.
    pub id: PeerId,
    /// MAVLink system.
    pub system: u8,
    /// MAVLink component.
    pub component: u8,
}

impl Peer {
    pub(super) fn of(link: Link, frame: &Frame) -> Self {
        Self { link, id: frame.peer, system: frame.system_id, component: frame.component_id }
    }
}

impl AutopilotSession {
    /// Takes the messages whose fields may hold what no enum knows; false when it is none of them.
    pub(super) fn handle_raw_service(&mut self, link: Link, frame: &Frame) -> bool {
        let (peer, p) = (Peer::of(link, frame), frame.payload());
        if let Some((system, component, request)) = Request::read(frame) {
            if self.is_for_us(system, component) {
                self.missions.handle(self.clock, peer, request);
                if let Some(fence) = self.missions.take_new_fence(&self.environment) {
                    self.autopilot.set_fence(fence);
                }
                self.send_answers();
            }
            return true;
        }
        match frame.message_id {
            PARAM_SET_ID if self.is_for_us(p.u8(4), p.u8(5)) => self.set_parameter(peer, frame),
            PARAM_REQUEST_READ_DATA::ID if self.is_for_us(p.u8(2), p.u8(3)) => {
                self.answer_param_read(peer, frame);
            }
            PARAM_SET_ID | PARAM_REQUEST_READ_DATA::ID => {}
            _ => return false,
        }
        true
    }

    /// Takes another service message.
    pub(super) fn handle_service(&mut self, link: Link, frame: &Frame, message: &MavMessage) {
        let (system, component) = (frame.target_system(), frame.target_component());
        if !self.is_for_us(system.unwrap_or(0), component.unwrap_or(0)) {
            return;
        }
        let peer = Peer::of(link, frame);
        match message {
            MavMessage::TIMESYNC(m) => self.answer_timesync(peer, m),
            #[expect(deprecated, reason = "deprecated in MAVLink, still sent by ground stations")]
            MavMessage::PING(m) => self.answer_ping(peer, m),
            MavMessage::PARAM_REQUEST_LIST(_) => self.begin_listing(peer),
            MavMessage::FILE_TRANSFER_PROTOCOL(m) => {
                self.files.handle(self.clock, peer, &m.payload);
                self.send_answers();
            }
            _ => {}
        }
    }

    /// What the services do without a question: lists and bursts that go on, items asked for again.
    pub(super) fn serve(&mut self) {
        self.list_on();
        self.missions.handle_time(self.clock);
        self.files.handle_time();
        self.send_answers();
        self.say_events();
    }

    /// Simulated time has started over.
    pub(super) fn restart_services(&mut self) {
        self.missions.restart();
        self.files.restart();
    }

    fn send_answers(&mut self) {
        while let Some(event) = self.missions.poll_event() {
            self.autopilot.say(event.severity, event.text);
        }
        while let Some((peer, answer)) = self.missions.poll_answer() {
            self.reply_payload(peer, answer.message_id, &answer.payload);
        }
        while let Some((peer, payload)) = self.files.poll_answer() {
            let message = FILE_TRANSFER_PROTOCOL_DATA {
                target_network: 0,
                target_system: peer.system,
                target_component: peer.component,
                payload,
            };
            self.reply(peer, &MavMessage::FILE_TRANSFER_PROTOCOL(message));
        }
    }

    fn answer_timesync(&mut self, peer: Peer, m: &TIMESYNC_DATA) {
        // tc1 = 0 asks; anything else answers a question of ours.
        if m.tc1 == 0 {
            let answer = TIMESYNC_DATA {
                tc1: nanoseconds(self.clock).max(1),
                ts1: m.ts1,
                target_system: peer.system,
                target_component: peer.component,
            };
            self.reply(peer, &MavMessage::TIMESYNC(answer));
        }
    }

    #[expect(deprecated, reason = "deprecated in MAVLink, still sent by ground stations")]
    fn answer_ping(&mut self, peer: Peer, m: &PING_DATA) {
        // Target 0, 0 asks; a target answers.
        if m.target_system == 0 && m.target_component == 0 {
            let answer = PING_DATA {
                time_usec: m.time_usec,
                seq: m.seq,
                target_system: peer.system,
                target_component: peer.component,
            };
            self.reply(peer, &MavMessage::PING(answer));
        }
    }
}

fn nanoseconds(t: TimeUs) -> i64 {
    i64::try_from(t).unwrap_or(i64::MAX).saturating_mul(1000)
}
