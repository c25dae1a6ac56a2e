//! The mission on the wire: handed over to the autopilot, started, paused and gone on with by command, the
//! commands of its items, and what peers are told of it.
//!
//! | command | parameters that count |
//! |---|---|
//! | MISSION_START | 1: the item to begin with, -1 the current one; arms |
//! | DO_SET_MISSION_CURRENT | 1: the item |
//! | DO_PAUSE_CONTINUE | 1: 0 pauses in HOLD, 1 goes on with the mission |
//!
//! (PX4 v1.14 has neither DO_SET_MISSION_CURRENT nor DO_PAUSE_CONTINUE: stations send MISSION_SET_CURRENT,
//! and change the mode.)

use mavlink::MessageData as _;
use mavlink::dialects::common::*;

use super::AutopilotSession;
use super::command_result::{CommandResult, whole};
use crate::autopilot::FlightMode;
use crate::autopilot::missions::Item;
use crate::link::frame::Command;
use crate::link::parachute::PARACHUTE_COMPONENT;
use crate::time::TimeUs;

impl AutopilotSession {
    /// Lets the autopilot know of a new mission, and of the item that a peer wants to be the current one.
    pub(super) fn hand_over_mission(&mut self) {
        let autopilot = &mut self.vehicle.autopilot;
        if let Some((items, start)) = self.missions.take_new_mission() {
            autopilot.load_mission(&items, start, &self.vehicle.environment);
        }
        if let Some(seq) = self.missions.take_wanted_item() {
            autopilot.mission_mut().set_current(seq);
        }
        self.missions.note_current(autopilot.mission().current());
    }

    /// MISSION_START, as PX4's commander has it (Commander.cpp of v1.14): DENIED without a mission and for an
    /// item that there is not, TEMPORARILY_REJECTED where mode or arming is refused.
    pub(super) fn start_mission(&mut self, now: TimeUs, command: &Command) -> CommandResult {
        let autopilot = &mut self.vehicle.autopilot;
        if !autopilot.mission().is_feasible() {
            return CommandResult::Denied.because(autopilot, "Mission start denied! No valid mission");
        }
        let first = match command.param(1) {
            Some(-1.0) => None,
            Some(first) => match whole(first).and_then(|first| u16::try_from(first).ok()) {
                Some(seq) if usize::from(seq) < autopilot.mission().len() => Some(seq),
                _ => return CommandResult::Denied.because(autopilot, "Mission start denied! No such item"),
            },
            None => return CommandResult::Denied.because(autopilot, "Mission start denied! No such item"),
        };
        if self.vehicle.enter(now, FlightMode::AutoMission) != CommandResult::Accepted {
            return CommandResult::TemporarilyRejected;
        }
        // Before arming puts the motors on.
        if let Some(seq) = first {
            self.vehicle.autopilot.mission_mut().set_current(seq);
        }
        self.missions.note_current(self.vehicle.autopilot.mission().current());
        CommandResult::TemporarilyRejected.unless(self.vehicle.autopilot.arm(now, false).is_ok())
    }

    /// DO_SET_MISSION_CURRENT.
    pub(super) fn set_mission_item(&mut self, command: &Command) -> CommandResult {
        let seq = command.param(1).and_then(whole).and_then(|seq| u16::try_from(seq).ok());
        let known = seq.is_some_and(|seq| self.missions.set_current(seq));
        self.send_answers();
        CommandResult::Denied.unless(known)
    }

    /// DO_PAUSE_CONTINUE.
    pub(super) fn pause_or_continue(&mut self, now: TimeUs, command: &Command) -> CommandResult {
        match command.param(1) {
            Some(0.0) => self.vehicle.enter(now, FlightMode::AutoLoiter),
            Some(1.0) => self.vehicle.enter(now, FlightMode::AutoMission),
            _ => CommandResult::Denied
                .because(&mut self.vehicle.autopilot, "pause/continue refused: parameter 1 must be 0 or 1"),
        }
    }

    /// Has the command of the mission's current item obeyed, and tells peers what has changed.
    pub(super) fn follow_mission(&mut self, now: TimeUs) {
        if let Some(item) = self.vehicle.autopilot.mission_mut().take_command() {
            self.obey_item(&item);
        }
        let mission = self.vehicle.autopilot.mission();
        self.missions.note_current(mission.current());
        if self.reports.take_change(mission)
            && let Some(message) = self.telemetry().message(MISSION_CURRENT_DATA::ID)
        {
            self.outbox.broadcast(&message);
        }
        if let Some(message) = self.reports.take_reached(now, self.vehicle.autopilot.mission()) {
            self.outbox.broadcast(&message);
        }
    }

    /// Obeys the command of a mission item, or passes it on.
    fn obey_item(&mut self, item: &Item) {
        let [first, second, third, fourth] = item.params;
        let params = [first, second, third, fourth, item.x as f32, item.y as f32, item.z];
        let command = Command { command: item.command, params, ..Command::default() };
        if command.command == MavCmd::MAV_CMD_DO_SET_HOME as u16 {
            self.vehicle.set_home(&command);
        } else {
            let target = (self.system_id(), PARACHUTE_COMPONENT);
            self.relay.pass_on(None, &command, target, &mut self.outbox);
        }
    }
}
