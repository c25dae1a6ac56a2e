//! The parachute as a MAVLink component of the vehicle's system, hosted by the simulator.
//!
//! MAV_COMP_ID_PARACHUTE, with a heartbeat at 1 Hz. It cuts the vehicle loose on MAV_CMD_DO_GRIPPER (param2 = 0,
//! release), answers every command addressed to it exactly once, tells everyone by STATUSTEXT, and puts the instant of
//! the release on the wire as NAMED_VALUE_INT `t_release` (ms of simulated time), at once and then at 1 Hz for whoever
//! joins later. MAV_CMD_DO_PARACHUTE, on a real vehicle "canopy out, motors dead", is refused with the reason.

use std::collections::VecDeque;

use mavlink::dialects::common::{
    HEARTBEAT_DATA, MavAutopilot, MavCmd, MavMessage, MavModeFlag, MavResult, MavSeverity, MavState, MavType,
    NAMED_VALUE_INT_DATA, STATUSTEXT_DATA,
};

use super::{Command, CommandAck, Encoder, Frame, Link, PeerId, Recipient, Session, TimeUs, Transmit};

/// MAV_COMP_ID_PARACHUTE.
pub const PARACHUTE_COMPONENT: u8 = 161;
/// Name of the NAMED_VALUE_INT that carries the instant of the release.
pub const T_RELEASE: &str = "t_release";

const HEARTBEAT_PERIOD_US: TimeUs = 1_000_000;
/// `GRIPPER_ACTION_RELEASE` and `GRIPPER_ACTION_GRAB`.
const GRIPPER_RELEASE: f32 = 0.0;
const GRIPPER_GRAB: f32 = 1.0;
const HEARTBEAT_ID: f32 = 0.0;
const NAMED_VALUE_INT_ID: f32 = 252.0;

/// The component. The simulator asks [`Self::take_release`] whether it has been told to cut, cuts, and tells it with
/// [`Self::note_release`]; a release that something else triggered is told the same way.
#[derive(Clone, Debug)]
pub struct ParachuteComponent {
    encoder: Encoder,
    next_heartbeat: TimeUs,
    released_at: Option<TimeUs>,
    release_asked: bool,
    outbox: VecDeque<(Recipient, Vec<u8>)>,
}

/// What a command comes to.
struct Answer {
    result: MavResult,
    text: Option<String>,
}

impl Answer {
    fn accepted(text: Option<&str>) -> Self {
        Self { result: MavResult::MAV_RESULT_ACCEPTED, text: text.map(str::to_owned) }
    }

    fn denied(text: &str) -> Self {
        Self { result: MavResult::MAV_RESULT_DENIED, text: Some(text.to_owned()) }
    }
}

impl ParachuteComponent {
    /// The parachute of system `system_id`, the vehicle hanging on it.
    pub fn new(system_id: u8) -> Self {
        Self {
            encoder: Encoder::new(system_id, PARACHUTE_COMPONENT),
            next_heartbeat: 0,
            released_at: None,
            release_asked: false,
            outbox: VecDeque::new(),
        }
    }

    /// Starts over with a vehicle hanging; sequence numbers run on.
    pub fn restart(&mut self) {
        *self = Self { encoder: self.encoder.clone(), ..Self::new(self.encoder.system_id()) };
    }

    /// Whether a command to cut has come since the last call.
    pub fn take_release(&mut self) -> bool {
        std::mem::take(&mut self.release_asked)
    }

    /// The vehicle has been cut loose, at `at`; `why` is for the people who watch.
    pub fn note_release(&mut self, now: TimeUs, at: TimeUs, why: &str) {
        if self.released_at.is_none() {
            self.released_at = Some(at);
            self.say(
                MavSeverity::MAV_SEVERITY_NOTICE,
                &format!("Released at {:.3} s: {why}", at as f64 * 1e-6),
            );
            self.send_t_release(now, Recipient::All);
        }
    }

    fn command(&mut self, now: TimeUs, command: &Command, peer: PeerId, from: (u8, u8)) {
        let addressed = command.target_component == PARACHUTE_COMPONENT;
        // To all components: only what none but us can do; the rest is the autopilot's to answer.
        let for_all = command.target_component == 0 && command.command == MavCmd::MAV_CMD_DO_GRIPPER as u16;
        let our_system = [0, self.encoder.system_id()].contains(&command.target_system);
        if !(our_system && (addressed || for_all)) {
            return;
        }
        let to = Recipient::Peer(peer);
        let answer = self.answer(now, command, to);
        let ack = CommandAck {
            command: command.command,
            result: answer.result as u8,
            target_system: from.0,
            target_component: from.1,
            ..CommandAck::default()
        };
        let bytes = self.encoder.encode_command_ack(&ack);
        self.outbox.push_back((to, bytes));
        if let Some(text) = answer.text {
            let refused = answer.result != MavResult::MAV_RESULT_ACCEPTED;
            let severity =
                if refused { MavSeverity::MAV_SEVERITY_WARNING } else { MavSeverity::MAV_SEVERITY_NOTICE };
            self.say(severity, &text);
        }
    }

