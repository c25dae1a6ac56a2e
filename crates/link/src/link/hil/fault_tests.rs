//! Faults on the wire: by MAV_CMD_INJECT_FAILURE to the parachute's component, in sensors and fixes, in
//! what the streamer is told.

use core::time::Duration;

use mavlink::dialects::common::*;
use nalgebra::Vector3;

use super::tests::{Hand, config};
use super::*;
use crate::sim::faults::{Fault, FaultKind, Sensor, SensorFault};
use crate::test_site::drop_simulation;

const OFF: f32 = 1.0;
const STUCK: f32 = 2.0;
const MOTOR: f32 = 101.0;

impl Hand {
    fn with_faults(faults: &[Fault]) -> Self {
        let mut hand = Self::with(drop_simulation().with_faults(faults), config());
        hand.session.peer_connected();
        hand
    }

    fn that_allows_faults() -> Self {
        Self::connected(HilConfig { allow_faults: true, ..config() })
    }

    /// Injects a fault into instance 2, by COMMAND_LONG; all that comes back.
    fn inject(&mut self, params: [f32; 2], instance: f32) -> Vec<Frame> {
        let message = MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
            command: MavCmd::MAV_CMD_INJECT_FAILURE,
            param1: params[0],
            param2: params[1],
            param3: instance,
            target_system: 1,
            target_component: 161,
            ..Default::default()
        });
        self.send_outside(&message)
    }

    fn send_outside(&mut self, message: &MavMessage) -> Vec<Frame> {
        self.drain(Link::Parachute);
        self.decoder.push(&self.script.encode(message));
        let frame = self.decoder.next_frame().unwrap();
        self.session.handle_input(Link::Parachute, &frame);
        self.drain(Link::Parachute)
    }

    /// The HIL_SENSOR and the HIL_GPS of the next step.
    fn read(&mut self) -> (HIL_SENSOR_DATA, Option<HIL_GPS_DATA>) {
        self.step();
        let (mut sensor, mut gps) = (None, None);
        for frame in self.drain(Link::Simulator) {
            match frame.known() {
                Some(MavMessage::HIL_SENSOR(m)) => sensor = Some(m.clone()),
                Some(MavMessage::HIL_GPS(m)) => gps = Some(m.clone()),
                _ => {}
            }
        }
        self.answer(self.session.now(), 0.0, false);
        (sensor.unwrap(), gps)
    }
}

fn results(frames: &[Frame]) -> Vec<u8> {
    let acks = frames.iter().filter_map(Frame::command_ack);
    let of_ours = |ack: super::super::CommandAck| {
        assert_eq!((ack.command, ack.target_system, ack.target_component), (420, 255, 190));
        ack.result
    };
    acks.map(of_ours).collect()
}

fn texts(frames: &[Frame]) -> Vec<String> {
    let text = |f: &Frame| match f.known() {
        Some(MavMessage::STATUSTEXT(m)) => Some(m.text.to_str().unwrap().to_owned()),
        _ => None,
    };
    frames.iter().filter_map(text).collect()
}

fn mutes(frames: &[Frame]) -> Vec<i32> {
    let value = |f: &Frame| match f.known() {
        Some(MavMessage::NAMED_VALUE_INT(m)) if m.name.to_str() == Ok("mute") => Some(m.value),
        _ => None,
    };
    frames.iter().filter_map(value).collect()
}

fn of_sensor(at_s: f64, until_s: f64, sensor: Sensor, fault: SensorFault) -> Fault {
    Fault { kind: FaultKind::Sensor { sensor, fault }, at_s, until_s: Some(until_s) }
}

#[test]
fn a_fault_is_injected_and_ended_by_command_where_the_mission_allows_it() {
    let mut hand = Hand::connected(config());
    let refused = hand.inject([MOTOR, OFF], 2.0);
    assert_eq!(results(&refused), [MavResult::MAV_RESULT_DENIED as u8]);
    assert_eq!(texts(&refused), ["Fault refused: the mission does not allow it"]);
    assert!(hand.session.run().simulation().faults().is_none());

    let mut hand = Hand::that_allows_faults();
    hand.fly(400_000, 0.5, true);
    let begun = hand.inject([MOTOR, OFF], 2.0);
    assert_eq!((results(&begun), texts(&begun)), (vec![0], vec!["Fault: rotor 2 off".to_owned()]));
    // Once more is accepted, and nothing new.
    let again = hand.inject([MOTOR, OFF], 2.0);
    assert_eq!((results(&again), texts(&again)), (vec![0], Vec::<String>::new()));
    hand.fly(800_000, 0.5, true);
    let ended = hand.inject([MOTOR, 0.0], 0.0);
    assert_eq!((results(&ended), texts(&ended)), (vec![0], vec!["Fault over: rotor 2 off".to_owned()]));
    let happened: Vec<_> = hand.events().iter().map(ToString::to_string).collect();
    assert!(
        happened.iter().any(|e| e.contains("0.400") && e.ends_with("fault: rotor 2 off")),
        "{happened:?}"
    );
    let spans = &hand.session.run().record().faults;
    assert_eq!((spans.len(), spans[0].ordered), (1, true));
    assert_eq!((spans[0].from_s, spans[0].until_s), (0.4, Some(0.8)));
    // To the simulator itself, on its own link.
    hand.command(Link::Simulator, MavCmd::MAV_CMD_INJECT_FAILURE, [MOTOR, STUCK], (1, 200));
    let ack = hand.drain(Link::Simulator)[0].command_ack().unwrap();
    assert_eq!((ack.command, ack.result), (420, 0));
    assert_eq!(hand.session.run().record().faults.len(), 5, "instance 0: all four");
}

