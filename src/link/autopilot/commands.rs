//! COMMAND_LONG and COMMAND_INT: what each does, and the one COMMAND_ACK it gets.
//!
//! A NaN in a parameter means "not given". A command that this autopilot does not have is UNSUPPORTED, numbers that mean nothing
//! are DENIED. A mode that PX4 knows but that is not entered is TEMPORARILY_REJECTED, for whatever reason, and the reason is
//! said: that is PX4's answer to each DO_SET_MODE that it does not follow, an unknown kind of AUTO included. (A main mode that it
//! does not know it accepts and ignores; that is not copied.)

use super::super::frame::Command;
use super::super::{CommandAck, Frame, Link};
use super::missions::Kind;
use super::streams::{Interval, id};
use super::{AutopilotSession, Peer};
use crate::autopilot::{FlightMode, Severity};

/// Result of a command (`MAV_RESULT`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Outcome {
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
    pub const DO_CHANGE_SPEED: u16 = 178;
    pub const DO_SET_HOME: u16 = 179;
    pub const DO_REPOSITION: u16 = 192;
    pub const DO_PARACHUTE: u16 = 208;
    pub const DO_GRIPPER: u16 = 211;
    pub const DO_SET_MISSION_CURRENT: u16 = 224;
    pub const PREFLIGHT_STORAGE: u16 = 245;
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
        let peer = Peer::of(link, frame);
        let outcome = self.obey(peer, command);
        let ack = CommandAck {
            command: command.command,
            result: outcome as u8,
            target_system: frame.system_id,
            target_component: frame.component_id,
            ..CommandAck::default()
        };
        self.reply_command_ack(peer, &ack);
    }

    fn obey(&mut self, peer: Peer, command: &Command) -> Outcome {
        match command.command {
            cmd::DO_SET_MODE => self.obey_set_mode(command),
            cmd::COMPONENT_ARM_DISARM => self.obey_arm(command),
            cmd::REQUEST_MESSAGE => self.obey_request_message(peer, command),
            cmd::GET_HOME_POSITION => self.obey_request(peer, Some(id::HOME_POSITION)),
            cmd::REQUEST_AUTOPILOT_CAPABILITIES => self.obey_request(peer, Some(id::AUTOPILOT_VERSION)),
            cmd::SET_MESSAGE_INTERVAL => self.obey_set_interval(peer, command),
            cmd::GET_MESSAGE_INTERVAL => self.obey_get_interval(peer, command),
            cmd::NAV_TAKEOFF => self.obey_takeoff(command),
            cmd::NAV_LAND => self.enter(FlightMode::AutoLand),
            cmd::NAV_RETURN_TO_LAUNCH => self.enter(FlightMode::AutoRtl),
            cmd::DO_REPOSITION => self.obey_reposition(command),
            cmd::DO_CHANGE_SPEED => self.obey_change_speed(command),
            cmd::DO_SET_HOME => self.obey_set_home(command),
            cmd::MISSION_START => self.refuse_mission_start(),
            cmd::DO_SET_MISSION_CURRENT => self.obey_set_mission_current(command),
            cmd::PREFLIGHT_STORAGE => self.obey_storage(command),
            cmd::DO_GRIPPER | cmd::DO_PARACHUTE => {
                self.not_flown("the parachute is component 161: command that")
            }
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
        match (main, sub) {
            (Some(main), Some(sub)) if base_mode & 1 == 1 => self.enter_mode(main, sub),
            _ => self.no_such_mode(),
        }
    }

    /// SET_MODE, the message; it gets no acknowledgement, a refusal is said.
    pub(super) fn handle_set_mode(&mut self, target_system: u8, custom_mode: u32) {
        if self.is_for_us(target_system, 0) {
            match custom_mode.to_le_bytes() {
                [0, 0, main, sub] => self.enter_mode(main, sub),
                _ => self.no_such_mode(),
            };
        }
    }

    fn enter_mode(&mut self, main: u8, sub: u8) -> Outcome {
        match FlightMode::from_numbers(main, sub) {
            Some(mode) => self.enter(mode),
            None if main == FlightMode::AutoLoiter.main_number() => {
                self.autopilot.say(Severity::Error, "mode refused: unsupported auto mode");
                Outcome::TemporarilyRejected
            }
            None => self.no_such_mode(),
        }
    }

    fn no_such_mode(&mut self) -> Outcome {
        self.autopilot.say(Severity::Error, "mode refused: no such mode");
        Outcome::Denied
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

    fn refuse_mission_start(&mut self) -> Outcome {
        let text = match self.missions.plan(Kind::Mission).len() {
            0 => "there is no mission to start",
            _ => "the mission is kept and not flown",
        };
        self.not_flown(text)
    }

    fn obey_set_mission_current(&mut self, command: &Command) -> Outcome {
        let seq = command.param(1).and_then(whole).and_then(|seq| u16::try_from(seq).ok());
        match seq {
            Some(seq) if self.missions.set_current(seq) => Outcome::Accepted,
            _ => Outcome::Denied,
        }
    }

    /// Parameter 1: 1 keep the parameters, 2 back to those of the start. Not in flight, as in PX4.
    fn obey_storage(&mut self, command: &Command) -> Outcome {
        if self.autopilot.is_armed() {
            self.autopilot.say(Severity::Error, "parameters are stored and reset only while disarmed");
            return Outcome::TemporarilyRejected;
        }
        match command.param(1) {
            Some(1.0) if self.keeps_parameters => {
                self.saved_parameters = Some(self.parameter_file());
                Outcome::Accepted
            }
            Some(1.0) => {
                self.autopilot
                    .say(Severity::Error, "parameters are not stored: there is no folder for results");
                Outcome::Denied
            }
            Some(2.0) => {
                self.reset_parameters();
                Outcome::Accepted
            }
            _ => Outcome::Unsupported,
        }
    }

    fn obey_request_message(&mut self, peer: Peer, command: &Command) -> Outcome {
        let message_id = command.param(1).and_then(whole);
        if message_id != Some(id::AVAILABLE_MODES) {
            return self.obey_request(peer, message_id);
        }
        let sent =
            command.param(2).map_or(Some(0), whole).is_some_and(|i| self.send_available_modes(peer, i));
        if sent { Outcome::Accepted } else { Outcome::Denied }
    }

    fn obey_request(&mut self, peer: Peer, message_id: Option<u32>) -> Outcome {
        match message_id.and_then(|message_id| self.telemetry().message(message_id)) {
            Some(message) => {
                self.reply(peer, &message);
                Outcome::Accepted
            }
            None => Outcome::Denied,
        }
    }

    fn obey_set_interval(&mut self, peer: Peer, command: &Command) -> Outcome {
        let interval = match command.param(2) {
            Some(0.0) => Interval::Default,
            Some(-1.0) => Interval::Off,
            Some(us) if us >= 1.0 && us.is_finite() => Interval::Every(us as u64),
            _ => return Outcome::Denied,
        };
        match command.param(1).and_then(whole) {
            Some(message_id) if self.port(peer.link).schedule.set(message_id, interval) => Outcome::Accepted,
            _ => Outcome::Denied,
        }
    }

    fn obey_get_interval(&mut self, peer: Peer, command: &Command) -> Outcome {
        let Some(message_id) = command.param(1).and_then(whole).and_then(|x| u16::try_from(x).ok()) else {
            return Outcome::Denied;
        };
        let interval_us = self.port(peer.link).schedule.interval_us(u32::from(message_id));
        self.reply_message_interval(peer, message_id, interval_us);
        Outcome::Accepted
    }
}

/// A parameter that must be a whole number, as the wire's floats hold it.
fn whole(x: f32) -> Option<u32> {
    (x >= 0.0 && x.fract() == 0.0 && x < 16_777_216.0).then_some(x as u32)
}