    fn answer(&mut self, now: TimeUs, command: &Command, to: Recipient) -> Answer {
        const GRIPPER: u16 = MavCmd::MAV_CMD_DO_GRIPPER as u16;
        const PARACHUTE: u16 = MavCmd::MAV_CMD_DO_PARACHUTE as u16;
        const REQUEST: u16 = MavCmd::MAV_CMD_REQUEST_MESSAGE as u16;
        match (command.command, self.released_at) {
            (GRIPPER, Some(_)) if command.param(2) == Some(GRIPPER_RELEASE) => {
                Answer::accepted(Some("Vehicle is loose already"))
            }
            (GRIPPER, None) if command.param(2) == Some(GRIPPER_RELEASE) => {
                self.release_asked = true;
                Answer::accepted(None)
            }
            (GRIPPER, _) if command.param(2) == Some(GRIPPER_GRAB) => {
                Answer::denied("Gripper refused: it can only release")
            }
            (GRIPPER, _) => Answer::denied("Gripper refused: param2 must be 0, release"),
            (PARACHUTE, None) => Answer::denied("DO_PARACHUTE refused: hangs; DO_GRIPPER cuts"),
            (PARACHUTE, Some(_)) => Answer::denied("DO_PARACHUTE refused: no canopy any more"),
            (REQUEST, _) if command.param(1) == Some(HEARTBEAT_ID) => {
                self.send_heartbeat(to);
                Answer::accepted(None)
            }
            (REQUEST, Some(_)) if command.param(1) == Some(NAMED_VALUE_INT_ID) => {
                self.send_t_release(now, to);
                Answer::accepted(None)
            }
            (REQUEST, _) => Answer { result: MavResult::MAV_RESULT_DENIED, text: None },
            _ => Answer { result: MavResult::MAV_RESULT_UNSUPPORTED, text: None },
        }
    }

    fn send(&mut self, to: Recipient, message: &MavMessage) {
        let bytes = self.encoder.encode(message);
        self.outbox.push_back((to, bytes));
    }

    fn say(&mut self, severity: MavSeverity, text: &str) {
        let text = STATUSTEXT_DATA { severity, text: text.into(), ..STATUSTEXT_DATA::default() };
        self.send(Recipient::All, &MavMessage::STATUSTEXT(text));
    }

    fn send_heartbeat(&mut self, to: Recipient) {
        let heartbeat = HEARTBEAT_DATA {
            custom_mode: 0,
            mavtype: MavType::MAV_TYPE_PARACHUTE,
            autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
            base_mode: MavModeFlag::empty(),
            system_status: MavState::MAV_STATE_ACTIVE,
            mavlink_version: 3,
        };
        self.send(to, &MavMessage::HEARTBEAT(heartbeat));
    }

    fn send_t_release(&mut self, now: TimeUs, to: Recipient) {
        if let Some(at) = self.released_at {
            let value = NAMED_VALUE_INT_DATA {
                time_boot_ms: (now / 1_000) as u32,
                value: ((at + 500) / 1_000) as i32,
                name: T_RELEASE.into(),
            };
            self.send(to, &MavMessage::NAMED_VALUE_INT(value));
        }
    }
}

impl Session for ParachuteComponent {
    fn handle_input(&mut self, now: TimeUs, link: Link, frame: &Frame) {
        if link == Link::Parachute
            && let Some(command) = frame.command()
        {
            self.command(now, &command, frame.peer, (frame.system_id, frame.component_id));
        }
    }

    fn handle_time(&mut self, now: TimeUs) {
        if now >= self.next_heartbeat {
            self.next_heartbeat = now - now % HEARTBEAT_PERIOD_US + HEARTBEAT_PERIOD_US;
            self.send_heartbeat(Recipient::All);
            self.send_t_release(now, Recipient::All);
        }
    }

