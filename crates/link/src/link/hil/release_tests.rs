//! What cuts the vehicle loose and what does not; flights that start over; failsafes.

use mavlink::dialects::common::*;

use super::tests::{Hand, config, config_by};
use super::*;
use crate::sim::{FlightRecord, ReleaseTrigger};
use crate::test_site;

const RELEASE: [f32; 2] = [1.0, 0.0];
const OFFBOARD: u32 = 6 << 16;
const HOLD: u32 = 3 << 24 | 4 << 16;

fn heartbeat(custom_mode: u32, armed: bool, system_status: MavState) -> MavMessage {
    let base_mode = MavModeFlag::from_bits_retain(if armed { 129 } else { 1 });
    MavMessage::HEARTBEAT(HEARTBEAT_DATA { custom_mode, base_mode, system_status, ..Default::default() })
}

/// The one HEARTBEAT that PX4 sends to a simulator: no mode in it.
fn px4_greeting() -> MavMessage {
    let base_mode = MavModeFlag::empty();
    MavMessage::HEARTBEAT(HEARTBEAT_DATA { custom_mode: 0, base_mode, ..Default::default() })
}

impl Hand {
    /// As on the parachute's socket, from whoever has that encoder.
    fn say_outside(&mut self, message: &MavMessage) {
        self.decoder.push(&self.encoder.encode(message));
        let frame = self.decoder.next_frame().unwrap();
        self.session.handle_input(Link::Parachute, &frame);
    }

    fn gripper(&mut self) -> (u8, Vec<String>) {
        self.drain(Link::Parachute);
        self.command(Link::Parachute, MavCmd::MAV_CMD_DO_GRIPPER, RELEASE, (1, 161));
        let frames = self.drain(Link::Parachute);
        (frames[0].command_ack().unwrap().result, texts(&frames))
    }
}

fn texts(frames: &[Frame]) -> Vec<String> {
    let text = |f: &Frame| match f.known() {
        Some(MavMessage::STATUSTEXT(m)) => Some(m.text.to_str().unwrap().to_owned()),
        _ => None,
    };
    frames.iter().filter_map(text).collect()
}

#[test]
fn the_other_triggers_cut_as_well() {
    for (trigger, hang_s, cause, at) in [
        (ReleaseTrigger::Time, 1.001, ReleaseCause::Time, 1_001_000),
        // The hang begins 2 s times 5 m/s above 600 m.
        (ReleaseTrigger::Altitude(605.01), 2.0, ReleaseCause::Altitude, 1_000_000),
        (ReleaseTrigger::ArmedOffboard, 2.0, ReleaseCause::ArmedOffboard, 804_000),
    ] {
        let sim = test_site::drop_simulation_at(test_site::environment(), hang_s);
        let mut hand = Hand::with(sim, config_by(trigger));
        hand.session.peer_connected();
        hand.fly(400_000, 0.0, false);
        hand.say(&heartbeat(OFFBOARD, false, MavState::MAV_STATE_STANDBY));
        hand.fly(800_000, 0.0, false);
        assert_eq!(hand.session.run().simulation().release_time_s(), None);
        hand.answer(800_000, 0.0, true);
        hand.fly(2_000_000, 0.0, true);
        assert!(
            hand.events().contains(&Timed { at, event: HilEvent::Drop(DropEvent::Released { cause }) }),
            "{trigger:?}"
        );
    }
}

#[test]
fn an_armed_autopilot_that_reports_no_mode_is_not_waited_for_in_silence() {
    for (trigger, reports) in [(ReleaseTrigger::ArmedOffboard, 1), (ReleaseTrigger::Command, 0)] {
        let mut hand = Hand::connected(config_by(trigger));
        hand.say(&px4_greeting());
        hand.fly(400_000, 0.0, false);
        hand.fly(3_000_000, 0.0, true);
        let unknown = Timed { at: 404_000, event: HilEvent::Drop(DropEvent::ModeUnknown) };
        assert_eq!(hand.events().iter().filter(|e| **e == unknown).count(), reports, "{trigger:?}");
        assert_eq!(hand.session.run().simulation().phase(), Phase::Hanging);
    }
    let text = Timed { at: 0, event: HilEvent::Drop(DropEvent::ModeUnknown) }.to_string();
    assert!(text.contains("armed_offboard") && text.contains("choose another trigger"), "{text}");
}

