//! The simulator's session against a hand that plays the autopilot.

use core::time::Duration;

use mavlink::dialects::common::*;

use super::super::decoder::Decoder;
use super::*;
use crate::sim::{DropRunConfig, ReleaseTrigger};
use crate::test_site;

pub(super) struct Hand {
    pub(super) session: HilSession,
    pub(super) encoder: Encoder,
    pub(super) script: Encoder,
    pub(super) decoder: Decoder,
}

impl Hand {
    pub(super) fn new(config: HilConfig) -> Self {
        Self::with(test_site::drop_simulation(), config)
    }

    pub(super) fn with(sim: DropSimulation, config: HilConfig) -> Self {
        Self {
            session: HilSession::new(sim, config),
            encoder: Encoder::new(1, 1),
            script: Encoder::new(255, 190),
            decoder: Decoder::new(),
        }
    }

    pub(super) fn connected(config: HilConfig) -> Self {
        let mut hand = Self::new(config);
        hand.session.peer_connected();
        hand
    }

    pub(super) fn say(&mut self, message: &MavMessage) {
        self.decoder.push(&self.encoder.encode(message));
        let frame = self.decoder.next_frame().unwrap();
        self.session.handle_input(Link::Simulator, &frame);
    }

    /// HIL_ACTUATOR_CONTROLS with the same command on all motors.
    pub(super) fn answer(&mut self, time_usec: TimeUs, control: f32, armed: bool) {
        let armed = if armed { 128 } else { 0 };
        self.say(&MavMessage::HIL_ACTUATOR_CONTROLS(HIL_ACTUATOR_CONTROLS_DATA {
            time_usec,
            controls: [control; 16],
            mode: MavModeFlag::from_bits_retain(1 | armed),
            ..Default::default()
        }));
    }

    pub(super) fn command(&mut self, link: Link, command: MavCmd, params: [f32; 2], target: (u8, u8)) {
        let message = MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
            command,
            param1: params[0],
            param2: params[1],
            target_system: target.0,
            target_component: target.1,
            ..Default::default()
        });
        let encoder = if link == Link::Parachute { &mut self.script } else { &mut self.encoder };
        self.decoder.push(&encoder.encode(&message));
        let frame = self.decoder.next_frame().unwrap();
        self.session.handle_input(link, &frame);
    }

    /// The next step, if one may be made.
    pub(super) fn step(&mut self) {
        if let Some(at) = self.session.next_wake() {
            self.session.handle_time(at);
        }
    }

    pub(super) fn drain(&mut self, link: Link) -> Vec<Frame> {
        let mut frames = Vec::new();
        while let Some(sent) = self.session.poll_output() {
            if sent.link == link {
                self.decoder.push(&sent.bytes);
                frames.push(self.decoder.next_frame().unwrap());
            }
        }
        frames
    }

    pub(super) fn ids(&mut self) -> Vec<u32> {
        self.drain(Link::Simulator).iter().map(|f| f.message_id).collect()
    }

    pub(super) fn events(&mut self) -> Vec<Timed<HilEvent>> {
        std::iter::from_fn(|| self.session.poll_event()).collect()
    }

    /// Answers every step with `control` until `until`.
    pub(super) fn fly(&mut self, until: TimeUs, control: f32, armed: bool) {
        while self.session.now() < until && self.session.pace() != Pace::Done {
            self.step();
            self.drain(Link::Simulator);
            self.answer(self.session.now(), control, armed);
        }
    }
}

pub(super) fn config() -> HilConfig {
    config_by(ReleaseTrigger::Command)
}

pub(super) fn config_by(trigger: ReleaseTrigger) -> HilConfig {
    let run = DropRunConfig { duration_us: 8_000_000, trigger, ..DropRunConfig::default() };
    HilConfig { run, ..HilConfig::default() }
}

#[test]
fn nothing_moves_without_a_peer() {
    let mut hand = Hand::new(config());
    hand.session.handle_time(1_000_000);
    assert_eq!((hand.session.now(), hand.session.pace()), (0, Pace::NoPeer));
    assert!(hand.ids().is_empty());
}