    fn poll_output(&mut self) -> Option<Transmit> {
        let (to, bytes) = self.outbox.pop_front()?;
        Some(Transmit { link: Link::Parachute, to, bytes })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Decoder;
    use super::*;
    use mavlink::dialects::common::{COMMAND_INT_DATA, COMMAND_LONG_DATA};

    fn command(command: MavCmd, param2: f32, target: (u8, u8)) -> MavMessage {
        MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
            command,
            param2,
            target_system: target.0,
            target_component: target.1,
            ..Default::default()
        })
    }

    /// Sends from 255/190, returns everything that comes back.
    fn ask(component: &mut ParachuteComponent, message: &MavMessage) -> Vec<Frame> {
        let mut decoder = Decoder::new();
        decoder.push(&Encoder::new(255, 190).encode(message));
        component.handle_input(1_000, Link::Parachute, &decoder.next_frame().unwrap());
        drain(component)
    }

    fn drain(component: &mut ParachuteComponent) -> Vec<Frame> {
        let mut decoder = Decoder::new();
        let mut frames = Vec::new();
        while let Some(transmit) = component.poll_output() {
            assert_eq!(transmit.link, Link::Parachute);
            decoder.datagram(&transmit.bytes, |frame| frames.push(frame));
        }
        assert!(frames.iter().all(|f| (f.system_id, f.component_id) == (1, 161)));
        frames
    }

    fn acks(frames: &[Frame]) -> Vec<(u16, u8, u8, u8)> {
        let ack = |f: &Frame| f.command_ack();
        let tuple = |a: CommandAck| (a.command, a.result, a.target_system, a.target_component);
        frames.iter().filter_map(ack).map(tuple).collect()
    }

    fn texts(frames: &[Frame]) -> Vec<String> {
        let text = |f: &Frame| match f.known() {
            Some(MavMessage::STATUSTEXT(t)) => Some(t.text.to_str().unwrap().to_owned()),
            _ => None,
        };
        frames.iter().filter_map(text).collect()
    }

    const GRIPPER: MavCmd = MavCmd::MAV_CMD_DO_GRIPPER;

    #[test]
    fn the_gripper_releases_and_says_when() {
        let mut component = ParachuteComponent::new(1);
        assert_eq!(acks(&ask(&mut component, &command(GRIPPER, 0.0, (1, 161)))), [(211, 0, 255, 190)]);
        assert!(component.take_release());
        assert!(!component.take_release());
        component.note_release(10_000_000, 10_000_000, "by command");
        let frames = drain(&mut component);
        assert_eq!(texts(&frames), ["Released at 10.000 s: by command"]);
        let t_release = |f: &Frame| match f.known() {
            Some(MavMessage::NAMED_VALUE_INT(m)) => Some((m.name.to_str().unwrap().to_owned(), m.value)),
            _ => None,
        };
        assert_eq!(frames.iter().find_map(t_release), Some(("t_release".to_owned(), 10_000)));
        component.handle_time(12_300_000);
        assert_eq!(drain(&mut component).iter().find_map(t_release), Some(("t_release".to_owned(), 10_000)));
        // Once more: answered, but nothing is left to cut.
        assert_eq!(acks(&ask(&mut component, &command(GRIPPER, 0.0, (1, 161)))), [(211, 0, 255, 190)]);
        assert!(!component.take_release());
    }

    #[test]
    fn a_command_int_releases_too() {
        let mut component = ParachuteComponent::new(1);
        let message = MavMessage::COMMAND_INT(COMMAND_INT_DATA {
            command: GRIPPER,
            target_system: 1,
            target_component: 161,
            ..Default::default()
        });
        assert_eq!(acks(&ask(&mut component, &message)), [(211, 0, 255, 190)]);
        assert!(component.take_release());
    }

    #[test]
    fn everything_else_is_refused_with_a_reason_and_once() {
        let mut component = ParachuteComponent::new(1);
        for (message, result, reason) in [
            (command(GRIPPER, 1.0, (1, 161)), 2, Some("Gripper refused: it can only release")),
            (command(GRIPPER, f32::NAN, (1, 161)), 2, Some("Gripper refused: param2 must be 0, release")),
            (command(GRIPPER, 0.4, (1, 161)), 2, Some("Gripper refused: param2 must be 0, release")),
            (
                command(MavCmd::MAV_CMD_DO_PARACHUTE, 0.0, (1, 161)),
                2,
                Some("DO_PARACHUTE refused: hangs; DO_GRIPPER cuts"),
            ),
            (command(MavCmd::MAV_CMD_NAV_TAKEOFF, 0.0, (1, 161)), 3, None),
        ] {
            let frames = ask(&mut component, &message);
            assert_eq!(acks(&frames).iter().map(|a| a.1).collect::<Vec<_>>(), [result]);
            assert_eq!(texts(&frames), reason.into_iter().collect::<Vec<_>>());
            assert!(!component.take_release());
        }
    }

    #[test]
    fn commands_to_others_are_neither_obeyed_nor_answered() {
        let mut component = ParachuteComponent::new(1);
        for (what, target) in
            [(GRIPPER, (2, 161)), (GRIPPER, (1, 1)), (MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, (1, 0))]
        {
            assert!(ask(&mut component, &command(what, 0.0, target)).is_empty());
            assert!(!component.take_release());
        }
        assert_eq!(acks(&ask(&mut component, &command(GRIPPER, 0.0, (1, 0)))).len(), 1);
    }

    #[test]
    fn heartbeats_come_once_a_second_and_sequence_numbers_survive_a_restart() {
        let mut component = ParachuteComponent::new(1);
        (0..=750).for_each(|i| component.handle_time(i * 4_000));
        let frames = drain(&mut component);
        assert_eq!(frames.iter().map(|f| f.sequence).collect::<Vec<_>>(), [0, 1, 2, 3]);
        component.restart();
        component.handle_time(0);
        assert_eq!(drain(&mut component)[0].sequence, 4);
    }
}
