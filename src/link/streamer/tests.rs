//! The streamer against a scripted vehicle.

use mavlink::dialects::common::*;
use nalgebra::Vector3;

use super::super::{CommandAck, Decoder, Encoder, Frame, Link, Session, TimeUs};
use super::*;
use crate::frames::LEVEL;
use crate::trajectory::Node;

/// A plan from 3 m/s down to 1 m/s north in 2 s.
fn plan() -> Trajectory {
    let node = |t_s: f64, v_ned| Node {
        t_s,
        q_ned_from_body: LEVEL,
        v_ned,
        omega_body: Vector3::zeros(),
        thrust_n: [0.0; 8],
        a_ned: Vector3::zeros(),
    };
    Trajectory::new(vec![node(0.0, Vector3::new(0.0, 0.0, 3.0)), node(2.0, Vector3::x())], 4).unwrap()
}

/// What the vehicle and its parachute answer.
#[derive(Clone, Copy)]
struct Answers {
    offboard: Option<u8>,
    arming: Option<u8>,
    release: Option<u8>,
    tells_release: bool,
    text: &'static str,
}

const WILLING: Answers =
    Answers { offboard: Some(0), arming: Some(0), release: Some(0), tells_release: true, text: "" };

struct Scene {
    streamer: StreamerSession,
    vehicle: Encoder,
    parachute: Encoder,
    decoder: Decoder,
    answers: Answers,
    armed: bool,
    now: TimeUs,
    /// Everything that the streamer sent, with its time.
    sent: Vec<(TimeUs, Frame)>,
    events: Vec<StreamerEvent>,
}

impl Scene {
    fn new(answers: Answers, change: impl FnOnce(&mut StreamerConfig)) -> Self {
        let mut config = StreamerConfig {
            hang_s: 5.0,
            target_v_ned: Vector3::new(1.0, 0.0, 0.5),
            end_s: Some(3.0),
            attempts: 3,
            ..StreamerConfig::default()
        };
        change(&mut config);
        Self {
            streamer: StreamerSession::new(config, plan()),
            vehicle: Encoder::new(1, 1),
            parachute: Encoder::new(1, 161),
            decoder: Decoder::new(),
            answers,
            armed: false,
            now: 0,
            sent: Vec::new(),
            events: Vec::new(),
        }
    }

    fn hear(&mut self, bytes: &[u8]) {
        self.decoder.push(bytes);
        let frame = self.decoder.next_frame().unwrap();
        self.streamer.handle_input(0, Link::Api, &frame);
    }

    fn vehicle_says(&mut self, message: &MavMessage) {
        let bytes = self.vehicle.encode(message);
        self.hear(&bytes);
    }

    fn heartbeat(&mut self) {
        let armed = if self.armed { 128 } else { 0 };
        self.vehicle_says(&MavMessage::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode: if self.armed { 6 << 16 } else { 0 },
            base_mode: MavModeFlag::from_bits_retain(1 | armed),
            ..Default::default()
        }));
    }

    /// Steps of 4 ms, with all that the vehicle does in them, until `until`.
    fn run(&mut self, until: TimeUs) {
        while self.now < until {
            self.now += 4_000;
            if self.now % 1_000_000 == 4_000 {
                self.heartbeat();
            }
            let time_boot_ms = (self.now / 1_000) as u32;
            self.vehicle_says(&MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms, ..Default::default() }));
            while let Some(sent) = self.streamer.poll_output() {
                self.decoder.push(&sent.bytes);
                let frame = self.decoder.next_frame().unwrap();
                self.answer(&frame);
                self.sent.push((self.now, frame));
            }
            self.events.extend(std::iter::from_fn(|| self.streamer.poll_event()));
        }
    }

    fn answer(&mut self, frame: &Frame) {
        let Some(command) = frame.command() else { return };
        let result = match command.command {
            176 => self.answers.offboard,
            400 => self.answers.arming,
            211 => self.answers.release,
            _ => None,
        };
        let Some(result) = result else { return };
        self.armed |= command.command == 400 && result == 0;
        let to_parachute = command.command == 211;
        let encoder = if to_parachute { &mut self.parachute } else { &mut self.vehicle };
        let (target_system, target_component) = (STREAMER_SYSTEM, STREAMER_COMPONENT);
        let ack = CommandAck {
            command: command.command,
            result,
            target_system,
            target_component,
            ..Default::default()
        };
        let bytes = encoder.encode_command_ack(&ack);
        self.hear(&bytes);
        if !self.answers.text.is_empty() {
            let text = self.answers.text.into();
            self.vehicle_says(&MavMessage::STATUSTEXT(STATUSTEXT_DATA { text, ..Default::default() }));
        }
        if to_parachute && result == 0 && self.answers.tells_release {
            self.tell_release(self.now);
        }
    }

    fn tell_release(&mut self, at: TimeUs) {
        let bytes = self.parachute.encode(&MavMessage::NAMED_VALUE_INT(NAMED_VALUE_INT_DATA {
            time_boot_ms: 0,
            value: (at / 1_000) as i32,
            name: "t_release".into(),
        }));
        self.hear(&bytes);
    }

    fn setpoints(&self, message_id: u32) -> Vec<&(TimeUs, Frame)> {
        self.sent.iter().filter(|(_, f)| f.message_id == message_id).collect()
    }
}

