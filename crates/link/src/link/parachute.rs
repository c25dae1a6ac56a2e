//! The parachute as a MAVLink component of the vehicle's system, hosted by the simulator.
//!
//! MAV_COMP_ID_PARACHUTE, with a heartbeat at 1 Hz. It cuts the vehicle loose on MAV_CMD_DO_GRIPPER (param2 =
//! 0, release), answers every command addressed to it exactly once, reports by STATUSTEXT to everyone, and
//! puts the instant of the release on the wire as NAMED_VALUE_INT `t_release` (ms of simulated time), at once
//! and then at 1 Hz for whoever joins later; as `t_end`, that the simulation is over; and, as `mute`, whether
//! the streamer is to send nothing (1) or goes on (0), where a fault has its setpoints lost.
//! MAV_CMD_DO_PARACHUTE, on a real vehicle "canopy out, motors dead", is refused with the reason.

use std::collections::VecDeque;

use mavlink::MessageData as _;
use mavlink::dialects::common::*;

use super::encoder::Encoder;
use super::frame::{Command, CommandAck, Frame};
use super::froude::Froude;
pub use super::froude::{T_END, T_RELEASE};
use super::peer::{PeerId, Recipient};
use super::session::{Link, Session, Transmit};
use super::statustext::TextWriter;
use super::wire::{heartbeat_after, heartbeat_of};
use crate::time::{TimeUs, seconds};

/// MAV_COMP_ID_PARACHUTE.
pub const PARACHUTE_COMPONENT: u8 = 161;

/// Name of the NAMED_VALUE_INT by which the streamer learns that it is to send nothing.
pub const MUTE: &str = "mute";
/// `GRIPPER_ACTION_RELEASE` and `GRIPPER_ACTION_GRAB`.
const GRIPPER_RELEASE: f32 = 0.0;
const GRIPPER_GRAB: f32 = 1.0;
const HEARTBEAT_ID: f32 = HEARTBEAT_DATA::ID as f32;
const NAMED_VALUE_INT_ID: f32 = NAMED_VALUE_INT_DATA::ID as f32;

/// The parachute component. The simulator asks [`Self::take_release`] whether a command to cut has come,
/// cuts, and reports it by [`Self::note_release`], as it does a release that something else triggered.
#[derive(Clone, Debug)]
pub struct ParachuteComponent {
    encoder: Encoder,
    now: TimeUs,
    /// How far the clock that it stamps by is ahead of simulated time [us].
    ahead_us: i64,
    next_heartbeat: TimeUs,
    released_at: Option<TimeUs>,
    release_asked: bool,
    /// Whether the streamer is to send nothing.
    mute: bool,
    /// Whether no HEARTBEAT is sent.
    silent: bool,
    /// Why a command to cut is not obeyed at present; `None`: it is.
    refusal: Option<&'static str>,
    texts: TextWriter,
    outbox: VecDeque<(Recipient, Vec<u8>)>,
}

/// Result of a command, and what is to be said about it.
type Answer = (MavResult, Option<String>);

impl ParachuteComponent {
    /// The parachute of system `system_id`, the vehicle hanging on it without an autopilot: it does not let
    /// go before [`Self::allow_release`].
    pub fn new(system_id: u8) -> Self {
        Self {
            encoder: Encoder::new(system_id, PARACHUTE_COMPONENT),
            now: 0,
            ahead_us: 0,
            next_heartbeat: 0,
            released_at: None,
            release_asked: false,
            mute: false,
            silent: false,
            refusal: Some("no autopilot is connected"),
            texts: TextWriter::default(),
            outbox: VecDeque::new(),
        }
    }

    /// The component on a wire of that scale.
    pub fn scaled(self, froude: Option<Froude>) -> Self {
        Self { encoder: self.encoder.scaled(froude), ..self }
    }

    /// Starts over with a vehicle hanging; sequence numbers run on, and what has been said is still sent.
    pub fn restart(&mut self) {
        let outbox = std::mem::take(&mut self.outbox);
        let fresh = Self::new(self.encoder.system_id());
        *self = Self { encoder: self.encoder.clone(), texts: self.texts, outbox, ..fresh };
    }

    /// From now on what it stamps is so far ahead of simulated time [us]: by the clock of an autopilot that
    /// has one of its own, which is the clock of who hears the vehicle.
    pub(super) fn set_ahead(&mut self, ahead_us: i64) {
        self.ahead_us = ahead_us;
    }

    /// From now on a command to cut is obeyed.
    pub fn allow_release(&mut self) {
        self.refusal = None;
    }

