//! The streamer against a scripted vehicle in drops that go otherwise: refusals, silence, late arming, other
//! triggers, new starts, early ends.

use mavlink::dialects::common::{
    EXTENDED_SYS_STATE_DATA, LOCAL_POSITION_NED_DATA, MavLandedState, MavMessage,
};

use super::scripted_vehicle::{Answers, ScriptedVehicle, WILLING};
use super::*;
use crate::link::{CommandAck, Decoder, Encoder};

#[test]
fn a_refusal_is_reported_with_the_vehicles_own_text_and_tried_again() {
    let mut script =
        ScriptedVehicle::new(Answers { arming: Some(1), text: "Preflight Fail: no fix", ..WILLING }, |_| ());
    script.run(2_400_000);
    script.answers = WILLING;
    script.run(12_000_000);
    assert_eq!(script.streamer.state(), StreamerState::Done);
    let refusals: Vec<_> =
        script.events.iter().filter(|e| matches!(e.event, StreamerEvent::Refused { .. })).collect();
    assert_eq!(refusals.len(), 2, "{refusals:?}");
    let StreamerEvent::Refused { what: "arming", result, said } = &refusals[0].event else { panic!() };
    assert_eq!(
        (result.as_str(), said.as_slice()),
        ("TEMPORARILY_REJECTED", &["Preflight Fail: no fix".to_owned()][..])
    );
    let confirmations: Vec<u8> = script
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
        let mut script = ScriptedVehicle::new(answers, |_| ());
        script.run(20_000_000);
        assert_eq!(script.streamer.state(), StreamerState::Failed);
        let Some(Timed { at, event: StreamerEvent::Failed(reported) }) = script.events.last() else {
            panic!()
        };
        assert_eq!(reported, reason);
        // A dead script's setpoints do not go on.
        assert!(script.sent.iter().all(|(t, _)| t <= at));
    }
}

#[test]
fn in_progress_is_not_an_answer_yet_and_others_acks_are_not_ours() {
    let mut script = ScriptedVehicle::new(Answers { offboard: Some(5), ..WILLING }, |_| ());
    script.run(1_000_000);
    assert_eq!(script.streamer.state(), StreamerState::RequestingOffboard);
    let foreign =
        CommandAck { command: 176, target_system: 255, target_component: 190, ..CommandAck::default() };
    let bytes = script.vehicle.encode_command_ack(&foreign);
    script.hear(&bytes);
    let from_parachute = CommandAck { target_system: 245, ..foreign };
    let bytes = script.parachute.encode_command_ack(&from_parachute);
    script.hear(&bytes);
    script.run(1_100_000);
    assert_eq!(script.streamer.state(), StreamerState::RequestingOffboard);
    script.answers = WILLING;
    script.run(2_000_000);
    assert_eq!(script.streamer.state(), StreamerState::Hanging);
}

#[test]
fn a_release_that_something_else_triggers_is_followed() {
    let mut script = ScriptedVehicle::new(WILLING, |c| c.commands_release = false);
    script.run(6_000_000);
    assert_eq!(script.streamer.state(), StreamerState::Hanging);
    script.report_release(5_996_000);
    script.run(6_100_000);
    assert_eq!(script.streamer.state(), StreamerState::Falling);
    script.run(6_600_000);
    // Off the 20 ms grid of before: setpoints go by the plan's time.
    assert_eq!(script.setpoints(84)[0].0, 6_492_000);
    assert_eq!(script.streamer.plan_start(), Some(6_496_000));
    assert!(script.sent.iter().filter_map(|(_, f)| f.command()).all(|c| c.command != 211));
}

#[test]
fn without_a_report_of_the_instant_the_acknowledgement_counts() {
    let mut script = ScriptedVehicle::new(Answers { tells_release: false, ..WILLING }, |_| ());
    script.run(12_000_000);
    let released = |e: &Timed<StreamerEvent>| match e.event {
        StreamerEvent::Released { released_at, reported } => Some((released_at, reported)),
        _ => None,
    };
    assert_eq!(script.events.iter().find_map(released), Some((5_000_000, false)));
}