#[test]
fn command_int_is_as_good_and_what_cannot_be_is_answered_as_mavlink_says() {
    let mut hand = Hand::that_allows_faults();
    hand.fly(400_000, 0.5, true);
    let message = |param1, param2, param3| {
        MavMessage::COMMAND_INT(COMMAND_INT_DATA {
            command: MavCmd::MAV_CMD_INJECT_FAILURE,
            param1,
            param2,
            param3,
            target_system: 1,
            target_component: 161,
            ..Default::default()
        })
    };
    for (params, result) in [
        ([0.0, STUCK, 1.0], MavResult::MAV_RESULT_ACCEPTED),
        ([8.0, OFF, 1.0], MavResult::MAV_RESULT_UNSUPPORTED),
        ([0.0, 7.0, 1.0], MavResult::MAV_RESULT_UNSUPPORTED),
        ([MOTOR, OFF, 5.0], MavResult::MAV_RESULT_DENIED),
        ([0.0, OFF, 2.0], MavResult::MAV_RESULT_DENIED),
        ([f32::NAN, OFF, 1.0], MavResult::MAV_RESULT_DENIED),
        ([MOTOR, f32::INFINITY, 1.0], MavResult::MAV_RESULT_DENIED),
        ([MOTOR, OFF, -1e30], MavResult::MAV_RESULT_DENIED),
    ] {
        let answered = hand.send_outside(&message(params[0], params[1], params[2]));
        assert_eq!(results(&answered), [result as u8], "{params:?}");
    }
    // Another vehicle's is nobody's here.
    let mut other = message(0.0, OFF, 1.0);
    if let MavMessage::COMMAND_INT(m) = &mut other {
        m.target_system = 9;
    }
    assert!(results(&hand.send_outside(&other)).is_empty());
    hand.session.peer_left();
    let answered = hand.inject([MOTOR, OFF], 2.0);
    assert_eq!(results(&answered), [MavResult::MAV_RESULT_TEMPORARILY_REJECTED as u8]);
    assert_eq!(texts(&answered), ["Fault refused: no autopilot is connected"]);
}

/// t = 0 of the test site is at 2.5 s.
#[test]
fn closed_form_sensors_that_fail_say_what_their_faults_make_of_the_truth() {
    let rate = Vector3::new(0.1, -0.2, 0.3);
    let offset = Vector3::new(10.0, 0.0, 0.0);
    let mut hand = Hand::with_faults(&[
        of_sensor(-2.0, -1.5, Sensor::Gyro, SensorFault::Drift { rate }),
        of_sensor(-2.0, -1.5, Sensor::Accelerometer, SensorFault::Off),
        of_sensor(-2.0, -1.5, Sensor::Barometer, SensorFault::Wrong { offset, scale: 1.0 }),
        of_sensor(-2.0, -1.5, Sensor::Magnetometer, SensorFault::Garbage),
    ]);
    let mut sound = Hand::connected(config());
    for step in 1..=300_u32 {
        let (read, _) = hand.read();
        let (truth, _) = sound.read();
        let t_s = f64::from(step) * 0.004;
        if !(0.5 - 1e-9..1.0 - 1e-9).contains(&t_s) {
            assert_eq!(read, truth, "{t_s}");
            continue;
        }
        let drift = rate * (t_s - 0.5);
        assert!((f64::from(read.xgyro - truth.xgyro) - drift.x).abs() < 1e-6, "{t_s}");
        assert!((f64::from(read.zgyro - truth.zgyro) - drift.z).abs() < 1e-6);
        assert_eq!(read.fields_updated.bits(), truth.fields_updated.bits() & !0x007);
        assert!((read.abs_pressure - truth.abs_pressure - 10.0).abs() < 1e-3);
        assert!(read.xmag.abs() <= 8.0 && read.xmag != truth.xmag);
    }
}

