//! Whole drops on the wire in memory: against the same flight without frames, and against themselves.
#![cfg(all(feature = "files", feature = "link"))]

pub mod bench;
mod estimator;
mod failsafes;
mod faults;
mod flood;
mod flood_with_key;
mod froude;
mod ground;
mod ground_bench;
mod manoeuvre;
mod releases;
#[cfg(feature = "cli")]
mod sockets;
mod sticks;

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd, MavMessage};
use samara::assess::{Verdict, VerdictBuilder};
use samara::link::{Decoder, Encoder, Link, Lockstep, StreamerEvent, TimeUs};
use samara::model::Parachute;
use samara::model::parachute::Pendulum;
use samara::sim::{DropSimulation, FlightPlan, Phase, Reference, ReleaseTrigger, Sample, Start};

use bench::{
    drop_on_the_wire, fly, mission, plan, simulation, simulation_of, simulator, simulator_of, streamer,
};

fn verdict(log: &[Sample]) -> Verdict {
    let mission = mission();
    let mut builder = VerdictBuilder::new(mission.limits.safety, mission.target_v_ned);
    log.iter().for_each(|s| builder.observe(s));
    builder.finish().unwrap()
}

/// The flight that the wire should give: 250 Hz, setpoints held at 50 Hz, true state.
fn without_frames(mut sim: DropSimulation) -> Vec<Sample> {
    let mission = mission();
    let trajectory = plan();
    sim.schedule_release(mission.release.hang_s);
    let flight = FlightPlan {
        setpoint_period_s: Some(0.02),
        ..FlightPlan::new(
            Reference::Plan {
                trajectory: &trajectory,
                then_v_ned: Some(mission.target_v_ned),
                feed_forward: false,
            },
            0.004,
            mission.duration_s,
        )
    };
    let mut log = Vec::new();
    let _ = samara::sim::fly(&mut sim, &mut bench::cascade(), &flight, &mut |s| {
        log.push(*s);
        ControlFlow::Continue(())
    });
    log
}

/// Flies it both ways.
fn the_wire_gives_the_flight_without_frames(sim: &DropSimulation) -> (Verdict, Verdict) {
    let simulator = simulator_of(sim.clone(), ReleaseTrigger::Command);
    let wire = fly(simulator, streamer(), |_, _, _| {}).log;
    let bare = without_frames(sim.clone());
    assert_eq!(wire.len(), bare.len());
    let mut worst: f64 = 0.0;
    for (a, b) in wire.iter().zip(&bare) {
        assert!((a.t_s - b.t_s).abs() < 1e-12);
        assert_eq!(a.phase, b.phase, "at {} s", a.t_s);
        worst = worst.max((a.state.body.v_ned - b.state.body.v_ned).norm());
    }
    let (a, b) = (verdict(&wire), verdict(&bare));
    // float32 on the wire: 1e-7 of the state in the loop.
    assert!(worst < 2e-6, "{worst}");
    assert!(
        (a.outcome.j_tpf / b.outcome.j_tpf - 1.0).abs() < 1e-6,
        "{} {}",
        a.outcome.j_tpf,
        b.outcome.j_tpf
    );
    (a, b)
}

#[test]
fn reference_the_wire_gives_the_flight_without_frames() {
    let (a, b) = the_wire_gives_the_flight_without_frames(&simulation());
    assert!(
        (a.outcome.j_tpf / b.outcome.j_tpf - 1.0).abs() < 1e-7,
        "{} {}",
        a.outcome.j_tpf,
        b.outcome.j_tpf
    );
    assert!(a.limits_passed.is_empty());
}

/// A canopy that swings: the vehicle leaves it pitched, turning and with a speed over the ground.
#[test]
fn reference_a_swinging_release_is_the_same_on_the_wire() {
    let pendulum = Pendulum { amplitude_rad: 0.35, phase_rad: 0.6, omega_rad_s: 0.4, length_m: 8.0 };
    let sim = simulation_of(Parachute { pendulum, ..mission().release.parachute }, Start::Release);
    let (swinging, _) = the_wire_gives_the_flight_without_frames(&sim);
    assert!(
        (swinging.outcome.j_tpf - verdict(&without_frames(simulation())).outcome.j_tpf).abs() > 1e-3,
        "it does not matter"
    );
}

