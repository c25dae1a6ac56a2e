//! An autopilot with a clock of its own, as a board has, played by hand.

use mavlink::MessageData as _;
use mavlink::dialects::common::*;

use super::super::frame::Frame;
use super::super::parachute::{PARACHUTE_COMPONENT, T_RELEASE};
use super::tests::{Hand, config};
use super::*;

/// The board's clock when simulated time begins [us].
const BOOTED_US: TimeUs = 300_000_000;

fn board(stamps: Stamps) -> Hand {
    Hand::connected(HilConfig { real_time: Some(stamps), ..config() })
}

fn heartbeat() -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA { custom_mode: 6 << 16, ..HEARTBEAT_DATA::default() })
}

fn parameter(name: &str, value: i32) -> MavMessage {
    MavMessage::PARAM_VALUE(PARAM_VALUE_DATA {
        param_id: name.into(),
        param_value: f32::from_bits(value as u32),
        param_type: MavParamType::MAV_PARAM_TYPE_INT32,
        ..PARAM_VALUE_DATA::default()
    })
}

fn told(hand: &mut Hand) -> Vec<String> {
    hand.events().iter().map(|event| event.event.to_string()).collect()
}

fn count(frames: &[Frame], id: u32) -> usize {
    frames.iter().filter(|frame| frame.message_id == id).count()
}

#[test]
fn nothing_begins_before_the_first_answer_and_then_no_step_waits_for_one() {
    let mut hand = board(Stamps::Simulated);
    hand.step();
    assert_eq!(
        (hand.session.pace(), hand.session.missing()),
        (Pace::AwaitingControls, Some(Missing::AnyFrame))
    );
    hand.say(&heartbeat());
    (0..100).for_each(|_| hand.step());
    let sent = hand.drain(Link::Simulator);
    assert_eq!((hand.session.now(), count(&sent, HIL_SENSOR_DATA::ID)), (4_000, 100));
    // What a PX4 would take for its own estimate and its own battery.
    assert_eq!(count(&sent, HIL_STATE_QUATERNION_DATA::ID) + count(&sent, BATTERY_STATUS_DATA::ID), 0);
    assert_eq!(hand.session.missing(), Some(Missing::ActuatorControls));
    hand.answer(BOOTED_US, 0.0, false);
    (0..100).for_each(|_| hand.step());
    assert_eq!((hand.session.now(), hand.session.missing()), (404_000, None));
    assert_eq!(hand.session.counts().mistimed, 0);
}

/// The host's time goes on while simulated time waits, so that what is sent keeps its rate.
#[test]
fn the_host_s_time_never_runs_backwards() {
    let mut hand = board(Stamps::Simulated);
    hand.say(&heartbeat());
    let mut last = 0;
    for i in 0..200 {
        let at = hand.session.next_wake().unwrap();
        assert_eq!(at, last + 4_000);
        last = at;
        hand.session.handle_time(at);
        if i > 100 {
            hand.answer(BOOTED_US + last, 0.0, false);
        }
    }
    assert!(hand.session.now() < last);
}

#[test]
fn answers_that_stay_out_are_told_and_time_goes_on() {
    let mut hand = board(Stamps::Simulated);
    hand.say(&heartbeat());
    hand.step();
    hand.answer(BOOTED_US, 0.0, false);
    hand.events();
    (0..1_000).for_each(|_| hand.step());
    let waits: Vec<String> = told(&mut hand).into_iter().filter(|text| text.contains("waiting")).collect();
    assert_eq!(waits.len(), 3, "{waits:?}");
    assert!(waits[2].starts_with("waiting since 4.0 s for HIL_ACTUATOR_CONTROLS"), "{waits:?}");
    assert_eq!(hand.session.now(), 4_004_000);
}

