//! Faults in whole drops: what becomes of the autopilot's flight, and commands that it passes on.

use mavlink::dialects::common::*;
use samara::link::{
    Decoder, Encoder, HilConfig, HilSession, Link, Lockstep, Session as _, StreamerEvent, TimeUs,
};
use samara::sim::faults::{Fault, FaultKind, MotorFault};
use samara::sim::{DropRunConfig, ReleaseTrigger};

use super::bench::{autopilot, fly, mission, simulation, streamer};

fn simulator_with(faults: &[Fault]) -> HilSession {
    let limits = Some(mission().limits.safety);
    let run = DropRunConfig { trigger: ReleaseTrigger::Command, limits, ..DropRunConfig::default() };
    let config = HilConfig { seed: mission().seed, run, allow_faults: true, ..HilConfig::default() };
    HilSession::new(simulation().with_faults(faults), config)
}

fn events(flown: &super::bench::Flown) -> Vec<(TimeUs, String)> {
    flown.record.events.iter().map(|e| (e.at, e.event.to_string())).collect()
}

fn at_of(events: &[(TimeUs, String)], text: &str) -> TimeUs {
    let found = events.iter().find(|(_, event)| event == text);
    found.unwrap_or_else(|| panic!("{text} in {events:?}")).0
}

/// COM_OF_LOSS_T is 1 s: t = 0 is at 10.5 s.
#[test]
fn setpoints_that_are_lost_end_in_the_autopilots_failsafe() {
    let lost = Fault { kind: FaultKind::SetpointLoss, at_s: 3.0, until_s: Some(6.0) };
    let flown = fly(simulator_with(&[lost]), streamer(), |_, _, _| {});
    let events = events(&flown);
    assert_eq!(at_of(&events, "fault: setpoints lost"), 13_500_000);
    assert_eq!(at_of(&events, "fault over: setpoints lost"), 16_500_000);
    let failsafe = at_of(&events, "failsafe: the autopilot has taken over");
    assert!((14_450_000..14_600_000).contains(&failsafe), "{failsafe}");
    assert!(flown.record.failsafe);
}

#[test]
fn a_parachute_that_holds_never_releases_whatever_the_streamer_believes() {
    let holds = Fault { kind: FaultKind::ParachuteHolds, at_s: -10.5, until_s: None };
    let flown = fly(simulator_with(&[holds]), streamer(), |_, _, _| {});
    assert!(flown.log.iter().all(|sample| sample.t_powered_s.is_none()));
    let released = |e: &StreamerEvent| matches!(e, StreamerEvent::Released { reported: false, .. });
    assert!(flown.events.iter().any(|e| released(&e.event)), "the command was accepted");
}

#[test]
fn a_late_release_shifts_the_plan() {
    let late = Fault { kind: FaultKind::LateRelease { delay_s: 0.5 }, at_s: -10.5, until_s: None };
    let flown = fly(simulator_with(&[late]), streamer(), |_, _, _| {});
    let events = events(&flown);
    assert_eq!(at_of(&events, "released by command"), 10_500_000);
    assert_eq!(at_of(&events, "rotors free"), 11_000_000);
    assert!(!flown.record.failsafe);
}

/// To the autopilot, which passes it on, and to the parachute's component: one answer each, from whom it was
/// sent to, and the same fault.
#[test]
fn a_command_is_passed_on_by_the_autopilot() {
    let mut wire = Lockstep::new(simulator_with(&[]), autopilot(), streamer());
    let mut station = Encoder::new(255, 190);
    let enabled = MavMessage::PARAM_SET(PARAM_SET_DATA {
        param_value: f32::from_bits(1),
        target_system: 1,
        target_component: 1,
        param_id: "SYS_FAILURE_EN".into(),
        param_type: MavParamType::MAV_PARAM_TYPE_INT32,
    });
    let mut decoder = Decoder::new();
    decoder.push(&station.encode(&enabled));
    wire.deliver(Link::Api, &decoder.next_frame().unwrap());
    let mut command = |component: u8, unit: f32, kind: f32| {
        let message = MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
            command: MavCmd::MAV_CMD_INJECT_FAILURE,
            param1: unit,
            param2: kind,
            param3: 2.0,
            target_system: 1,
            target_component: component,
            ..Default::default()
        });
        let mut decoder = Decoder::new();
        decoder.push(&station.encode(&message));
        decoder.next_frame().unwrap()
    };
    let early = command(1, 101.0, 1.0);
    wire.deliver(Link::Api, &early);
    let (mut acks, mut texts, mut decoder) = (Vec::new(), Vec::new(), Decoder::new());
    for step in 0..3_000 {
        match step {
            100 => wire.deliver(Link::Api, &command(1, 101.0, 1.0)),
            200 => wire.deliver(Link::Parachute, &command(161, 101.0, 4.0)),
            300 => wire.deliver(Link::GroundStation, &command(1, 101.0, 0.0)),
            400 => wire.deliver(Link::Api, &command(1, 104.0, 1.0)),
            _ => {}
        }
        let goes_on = wire.step(&mut |_, _, bytes| {
            decoder.datagram(bytes, |frame| {
                if let Some(ack) = frame.command_ack().filter(|a| a.command == 420 && a.target_system == 255)
                {
                    acks.push((step, frame.component_id, ack.result));
                }
                if let Some(MavMessage::STATUSTEXT(m)) = frame.known() {
                    texts.push(m.text.to_str().unwrap().to_owned());
                }
            });
        });
        assert!(goes_on.unwrap());
        if step == 450 {
            break;
        }
    }
    // Before there is a simulator it is rejected; then passed on within a step.
    let (rejected, unsupported) = (1, 3);
    assert_eq!(
        acks,
        [(0, 1, rejected), (100, 1, 0), (200, 161, 0), (300, 1, 0), (400, 1, unsupported)],
        "{texts:?}"
    );
    assert!(texts.iter().any(|t| t.contains("failure injected: motor off, instance 2")), "{texts:?}");
    let faults: Vec<_> =
        wire.simulator.run().record().faults.iter().map(|s| (s.kind, s.until_s.is_some())).collect();
    let rotor = 2;
    assert_eq!(
        faults,
        [
            (FaultKind::Motor { rotor, fault: MotorFault::Off }, true),
            (FaultKind::Motor { rotor, fault: MotorFault::Weak { factor: 0.8 } }, true)
        ]
    );
    assert!(wire.autopilot.next_wake().is_some());
}