/// The paper's study begins at t = 0, t_d after the cut; in between there is nothing to control.
#[test]
fn reference_a_study_from_t0_is_the_same_on_the_wire() {
    let sim = simulation_of(mission().release.parachute, Start::T0);
    let (study, _) = the_wire_gives_the_flight_without_frames(&sim);
    // An independent implementation: J_TPF .5551 for this start.
    assert!((study.outcome.j_tpf / 0.5551 - 1.0).abs() < 0.001, "{}", study.outcome.j_tpf);
}

#[test]
fn the_release_comes_at_the_missions_time_and_the_rotors_half_a_second_later() {
    let wire = drop_on_the_wire(|_, _, _| {});
    let first = |phase| wire.log.iter().find(|s| s.phase == phase).map(|s| s.t_s).unwrap();
    assert!((first(Phase::Falling) - 10.0).abs() < 1e-9 && (first(Phase::Powered) - 10.5).abs() < 1e-9);
    let at = |event| wire.events.iter().find(|e| e.event == event).map(|e| e.at);
    let released = StreamerEvent::Released { released_at: 10_000_000, reported: true };
    assert!(at(released).is_some());
    // Setpoints are sent one step ahead of their time.
    assert_eq!(at(StreamerEvent::Tracking), Some(10_496_000));
    assert_eq!(at(StreamerEvent::Target), Some(40_496_000));
    assert!(
        wire.events
            .iter()
            .all(|e| !matches!(e.event, StreamerEvent::Refused { .. } | StreamerEvent::Failed(_)))
    );
}

#[test]
fn a_replayed_drop_gives_the_same_bytes() {
    let record = || {
        let mut bytes = Vec::new();
        let wire = drop_on_the_wire(|now, link, frame| {
            bytes.extend_from_slice(&now.to_be_bytes());
            bytes.push(link as u8);
            bytes.extend_from_slice(frame);
        });
        (bytes, wire.log)
    };
    let (first, second) = (record(), record());
    assert!(first.0 == second.0 && first.1 == second.1);
}

#[test]
fn every_step_has_its_messages_in_order_and_sequences_have_no_gaps() {
    let mut decoder = Decoder::new();
    let mut last: BTreeMap<(Link, u8, u8), u8> = BTreeMap::new();
    let mut hil: Vec<(TimeUs, u32)> = Vec::new();
    drop_on_the_wire(|now, link, bytes| {
        decoder.datagram(bytes, |frame| {
            let sender = (link, frame.system_id, frame.component_id);
            if let Some(before) = last.insert(sender, frame.sequence) {
                assert_eq!(frame.sequence, before.wrapping_add(1), "{sender:?} at {now}");
            }
            if link == Link::Simulator && [93, 107, 113, 115, 331].contains(&frame.message_id) {
                assert_eq!(frame.payload().u64(0), now);
                hil.push((now, frame.message_id));
            }
        });
    });
    assert_eq!(decoder.faults().dropped(), 0);
    for (i, step) in hil.chunk_by(|a, b| a.0 == b.0).enumerate() {
        assert_eq!(step[0].0, (i as TimeUs + 1) * 4_000);
        let ids: Vec<u32> = step.iter().map(|m| m.1).filter(|id| *id != 113).collect();
        // The autopilot asks for 115 each 5 ms, which has room in two steps, and for 331 with each step.
        let expected: &[u32] = match i {
            0 => &[115, 107, 93],
            i if i % 2 == 1 => &[115, 331, 107, 93],
            _ => &[331, 107, 93],
        };
        // The mission is over before its last answer counts, but that comes as well.
        assert_eq!(ids, expected, "step {i}");
    }
}

/// A command is for who is at the other end: the simulator's link does not lead to the parachute.
#[test]
fn what_is_delivered_goes_by_its_link() {
    let gripper = MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
        command: MavCmd::MAV_CMD_DO_GRIPPER,
        target_system: 1,
        target_component: 161,
        ..Default::default()
    });
    let mut frames = Vec::new();
    Decoder::new().datagram(&Encoder::new(255, 190).encode(&gripper), |frame| frames.push(frame));
    let mut wire = Lockstep::new(simulator(), bench::autopilot(), streamer());
    for (link, phase) in [
        (Link::Simulator, Phase::Hanging),
        (Link::GroundStation, Phase::Hanging),
        (Link::Api, Phase::Hanging),
        (Link::Parachute, Phase::Falling),
    ] {
        wire.step(&mut |_, _, _| {}).unwrap();
        wire.deliver(link, &frames[0]);
        assert_eq!(wire.simulator.run().simulation().phase(), phase, "{link:?}");
    }
}