fn texts(events: &[StreamerEvent]) -> Vec<String> {
    events.iter().map(ToString::to_string).collect()
}

#[test]
fn a_willing_vehicle_is_taken_through_all_states() {
    let mut scene = Scene::new(WILLING, |_| ());
    scene.run(12_000_000);
    assert_eq!(scene.streamer.state(), StreamerState::Done);
    let expected = [
        "   0.004 s  vehicle 1 heard, streaming level attitude, no thrust",
        "   0.508 s  OFFBOARD accepted",
        "   0.512 s  armed",
        "   5.000 s  release commanded",
        "   5.000 s  released at 5.000 s",
        "   5.496 s  streaming the plan",
        "   7.496 s  plan at its end, streaming the target velocity",
        "   8.500 s  stream ended",
    ];
    assert_eq!(texts(&scene.events), expected);
}

#[test]
fn setpoints_come_at_50_hz_ahead_of_their_time_with_the_right_masks() {
    let mut scene = Scene::new(WILLING, |_| ());
    scene.run(12_000_000);
    let level = scene.setpoints(82);
    let velocity = scene.setpoints(84);
    // t = 0 at 5.5 s; the end at 8.5 s.
    assert_eq!(velocity.len(), 151);
    assert_eq!((velocity[0].0, velocity[150].0), (5_496_000, 8_496_000));
    assert!(velocity.windows(2).all(|w| w[1].0 - w[0].0 == 20_000));
    assert!(level[1..].windows(2).all(|w| w[1].0 - w[0].0 == 20_000));
    assert_eq!(level.last().unwrap().0, 5_476_000);
    let Some(MavMessage::SET_ATTITUDE_TARGET(m)) = level[0].1.known() else { panic!() };
    assert_eq!((m.type_mask.bits(), m.thrust, m.q), (7, 0.0, [1.0, 0.0, 0.0, 0.0]));
    for (i, (_, frame)) in velocity.iter().enumerate() {
        let Some(MavMessage::SET_POSITION_TARGET_LOCAL_NED(m)) = frame.known() else { panic!() };
        let t = i as f64 * 0.02;
        let v = if t < 1.999 { plan().velocity_ned(t) } else { Vector3::new(1.0, 0.0, 0.5) };
        assert_eq!([m.vx, m.vy, m.vz], [v.x as f32, v.y as f32, v.z as f32], "{t}");
        assert_eq!((m.type_mask.bits(), m.coordinate_frame as u8), (0x0DC7, 1));
        assert_eq!((m.target_system, m.target_component), (1, 1));
    }
}

#[test]
fn feed_forward_sends_the_acceleration_with_its_mask() {
    let mut scene = Scene::new(WILLING, |c| c.feed_forward = true);
    scene.run(7_000_000);
    let velocity = scene.setpoints(84);
    let Some(MavMessage::SET_POSITION_TARGET_LOCAL_NED(m)) = velocity[20].1.known() else { panic!() };
    assert_eq!(m.type_mask.bits(), 0x0C07);
    assert_eq!(m.afx, plan().acceleration_ned(0.4).x as f32);
    assert!(m.afx > 0.1);
}

#[test]
fn a_refusal_is_told_with_the_vehicles_own_words_and_tried_again() {
    let mut scene =
        Scene::new(Answers { arming: Some(1), text: "Preflight Fail: no fix", ..WILLING }, |_| ());
    scene.run(2_400_000);
    scene.answers = WILLING;
    scene.run(12_000_000);
    assert_eq!(scene.streamer.state(), StreamerState::Done);
    let refusals: Vec<_> =
        scene.events.iter().filter(|e| matches!(e, StreamerEvent::Refused { .. })).collect();
    assert_eq!(refusals.len(), 2, "{refusals:?}");
    let StreamerEvent::Refused { what: "arming", result, said, .. } = refusals[0] else { panic!() };
    assert_eq!(
        (result.as_str(), said.as_slice()),
        ("TEMPORARILY_REJECTED", &["Preflight Fail: no fix".to_owned()][..])
    );
    let confirmations: Vec<u8> = scene
        .sent
        .iter()
        .filter_map(|(_, f)| f.command())
        .filter(|c| c.command == 400)
        .map(|c| c.confirmation)
        .collect();
    assert_eq!(confirmations, [0, 1, 2]);
}