#[test]
fn px4s_heartbeat_may_come_to_the_parachutes_socket() {
    let mut hand = Hand::connected(config_by(ReleaseTrigger::ArmedOffboard));
    hand.say(&px4_greeting());
    hand.say_outside(&heartbeat(HOLD, false, MavState::MAV_STATE_STANDBY));
    hand.fly(400_000, 0.0, false);
    hand.fly(800_000, 0.0, true);
    assert_eq!(hand.session.run().simulation().phase(), Phase::Hanging);
    // Somebody else's does not count.
    let encoder = std::mem::replace(&mut hand.encoder, Encoder::new(2, 1));
    hand.say_outside(&heartbeat(OFFBOARD, true, MavState::MAV_STATE_ACTIVE));
    hand.encoder = encoder;
    hand.fly(804_000, 0.0, true);
    assert_eq!(hand.session.run().simulation().phase(), Phase::Hanging);
    hand.say_outside(&heartbeat(OFFBOARD, true, MavState::MAV_STATE_ACTIVE));
    hand.fly(808_000, 0.0, true);
    assert_eq!(hand.session.run().simulation().release_time_s(), Some(0.808));
    assert!(!hand.events().iter().any(|e| e.event == HilEvent::Drop(DropEvent::ModeUnknown)));
}

#[test]
fn a_new_peer_finds_the_drop_at_its_beginning() {
    let mut hand = Hand::connected(config());
    hand.fly(1_000_000, 0.0, true);
    hand.session.release(ReleaseCause::Command);
    hand.fly(3_000_000, 0.5, true);
    let sequence = hand.session.encoder.clone();
    hand.session.peer_left();
    hand.session.handle_time(4_000_000);
    assert_eq!((hand.session.now(), hand.session.pace()), (3_000_000, Pace::NoPeer));
    hand.session.peer_connected();
    assert_eq!((hand.session.now(), hand.session.pace()), (0, Pace::Free));
    assert_eq!(
        (hand.session.run().simulation().phase(), hand.session.run().log().len()),
        (Phase::Hanging, 0)
    );
    assert_eq!(hand.session.encoder, sequence);
    assert_eq!(hand.session.run().record(), &FlightRecord::default());
    let events = hand.events();
    assert!(events.contains(&Timed { at: 3_000_000, event: HilEvent::PeerLeft }));
    assert!(events.contains(&Timed { at: 0, event: HilEvent::Connected { again: true } }));
    hand.step();
    assert_eq!(hand.drain(Link::Simulator)[0].payload().u64(0), 4_000);
}

#[test]
fn nothing_is_released_while_no_autopilot_is_connected() {
    let mut hand = Hand::new(config());
    let refused = |hand: &mut Hand| {
        assert_eq!(hand.gripper(), (1, vec!["Release refused: no autopilot is connected".to_owned()]));
        assert_eq!(hand.session.run().simulation().phase(), Phase::Hanging);
    };
    refused(&mut hand);
    hand.session.peer_connected();
    hand.fly(1_000_000, 0.0, true);
    hand.session.peer_left();
    refused(&mut hand);
    hand.session.peer_connected();
    assert_eq!(hand.gripper().0, 0);
    assert_eq!(hand.session.run().simulation().phase(), Phase::Falling);
}

