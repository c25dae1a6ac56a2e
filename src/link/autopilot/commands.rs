//! COMMAND_LONG and COMMAND_INT: what each does, and the one COMMAND_ACK it gets.
//!
//! A NaN in a parameter means "not given". What this autopilot does not know is UNSUPPORTED; what it knows and will not
//! do now is TEMPORARILY_REJECTED, and never DENIED or ACCEPTED instead.

use mavlink::dialects::common::{MESSAGE_INTERVAL_DATA, MavMessage};

use super::super::frame::Command;
use super::super::{CommandAck, Frame, Link};
use super::AutopilotSession;
use super::streams::{Interval, id};
use crate::autopilot::{FlightMode, ModeRefusal, Severity};

/// Result of a command (`MAV_RESULT`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
enum Outcome {
    Accepted = 0,
    TemporarilyRejected = 1,
    Denied = 2,
    Unsupported = 3,
}

/// Command numbers (`MAV_CMD`).
mod cmd {
    pub const NAV_RETURN_TO_LAUNCH: u16 = 20;
    pub const NAV_LAND: u16 = 21;
    pub const NAV_TAKEOFF: u16 = 22;
    pub const DO_SET_MODE: u16 = 176;
    pub const DO_REPOSITION: u16 = 192;
    pub const DO_PARACHUTE: u16 = 208;
    pub const DO_GRIPPER: u16 = 211;
    pub const MISSION_START: u16 = 300;
    pub const COMPONENT_ARM_DISARM: u16 = 400;
    pub const GET_HOME_POSITION: u16 = 410;
    pub const GET_MESSAGE_INTERVAL: u16 = 510;
    pub const SET_MESSAGE_INTERVAL: u16 = 511;
    pub const REQUEST_MESSAGE: u16 = 512;
    pub const REQUEST_AUTOPILOT_CAPABILITIES: u16 = 520;
}

/// Parameter 2 of COMPONENT_ARM_DISARM that skips the checks.
const FORCE: f32 = 21196.0;

impl AutopilotSession {
    /// Obeys a command that is addressed to this autopilot, and answers its sender; leaves others alone.
    pub(super) fn handle_command(&mut self, link: Link, frame: &Frame, command: &Command) {
        if !self.is_for_us(command.target_system, command.target_component) {
            return;
        }
        // Addressed to every component: the parachute's commands are the parachute's to answer.
        let of_parachute = matches!(command.command, cmd::DO_PARACHUTE | cmd::DO_GRIPPER);
        if of_parachute && command.target_component == 0 {
            return;
        }
        let outcome = self.obey(link, frame, command);
        let ack = CommandAck {
            command: command.command,
            result: outcome as u8,
            target_system: frame.system_id,
            target_component: frame.component_id,
            ..CommandAck::default()
        };
        self.send_command_ack(link, frame.peer, &ack);
    }

    fn obey(&mut self, link: Link, frame: &Frame, command: &Command) -> Outcome {
        match command.command {
            cmd::DO_SET_MODE => self.obey_set_mode(command),
            cmd::COMPONENT_ARM_DISARM => self.obey_arm(command),
            cmd::REQUEST_MESSAGE => self.obey_request(link, frame, command.param(1).and_then(whole)),
            cmd::GET_HOME_POSITION => self.obey_request(link, frame, Some(id::HOME_POSITION)),
            cmd::REQUEST_AUTOPILOT_CAPABILITIES => {
                self.obey_request(link, frame, Some(id::AUTOPILOT_VERSION))
            }
            cmd::SET_MESSAGE_INTERVAL => self.obey_set_interval(link, command),
            cmd::GET_MESSAGE_INTERVAL => self.obey_get_interval(link, frame, command),
            cmd::NAV_TAKEOFF => self.not_flown("TAKEOFF is not flown here, only OFFBOARD and HOLD"),
            cmd::NAV_LAND => self.not_flown("LAND is not flown here, only OFFBOARD and HOLD"),
            cmd::NAV_RETURN_TO_LAUNCH => self.not_flown("RETURN is not flown here, only OFFBOARD and HOLD"),
            cmd::DO_REPOSITION => self.not_flown("REPOSITION is not flown: no position control"),
            cmd::MISSION_START => self.not_flown("there is no mission to start"),
            _ => Outcome::Unsupported,
        }
    }

