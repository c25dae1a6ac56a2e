//! Messages of the autopilot: on the simulator link, and its HEARTBEAT also on the parachute's socket.
//!
//! PX4 says on the simulator link that it is armed (HIL_ACTUATOR_CONTROLS) but not in which mode: it sends
//! one HEARTBEAT there, at the start, with no mode in it. A router that brings its HEARTBEAT to the
//! parachute's socket makes up for that.

use mavlink::dialects::common::*;

use super::super::autopilot::COMMANDED;
use super::super::frame::{Command, CommandAck, Frame};
use super::super::injection::{INJECT_FAILURE, orders};
use super::super::parachute::PARACHUTE_COMPONENT;
use super::{FIRST_REPORT, HilCounts, HilEvent, HilSession, Pace, SIMULATOR_COMPONENT, Stamps};
use crate::autopilot::FlightMode;
use crate::model::{MAX_ROTORS, PerRotor};
use crate::params::file::AUTOPILOT_COMPONENT;
use crate::sim::ReleaseCause;
use crate::time::TimeUs;

impl HilSession {
    pub(super) fn take_from_autopilot(&mut self, frame: &Frame) {
        if !std::mem::replace(&mut self.peer.heard, true)
            && self.is_in_real_time()
            && self.pace == Pace::AwaitingControls
        {
            self.pace = Pace::Free;
            self.peer.answered_at = self.host_time();
        }
        match frame.known() {
            Some(MavMessage::HIL_ACTUATOR_CONTROLS(m)) => self.take_controls(m),
            Some(MavMessage::HEARTBEAT(m)) => {
                self.peer.mode_on_link |= m.custom_mode != 0;
                self.take_heartbeat(m);
            }
            Some(MavMessage::PARAM_VALUE(m)) => {
                if let Some(board) = &mut self.board {
                    board.take(m);
                }
            }
            Some(MavMessage::STATUSTEXT(m)) if !matches!(self.pace, Pace::NoPeer | Pace::Done) => {
                for text in self.texts.take((frame.system_id, frame.component_id), m) {
                    if let Some(words) = text.strip_prefix(COMMANDED) {
                        self.run.note_command(words);
                    }
                }
            }
            _ => {
                if let Some(command) = frame.command() {
                    self.take_command(&command, (frame.system_id, frame.component_id));
                }
            }
        }
    }

    /// Everybody may send to the parachute's socket; of the autopilot, while it is connected, its HEARTBEAT
    /// counts; of a companion that is waited for, that it is there, and its setpoints.
    pub(super) fn take_from_outside(&mut self, frame: &Frame) {
        if frame.system_id != self.config.system_id {
            self.take_from_companion(frame);
        }
        let from_autopilot =
            (frame.system_id, frame.component_id) == (self.config.system_id, AUTOPILOT_COMPONENT);
        if from_autopilot
            && !matches!(self.pace, Pace::NoPeer | Pace::Done)
            && !self.peer.mode_on_link
            && let Some(MavMessage::HEARTBEAT(m)) = frame.known()
        {
            self.take_heartbeat(m);
        }
    }

    fn take_from_companion(&mut self, frame: &Frame) {
        let (now, froude) = (self.now(), self.config.froude);
        if let Some(companion) = &mut self.companion
            && companion.take(frame, now, froude)
        {
            let starts = companion.starts();
            self.report(if starts { HilEvent::CompanionHeard } else { HilEvent::CompanionStreams });
        }
    }

    fn take_controls(&mut self, m: &HIL_ACTUATOR_CONTROLS_DATA) {
        let stamp = self.config.froude.map_or(m.time_usec, |f| f.site_us(m.time_usec));
        let now = self.now();
        if self.is_in_real_time() {
            self.note_clock(stamp);
        } else if now == 0 || stamp > now {
            self.counts.mistimed += 1;
            // One report at the 1st, 2nd, 4th, 8th .. of them.
            if self.counts.mistimed.is_power_of_two() {
                self.report(HilEvent::Mistimed(stamp));
            }
            return;
        }
        let armed = m.mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
        self.run.set_armed(armed);
        self.report_drop();
        let n_rotors = self.run.simulation().vehicle().rotors.len();
        let throttle = throttle_of(m, n_rotors, &mut self.counts);
        self.peer.turned = armed && (self.peer.turned || throttle.iter().any(|&u| u > 0.0));
        self.run.set_throttle(throttle);
        if !std::mem::replace(&mut self.peer.answered, true) {
            self.report(if self.is_in_real_time() { HilEvent::RealTime } else { HilEvent::Lockstep });
        }
        if self.is_in_real_time() {
            return;
        }
        if stamp == now {
            if matches!(self.pace, Pace::Free | Pace::AwaitingControls) {
                self.pace = Pace::Ready;
            }
        } else {
            self.counts.mistimed += 1;
            if self.pace == Pace::Free {
                self.pace = Pace::AwaitingControls;
            }
        }
    }

    /// An autopilot with a clock of its own has answered, by that at `stamp`.
    fn note_clock(&mut self, stamp: TimeUs) {
        let ahead_us = stamp as i64 - self.now() as i64;
        // What came soonest shows best how far it is ahead.
        let ahead_us = self.peer.ahead_us.map_or(ahead_us, |before| before.max(ahead_us));
        self.peer.ahead_us = Some(ahead_us);
        if self.config.real_time == Some(Stamps::Autopilots) {
            self.parachute.set_ahead(ahead_us);
        }
        self.peer.answered_at = self.host_time();
        self.next_report = FIRST_REPORT;
    }

