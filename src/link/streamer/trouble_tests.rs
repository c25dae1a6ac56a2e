//! The streamer against a scripted vehicle in drops that go otherwise: refusals, silence, late arming, other triggers, new starts,
//! early ends.

use mavlink::dialects::common::{EXTENDED_SYS_STATE_DATA, MavLandedState, MavMessage};

use super::super::CommandAck;
use super::scene::{Answers, Scene, WILLING};
use super::*;

#[test]
fn a_refusal_is_told_with_the_vehicles_own_words_and_tried_again() {
    let mut scene =
        Scene::new(Answers { arming: Some(1), text: "Preflight Fail: no fix", ..WILLING }, |_| ());
    scene.run(2_400_000);
    scene.answers = WILLING;
    scene.run(12_000_000);
    assert_eq!(scene.streamer.state(), StreamerState::Done);
    let refusals: Vec<_> =
        scene.events.iter().filter(|e| matches!(e.event, StreamerEvent::Refused { .. })).collect();
    assert_eq!(refusals.len(), 2, "{refusals:?}");
    let StreamerEvent::Refused { what: "arming", result, said } = &refusals[0].event else { panic!() };
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
        let Some(Timed { at, event: StreamerEvent::Failed { reason: told } }) = scene.events.last() else {
            panic!()
        };
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
    let told = |e: &Timed<StreamerEvent>| match e.event {
        StreamerEvent::Released { released_at, told } => Some((released_at, told)),
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
    let at = |event| scene.events.iter().find(|e| e.event == event).unwrap().at;
    assert_eq!(at(StreamerEvent::ReleaseAsked), at(StreamerEvent::Armed) + 3_000_000);
}

#[test]
fn a_vehicle_that_starts_over_is_followed_and_one_that_disarms_is_told() {
    let mut scene = Scene::new(WILLING, |_| ());
    scene.run(6_000_000);
    scene.armed = false;
    scene.run(7_100_000);
    let lost = |e: &&Timed<StreamerEvent>| matches!(e.event, StreamerEvent::Lost { .. });
    assert_eq!(scene.events.iter().filter(lost).count(), 2);
    scene.now = 0;
    scene.run(12_000_000);
    assert_eq!(scene.events.iter().filter(|e| e.event == StreamerEvent::VehicleRestarted).count(), 1);
    assert_eq!(scene.streamer.state(), StreamerState::Done);
}

/// Drives the streamer into a state.
fn scene_in(state: StreamerState) -> Scene {
    let answers = match state {
        StreamerState::RequestingOffboard => Answers { offboard: Some(5), ..WILLING },
        StreamerState::Arming => Answers { arming: Some(5), ..WILLING },
        StreamerState::Releasing => Answers { release: Some(5), ..WILLING },
        _ => WILLING,
    };
    let mut scene = Scene::new(answers, |c| c.end_s = None);
    while scene.streamer.state() != state {
        scene.run(scene.now + 4_000);
        assert!(scene.now < 20_000_000, "never {state:?}");
    }
    scene.events.clear();
    scene
}

const BEFORE_THE_PLANS_END: [StreamerState; 7] = [
    StreamerState::Streaming,
    StreamerState::RequestingOffboard,
    StreamerState::Arming,
    StreamerState::Hanging,
    StreamerState::Releasing,
    StreamerState::Falling,
    StreamerState::Tracking,
];

fn last_event(scene: &mut Scene) -> String {
    std::iter::from_fn(|| scene.streamer.poll_event()).last().unwrap().to_string()
}

#[test]
fn the_simulations_end_ends_the_stream_in_every_state() {
    for state in BEFORE_THE_PLANS_END {
        let mut scene = scene_in(state);
        scene.tell_instant("t_end", 20_000_000);
        assert_eq!(scene.streamer.state(), StreamerState::Failed, "{state:?}");
        let told = last_event(&mut scene);
        assert!(
            told.ends_with("gave up: the simulation ended at 20.000 s, and the plan is not at its end"),
            "{told}"
        );
    }
    let mut scene = scene_in(StreamerState::Target);
    scene.tell_instant("t_end", 20_000_000);
    assert_eq!(scene.streamer.state(), StreamerState::Done);
    // Who has not met a vehicle yet waits on.
    let mut scene = Scene::new(WILLING, |_| ());
    scene.tell_instant("t_end", 20_000_000);
    assert_eq!(scene.streamer.state(), StreamerState::WaitingForVehicle);
}

/// EXTENDED_SYS_STATE of a vehicle, once it has been told to be careful.
fn shows_landed_state(scene: &mut Scene, landed_state: MavLandedState) {
    scene.streamer.config.procedure = Some(Procedure::default());
    scene.vehicle_says(&MavMessage::EXTENDED_SYS_STATE(EXTENDED_SYS_STATE_DATA {
        landed_state,
        ..Default::default()
    }));
}

/// PX4 says ON_GROUND when it has landed, or falls too slowly for it. What has been streamed stays streamed.
#[test]
fn a_landing_takes_nothing_back() {
    for state in [StreamerState::Tracking, StreamerState::Target] {
        let mut scene = scene_in(state);
        shows_landed_state(&mut scene, MavLandedState::MAV_LANDED_STATE_ON_GROUND);
        scene.run(scene.now + 100_000);
        assert_eq!(scene.streamer.state(), state);
        assert!(!scene.events.iter().any(|e| e.event == StreamerEvent::HeldBack));
        let (_, last) = scene.sent.iter().rfind(|(_, f)| matches!(f.message_id, 82 | 84)).unwrap();
        assert_eq!(last.message_id, 84, "velocities, not the level attitude without thrust");
        scene.run(scene.now + 3_000_000);
        scene.tell_instant("t_end", 20_000_000);
        assert_eq!(scene.streamer.state(), StreamerState::Done);
    }
}

#[test]
fn velocities_wait_while_the_vehicle_believes_to_be_on_the_ground() {
    let mut scene = scene_in(StreamerState::Falling);
    shows_landed_state(&mut scene, MavLandedState::MAV_LANDED_STATE_ON_GROUND);
    scene.run(scene.now + 1_000_000);
    assert_eq!(scene.streamer.state(), StreamerState::Falling);
    let held = |e: &&Timed<StreamerEvent>| e.event == StreamerEvent::HeldBack;
    assert_eq!(scene.events.iter().filter(held).count(), 1);
    shows_landed_state(&mut scene, MavLandedState::MAV_LANDED_STATE_IN_AIR);
    scene.run(scene.now + 4_000);
    assert_eq!(scene.streamer.state(), StreamerState::Tracking);
}

#[test]
fn a_vehicle_that_stays_silent_is_gone_in_every_state() {
    let silent_for = |scene: &mut Scene, s: u64| {
        (0..=10 * s).for_each(|tenths| scene.streamer.handle_silence(Duration::from_millis(100 * tenths)));
    };
    for state in BEFORE_THE_PLANS_END {
        let mut scene = scene_in(state);
        silent_for(&mut scene, 14);
        assert_eq!(scene.streamer.state(), state, "it may be starting anew");
        silent_for(&mut scene, 15);
        assert_eq!(scene.streamer.state(), StreamerState::Failed, "{state:?}");
        let told = last_event(&mut scene);
        assert!(told.contains("the vehicle has said nothing for 15.0 s"), "{told}");
    }
    let mut scene = scene_in(StreamerState::Target);
    silent_for(&mut scene, 4);
    assert_eq!(scene.streamer.state(), StreamerState::Done);
    let mut scene = Scene::new(WILLING, |_| ());
    silent_for(&mut scene, 1_000);
    assert_eq!(scene.streamer.state(), StreamerState::WaitingForVehicle);
}

/// At a thousandth of real time an ATTITUDE comes every four seconds.
#[test]
fn a_slow_clock_is_not_taken_for_a_vehicle_that_is_gone() {
    let mut scene = scene_in(StreamerState::Target);
    for _ in 0..3 {
        scene.streamer.handle_silence(Duration::from_millis(3_900));
        scene.run(scene.now + 4_000);
    }
    scene.streamer.handle_silence(Duration::from_millis(15_500));
    assert_eq!(scene.streamer.state(), StreamerState::Target);
    scene.streamer.handle_silence(Duration::from_millis(15_600));
    assert_eq!(scene.streamer.state(), StreamerState::Done);
}

#[test]
fn silence_names_what_is_missing() {
    let mut scene = Scene::new(WILLING, |_| ());
    for s in 1..10 {
        scene.streamer.handle_silence(Duration::from_secs(s));
    }
    let told: Vec<Timed<StreamerEvent>> = std::iter::from_fn(|| scene.streamer.poll_event()).collect();
    assert_eq!(told.len(), 3, "{told:?}");
    assert!(
        told[0].to_string().ends_with("waiting since 2.0 s for HEARTBEAT from the autopilot of system 1")
    );
    scene.run(1_000_000);
    scene.streamer.handle_silence(Duration::from_secs(2));
    let Some(event) = scene.streamer.poll_event() else { panic!() };
    assert!(event.to_string().contains("ATTITUDE"), "{event}");
}