    /// From now on a command to cut is answered TEMPORARILY_REJECTED, with this reason.
    pub fn refuse_release(&mut self, reason: &'static str) {
        self.refusal = Some(reason);
    }

    /// Whether a command to cut has come since the last call.
    pub fn take_release(&mut self) -> bool {
        std::mem::take(&mut self.release_asked)
    }

    /// The vehicle has been cut loose, at `at`; `why` is for the people who watch.
    pub fn note_release(&mut self, now: TimeUs, at: TimeUs, why: &str) {
        if self.released_at.is_none() {
            self.released_at = Some(at);
            self.say(MavSeverity::MAV_SEVERITY_NOTICE, &format!("Released at {:.3} s: {why}", seconds(at)));
            self.send_t_release(now, Recipient::All);
        }
    }

    /// The simulation is over, at `now`; `why` is for the people who watch.
    pub fn note_end(&mut self, now: TimeUs, why: &str) {
        let text = format!("Simulation over at {:.3} s: {why}", seconds(now));
        self.say(MavSeverity::MAV_SEVERITY_NOTICE, &text);
        self.repeat_end(now);
    }

    /// Says again as a number, without the text, that the simulation was over at `now`: a datagram may be
    /// lost.
    pub fn repeat_end(&mut self, now: TimeUs) {
        self.send_instant(now, Recipient::All, T_END, now);
    }

    /// Shows everybody that it is there, out of turn: while simulated time stands still.
    pub fn call(&mut self) {
        self.send_heartbeat(Recipient::All);
    }

    /// Says something to everybody.
    pub fn say(&mut self, severity: MavSeverity, text: &str) {
        for message in self.texts.messages(severity, text) {
            self.send(Recipient::All, &MavMessage::STATUSTEXT(message));
        }
    }

    /// From now on the streamer is to send nothing, or goes on.
    pub fn note_mute(&mut self, now: TimeUs, mute: bool) {
        if std::mem::replace(&mut self.mute, mute) != mute {
            self.send_value(now, Recipient::All, MUTE, i32::from(mute));
        }
    }

    /// From now on no HEARTBEAT is sent, or they go on; all else is sent as before: it is the simulator's.
    pub fn note_silent(&mut self, silent: bool) {
        self.silent = silent;
    }

    /// Whether a command is addressed to the parachute, and to it alone.
    pub(super) fn is_addressed(&self, command: &Command) -> bool {
        command.target_component == PARACHUTE_COMPONENT && self.is_of_our_system(command)
    }

    fn is_of_our_system(&self, command: &Command) -> bool {
        [0, self.encoder.system_id()].contains(&command.target_system)
    }

    /// Acknowledges a command of `from` (system, component) that the simulator has obeyed or refused; what
    /// there is to say of it goes to everybody.
    pub(super) fn acknowledge(
        &mut self,
        command: &Command,
        peer: PeerId,
        from: (u8, u8),
        (result, text): (MavResult, Option<String>),
    ) {
        let ack = CommandAck::new(command, result as u8, from);
        let bytes = self.encoder.encode_command_ack(&ack);
        self.outbox.push_back((Recipient::Peer(peer), bytes));
        if let Some(text) = text {
            self.say(MavSeverity::MAV_SEVERITY_WARNING, &text);
        }
    }

    fn command(&mut self, command: &Command, peer: PeerId, from: (u8, u8)) {
        let addressed = command.target_component == PARACHUTE_COMPONENT;
        // To all components: only what none but us can do; the rest is the autopilot's to answer.
        let for_all = command.target_component == 0 && command.command == MavCmd::MAV_CMD_DO_GRIPPER as u16;
        if !(self.is_of_our_system(command) && (addressed || for_all)) {
            return;
        }
        let to = Recipient::Peer(peer);
        let (result, text) = self.answer(command, to);
        let bytes = self.encoder.encode_command_ack(&CommandAck::new(command, result as u8, from));
        self.outbox.push_back((to, bytes));
        self.comment(result, text);
    }

    /// Obeys a command that the vehicle's autopilot passes on, or refuses it, and says so to everybody; its
    /// result.
    pub(super) fn obey(&mut self, command: &Command) -> MavResult {
        let (result, text) = self.answer(command, Recipient::All);
        self.comment(result, text);
        result
    }

    /// Says to everybody what there is to say of a command with this result.
    fn comment(&mut self, result: MavResult, text: Option<String>) {
        if let Some(text) = text {
            let refused = result != MavResult::MAV_RESULT_ACCEPTED;
            let severity =
                if refused { MavSeverity::MAV_SEVERITY_WARNING } else { MavSeverity::MAV_SEVERITY_NOTICE };
            self.say(severity, &text);
        }
    }

