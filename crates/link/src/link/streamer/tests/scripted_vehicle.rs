//! A scripted vehicle for the streamer's tests.

use mavlink::dialects::common::*;
use nalgebra::Vector3;

use super::*;
use crate::autopilot::FlightMode;
use crate::link::{CommandAck, Decoder, Encoder, Frame, Link, Session, TimeUs};
use crate::trajectory::Node;

/// A plan from 3 m/s down to 1 m/s north in 2 s.
pub(super) fn plan() -> Trajectory {
    let nodes = vec![Node::level(0.0, Vector3::new(0.0, 0.0, 3.0)), Node::level(2.0, Vector3::x())];
    Trajectory::new(nodes, 4).unwrap()
}

/// What the vehicle and its parachute answer.
#[derive(Clone, Copy)]
pub(super) struct Answers {
    pub(super) offboard: Option<u8>,
    pub(super) arming: Option<u8>,
    pub(super) release: Option<u8>,
    pub(super) tells_release: bool,
    pub(super) text: &'static str,
}

pub(super) const WILLING: Answers =
    Answers { offboard: Some(0), arming: Some(0), release: Some(0), tells_release: true, text: "" };

pub(super) struct ScriptedVehicle {
    pub(super) streamer: StreamerSession,
    pub(super) vehicle: Encoder,
    pub(super) parachute: Encoder,
    pub(super) decoder: Decoder,
    pub(super) answers: Answers,
    pub(super) armed: bool,
    /// Mode before it is armed in OFFBOARD.
    pub(super) mode_before: FlightMode,
    pub(super) now: TimeUs,
    /// Everything that the streamer sent, with its time.
    pub(super) sent: Vec<(TimeUs, Frame)>,
    pub(super) events: Vec<Timed<StreamerEvent>>,
}

impl ScriptedVehicle {
    pub(super) fn new(answers: Answers, change: impl FnOnce(&mut StreamerConfig)) -> Self {
        let mut config = StreamerConfig {
            hang_s: 5.0,
            target_v_ned: Vector3::new(1.0, 0.0, 0.5),
            end_s: Some(3.0),
            attempts: 3,
            ..StreamerConfig::default()
        };
        change(&mut config);
        Self {
            streamer: StreamerSession::new(config, plan()),
            vehicle: Encoder::new(1, 1),
            parachute: Encoder::new(1, 161),
            decoder: Decoder::new(),
            answers,
            armed: false,
            mode_before: FlightMode::AutoLoiter,
            now: 0,
            sent: Vec::new(),
            events: Vec::new(),
        }
    }

    pub(super) fn hear(&mut self, bytes: &[u8]) {
        self.decoder.push(bytes);
        let frame = self.decoder.next_frame().unwrap();
        self.streamer.handle_input(Link::Api, &frame);
    }

    pub(super) fn vehicle_says(&mut self, message: &MavMessage) {
        let bytes = self.vehicle.encode(message);
        self.hear(&bytes);
    }

    pub(super) fn heartbeat(&mut self) {
        let armed = if self.armed { 128 } else { 0 };
        self.vehicle_says(&MavMessage::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode: if self.armed { 6 << 16 } else { self.mode_before.custom_mode() },
            base_mode: MavModeFlag::from_bits_retain(1 | armed),
            ..Default::default()
        }));
    }

    /// Steps of 4 ms, with all that the vehicle does in them, until `until`.
    pub(super) fn run(&mut self, until: TimeUs) {
        while self.now < until {
            self.now += 4_000;
            if self.now % 1_000_000 == 4_000 {
                self.heartbeat();
            }
            let time_boot_ms = (self.now / 1_000) as u32;
            self.vehicle_says(&MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms, ..Default::default() }));
            while let Some(sent) = self.streamer.poll_output() {
                self.decoder.push(&sent.bytes);
                let frame = self.decoder.next_frame().unwrap();
                self.answer(&frame);
                self.sent.push((self.now, frame));
            }
            self.events.extend(std::iter::from_fn(|| self.streamer.poll_event()));
        }
    }

    pub(super) fn answer(&mut self, frame: &Frame) {
        let Some(command) = frame.command() else { return };
        let result = match command.command {
            176 => self.answers.offboard,
            400 => self.answers.arming,
            211 => self.answers.release,
            _ => None,
        };
        let Some(result) = result else { return };
        self.armed |= command.command == 400 && result == 0;
        let to_parachute = command.command == 211;
        let encoder = if to_parachute { &mut self.parachute } else { &mut self.vehicle };
        let (target_system, target_component) = (STREAMER_SYSTEM, STREAMER_COMPONENT);
        let ack = CommandAck {
            command: command.command,
            result,
            target_system,
            target_component,
            ..Default::default()
        };
        let bytes = encoder.encode_command_ack(&ack);
        self.hear(&bytes);
        if !self.answers.text.is_empty() {
            let text = self.answers.text.into();
            self.vehicle_says(&MavMessage::STATUSTEXT(STATUSTEXT_DATA { text, ..Default::default() }));
        }
        if to_parachute && result == 0 && self.answers.tells_release {
            self.report_release(self.now);
        }
    }

    pub(super) fn report_release(&mut self, at: TimeUs) {
        self.report_instant("t_release", at);
    }

    /// What the parachute has to say about an instant.
    pub(super) fn report_instant(&mut self, name: &str, at: TimeUs) {
        let bytes = self.parachute.encode(&MavMessage::NAMED_VALUE_INT(NAMED_VALUE_INT_DATA {
            time_boot_ms: 0,
            value: (at / 1_000) as i32,
            name: name.into(),
        }));
        self.hear(&bytes);
    }

    pub(super) fn setpoints(&self, message_id: u32) -> Vec<&(TimeUs, Frame)> {
        self.sent.iter().filter(|(_, f)| f.message_id == message_id).collect()
    }
}

pub(super) fn texts(events: &[Timed<StreamerEvent>]) -> Vec<String> {
    events.iter().map(ToString::to_string).collect()
}
