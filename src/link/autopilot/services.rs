//! What ground stations ask for besides telemetry: clocks, parameters, missions, files. Small and honest: parameters can
//! be read, there is no mission, there are no files; each question gets its answer, so that nobody waits.

use mavlink::dialects::common::*;

use super::super::{Frame, Link};
use super::AutopilotSession;
use crate::autopilot::Severity;
use crate::autopilot::parameters::{ParameterValue, Parameters};

impl AutopilotSession {
    /// Answers a service message; false when it is none.
    pub(super) fn handle_service(&mut self, link: Link, frame: &Frame, message: &MavMessage) {
        let answers_us = |target: Option<u8>, component: Option<u8>| {
            self.is_for_us(target.unwrap_or(0), component.unwrap_or(0))
        };
        if !answers_us(frame.target_system(), frame.target_component()) {
            return;
        }
        match message {
            MavMessage::TIMESYNC(m) => self.answer_timesync(link, frame, m),
            #[expect(deprecated, reason = "deprecated in MAVLink, still sent by ground stations")]
            MavMessage::PING(m) => self.answer_ping(link, frame, m),
            MavMessage::PARAM_REQUEST_LIST(_) => self.send_all_parameters(link, frame),
            MavMessage::PARAM_REQUEST_READ(m) => self.answer_param_read(link, frame, m),
            MavMessage::MISSION_REQUEST_LIST(m) => {
                let count = MISSION_COUNT_DATA {
                    count: 0,
                    target_system: frame.system_id,
                    target_component: frame.component_id,
                    mission_type: m.mission_type,
                    opaque_id: 0,
                };
                self.reply(link, frame, &MavMessage::MISSION_COUNT(count));
            }
            MavMessage::MISSION_COUNT(m) if m.count > 0 => {
                self.autopilot.say(Severity::Error, "mission refused: missions are not flown");
                self.ack_mission(link, frame, m.mission_type, MavMissionResult::MAV_MISSION_UNSUPPORTED);
            }
            MavMessage::MISSION_COUNT(m) => {
                self.ack_mission(link, frame, m.mission_type, MavMissionResult::MAV_MISSION_ACCEPTED);
            }
            MavMessage::MISSION_CLEAR_ALL(m) => {
                self.ack_mission(link, frame, m.mission_type, MavMissionResult::MAV_MISSION_ACCEPTED);
            }
            MavMessage::MISSION_REQUEST_INT(m) => {
                self.ack_mission(link, frame, m.mission_type, MavMissionResult::MAV_MISSION_INVALID_SEQUENCE);
            }
            #[expect(deprecated, reason = "deprecated in MAVLink, still sent by ground stations")]
            MavMessage::MISSION_REQUEST(m) => {
                self.ack_mission(link, frame, m.mission_type, MavMissionResult::MAV_MISSION_INVALID_SEQUENCE);
            }
            MavMessage::FILE_TRANSFER_PROTOCOL(m) => self.refuse_file(link, frame, m),
            _ => {}
        }
    }

    fn answer_timesync(&mut self, link: Link, frame: &Frame, m: &TIMESYNC_DATA) {
        // tc1 = 0 asks; anything else answers a question of ours.
        if m.tc1 == 0 {
            let now_ns = i64::try_from(self.clock).unwrap_or(i64::MAX).saturating_mul(1000);
            let answer = TIMESYNC_DATA {
                tc1: now_ns.max(1),
                ts1: m.ts1,
                target_system: frame.system_id,
                target_component: frame.component_id,
            };
            self.reply(link, frame, &MavMessage::TIMESYNC(answer));
        }
    }

    #[expect(deprecated, reason = "deprecated in MAVLink, still sent by ground stations")]
    fn answer_ping(&mut self, link: Link, frame: &Frame, m: &PING_DATA) {
        // Target 0, 0 asks; a target answers.
        if m.target_system == 0 && m.target_component == 0 {
            let answer = PING_DATA {
                time_usec: m.time_usec,
                seq: m.seq,
                target_system: frame.system_id,
                target_component: frame.component_id,
            };
            self.reply(link, frame, &MavMessage::PING(answer));
        }
    }

    fn parameters(&self) -> Parameters {
        Parameters::of(&self.autopilot, self.system_id)
    }