    fn answer(&mut self, command: &Command, to: Recipient) -> Answer {
        const GRIPPER: u16 = MavCmd::MAV_CMD_DO_GRIPPER as u16;
        const PARACHUTE: u16 = MavCmd::MAV_CMD_DO_PARACHUTE as u16;
        const REQUEST: u16 = MavCmd::MAV_CMD_REQUEST_MESSAGE as u16;
        const ACCEPTED: Answer = (MavResult::MAV_RESULT_ACCEPTED, None);
        let denied = |text: &str| (MavResult::MAV_RESULT_DENIED, Some(text.to_owned()));
        match (command.command, self.released_at) {
            (GRIPPER, Some(_)) if command.param(2) == Some(GRIPPER_RELEASE) => {
                (MavResult::MAV_RESULT_ACCEPTED, Some("Vehicle is loose already".to_owned()))
            }
            (GRIPPER, None) if command.param(2) == Some(GRIPPER_RELEASE) => {
                if let Some(reason) = self.refusal {
                    let text = format!("Release refused: {reason}");
                    return (MavResult::MAV_RESULT_TEMPORARILY_REJECTED, Some(text));
                }
                self.release_asked = true;
                ACCEPTED
            }
            (GRIPPER, _) if command.param(2) == Some(GRIPPER_GRAB) => {
                denied("Gripper refused: it can only release")
            }
            (GRIPPER, _) => denied("Gripper refused: param2 must be 0, release"),
            (PARACHUTE, None) => denied("DO_PARACHUTE refused: hangs; DO_GRIPPER cuts"),
            (PARACHUTE, Some(_)) => denied("DO_PARACHUTE refused: no canopy any more"),
            (REQUEST, _) if command.param(1) == Some(HEARTBEAT_ID) => {
                self.send_heartbeat(to);
                ACCEPTED
            }
            (REQUEST, Some(_)) if command.param(1) == Some(NAMED_VALUE_INT_ID) => {
                self.send_t_release(self.now, to);
                ACCEPTED
            }
            (REQUEST, _) => (MavResult::MAV_RESULT_DENIED, None),
            _ => (MavResult::MAV_RESULT_UNSUPPORTED, None),
        }
    }

    fn send(&mut self, to: Recipient, message: &MavMessage) {
        let bytes = self.encoder.encode(message);
        self.outbox.push_back((to, bytes));
    }

    fn send_heartbeat(&mut self, to: Recipient) {
        self.send(to, &heartbeat_of(MavType::MAV_TYPE_PARACHUTE));
    }

    fn send_t_release(&mut self, now: TimeUs, to: Recipient) {
        if let Some(at) = self.released_at {
            self.send_instant(now, to, T_RELEASE, at);
        }
    }

    fn send_instant(&mut self, now: TimeUs, to: Recipient, name: &str, at: TimeUs) {
        self.send_value(now, to, name, ((self.stamped(at) + 500) / 1_000) as i32);
    }

    fn stamped(&self, at: TimeUs) -> TimeUs {
        at.saturating_add_signed(self.ahead_us)
    }

    fn send_value(&mut self, now: TimeUs, to: Recipient, name: &str, value: i32) {
        let time_boot_ms = (self.stamped(now) / 1_000) as u32;
        let named = NAMED_VALUE_INT_DATA { time_boot_ms, value, name: name.into() };
        self.send(to, &MavMessage::NAMED_VALUE_INT(named));
    }
}

impl Session for ParachuteComponent {
    fn handle_input(&mut self, link: Link, frame: &Frame) {
        if link == Link::Parachute
            && let Some(command) = frame.command()
        {
            self.command(&command, frame.peer, (frame.system_id, frame.component_id));
        }
    }

    fn handle_time(&mut self, now: TimeUs) {
        self.now = now;
        if now >= self.next_heartbeat {
            self.next_heartbeat = heartbeat_after(now);
            if !self.silent {
                self.send_heartbeat(Recipient::All);
            }
            self.send_t_release(now, Recipient::All);
            if self.mute {
                self.send_value(now, Recipient::All, MUTE, 1);
            }
        }
    }

    fn next_wake(&self) -> Option<TimeUs> {
        Some(self.next_heartbeat)
    }

    fn poll_output(&mut self) -> Option<Transmit> {
        let (to, bytes) = self.outbox.pop_front()?;
        Some(Transmit { link: Link::Parachute, to, bytes })
    }
}