#[test]
fn closed_form_a_stuck_gyro_repeats_its_last_reading() {
    let mut hand = Hand::with_faults(&[of_sensor(-1.0, 9.0, Sensor::Gyro, SensorFault::Stuck)]);
    hand.session.config.sensors.gyroscope.noise_density = 0.01;
    let (run, config) = (hand.session.run.clone(), hand.session.config);
    hand.session = HilSession::hosting(run, config);
    hand.session.peer_connected();
    let readings: Vec<_> = (0..500).map(|_| hand.read().0).map(|m| (m.xgyro, m.ygyro, m.zgyro)).collect();
    // The fault begins at 1.5 s: the reading of the 375th step is the first that is not new.
    assert!(readings[..374].windows(2).all(|w| w[0] != w[1]));
    assert!(readings[373..].windows(2).all(|w| w[0] == w[1]));
}

#[test]
fn a_receiver_that_is_off_sends_nothing_and_one_without_a_fix_says_so() {
    let mut hand = Hand::with_faults(&[
        of_sensor(-2.0, -1.0, Sensor::Gps, SensorFault::Off),
        of_sensor(-1.0, -0.5, Sensor::Gps, SensorFault::NoFix),
    ]);
    let mut fixes = Vec::new();
    for _ in 0..625 {
        if let (_, Some(gps)) = hand.read() {
            fixes.push((gps.time_usec, gps.fix_type, gps.satellites_visible));
        }
    }
    let within = |from: u64, until: u64| fixes.iter().filter(move |(at, ..)| (from..until).contains(at));
    assert_eq!(within(500_000, 1_500_000).count(), 0);
    assert_eq!(within(1_500_000, 2_000_000).count(), 5);
    assert!(within(1_500_000, 2_000_000).all(|(_, fix, satellites)| (*fix, *satellites) == (1, 0)));
    assert!(within(0, 500_000).chain(within(2_000_000, 2_500_000)).all(|(_, fix, _)| *fix == 3));
}

/// By hand: a HEARTBEAT each second, but for that within the fault, from 0.5 to 1.5 s.
#[test]
fn a_silent_parachute_sends_no_heartbeat() {
    let silent = Fault { kind: FaultKind::ParachuteSilent, at_s: -2.0, until_s: Some(-1.0) };
    let mut hand = Hand::with_faults(&[silent]);
    let mut beats = Vec::new();
    while hand.session.now() < 3_500_000 {
        hand.step();
        let (now, said) = (hand.session.now(), hand.drain(Link::Parachute));
        let is_beat = |frame: &Frame| matches!(frame.known(), Some(MavMessage::HEARTBEAT(_)));
        beats.extend(said.iter().filter(|frame| is_beat(frame)).map(|_| now));
        hand.answer(hand.session.now(), 0.0, false);
    }
    let seconds: Vec<u64> = beats.iter().map(|at| at / 1_000_000).collect();
    assert_eq!(seconds, [0, 2, 3], "{beats:?}");
}

#[test]
fn the_streamer_is_told_that_it_is_mute_and_is_not_waited_for() {
    let lost = Fault { kind: FaultKind::SetpointLoss, at_s: -2.0, until_s: Some(-1.0) };
    let config = HilConfig { companion: Some(Duration::from_secs(5)), ..config() };
    let mut hand = Hand::with(drop_simulation().with_faults(&[lost]), config);
    hand.session.peer_connected();
    let mut said = Vec::new();
    // A setpoint before each step, and what the parachute says in it.
    let mut step = |hand: &mut Hand, streams: bool| {
        if streams {
            let time_boot_ms = (hand.session.now() / 1_000) as u32;
            let setpoint = SET_ATTITUDE_TARGET_DATA { time_boot_ms, ..Default::default() };
            hand.send_outside(&MavMessage::SET_ATTITUDE_TARGET(setpoint));
        }
        let before = hand.session.now();
        hand.step();
        said.extend(mutes(&hand.drain(Link::Parachute)));
        assert_eq!(hand.session.now(), before + 4_000, "time stands still");
        hand.answer(hand.session.now(), 0.0, false);
    };
    while hand.session.now() < 500_000 {
        assert!(!hand.session.is_mute());
        step(&mut hand, true);
    }
    // Nothing comes from the companion any more, and time goes on.
    while hand.session.now() < 1_500_000 {
        assert!(hand.session.is_mute());
        step(&mut hand, false);
    }
    assert!(!hand.session.is_mute());
    // At once, with the heartbeat of 1 s, and at the end.
    assert_eq!(said, [1, 1, 0]);
}