    fn send_all_parameters(&mut self, link: Link, frame: &Frame) {
        let parameters = self.parameters();
        for index in 0..parameters.len() {
            self.send_parameter(link, frame, &parameters, index);
        }
    }

    fn send_parameter(&mut self, link: Link, frame: &Frame, parameters: &Parameters, index: usize) {
        let Some((name, value)) = parameters.at(index) else { return };
        let (param_value, param_type) = match value {
            // Integers travel as their bytes.
            ParameterValue::Int(x) => (f32::from_bits(x as u32), MavParamType::MAV_PARAM_TYPE_INT32),
            ParameterValue::Real(x) => (x, MavParamType::MAV_PARAM_TYPE_REAL32),
        };
        let message = PARAM_VALUE_DATA {
            param_value,
            param_count: parameters.len() as u16,
            param_index: index as u16,
            param_id: name.into(),
            param_type,
        };
        self.reply(link, frame, &MavMessage::PARAM_VALUE(message));
    }

    fn answer_param_read(&mut self, link: Link, frame: &Frame, m: &PARAM_REQUEST_READ_DATA) {
        let parameters = self.parameters();
        let index = match usize::try_from(m.param_index) {
            Ok(index) => Some(index).filter(|&i| i < parameters.len()),
            Err(_) => m.param_id.to_str().ok().and_then(|name| parameters.index_of(name)),
        };
        match index {
            Some(index) => self.send_parameter(link, frame, &parameters, index),
            None => {
                let error = MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST;
                self.send_param_error(link, frame, m.param_id, m.param_index, error);
            }
        }
    }

    /// PARAM_SET, whatever its type: parameters are read-only; the value in effect is told again. `frame` is a PARAM_SET.
    pub(super) fn refuse_param_set(&mut self, link: Link, frame: &Frame) {
        let p = frame.payload();
        if !self.is_for_us(p.u8(4), p.u8(5)) {
            return;
        }
        let name = p.text::<16>(6);
        let parameters = self.parameters();
        let error = match parameters.index_of(&name) {
            Some(index) => {
                self.send_parameter(link, frame, &parameters, index);
                self.autopilot
                    .say(Severity::Warning, "parameters are read-only: gains come from the mission");
                MavParamError::MAV_PARAM_ERROR_READ_ONLY
            }
            None => MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST,
        };
        self.send_param_error(link, frame, name.as_str().into(), -1, error);
    }

    fn send_param_error(
        &mut self,
        link: Link,
        frame: &Frame,
        param_id: mavlink::types::CharArray<16>,
        param_index: i16,
        error: MavParamError,
    ) {
        let message = PARAM_ERROR_DATA {
            param_index,
            target_system: frame.system_id,
            target_component: frame.component_id,
            param_id,
            error,
        };
        self.reply(link, frame, &MavMessage::PARAM_ERROR(message));
    }

    fn ack_mission(&mut self, link: Link, frame: &Frame, kind: MavMissionType, result: MavMissionResult) {
        let ack = MISSION_ACK_DATA {
            target_system: frame.system_id,
            target_component: frame.component_id,
            mavtype: result,
            mission_type: kind,
            opaque_id: 0,
        };
        self.reply(link, frame, &MavMessage::MISSION_ACK(ack));
    }

    /// There is no file server: a NAK, "unknown command", to each request. Payload: sequence (2 bytes), session, opcode,
    /// size, requested opcode, burst flag, padding, offset (4), data.
    fn refuse_file(&mut self, link: Link, frame: &Frame, m: &FILE_TRANSFER_PROTOCOL_DATA) {
        const ACK: u8 = 128;
        const NAK: u8 = 129;
        const UNKNOWN_COMMAND: u8 = 7;
        let [low, high, session, opcode, ..] = m.payload;
        if opcode >= ACK {
            return;
        }
        let sequence = u16::from_le_bytes([low, high]).wrapping_add(1);
        let mut payload = [0; 251];
        payload[..2].copy_from_slice(&sequence.to_le_bytes());
        (payload[2], payload[3], payload[4], payload[5], payload[12]) =
            (session, NAK, 1, opcode, UNKNOWN_COMMAND);
        let answer = FILE_TRANSFER_PROTOCOL_DATA {
            target_network: 0,
            target_system: frame.system_id,
            target_component: frame.component_id,
            payload,
        };
        self.reply(link, frame, &MavMessage::FILE_TRANSFER_PROTOCOL(answer));
    }
}