#[test]
fn what_stays_refused_or_unanswered_is_given_up_and_explained() {
    for (answers, reason) in [
        (Answers { offboard: Some(2), ..WILLING }, "OFFBOARD was refused (DENIED) by the autopilot"),
        (Answers { offboard: Some(3), ..WILLING }, "OFFBOARD was refused (UNSUPPORTED) by the autopilot"),
        (Answers { arming: None, ..WILLING }, "arming was never answered by the autopilot"),
        (Answers { release: None, ..WILLING }, "release was never answered by the parachute"),
        (Answers { release: Some(200), ..WILLING }, "release was refused (result 200) by the parachute"),
    ] {
        let mut scene = Scene::new(answers, |_| ());
        scene.run(20_000_000);
        assert_eq!(scene.streamer.state(), StreamerState::Failed);
        let Some(StreamerEvent::Failed { reason: told, at }) = scene.events.last() else { panic!() };
        assert_eq!(told, reason);
        // A dead script's setpoints do not go on.
        assert!(scene.sent.iter().all(|(t, _)| t <= at));
    }
}

#[test]
fn in_progress_is_not_an_answer_yet_and_others_acks_are_not_ours() {
    let mut scene = Scene::new(Answers { offboard: Some(5), ..WILLING }, |_| ());
    scene.run(1_000_000);
    assert_eq!(scene.streamer.state(), StreamerState::RequestingOffboard);
    let foreign =
        CommandAck { command: 176, target_system: 255, target_component: 190, ..CommandAck::default() };
    let bytes = scene.vehicle.encode_command_ack(&foreign);
    scene.hear(&bytes);
    let from_parachute = CommandAck { target_system: 245, ..foreign };
    let bytes = scene.parachute.encode_command_ack(&from_parachute);
    scene.hear(&bytes);
    scene.run(1_100_000);
    assert_eq!(scene.streamer.state(), StreamerState::RequestingOffboard);
    scene.answers = WILLING;
    scene.run(2_000_000);
    assert_eq!(scene.streamer.state(), StreamerState::Hanging);
}

#[test]
fn a_release_that_something_else_triggers_is_followed() {
    let mut scene = Scene::new(WILLING, |c| c.commands_release = false);
    scene.run(6_000_000);
    assert_eq!(scene.streamer.state(), StreamerState::Hanging);
    scene.tell_release(5_996_000);
    scene.run(6_100_000);
    assert_eq!(scene.streamer.state(), StreamerState::Falling);
    scene.run(6_600_000);
    // Off the 20 ms grid of before: setpoints go by the plan's time.
    assert_eq!(scene.setpoints(84)[0].0, 6_492_000);
    assert_eq!(scene.streamer.plan_start(), Some(6_496_000));
    assert!(scene.sent.iter().filter_map(|(_, f)| f.command()).all(|c| c.command != 211));
}

#[test]
fn without_word_of_the_instant_the_acknowledgement_counts() {
    let mut scene = Scene::new(Answers { tells_release: false, ..WILLING }, |_| ());
    scene.run(12_000_000);
    let told = |e: &StreamerEvent| match e {
        StreamerEvent::Released { released_at, told, .. } => Some((*released_at, *told)),
        _ => None,
    };
    assert_eq!(scene.events.iter().find_map(told), Some((5_000_000, false)));
}

#[test]
fn a_late_armed_vehicle_has_time_to_settle() {
    let mut scene = Scene::new(Answers { arming: Some(1), ..WILLING }, |c| c.attempts = 20);
    scene.run(4_800_000);
    scene.answers = WILLING;
    scene.run(9_000_000);
    let asked = |e: &StreamerEvent| match e {
        StreamerEvent::ReleaseAsked { at } => Some(*at),
        _ => None,
    };
    let armed = |e: &StreamerEvent| match e {
        StreamerEvent::Armed { at } => Some(*at),
        _ => None,
    };
    let (asked, armed) =
        (scene.events.iter().find_map(asked).unwrap(), scene.events.iter().find_map(armed).unwrap());
    assert_eq!(asked, armed + 3_000_000);
}

#[test]
fn a_vehicle_that_starts_over_is_followed_and_one_that_disarms_is_told() {
    let mut scene = Scene::new(WILLING, |_| ());
    scene.run(6_000_000);
    scene.armed = false;
    scene.run(7_100_000);
    let lost = |e: &&StreamerEvent| matches!(e, StreamerEvent::Lost { .. });
    assert_eq!(scene.events.iter().filter(lost).count(), 2);
    scene.now = 0;
    scene.run(12_000_000);
    assert_eq!(
        scene.events.iter().filter(|e| matches!(e, StreamerEvent::VehicleRestarted { .. })).count(),
        1
    );
    assert_eq!(scene.streamer.state(), StreamerState::Done);
}

#[test]
fn silence_names_what_is_missing() {
    let mut scene = Scene::new(WILLING, |_| ());
    for s in 1..10 {
        scene.streamer.handle_silence(Duration::from_secs(s));
    }
    let told: Vec<StreamerEvent> = std::iter::from_fn(|| scene.streamer.poll_event()).collect();
    assert_eq!(told.len(), 3, "{told:?}");
    assert!(
        told[0].to_string().ends_with("waiting since 2.0 s for HEARTBEAT from the autopilot of system 1")
    );
    scene.run(1_000_000);
    scene.streamer.handle_silence(Duration::from_secs(2));
    let Some(event) = scene.streamer.poll_event() else { panic!() };
    assert!(event.to_string().contains("ATTITUDE"), "{event}");
}