#[test]
fn a_release_before_the_first_step_does_not_outlive_its_autopilot() {
    let mut hand = Hand::connected(config());
    assert_eq!(hand.gripper().0, 0);
    assert_eq!((hand.session.now(), hand.session.run().simulation().phase()), (0, Phase::Falling));
    hand.session.peer_left();
    hand.session.peer_connected();
    assert_eq!(hand.session.run().simulation().phase(), Phase::Hanging);
    assert!(hand.events().contains(&Timed { at: 0, event: HilEvent::Connected { again: true } }));
}

/// What one autopilot asked for is not sent to the next: PX4 would take ODOMETRY for vision.
#[test]
fn a_new_peer_is_sent_what_it_asks_for_itself() {
    let mut hand = Hand::connected(config());
    hand.command(Link::Simulator, MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, [331.0, 4_000.0], (1, 0));
    hand.session.peer_left();
    hand.session.peer_connected();
    hand.step();
    assert_eq!(hand.ids(), [115, 113, 107]);
}

#[test]
fn a_finished_mission_releases_nothing() {
    let mut hand = Hand::connected(config());
    hand.fly(8_000_000, 0.0, false);
    assert_eq!(hand.gripper(), (1, vec!["Release refused: the mission is over".to_owned()]));
}

#[test]
fn a_failsafe_after_the_release_is_remembered() {
    let fly = |released_first: bool, over_before: bool| {
        let mut hand = Hand::connected(config());
        hand.fly(400_000, 0.0, true);
        if released_first {
            hand.session.release(ReleaseCause::Command);
        }
        hand.say(&heartbeat(HOLD, true, MavState::MAV_STATE_CRITICAL));
        hand.fly(800_000, 0.0, true);
        if over_before {
            hand.say(&heartbeat(OFFBOARD, true, MavState::MAV_STATE_ACTIVE));
        }
        hand.session.release(ReleaseCause::Command);
        hand.fly(2_000_000, 0.0, true);
        hand.session.run().record().clone()
    };
    assert!(fly(true, true).failsafe, "in flight");
    assert!(fly(false, false).failsafe, "from the canopy into the flight");
    let early = fly(false, true);
    assert!(!early.failsafe, "under the canopy only");
    let reports: Vec<(u64, String)> = early.events.iter().map(|e| (e.at, e.event.to_string())).collect();
    assert_eq!(
        reports.iter().map(|(at, text)| (*at, text.as_str())).collect::<Vec<_>>(),
        [
            (4_000, "armed"),
            (400_000, "failsafe: the autopilot has taken over"),
            (800_000, "failsafe over"),
            (800_000, "released by command"),
            (1_300_000, "rotors free"),
        ]
    );
}

/// A HEARTBEAT of a disarmed vehicle in trouble is no failsafe that flies.
#[test]
fn who_is_disarmed_flies_no_failsafe() {
    let mut hand = Hand::connected(config());
    hand.session.release(ReleaseCause::Command);
    hand.say(&heartbeat(HOLD, false, MavState::MAV_STATE_CRITICAL));
    hand.fly(1_000_000, 0.0, false);
    assert!(!hand.session.run().record().failsafe);
}

/// PX4's HEARTBEAT says FLIGHT_TERMINATION of motors that are locked before a throw launch, and of a flight
/// that it has terminated. Locked they are commanded nothing.
#[test]
fn regress_motors_that_are_locked_before_a_throw_launch_are_no_failsafe() {
    let fly = |control: f32| {
        let mut hand = Hand::connected(config());
        hand.fly(400_000, 0.0, true);
        hand.say(&heartbeat(OFFBOARD, true, MavState::MAV_STATE_FLIGHT_TERMINATION));
        hand.session.release(ReleaseCause::Command);
        hand.fly(1_600_000, control, true);
        hand.say(&heartbeat(OFFBOARD, true, MavState::MAV_STATE_FLIGHT_TERMINATION));
        hand.fly(2_000_000, control, true);
        hand.session.run().record().clone()
    };
    let locked = fly(0.0);
    assert!(!locked.failsafe && locked.motors_stood);
    let terminated = fly(0.4);
    assert!(terminated.failsafe && !terminated.motors_stood);
}