/// Asked, answered, told, and a board that would fly by other sensors, or turn other motors, is not released.
#[test]
fn a_board_is_asked_how_it_is_set_up_and_told_parameter_by_parameter() {
    let set_up = |hitl, third| {
        let mut hand = board(Stamps::Simulated);
        hand.say(&heartbeat());
        hand.step();
        let asked = count(&hand.drain(Link::Simulator), PARAM_REQUEST_READ_DATA::ID);
        assert_eq!(asked, 5, "SYS_HITL and four outputs");
        hand.say(&parameter("SYS_HITL", hitl));
        for (i, function) in [101, 102, third, 104].into_iter().enumerate() {
            hand.say(&parameter(&format!("HIL_ACT_FUNC{}", i + 1), function));
        }
        hand.answer(BOOTED_US, 0.0, false);
        hand.step();
        hand.session.poll_output();
        hand.command(Link::Parachute, MavCmd::MAV_CMD_DO_GRIPPER, [1.0, 0.0], (1, PARACHUTE_COMPONENT));
        let released = hand.session.run().simulation().phase() != Phase::Hanging;
        (told(&mut hand).into_iter().filter(|text| text.starts_with("board")).collect::<Vec<_>>(), released)
    };
    let (texts, released) = set_up(1, 103);
    assert_eq!(texts.len(), 5);
    assert!(released && texts.iter().all(|text| text.ends_with("as it should be")), "{texts:?}");
    let (texts, released) = set_up(0, 0);
    assert!(!released);
    assert!(
        texts[0].starts_with("board: SYS_HITL = 0, and should be 1: it flies by its own sensors"),
        "{texts:?}"
    );
    assert!(texts[3].starts_with("board: HIL_ACT_FUNC3 = 0, and should be 103"), "{texts:?}");
    assert!(!set_up(1, 104).1 && !set_up(2, 103).1);
}

/// A PX4 before v1.14 has a mixer and no such parameters; it says nothing of what it does not have.
#[test]
fn outputs_that_are_not_there_are_told_once_and_hold_nobody_up() {
    let mut hand = board(Stamps::Simulated);
    hand.say(&heartbeat());
    hand.step();
    hand.say(&parameter("SYS_HITL", 1));
    (0..500).for_each(|_| hand.step());
    let texts: Vec<_> = told(&mut hand).into_iter().filter(|text| text.starts_with("board")).collect();
    assert_eq!(texts.len(), 2, "{texts:?}");
    assert!(texts[1].starts_with("board: HIL_ACT_FUNC1 is not there: a PX4 before v1.14"), "{texts:?}");
}

/// A streamer of another process goes by the vehicle's clock; what came soonest shows best how far that is
/// ahead.
#[test]
fn closed_form_the_release_is_stamped_by_the_board_s_clock() {
    let stamped = |stamps| {
        let mut hand = board(stamps);
        hand.say(&heartbeat());
        hand.step();
        for late_us in [5_000, 2_000, 9_000] {
            hand.answer(BOOTED_US + hand.session.now() - late_us, 0.5, true);
            hand.step();
        }
        let now = hand.session.now();
        hand.session.release(ReleaseCause::Command);
        let is_release = |m: &NAMED_VALUE_INT_DATA| m.name.to_str() == Ok(T_RELEASE);
        let frames = hand.drain(Link::Parachute);
        let value = frames.iter().find_map(|frame| match frame.known() {
            Some(MavMessage::NAMED_VALUE_INT(m)) if is_release(m) => Some(m.value),
            _ => None,
        });
        (i64::from(value.unwrap()), now as i64)
    };
    let (value, now) = stamped(Stamps::Autopilots);
    assert_eq!(value, (BOOTED_US as i64 + now - 2_000 + 500) / 1_000);
    let (value, now) = stamped(Stamps::Simulated);
    assert_eq!(value, (now + 500) / 1_000);
}

#[test]
fn a_board_is_disarmed_at_the_end() {
    let mut hand = board(Stamps::Simulated);
    hand.say(&heartbeat());
    hand.step();
    hand.answer(BOOTED_US, 0.5, true);
    hand.drain(Link::Simulator);
    hand.session.stop();
    let frames = hand.drain(Link::Simulator);
    let disarms = |frame: &Frame| {
        frame.command().is_some_and(|c| {
            c.command == MavCmd::MAV_CMD_COMPONENT_ARM_DISARM as u16
                && (c.param(1), c.param(2)) == (Some(0.0), Some(21196.0))
                && (c.target_system, c.target_component) == (1, 1)
        })
    };
    assert!(frames.iter().any(disarms));
}

/// With its port PX4 may leave MAVLink off until it hears a HEARTBEAT.
#[test]
fn a_board_that_is_silent_is_called() {
    let mut hand = board(Stamps::Simulated);
    for ms in (0..=3_000).step_by(100) {
        hand.session.handle_silence(Duration::from_millis(ms));
    }
    assert_eq!(count(&hand.drain(Link::Simulator), HEARTBEAT_DATA::ID), 4);
}
