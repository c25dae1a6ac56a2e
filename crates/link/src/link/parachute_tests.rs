//! The parachute component against a script.

use mavlink::dialects::common::{COMMAND_INT_DATA, COMMAND_LONG_DATA, MavCmd, MavMessage};

use super::decoder::Decoder;

use super::encoder::Encoder;

use super::frame::{CommandAck, Frame};

use super::parachute::ParachuteComponent;

use super::session::{Link, Session};

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
    component.handle_input(Link::Parachute, &decoder.next_frame().unwrap());
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

/// The parachute of system 1, with an autopilot connected.
fn attended() -> ParachuteComponent {
    let mut component = ParachuteComponent::new(1);
    component.allow_release();
    component
}

const GRIPPER: MavCmd = MavCmd::MAV_CMD_DO_GRIPPER;

#[test]
fn the_gripper_releases_and_says_when() {
    let mut component = attended();
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
    let mut component = attended();
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
    let mut component = attended();
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
    let mut component = attended();
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
    let mut component = attended();
    (0..=750).for_each(|i| component.handle_time(i * 4_000));
    let frames = drain(&mut component);
    assert_eq!(frames.iter().map(|f| f.sequence).collect::<Vec<_>>(), [0, 1, 2, 3]);
    component.restart();
    component.handle_time(0);
    assert_eq!(drain(&mut component)[0].sequence, 4);
}

#[test]
fn a_release_that_is_not_allowed_is_put_off_with_the_reason() {
    let mut component = ParachuteComponent::new(1);
    for reason in ["no autopilot is connected", "the mission is over"] {
        component.refuse_release(reason);
        let frames = ask(&mut component, &command(GRIPPER, 0.0, (1, 161)));
        assert_eq!(acks(&frames), [(211, 1, 255, 190)]);
        assert_eq!(texts(&frames), [format!("Release refused: {reason}")]);
        assert!(!component.take_release());
    }
    component.allow_release();
    assert_eq!(acks(&ask(&mut component, &command(GRIPPER, 0.0, (1, 161)))), [(211, 0, 255, 190)]);
    assert!(component.take_release());
}

#[test]
fn the_end_is_sent_as_text_and_as_a_number() {
    let mut component = attended();
    component.note_end(45_000_000, "end of the mission");
    let frames = drain(&mut component);
    assert_eq!(texts(&frames), ["Simulation over at 45.000 s: end of the mission"]);
    let Some(MavMessage::NAMED_VALUE_INT(m)) = frames[1].known() else { panic!() };
    assert_eq!((m.name.to_str(), m.value), (Ok("t_end"), 45_000));
}
