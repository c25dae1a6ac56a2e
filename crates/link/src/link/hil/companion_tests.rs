//! A simulation that keeps step with a script's setpoints. Source of truth: the rule that
//! docs/scripting.md states, step by step.

use core::time::Duration;

use mavlink::MessageData as _;
use mavlink::dialects::common::*;

use super::tests::{Hand, config};
use super::*;

const PATIENCE: Duration = Duration::from_secs(5);

fn waiting() -> Hand {
    Hand::connected(HilConfig { companion: Some(PATIENCE), ..config() })
}

fn setpoint(time_boot_ms: u32) -> MavMessage {
    let message = SET_POSITION_TARGET_LOCAL_NED_DATA { time_boot_ms, ..Default::default() };
    MavMessage::SET_POSITION_TARGET_LOCAL_NED(message)
}

fn greeting() -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA::default())
}

impl Hand {
    /// As on the parachute's socket, from the script.
    fn script_says(&mut self, message: &MavMessage) {
        self.decoder.push(&self.script.encode(message));
        let frame = self.decoder.next_frame().unwrap();
        self.session.handle_input(Link::Parachute, &frame);
    }

    /// Flies as far as it may, answered at once; the time there [ms].
    fn flies_to(&mut self) -> TimeUs {
        while self.session.next_wake().is_some() && self.session.pace() != Pace::Done {
            self.step();
            self.drain(Link::Simulator);
            self.answer(self.session.now(), 0.0, false);
        }
        self.session.now() / 1_000
    }

    fn companion_events(&mut self) -> Vec<HilEvent> {
        let of_companion = |e: &HilEvent| {
            matches!(e, HilEvent::CompanionHeard | HilEvent::CompanionStreams | HilEvent::CompanionSilent(_))
        };
        self.events().into_iter().map(|e| e.event).filter(of_companion).collect()
    }
}

#[test]
fn nothing_moves_before_a_companion_is_heard_and_the_parachute_calls_for_it() {
    let mut hand = waiting();
    assert_eq!((hand.flies_to(), hand.session.missing()), (0, Some(Missing::Companion)));
    let mut calls = 0;
    for tenths in 1..=35 {
        hand.session.handle_silence(Duration::from_millis(100 * tenths));
        calls += hand.drain(Link::Parachute).iter().filter(|f| f.message_id == HEARTBEAT_DATA::ID).count();
    }
    assert_eq!(calls, 4, "at once and once a second");
    // The vehicle's own frames, which a router brings to the socket, are no companion's.
    let own = hand.encoder.encode(&greeting());
    hand.decoder.push(&own);
    let frame = hand.decoder.next_frame().unwrap();
    hand.session.handle_input(Link::Parachute, &frame);
    assert_eq!(hand.flies_to(), 0);

    hand.script_says(&greeting());
    assert!(hand.session.companion_starts());
    assert_eq!(hand.flies_to(), 8_000, "to the end of the mission, at the host's pace");
    assert_eq!(hand.companion_events(), [HilEvent::CompanionHeard]);
}

#[test]
fn time_is_two_periods_ahead_of_the_setpoints_at_most() {
    let mut hand = waiting();
    hand.script_says(&setpoint(0));
    assert!(!hand.session.companion_starts());
    assert_eq!((hand.flies_to(), hand.session.missing()), (100, Some(Missing::Setpoint)));
    // 50 Hz, stamped with simulated time, each as late as it may be.
    for stamp in (20..=400).step_by(20) {
        hand.script_says(&setpoint(stamp));
        hand.flies_to();
        assert!(hand.session.now() <= 1_000 * (TimeUs::from(stamp) + 40) || stamp < 100, "{stamp}");
    }
    assert_eq!(hand.flies_to(), 440);
    // Slower, 10 Hz: the longest of the last intervals counts.
    for stamp in (500..=1_000).step_by(100) {
        hand.script_says(&setpoint(stamp));
    }
    assert_eq!(hand.flies_to(), 1_200);
    // Faster again: once eight short intervals have passed.
    for stamp in (1_010..=1_080).step_by(10) {
        hand.script_says(&setpoint(stamp));
    }
    hand.script_says(&setpoint(1_190));
    for stamp in (1_200..=1_270).step_by(10) {
        hand.script_says(&setpoint(stamp));
    }
    assert_eq!(hand.flies_to(), 1_308, "1270 ms and twice the least interval, 20 ms, in steps of 4 ms");
    assert_eq!(hand.companion_events(), [HilEvent::CompanionStreams]);
}

#[test]
fn setpoints_with_another_clock_count_from_when_they_are_heard() {
    for stamp in [0, 77_000_000, u32::MAX] {
        let mut hand = waiting();
        hand.script_says(&greeting());
        hand.fly(3_000_000, 0.0, false);
        for k in 1..=30 {
            hand.script_says(&setpoint(stamp));
            assert_eq!(hand.flies_to(), 3_000 + 100 * k, "stamped {stamp}");
        }
    }
}

#[test]
fn a_companion_that_falls_silent_is_given_up_and_taken_back() {
    let mut hand = waiting();
    hand.script_says(&setpoint(0));
    hand.script_says(&setpoint(20));
    assert_eq!(hand.flies_to(), 60);
    hand.session.handle_silence(Duration::from_millis(4_900));
    assert_eq!(hand.flies_to(), 60);
    hand.session.handle_silence(PATIENCE);
    assert_eq!(hand.session.missing(), None);
    hand.fly(1_000_000, 0.0, false);
    assert_eq!(hand.session.now(), 1_000_000);
    // A message that is no setpoint changes nothing.
    hand.script_says(&greeting());
    assert!(hand.session.next_wake().is_some());
    hand.script_says(&setpoint(1_000));
    assert_eq!(hand.flies_to(), 1_100);
    let expected =
        [HilEvent::CompanionStreams, HilEvent::CompanionSilent(PATIENCE), HilEvent::CompanionStreams];
    assert_eq!(hand.companion_events(), expected);
}

#[test]
fn another_autopilot_finds_time_0_and_the_companion_known() {
    let mut hand = waiting();
    hand.script_says(&setpoint(0));
    hand.flies_to();
    hand.session.peer_left();
    assert_eq!(hand.session.missing(), Some(Missing::Autopilot));
    hand.session.peer_connected();
    assert_eq!(hand.session.now(), 0);
    assert!(hand.session.companion_starts(), "heard; its setpoints are of another flight");
    assert_eq!(hand.flies_to(), 8_000);
}