#[test]
fn a_step_sends_truth_fix_and_sensors_in_this_order_with_its_stamp() {
    let mut hand = Hand::connected(config());
    hand.step();
    let frames = hand.drain(Link::Simulator);
    assert_eq!(frames.iter().map(|f| f.message_id).collect::<Vec<_>>(), [115, 113, 107]);
    assert!(frames.iter().all(|f| f.payload().u64(0) == 4_000 && (f.system_id, f.component_id) == (1, 200)));
    hand.step();
    assert_eq!(hand.ids(), [115, 107]);
}

#[test]
fn free_run_until_the_first_answer_then_one_step_per_answer() {
    let mut hand = Hand::connected(config());
    for _ in 0..40 {
        assert_eq!(hand.session.pace(), Pace::Free);
        hand.step();
    }
    // The first answer is late, as PX4's is: it starts the lockstep, but the present step is still owed one.
    hand.answer(100_000, 0.0, false);
    assert_eq!(hand.session.pace(), Pace::AwaitingControls);
    hand.step();
    assert_eq!(hand.session.now(), 160_000);
    hand.answer(160_000, 0.0, false);
    assert_eq!(hand.session.pace(), Pace::Ready);
    hand.step();
    assert_eq!((hand.session.now(), hand.session.pace()), (164_000, Pace::AwaitingControls));
    assert_eq!((hand.session.counts().steps, hand.session.counts().unanswered), (41, 40));
    assert!(hand.events().contains(&Timed { at: 160_000, event: HilEvent::Lockstep }));
}

/// Whoever starts the simulator first is told what it waits for.
#[test]
fn an_autopilot_that_has_not_connected_is_asked_after() {
    let mut hand = Hand::connected(config());
    hand.session.peer_left();
    hand.events();
    let mut asked = Vec::new();
    for waited in (0..=40).map(Duration::from_secs) {
        hand.session.handle_silence(waited);
        let of_nobody = HilEvent::Waiting { missing: Missing::Autopilot, waited };
        asked.extend(hand.events().iter().filter(|e| e.event == of_nobody).map(|_| waited.as_secs()));
    }
    assert_eq!(asked, [5, 10, 20, 40]);
    assert!(Missing::Autopilot.to_string().contains("TCP 4560 + instance"));
}

#[test]
fn a_peer_that_never_answers_stops_the_free_run_and_is_named() {
    let mut hand = Hand::connected(config());
    for _ in 0..10_000 {
        hand.step();
    }
    assert_eq!((hand.session.now(), hand.session.pace()), (5_000_000, Pace::AwaitingControls));
    hand.events();
    for tenths in 0..100 {
        hand.session.handle_silence(Duration::from_millis(100 * tenths));
    }
    let reports: Vec<String> = hand.events().iter().map(ToString::to_string).collect();
    assert_eq!(reports.len(), 4, "{reports:?}");
    assert_eq!(
        reports[0],
        "   5.000 s  waiting since 1.0 s for any message from the autopilot, which has connected but sent nothing"
    );
    hand.say(&MavMessage::HEARTBEAT(HEARTBEAT_DATA::default()));
    assert_eq!(hand.session.missing(), Some(Missing::ActuatorControls));
}

#[test]
fn answers_from_the_future_are_not_used() {
    let mut hand = Hand::connected(config());
    hand.fly(40_000, 0.0, false);
    hand.step();
    hand.answer(1_000_000, 0.9, true);
    assert_eq!(hand.session.pace(), Pace::AwaitingControls);
    assert_eq!(hand.session.counts().mistimed, 1);
    assert!(hand.events().contains(&Timed { at: 44_000, event: HilEvent::Mistimed(1_000_000) }));
}

#[test]
fn controls_that_are_no_commands_are_tamed_and_counted() {
    let mut hand = Hand::connected(config());
    hand.session.release(ReleaseCause::Command);
    for control in [f32::NAN, f32::INFINITY, -3.0, 1e30] {
        hand.step();
        hand.answer(hand.session.now(), control, true);
        assert!(hand.session.run().throttle()[..4].iter().all(|t| (0.0..=1.0).contains(t)));
    }
    hand.fly(2_000_000, f32::NAN, true);
    assert!(hand.session.run().simulation().state().body.v_ned.iter().all(|v| v.is_finite()));
    assert_eq!(hand.session.counts().clamped, 8);
    assert!(hand.session.counts().not_finite > 8);
    // Motors that are off may say -1.
    hand.step();
    hand.answer(hand.session.now(), -1.0, false);
    assert_eq!(hand.session.counts().clamped, 8);
}