#[test]
fn a_late_armed_vehicle_has_time_to_settle() {
    let mut script = ScriptedVehicle::new(Answers { arming: Some(1), ..WILLING }, |c| c.attempts = 20);
    script.run(4_800_000);
    script.answers = WILLING;
    script.run(9_000_000);
    let at = |event| script.events.iter().find(|e| e.event == event).unwrap().at;
    assert_eq!(at(StreamerEvent::ReleaseAsked), at(StreamerEvent::Armed) + 3_000_000);
}

#[test]
fn a_vehicle_that_starts_over_is_followed_and_one_that_disarms_is_reported() {
    let mut script = ScriptedVehicle::new(WILLING, |_| ());
    script.run(6_000_000);
    script.armed = false;
    script.run(7_100_000);
    let lost = |e: &&Timed<StreamerEvent>| matches!(e.event, StreamerEvent::Lost { .. });
    assert_eq!(script.events.iter().filter(lost).count(), 2);
    script.now = 0;
    script.run(12_000_000);
    assert_eq!(script.events.iter().filter(|e| e.event == StreamerEvent::VehicleRestarted).count(), 1);
    assert_eq!(script.streamer.state(), StreamerState::Done);
}

/// Drives the streamer into a state.
fn scene_in(state: StreamerState) -> ScriptedVehicle {
    let answers = match state {
        StreamerState::RequestingOffboard => Answers { offboard: Some(5), ..WILLING },
        StreamerState::Arming => Answers { arming: Some(5), ..WILLING },
        StreamerState::Releasing => Answers { release: Some(5), ..WILLING },
        _ => WILLING,
    };
    let mut script = ScriptedVehicle::new(answers, |c| c.end_s = None);
    while script.streamer.state() != state {
        script.run(script.now + 4_000);
        assert!(script.now < 20_000_000, "never {state:?}");
    }
    script.events.clear();
    script
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

fn last_event(script: &mut ScriptedVehicle) -> String {
    std::iter::from_fn(|| script.streamer.poll_event()).last().unwrap().to_string()
}

#[test]
fn the_simulations_end_ends_the_stream_in_every_state() {
    for state in BEFORE_THE_PLANS_END {
        let mut script = scene_in(state);
        script.report_instant("t_end", 20_000_000);
        assert_eq!(script.streamer.state(), StreamerState::Failed, "{state:?}");
        let last = last_event(&mut script);
        assert!(
            last.ends_with("gave up: the simulation ended at 20.000 s, and the plan is not at its end"),
            "{last}"
        );
    }
    let mut script = scene_in(StreamerState::Target);
    script.report_instant("t_end", 20_000_000);
    assert_eq!(script.streamer.state(), StreamerState::Done);
    // Who has not met a vehicle yet waits on.
    let mut script = ScriptedVehicle::new(WILLING, |_| ());
    script.report_instant("t_end", 20_000_000);
    assert_eq!(script.streamer.state(), StreamerState::WaitingForVehicle);
}

/// EXTENDED_SYS_STATE of a vehicle, once the test lets it be careful.
fn shows_landed_state(script: &mut ScriptedVehicle, landed_state: MavLandedState) {
    script.streamer.flight.config.procedure = Some(Procedure::default());
    script.vehicle_says(&MavMessage::EXTENDED_SYS_STATE(EXTENDED_SYS_STATE_DATA {
        landed_state,
        ..Default::default()
    }));
}

/// PX4 says ON_GROUND when it has landed, or falls too slowly for it. What has been streamed stays streamed.
#[test]
fn a_landing_takes_nothing_back() {
    for state in [StreamerState::Tracking, StreamerState::Target] {
        let mut script = scene_in(state);
        shows_landed_state(&mut script, MavLandedState::MAV_LANDED_STATE_ON_GROUND);
        script.run(script.now + 100_000);
        assert_eq!(script.streamer.state(), state);
        assert!(!script.events.iter().any(|e| e.event == StreamerEvent::HeldBack));
        let (_, last) = script.sent.iter().rfind(|(_, f)| matches!(f.message_id, 82 | 84)).unwrap();
        assert_eq!(last.message_id, 84, "velocities, not the level attitude without thrust");
        script.run(script.now + 3_000_000);
        script.report_instant("t_end", 20_000_000);
        assert_eq!(script.streamer.state(), StreamerState::Done);
    }
}

#[test]
fn velocities_wait_while_the_vehicle_believes_to_be_on_the_ground() {
    let mut script = scene_in(StreamerState::Falling);
    shows_landed_state(&mut script, MavLandedState::MAV_LANDED_STATE_ON_GROUND);
    script.run(script.now + 1_000_000);
    assert_eq!(script.streamer.state(), StreamerState::Falling);
    let held = |e: &&Timed<StreamerEvent>| e.event == StreamerEvent::HeldBack;
    assert_eq!(script.events.iter().filter(held).count(), 1);
    shows_landed_state(&mut script, MavLandedState::MAV_LANDED_STATE_IN_AIR);
    script.run(script.now + 4_000);
    assert_eq!(script.streamer.state(), StreamerState::Tracking);
}

#[test]
fn a_vehicle_that_stays_silent_is_gone_in_every_state() {
    let silent_for = |script: &mut ScriptedVehicle, s: u64| {
        (0..=10 * s).for_each(|tenths| script.streamer.handle_silence(Duration::from_millis(100 * tenths)));
    };
    for state in BEFORE_THE_PLANS_END {
        let mut script = scene_in(state);
        silent_for(&mut script, 14);
        assert_eq!(script.streamer.state(), state, "it may be starting anew");
        silent_for(&mut script, 15);
        assert_eq!(script.streamer.state(), StreamerState::Failed, "{state:?}");
        let last = last_event(&mut script);
        assert!(last.contains("the vehicle has said nothing for 15.0 s"), "{last}");
    }
    let mut script = scene_in(StreamerState::Target);
    silent_for(&mut script, 4);
    assert_eq!(script.streamer.state(), StreamerState::Done);
    let mut script = ScriptedVehicle::new(WILLING, |_| ());
    silent_for(&mut script, 1_000);
    assert_eq!(script.streamer.state(), StreamerState::WaitingForVehicle);
}

/// At a thousandth of real time an ATTITUDE comes every four seconds.
#[test]
fn a_slow_clock_is_not_taken_for_a_vehicle_that_is_gone() {
    let mut script = scene_in(StreamerState::Target);
    for _ in 0..3 {
        script.streamer.handle_silence(Duration::from_millis(3_900));
        script.run(script.now + 4_000);
    }
    script.streamer.handle_silence(Duration::from_millis(15_500));
    assert_eq!(script.streamer.state(), StreamerState::Target);
    script.streamer.handle_silence(Duration::from_millis(15_600));
    assert_eq!(script.streamer.state(), StreamerState::Done);
}

#[test]
fn silence_names_what_is_missing() {
    let mut script = ScriptedVehicle::new(WILLING, |_| ());
    for s in 1..10 {
        script.streamer.handle_silence(Duration::from_secs(s));
    }
    let reports: Vec<Timed<StreamerEvent>> = std::iter::from_fn(|| script.streamer.poll_event()).collect();
    assert_eq!(reports.len(), 3, "{reports:?}");
    assert!(
        reports[0].to_string().ends_with("waiting since 2.0 s for HEARTBEAT from the autopilot of system 1")
    );
    script.run(1_000_000);
    script.streamer.handle_silence(Duration::from_secs(2));
    let Some(event) = script.streamer.poll_event() else { panic!() };
    assert!(event.to_string().contains("ATTITUDE"), "{event}");
}

/// A velocity that is no number is none: the setpoint of least thrust would be made of it.
#[test]
fn a_velocity_that_is_no_number_is_not_taken() {
    let mut script = ScriptedVehicle::new(WILLING, |_| ());
    script.run(1_000_000);
    let tell = |script: &mut ScriptedVehicle, v: [f32; 3]| {
        let [vx, vy, vz] = v;
        let position = LOCAL_POSITION_NED_DATA { time_boot_ms: 1_000, vx, vy, vz, ..Default::default() };
        let bytes = Encoder::new(1, 1).encode(&MavMessage::LOCAL_POSITION_NED(position));
        Decoder::new().datagram(&bytes, |frame| script.streamer.handle_input(Link::Api, &frame));
        script.streamer.flight.vehicle.velocity_ned
    };
    let known = tell(&mut script, [1.0, 2.0, 3.0]);
    assert_eq!(known, Some((1_000_000, Vector3::new(1.0, 2.0, 3.0))));
    for v in [[f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.0], [0.0, 0.0, f32::NEG_INFINITY]] {
        assert_eq!(tell(&mut script, v), known, "{v:?}");
    }
}
