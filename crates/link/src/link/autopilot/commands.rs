//! COMMAND_LONG and COMMAND_INT: which part of the vehicle obeys each, and the one COMMAND_ACK that it gets.
//!
//! A NaN in a parameter means "not given". A command that this autopilot does not have is UNSUPPORTED,
//! numbers that mean nothing are DENIED.

use mavlink::MessageData as _;
use mavlink::dialects::common::*;
use num_traits::FromPrimitive as _;

use super::AutopilotSession;
use super::command_result::{CommandResult, whole};
use super::outbox::Peer;
use super::refusals::Missing;
use super::telemetry::available_modes;
use crate::autopilot::FlightMode;
use crate::link::frame::{Command, CommandAck};
use crate::link::hil::SIMULATOR_COMPONENT;
use crate::link::parachute::PARACHUTE_COMPONENT;

/// `GRIPPER_ACTION_RELEASE`.
const RELEASE: f32 = 0.0;

impl AutopilotSession {
    /// Obeys a command that is addressed to this autopilot, and answers its sender; leaves others alone.
    pub(super) fn handle_command(&mut self, peer: Peer, command: &Command) {
        if !self.is_for_us((command.target_system, command.target_component)) {
            return;
        }
        // Addressed to every component: the parachute's commands are the parachute's to answer.
        let known = MavCmd::from_u16(command.command);
        let of_parachute = matches!(known, Some(MavCmd::MAV_CMD_DO_PARACHUTE | MavCmd::MAV_CMD_DO_GRIPPER));
        if of_parachute && command.target_component == 0 {
            return;
        }
        let result = match known {
            Some(MavCmd::MAV_CMD_INJECT_FAILURE) if !self.vehicle.autopilot.settings.injects_failures => {
                let reason = "failure injection refused: SYS_FAILURE_EN is 0";
                CommandResult::Denied.because(&mut self.vehicle.autopilot, reason.to_owned())
            }
            Some(MavCmd::MAV_CMD_INJECT_FAILURE) => {
                match self.pass_on(peer, command, SIMULATOR_COMPONENT, "failure injection") {
                    Some(result) => result,
                    // The simulator's answer is passed on when it comes.
                    None => return,
                }
            }
            Some(MavCmd::MAV_CMD_DO_GRIPPER) => match self.release(peer, command) {
                Some(result) => result,
                // The parachute's answer is passed on when it comes.
                None => return,
            },
            Some(known) => self.obey(peer, known, command),
            None => CommandResult::Unsupported,
        };
        let ack = CommandAck::new(command, result as u8, (peer.system, peer.component));
        self.outbox.reply_command_ack(peer, &ack);
    }

    /// Passes a command on to a component at the simulator's end, whose answer goes back when it comes;
    /// `Some`: it is answered at once.
    fn pass_on(&mut self, peer: Peer, command: &Command, to: u8, what: &str) -> Option<CommandResult> {
        let target = (self.system_id(), to);
        let reason = if !self.clock.is_running() {
            "no simulator"
        } else if !self.relay.pass_on(Some(peer), command, target, &mut self.outbox) {
            "too many at once"
        } else {
            return None;
        };
        let reason = format!("{what} refused: {reason}");
        Some(CommandResult::TemporarilyRejected.because(&mut self.vehicle.autopilot, reason))
    }

    /// DO_GRIPPER as ground stations give it, to the autopilot: the gripper is the parachute, and can only
    /// release (parameter 2: 0).
    fn release(&mut self, peer: Peer, command: &Command) -> Option<CommandResult> {
        if command.param(2) == Some(RELEASE) {
            return self.pass_on(peer, command, PARACHUTE_COMPONENT, "release");
        }
        let reason = "gripper refused: it can only release";
        Some(CommandResult::Denied.because(&mut self.vehicle.autopilot, reason))
    }