    fn not_flown(&mut self, text: &'static str) -> Outcome {
        self.autopilot.say(Severity::Error, text);
        Outcome::Unsupported
    }

    fn obey_set_mode(&mut self, command: &Command) -> Outcome {
        // Parameter 1 holds base mode flags; bit 0 says that parameters 2 and 3 count.
        let base_mode = command.param(1).and_then(whole).unwrap_or(1);
        let main = command.param(2).and_then(whole).and_then(|x| u8::try_from(x).ok());
        let sub = u8::try_from(command.param(3).and_then(whole).unwrap_or(0)).ok();
        let mode = match (main, sub) {
            (Some(main), Some(sub)) if base_mode & 1 == 1 => FlightMode::from_numbers(main, sub),
            _ => None,
        };
        self.enter_mode(mode)
    }

    /// SET_MODE, the message; it gets no acknowledgement, a refusal is said.
    pub(super) fn handle_set_mode(&mut self, target_system: u8, custom_mode: u32) {
        if self.is_for_us(target_system, 0) {
            self.enter_mode(FlightMode::from_custom_mode(custom_mode));
        }
    }

    fn enter_mode(&mut self, mode: Option<FlightMode>) -> Outcome {
        let Some(mode) = mode else {
            self.autopilot.say(Severity::Error, "mode refused: no such mode");
            return Outcome::Denied;
        };
        match self.autopilot.request_mode(self.clock, mode) {
            Ok(()) => Outcome::Accepted,
            Err(ModeRefusal::NotFlown(_)) => Outcome::Denied,
            Err(ModeRefusal::NoSetpoint) => Outcome::TemporarilyRejected,
        }
    }

    fn obey_arm(&mut self, command: &Command) -> Outcome {
        let force = command.param(2) == Some(FORCE);
        let done = match command.param(1) {
            Some(1.0) => self.autopilot.arm(self.clock, force).is_ok(),
            Some(0.0) => self.autopilot.disarm(force).is_ok(),
            _ => {
                self.autopilot.say(Severity::Error, "arm/disarm refused: parameter 1 must be 0 or 1");
                return Outcome::Denied;
            }
        };
        if done { Outcome::Accepted } else { Outcome::TemporarilyRejected }
    }

    fn obey_request(&mut self, link: Link, frame: &Frame, message_id: Option<u32>) -> Outcome {
        match message_id.and_then(|message_id| self.telemetry().message(message_id)) {
            Some(message) => {
                self.reply(link, frame, &message);
                Outcome::Accepted
            }
            None => Outcome::Denied,
        }
    }

    fn obey_set_interval(&mut self, link: Link, command: &Command) -> Outcome {
        let interval = match command.param(2) {
            Some(0.0) => Interval::Default,
            Some(-1.0) => Interval::Off,
            Some(us) if us >= 1.0 && us.is_finite() => Interval::Every(us as u64),
            _ => return Outcome::Denied,
        };
        match command.param(1).and_then(whole) {
            Some(message_id) if self.port(link).schedule.set(message_id, interval) => Outcome::Accepted,
            _ => Outcome::Denied,
        }
    }

    fn obey_get_interval(&mut self, link: Link, frame: &Frame, command: &Command) -> Outcome {
        let Some(message_id) = command.param(1).and_then(whole).and_then(|x| u16::try_from(x).ok()) else {
            return Outcome::Denied;
        };
        let interval_us = self.port(link).schedule.interval_us(u32::from(message_id));
        let message = MESSAGE_INTERVAL_DATA { interval_us, message_id };
        self.reply(link, frame, &MavMessage::MESSAGE_INTERVAL(message));
        Outcome::Accepted
    }
}

/// A parameter that must be a whole number, as the wire's floats hold it.
fn whole(x: f32) -> Option<u32> {
    (x >= 0.0 && x.fract() == 0.0 && x < 16_777_216.0).then_some(x as u32)
}
