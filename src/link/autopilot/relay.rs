//! MAV_CMD_INJECT_FAILURE to the autopilot, passed on to the simulator, whose answer goes back to who gave
//! the command: what fails is the simulator's to say.
//!
//! (PX4 keeps what is sent to it, and changes what its own drivers and its own simulator's sensors report.)

use std::collections::VecDeque;

use mavlink::dialects::common::*;

use super::outbox::{Outbox, Peer};
use crate::autopilot::{Autopilot, Severity};
use crate::link::frame::{Command, CommandAck};
use crate::link::hil::SIMULATOR_COMPONENT;
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
    peer: Peer,
    command: Command,
    since: TimeUs,
}

impl Relay {
    /// Passes a command on to the simulator of the vehicle of `system_id`; `false`: too many wait already.
    pub(super) fn pass_on(
        &mut self,
        peer: Peer,
        command: &Command,
        system_id: u8,
        outbox: &mut Outbox,
    ) -> bool {
        if self.waiting.len() >= MOST {
            return false;
        }
        let [param1, param2, param3, param4, ..] = command.params;
        let passed = COMMAND_LONG_DATA {
            command: MavCmd::MAV_CMD_INJECT_FAILURE,
            param1,
            param2,
            param3,
            param4,
            target_system: system_id,
            target_component: SIMULATOR_COMPONENT,
            ..COMMAND_LONG_DATA::DEFAULT
        };
        outbox.send(Link::Simulator, &MavMessage::COMMAND_LONG(passed));
        self.waiting.push_back(Waiting { peer, command: *command, since: self.now });
        true
    }

    /// Takes an answer of the simulator: that to the oldest command that was passed on goes back.
    pub(super) fn take(&mut self, ack: &CommandAck, autopilot: &mut Autopilot, outbox: &mut Outbox) {
        if ack.command != INJECT_FAILURE {
            return;
        }
        let Some(waiting) = self.waiting.pop_front() else { return };
        if ack.result == MavResult::MAV_RESULT_ACCEPTED as u8 {
            autopilot.say(Severity::Warning, format!("failure injected: {}", words(&waiting.command)));
            if let Some((motor, is_off)) = motor_off(&waiting.command) {
                autopilot.note_motor_off(motor, is_off);
            }
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
        let ack = CommandAck::new(&self.command, result, (self.peer.system, self.peer.component));
        outbox.reply_command_ack(self.peer, &ack);
    }
}