#[test]
fn message_intervals_are_answered_exactly_once_and_odometry_follows() {
    let mut hand = Hand::connected(config());
    let interval = MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL;
    for (params, result) in [([115.0, 5_000.0], 0), ([331.0, 4_000.0], 0), ([107.0, 4_000.0], 2)] {
        hand.command(Link::Simulator, interval, params, (0, 0));
        let acks = hand.drain(Link::Simulator);
        let ack = acks[0].command_ack().unwrap();
        assert_eq!((acks.len(), ack.command, ack.result), (1, 511, result));
        assert_eq!((ack.target_system, ack.target_component), (1, 1));
    }
    hand.command(Link::Simulator, MavCmd::MAV_CMD_DO_SET_MODE, [0.0; 2], (0, 0));
    assert_eq!(hand.drain(Link::Simulator)[0].command_ack().unwrap().result, 3);
    hand.command(Link::Simulator, interval, [331.0, -1.0], (9, 0));
    assert!(hand.ids().is_empty());
    hand.step();
    assert_eq!(hand.ids(), [115, 331, 113, 107]);
}

#[test]
fn a_gripper_command_cuts_now() {
    let mut hand = Hand::connected(config());
    hand.fly(1_000_000, 0.0, true);
    hand.command(Link::Parachute, MavCmd::MAV_CMD_DO_GRIPPER, [0.0, 0.0], (1, 161));
    assert_eq!(hand.session.run().simulation().release_time_s(), Some(1.0));
    let ids: Vec<u32> = hand.drain(Link::Parachute).iter().map(|f| f.message_id).collect();
    assert!(ids.ends_with(&[77, 253, 252]), "{ids:?}");
    hand.fly(2_000_000, 0.0, true);
    let events = hand.events();
    assert!(events.contains(&Timed {
        at: 1_000_000,
        event: HilEvent::Drop(DropEvent::Released { cause: ReleaseCause::Command })
    }));
    assert!(events.contains(&Timed { at: 1_500_000, event: HilEvent::Drop(DropEvent::RotorsFree) }));
}

/// The autopilot passes on the release of a mission's item by its own link, which is where the answer goes.
#[test]
fn a_gripper_command_that_the_autopilot_passes_on_cuts_and_is_answered() {
    let mut hand = Hand::connected(config());
    hand.fly(1_000_000, 0.0, true);
    for (target, answered) in [((1, 200), true), ((1, 1), false), ((1, 161), true)] {
        hand.command(Link::Simulator, MavCmd::MAV_CMD_DO_GRIPPER, [0.0, 0.0], target);
        let acks: Vec<_> = hand.drain(Link::Simulator).iter().filter_map(Frame::command_ack).collect();
        assert_eq!(acks.len(), usize::from(answered), "{target:?}");
        let cut = target.1 == 161;
        assert!(acks.iter().all(|ack| (ack.command, ack.result == 0) == (211, cut)), "{target:?}");
        assert_eq!(hand.session.run().simulation().release_time_s(), cut.then_some(1.0));
    }
}

#[test]
fn the_mission_ends_and_its_log_is_whole() {
    let mut hand = Hand::connected(config());
    hand.fly(20_000_000, 0.0, false);
    assert_eq!((hand.session.now(), hand.session.pace()), (8_000_000, Pace::Done));
    assert_eq!(hand.events().last(), Some(&Timed { at: 8_000_000, event: HilEvent::Finished }));
    let log = hand.session.into_run().into_log();
    assert_eq!(log.len(), 2_001);
    assert!((log[0].t_s, log[2_000].t_s) == (0.0, 8.0));
}

#[test]
fn the_end_is_sent_to_those_who_listen() {
    let mut hand = Hand::connected(config());
    hand.fly(4_000, 0.0, false);
    hand.session.stop();
    assert_eq!(hand.session.pace(), Pace::Done);
    let ids: Vec<u32> = hand.drain(Link::Parachute).iter().map(|f| f.message_id).collect();
    assert_eq!(ids, [253, 252]);
    hand.session.stop();
    assert!(hand.drain(Link::Parachute).is_empty(), "once");
}