    fn take_heartbeat(&mut self, m: &HEARTBEAT_DATA) {
        let mode = FlightMode::from_custom_mode(m.custom_mode);
        let offboard = mode == Some(FlightMode::Offboard);
        self.run.set_landing(matches!(mode, Some(FlightMode::AutoLand | FlightMode::AutoRtl)));
        self.run.set_mode((m.custom_mode != 0).then_some(offboard));
        let armed = m.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
        if armed {
            self.run.set_armed(true);
        }
        let shown = match m.system_status {
            MavState::MAV_STATE_CRITICAL => true,
            // PX4 says the same of motors that are locked, as before a throw launch, and of a flight that it
            // has terminated (`HEARTBEAT.hpp`, v1.12 and later). Before they have turned it is no end of a
            // flight.
            MavState::MAV_STATE_FLIGHT_TERMINATION => self.peer.turned,
            _ => false,
        };
        self.run.set_failsafe(armed && shown);
        self.report_drop();
    }

    /// Takes a command on the simulator's link: the simulator's own, and the release that the autopilot
    /// passes on to the parachute.
    fn take_command(&mut self, command: &Command, from: (u8, u8)) {
        let injects = command.command == INJECT_FAILURE;
        let from_autopilot = from == (self.config.system_id, AUTOPILOT_COMPONENT);
        let to_gripper = command.command == MavCmd::MAV_CMD_DO_GRIPPER as u16;
        if to_gripper && from_autopilot && self.parachute.is_addressed(command) {
            let result = self.parachute.obey(command);
            self.answer_command(command, result, from);
            self.release_if_asked();
            return;
        }
        let ours = [0, self.config.system_id].contains(&command.target_system)
            && ([0, SIMULATOR_COMPONENT].contains(&command.target_component)
                || injects && command.target_component == PARACHUTE_COMPONENT);
        if !ours {
            return;
        }
        let result = if injects { self.inject(command).0 } else { self.rates.command(command, self.now()) };
        self.answer_command(command, result, from);
        self.report_drop();
    }

    fn answer_command(&mut self, command: &Command, result: MavResult, from: (u8, u8)) {
        let ack = CommandAck::new(command, result as u8, from);
        self.outbox.push_back(self.encoder.encode_command_ack(&ack));
    }

    /// Cuts the vehicle loose, if the parachute was told to.
    pub(super) fn release_if_asked(&mut self) {
        if self.parachute.take_release() {
            self.release(ReleaseCause::Command);
        }
    }
}

impl HilSession {
    /// Takes MAV_CMD_INJECT_FAILURE where it is addressed to the parachute; whether it was that.
    pub(super) fn take_injection(&mut self, frame: &Frame) -> bool {
        let Some(command) = frame.command().filter(|c| c.command == INJECT_FAILURE) else { return false };
        if !self.parachute.is_addressed(&command) {
            return false;
        }
        let answer = self.inject(&command);
        self.parachute.acknowledge(&command, frame.peer, (frame.system_id, frame.component_id), answer);
        self.report_drop();
        true
    }

    /// Begins or ends the faults that a command names, which is still to be reported; its result, and why it
    /// is refused.
    fn inject(&mut self, command: &Command) -> (MavResult, Option<String>) {
        let refused = |result, why: &str| (result, Some(format!("Fault refused: {why}")));
        if !self.config.allow_faults {
            return refused(MavResult::MAV_RESULT_DENIED, "the mission does not allow it");
        }
        match self.pace {
            Pace::NoPeer => {
                return refused(MavResult::MAV_RESULT_TEMPORARILY_REJECTED, "no autopilot is connected");
            }
            Pace::Done => {
                return refused(MavResult::MAV_RESULT_TEMPORARILY_REJECTED, "the mission is over");
            }
            Pace::Free | Pace::AwaitingControls | Pace::Ready => {}
        }
        let rotors = self.run.simulation().vehicle().rotors.len();
        let orders = match orders(command, rotors) {
            Ok(orders) => orders,
            Err(result) => return (result, None),
        };
        for order in orders {
            if !self.run.order_fault(order) {
                return refused(MavResult::MAV_RESULT_TEMPORARILY_REJECTED, "too many in this flight");
            }
        }
        (MavResult::MAV_RESULT_ACCEPTED, None)
    }
}

/// Throttles of the motors' commands, 0..1: a command that is no number is 0, one beyond the range is
/// clamped, and both are counted.
fn throttle_of(m: &HIL_ACTUATOR_CONTROLS_DATA, n_rotors: usize, counts: &mut HilCounts) -> PerRotor {
    let armed = m.mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
    let mut throttle = [0.0; MAX_ROTORS];
    for (throttle, control) in throttle.iter_mut().zip(m.controls).take(n_rotors) {
        let control = f64::from(control);
        counts.not_finite += u64::from(!control.is_finite());
        counts.clamped += u64::from(control.is_finite() && armed && !(0.0..=1.0).contains(&control));
        *throttle = if control.is_finite() { control.clamp(0.0, 1.0) } else { 0.0 };
    }
    throttle
}
