//! Commands to the autopilot that others obey, passed on to the simulator's end: MAV_CMD_INJECT_FAILURE,
//! since what fails is the simulator's to say, and MAV_CMD_DO_GRIPPER, by a peer or by a mission's item,
//! which is the parachute's. The answer goes back to who gave the command, or to the mission.
//!
//! (PX4 keeps both: it changes what its own drivers and its own simulator's sensors report, and has a gripper
//! of its own.)

use std::collections::VecDeque;

use mavlink::dialects::common::*;
use num_traits::FromPrimitive as _;

use super::outbox::{Outbox, Peer};
use crate::autopilot::{Autopilot, Severity};
use crate::link::frame::{Command, CommandAck};
use crate::link::injection::{INJECT_FAILURE, motor_off, words};
use crate::link::session::Link;
use crate::time::TimeUs;

/// Most commands whose answers are waited for.
const MOST: usize = 16;
/// A simulator that has not answered after so long, by the host's time, does not.
const PATIENCE_US: TimeUs = 1_000_000;

/// Commands that have been passed on, the oldest first.
#[derive(Clone, Debug, Default)]
pub(super) struct Relay {
    waiting: VecDeque<Waiting>,
    now: TimeUs,
}

#[derive(Clone, Debug)]
struct Waiting {
    /// The peer that gave the command; `None`: an item of the mission.
    peer: Option<Peer>,
    command: Command,
    since: TimeUs,
}

impl Relay {
    /// Passes a command of a peer, or of the mission, on to a component (system and component) at the
    /// simulator's end; `false`: too many wait already.
    pub(super) fn pass_on(
        &mut self,
        peer: Option<Peer>,
        command: &Command,
        target: (u8, u8),
        outbox: &mut Outbox,
    ) -> bool {
        if self.waiting.len() >= MOST {
            return false;
        }
        let [param1, param2, param3, param4, ..] = command.params;
        let Some(number) = MavCmd::from_u16(command.command) else { return false };
        let passed = COMMAND_LONG_DATA {
            command: number,
            param1,
            param2,
            param3,
            param4,
            target_system: target.0,
            target_component: target.1,
            ..COMMAND_LONG_DATA::DEFAULT
        };
        outbox.send(Link::Simulator, &MavMessage::COMMAND_LONG(passed));
        self.waiting.push_back(Waiting { peer, command: *command, since: self.now });
        true
    }

    /// Takes an answer from the simulator's end: that to the oldest command of its number that was passed on
    /// goes back.
    pub(super) fn take(&mut self, ack: &CommandAck, autopilot: &mut Autopilot, outbox: &mut Outbox) {
        let oldest = self.waiting.iter().position(|waiting| waiting.command.command == ack.command);
        let Some(waiting) = oldest.and_then(|i| self.waiting.remove(i)) else { return };
        let accepted = ack.result == MavResult::MAV_RESULT_ACCEPTED as u8;
        if accepted && ack.command == INJECT_FAILURE {
            autopilot.say(Severity::Warning, format!("failure injected: {}", words(&waiting.command)));
            if let Some((motor, is_off)) = motor_off(&waiting.command) {
                autopilot.health.withhold_reports(motor, is_off);
            }
        } else if accepted && waiting.peer.is_none() {
            autopilot.mission_mut().acknowledge_release();
        }
        waiting.answer(ack.result, outbox);
    }

    /// The host's time has come to `now`: commands that were not answered in time have failed.
    pub(super) fn handle_time(&mut self, now: TimeUs, outbox: &mut Outbox) {
        self.now = now;
        while let Some(waiting) = self.waiting.front()
            && now.saturating_sub(waiting.since) >= PATIENCE_US
        {
            waiting.answer(MavResult::MAV_RESULT_FAILED as u8, outbox);
            self.waiting.pop_front();
        }
    }

    /// The simulator has gone: nothing is answered any more.
    pub(super) fn forget(&mut self, outbox: &mut Outbox) {
        for waiting in self.waiting.drain(..) {
            waiting.answer(MavResult::MAV_RESULT_FAILED as u8, outbox);
        }
    }
}

impl Waiting {
    fn answer(&self, result: u8, outbox: &mut Outbox) {
        let Some(peer) = self.peer else { return };
        let ack = CommandAck::new(&self.command, result, (peer.system, peer.component));
        outbox.reply_command_ack(peer, &ack);
    }
}
