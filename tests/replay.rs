//! Drops flown again from their recorded actuators: the truth is that of the flight, to the last bit.

use std::ops::ControlFlow;

use mavlink::dialects::common::MavMessage;
use samara::config::Mission;
use samara::link::parties::{self, StreamerChoice};
use samara::link::{Encoder, Link, Lockstep, ReplayError, Replayed, Tlog, TlogReader, TlogRecord, replay};
use samara::plan::SolverOptions;
use samara::sim::Sample;

/// The bytes of `hil.tlog` and `companion.tlog` of a drop by the reference autopilot, and its truth.
struct Flight {
    mission: Mission,
    hil: Vec<u8>,
    companion: Vec<u8>,
    truth: Vec<Sample>,
}

fn mission(name: &str) -> Mission {
    Mission::shipped(name).unwrap()
}

fn fly(mission: Mission) -> Flight {
    let plan = mission.solve(&SolverOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
    let (autopilot, _) = parties::autopilot(&mission, None, false, 1).unwrap();
    let streamer = parties::streamer(&mission, plan.trajectory, 1, StreamerChoice::default());
    let mut wire = Lockstep::new(parties::simulator(&mission, 1, None, None), autopilot, streamer);
    let mut hil = Tlog::new(Vec::new(), mission.epoch_unix_us);
    let mut companion = Tlog::new(Vec::new(), mission.epoch_unix_us);
    wire.run(&mut |now, link, bytes| match link {
        Link::Simulator => hil.write(now, bytes).unwrap(),
        Link::Api | Link::Parachute => companion.write(now, bytes).unwrap(),
        Link::GroundStation => {}
    })
    .unwrap();
    let (hil, companion) = (hil.finish().unwrap(), companion.finish().unwrap());
    Flight { mission, hil, companion, truth: truth(wire.simulator.run().log()) }
}

/// The log without setpoints, which another link carries.
fn truth(log: &[Sample]) -> Vec<Sample> {
    log.iter().map(|sample| Sample { v_sp_ned: None, ..*sample }).collect()
}

fn read(bytes: &[u8], mission: &Mission) -> Vec<TlogRecord> {
    TlogReader::new(bytes, mission.epoch_unix_us).map(Result::unwrap).collect()
}

fn again(mission: &Mission, hil: &[u8], companion: &[u8]) -> Result<Replayed, ReplayError> {
    let simulator = parties::simulator(mission, 1, None, None);
    replay(simulator, &read(hil, mission), &read(companion, mission))
}

/// The flight itself: still air, turbulence and sensors that err, and a trial of a campaign.
#[test]
fn prop_a_drop_is_flown_again_to_the_last_bit() {
    let drawn = mission("x500_drop");
    let drawn = drawn.with_drop(&drawn.draw_drop(27));
    for mission in [mission("x500_drop"), mission("titan_drop"), mission("titan_paper"), drawn] {
        let flight = fly(mission);
        let replayed = again(&flight.mission, &flight.hil, &flight.companion).unwrap();
        let last = flight.truth.last().unwrap();
        assert!(last.t_powered_s.is_some_and(|t_s| t_s > 1.0), "{}", flight.mission.name);
        assert_eq!(replayed.difference, None, "{}", flight.mission.name);
        assert!(replayed.equal_messages > 2 * flight.truth.len());
        assert!(truth(replayed.run.log()) == flight.truth, "{}", flight.mission.name);
    }
}

/// One actuator of one record is another: its step is named. So are another mission's air, a flight without
/// the release command, and a recording with a gap or without actuators.
#[test]
fn what_is_not_the_flight_is_named() {
    let flight = fly(mission("x500_drop"));
    let Flight { mission: of, hil, companion, .. } = &flight;
    let records = read(hil, of);
    let powered = flight.truth.iter().find(|s| s.t_powered_s.is_some_and(|t_s| t_s > 1.0)).unwrap();
    let from = samara::time::microseconds(powered.t_s);
    let changed = records.iter().find(|r| r.frame.message_id == 93 && r.at >= from).unwrap().clone();
    let Some(MavMessage::HIL_ACTUATOR_CONTROLS(mut controls)) = changed.frame.known().cloned() else {
        panic!("{changed:?}")
    };
    controls.controls[0] = f32::from_bits(controls.controls[0].to_bits() ^ 0x0040_0000);
    let mut encoder = Encoder::new(1, 1);
    let mut log = Tlog::new(Vec::new(), of.epoch_unix_us);
    for record in &records {
        if record.number == changed.number {
            let frame = encoder.encode(&MavMessage::HIL_ACTUATOR_CONTROLS(controls.clone()));
            log.write(record.at, &frame).unwrap();
        } else {
            log.write(record.at, record.frame.bytes()).unwrap();
        }
    }
    let replayed = again(of, &log.finish().unwrap(), companion).unwrap();
    let difference = replayed.difference.unwrap();
    assert!((4_000..=8_000).contains(&(difference.at - changed.at)), "{difference:?} {}", changed.at);

    let mut other = of.clone();
    other.seed += 1;
    assert!(again(&other, hil, companion).unwrap().difference.is_some());
    assert!(again(of, hil, &[]).unwrap().difference.is_some());

    let records: Vec<TlogRecord> = records.into_iter().filter(|r| r.number != changed.number).collect();
    let simulator = || parties::simulator(of, 1, None, None);
    let gap = replay(simulator(), &records, &[]).unwrap_err();
    assert!(matches!(gap, ReplayError::Unanswered { at, .. } if at == changed.at), "{gap}");
    assert_eq!(replay(simulator(), &[], &[]).unwrap_err(), ReplayError::NoActuators);
}