    #[expect(deprecated, reason = "some are deprecated in MAVLink, still sent by ground stations")]
    fn obey(&mut self, peer: Peer, known: MavCmd, command: &Command) -> CommandResult {
        let (now, vehicle) = (self.clock.now(), &mut self.vehicle);
        match known {
            MavCmd::MAV_CMD_DO_SET_MODE => vehicle.set_mode(now, command),
            MavCmd::MAV_CMD_DO_SET_STANDARD_MODE => vehicle.set_standard_mode(now, command),
            MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => vehicle.arm_or_disarm(now, command),
            MavCmd::MAV_CMD_NAV_TAKEOFF => vehicle.take_off(now, command),
            MavCmd::MAV_CMD_NAV_LAND => vehicle.enter(now, FlightMode::AutoLand),
            MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH => vehicle.enter(now, FlightMode::AutoRtl),
            MavCmd::MAV_CMD_DO_REPOSITION => vehicle.reposition(now, command),
            MavCmd::MAV_CMD_DO_CHANGE_SPEED => vehicle.change_speed(command),
            MavCmd::MAV_CMD_DO_SET_HOME => vehicle.set_home(command),
            MavCmd::MAV_CMD_REQUEST_MESSAGE => self.send_requested(peer, command),
            MavCmd::MAV_CMD_GET_HOME_POSITION => self.send_message(peer, HOME_POSITION_DATA::ID),
            MavCmd::MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES => {
                self.send_message(peer, AUTOPILOT_VERSION_DATA::ID)
            }
            MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL => self.streams.of(peer.link).set_interval(command),
            MavCmd::MAV_CMD_GET_MESSAGE_INTERVAL => self.send_interval(peer, command),
            MavCmd::MAV_CMD_PREFLIGHT_STORAGE => {
                let gravity_m_s2 = vehicle.environment.gravity_m_s2;
                self.parameters.store(command, gravity_m_s2, &mut vehicle.autopilot, &mut self.outbox)
            }
            MavCmd::MAV_CMD_MISSION_START => self.start_mission(now, command),
            MavCmd::MAV_CMD_DO_SET_MISSION_CURRENT => self.set_mission_item(command),
            MavCmd::MAV_CMD_DO_PAUSE_CONTINUE => self.pause_or_continue(now, command),
            MavCmd::MAV_CMD_DO_PARACHUTE => {
                let reason = "the parachute is component 161: command that";
                CommandResult::Unsupported.because(&mut vehicle.autopilot, reason)
            }
            _ => {
                if let Some(missing) = Missing::of_command(known) {
                    self.refusals.say(missing, &mut vehicle.autopilot);
                }
                CommandResult::Unsupported
            }
        }
    }

    /// REQUEST_MESSAGE: parameter 1 the message; AVAILABLE_MODES has an index in parameter 2.
    fn send_requested(&mut self, peer: Peer, command: &Command) -> CommandResult {
        match command.param(1).and_then(whole) {
            Some(AVAILABLE_MODES_DATA::ID) => {
                let Some(index) = command.param(2).map_or(Some(0), whole) else {
                    return CommandResult::Denied;
                };
                let sent = available_modes(index).map(|message| self.outbox.reply(peer, &message)).count();
                CommandResult::Denied.unless(sent > 0)
            }
            Some(message_id) => self.send_message(peer, message_id),
            None => CommandResult::Denied,
        }
    }

    fn send_message(&mut self, peer: Peer, message_id: u32) -> CommandResult {
        let message = self.telemetry().message(message_id);
        if let Some(message) = &message {
            self.outbox.reply(peer, message);
        }
        CommandResult::Denied.unless(message.is_some())
    }

    /// GET_MESSAGE_INTERVAL: parameter 1 the message.
    fn send_interval(&mut self, peer: Peer, command: &Command) -> CommandResult {
        let message_id = command.param(1).and_then(whole).and_then(|id| u16::try_from(id).ok());
        let Some(message_id) = message_id else { return CommandResult::Denied };
        let interval_us = self.streams.of(peer.link).interval_us(message_id);
        let message = MESSAGE_INTERVAL_DATA { interval_us, message_id };
        self.outbox.reply(peer, &MavMessage::MESSAGE_INTERVAL(message));
        CommandResult::Accepted
    }
}
