//! A drop's trigger, log, record and events, without a wire.

use super::drop_run::*;
use super::limits::SafetyLimits;
use super::test_site::{DELAY_S, HANG_S, drop_simulation, drop_simulation_at, environment};
use super::{Battery, Ground, Phase, ReleaseTrigger};
use crate::math;
use crate::model::MAX_ROTORS;
use crate::time::{TimeUs, Timed, microseconds, seconds};

fn config(trigger: ReleaseTrigger) -> DropRunConfig {
    DropRunConfig { duration_us: 4_000_000, trigger, ..DropRunConfig::default() }
}

fn run(trigger: ReleaseTrigger) -> DropRun {
    DropRun::new(drop_simulation(), config(trigger))
}

fn step_until(run: &mut DropRun, until: TimeUs) {
    while run.now() < until {
        run.step();
    }
}

fn events(run: &DropRun) -> Vec<(TimeUs, String)> {
    run.record().events.iter().map(|e| (e.at, e.event.to_string())).collect()
}

/// All of the events by name.
fn texts(run: &DropRun) -> Vec<String> {
    run.record().events.iter().map(|e| e.event.to_string()).collect()
}

#[test]
fn closed_form_each_trigger_cuts_at_its_time() {
    // The hang begins 2 s times 5 m/s above 600 m: 605.01 m is passed in the step that ends at 1 s.
    for (trigger, cause, at) in [
        (ReleaseTrigger::Command, ReleaseCause::Command, 1_200_000),
        (ReleaseTrigger::Time, ReleaseCause::Time, microseconds(HANG_S)),
        (ReleaseTrigger::Altitude(605.01), ReleaseCause::Altitude, 1_000_000),
        (ReleaseTrigger::ArmedOffboard, ReleaseCause::ArmedOffboard, 804_000),
    ] {
        let mut run = run(trigger);
        run.set_mode(Some(false));
        run.set_armed(true);
        step_until(&mut run, 800_000);
        run.set_mode(Some(true));
        step_until(&mut run, 1_200_000);
        if trigger == ReleaseTrigger::Command {
            run.release(ReleaseCause::Command);
        }
        step_until(&mut run, 4_000_000);
        let free = at + microseconds(DELAY_S);
        let happened: Vec<_> = run.record().events.iter().map(|e| (e.at, e.event)).collect();
        let expected = [
            (0, DropEvent::Armed { armed: true }),
            (at, DropEvent::Released { cause }),
            (free, DropEvent::RotorsFree),
        ];
        assert_eq!(happened, expected, "{trigger:?}");
        assert_eq!(run.simulation().release_time_s(), Some(seconds(at)));
    }
}

/// A host hears of a release at the very beginning like of any other, and again after a new start.
#[test]
fn a_drop_without_a_hang_reports_its_release_at_time_0() {
    let mut run = DropRun::new(drop_simulation_at(environment(), 0.0), config(ReleaseTrigger::Time));
    for _ in 0..2 {
        assert_eq!((run.simulation().phase(), run.has_begun()), (Phase::Falling, false));
        step_until(&mut run, 1_000_000);
        let expected = [
            (0, DropEvent::Released { cause: ReleaseCause::Time }),
            (0, DropEvent::ReleasedUnarmed),
            (microseconds(DELAY_S), DropEvent::RotorsFree),
        ];
        let happened: Vec<_> = run.record().events.iter().map(|e| (e.at, e.event)).collect();
        assert_eq!(happened, expected);
        assert!(run.has_begun());
        run.restart();
    }
}

#[test]
fn a_command_cuts_whatever_the_trigger_is_and_only_once() {
    for trigger in [ReleaseTrigger::Time, ReleaseTrigger::Altitude(0.0), ReleaseTrigger::ArmedOffboard] {
        let mut run = run(trigger);
        step_until(&mut run, 400_000);
        run.release(ReleaseCause::Command);
        step_until(&mut run, 3_000_000);
        run.release(ReleaseCause::Command);
        let expected = ["released by command", "released while the autopilot is not armed", "rotors free"];
        assert_eq!(texts(&run), expected, "{trigger:?}");
    }
}

/// A hand on the arming switch, ten thousand times in one step of the simulation: drop.json grew by 42 MB.
#[test]
fn regress_an_autopilot_that_arms_without_end_fills_no_record() {
    let mut run = run(ReleaseTrigger::Time);
    for i in 0..10_000 {
        run.set_armed(i % 2 == 0);
        run.set_failsafe(i % 2 == 0);
    }
    let toggles = run.record().events.len();
    assert_eq!(toggles, MOST_REPORTS);
    // What happens to the vehicle is recorded all the same.
    step_until(&mut run, 3_000_000);
    assert!(texts(&run)[toggles..].iter().any(|text| text == "rotors free"), "{:?}", &texts(&run)[toggles..]);
}

#[test]
fn an_autopilot_without_a_mode_is_reported_where_the_release_waits_for_one() {
    for (trigger, mode, reports) in [
        (ReleaseTrigger::ArmedOffboard, None, 1),
        (ReleaseTrigger::ArmedOffboard, Some(false), 0),
        (ReleaseTrigger::Command, None, 0),
    ] {
        let mut run = run(trigger);
        run.set_mode(mode);
        step_until(&mut run, 400_000);
        run.set_armed(true);
        run.set_armed(true);
        step_until(&mut run, 3_000_000);
        let unknown = Timed { at: 400_000, event: DropEvent::ModeUnknown };
        assert_eq!(run.record().events.iter().filter(|e| **e == unknown).count(), reports, "{trigger:?}");
        assert_eq!(run.simulation().phase(), Phase::Hanging);
    }
}

/// What the motors did under the canopy does not count, nor what they are commanded once later.
#[test]
fn motors_that_are_never_started_after_the_release_are_recorded() {
    let fly = |turns: [TimeUs; 2]| {
        let mut run = run(ReleaseTrigger::Time);
        run.set_armed(true);
        step_until(&mut run, turns[0]);
        run.set_throttle([0.4; MAX_ROTORS]);
        step_until(&mut run, turns[1]);
        run.set_throttle([0.0; MAX_ROTORS]);
        step_until(&mut run, 4_000_000);
        run.record().motors_stood
    };
    let released = microseconds(HANG_S);
    assert!(fly([400_000, 800_000]), "under the canopy alone");
    assert!(!fly([released + 900_000, released + 904_000]), "one step of the fall");
    assert!(!fly([400_000, released + 400_000]), "from the canopy into the fall");
    let mut hanging = run(ReleaseTrigger::Command);
    step_until(&mut hanging, 4_000_000);
    assert!(!hanging.record().motors_stood, "never released");
}

#[test]
fn a_failsafe_counts_from_the_release_on() {
    let fly = |begins: TimeUs, ends: TimeUs| {
        let mut run = run(ReleaseTrigger::Time);
        step_until(&mut run, begins);
        run.set_failsafe(true);
        step_until(&mut run, ends);
        run.set_failsafe(false);
        step_until(&mut run, 4_000_000);
        run.record().failsafe
    };
    assert!(!fly(400_000, 800_000), "under the canopy");
    assert!(fly(400_000, 2_400_000), "into the flight");
    assert!(fly(2_400_000, 2_800_000), "in flight");
}

#[test]
fn a_limit_is_reported_when_it_is_first_passed_after_the_release() {
    // It sinks at 5 m/s under the canopy: above the limit, but not yet a flight.
    let limits = SafetyLimits {
        speed_m_s: 4.0,
        pitch_rad: 1.0,
        pitch_rate_rad_s: 1.0,
        vertical_acceleration_m_s2: 1.0,
    };
    let mut run = DropRun::new(
        drop_simulation(),
        DropRunConfig { limits: Some(limits), ..config(ReleaseTrigger::Time) },
    );
    step_until(&mut run, 4_000_000);
    let passed: Vec<_> = events(&run).into_iter().filter(|(_, text)| text.starts_with("limit")).collect();
    assert_eq!(passed, [(microseconds(HANG_S), "limit passed: speed".to_owned())]);
}

#[test]
fn closed_form_it_comes_to_the_ground_under_its_canopy_at_the_speed_of_descent() {
    // From 10 m above the origin at 5 m/s: the ground 5 m above it is reached after 1 s.
    let simulation = drop_simulation().above(Ground { down_m: -5.0 });
    let mut run = DropRun::new(simulation, config(ReleaseTrigger::Command));
    step_until(&mut run, 1_100_000);
    let happened = events(&run);
    let find = |text: &str| happened.iter().find(|(_, t)| t.starts_with(text)).map(|(at, _)| *at);
    let released = find("released on the ground").unwrap();
    assert!(released.abs_diff(1_000_000) <= 4_000, "{happened:?}");
    assert!(find("on the ground at 5.00 m/s").unwrap().abs_diff(1_000_000) <= 4_000, "{happened:?}");
}

/// Log and events are those of the bare simulation, stepped by hand.
#[test]
fn prop_a_run_changes_nothing_in_the_flight() {
    let mut run = run(ReleaseTrigger::Time);
    let mut bare = drop_simulation_at(environment(), HANG_S);
    bare.schedule_release(HANG_S);
    let mut throttle = [0.0; MAX_ROTORS];
    let mut log = Vec::new();
    while !run.is_over() {
        throttle[..4].fill(0.4 + 0.1 * math::sin(run.now() as f64 * 1e-5));
        run.set_throttle(throttle);
        run.step();
        log.push(bare.advance_sampled(&throttle, None, 0.004));
    }
    log.push(bare.sample(&throttle, None));
    assert_eq!(run.log(), log);
    assert_eq!(log.last().map(|s| s.t_s), Some(4.0));
}

/// The log of steps beyond the end is that of a longer mission: a row for each step, and one end.
#[test]
fn steps_after_the_end_repeat_no_row() {
    let mut beyond = run(ReleaseTrigger::Time);
    let duration_us = 4_400_000;
    let mut longer =
        DropRun::new(drop_simulation(), DropRunConfig { duration_us, ..config(ReleaseTrigger::Time) });
    for run in [&mut beyond, &mut longer] {
        step_until(run, 4_000_000);
        run.set_throttle([0.5; MAX_ROTORS]);
        step_until(run, duration_us);
    }
    assert!(beyond.log().is_sorted_by(|a, b| a.t_s < b.t_s));
    assert_eq!(beyond.log(), longer.log());
}

#[test]
fn a_run_that_starts_over_is_the_run_that_was() {
    let battery = Some(Battery::new(1e4, 1.0));
    let mut run = DropRun::new(drop_simulation(), DropRunConfig { battery, ..config(ReleaseTrigger::Time) });
    let mut fly = || {
        run.set_armed(true);
        run.set_throttle([0.5; MAX_ROTORS]);
        step_until(&mut run, 4_000_000);
        let polled: Vec<_> = std::iter::from_fn(|| run.poll_event()).collect();
        assert_eq!(polled, run.record().events, "each event is polled once");
        let flown = (run.log().to_vec(), run.record().clone(), run.battery().copied());
        run.restart();
        assert!(!run.has_begun() && run.log().is_empty() && run.poll_event().is_none());
        flown
    };
    let first = fly();
    assert!(first.2.unwrap().consumed_j() > 0.0);
    assert_eq!(fly(), first);
}

/// ArduPilot's JSON interface, as far as a drop needs it: another simulator protocol is another host.
struct JsonHost(DropRun);

impl JsonHost {
    /// Takes a servo packet (magic, frame rate, frame count, 16 pulse widths [us]), makes the step that it
    /// asks for and returns the answer; `None` for what is no servo packet.
    fn handle_datagram(&mut self, packet: &[u8; 40]) -> Option<String> {
        let word = |at: usize| u16::from_le_bytes([packet[at], packet[at + 1]]);
        if word(0) != 18_458 {
            return None;
        }
        let throttle = |i: usize| ((f64::from(word(8 + 2 * i)) - 1_000.0) / 1_000.0).clamp(0.0, 1.0);
        self.0.set_armed(true);
        self.0.set_throttle(std::array::from_fn(throttle));
        self.0.step();
        let (t_s, sim) = (seconds(self.0.now()), self.0.simulation());
        let body = &sim.state().body;
        let numbers = |x: nalgebra::Vector3<f64>| format!("[{}, {}, {}]", x.x, x.y, x.z);
        let (gyro, accel) = (numbers(body.omega_body), numbers(sim.specific_force_body()));
        let (p, q, v) = (numbers(body.p_ned), body.q_ned_from_body, numbers(body.v_ned));
        Some(format!(
            r#"{{"timestamp": {t_s}, "imu": {{"gyro": {gyro}, "accel_body": {accel}}}, "position": {p}, "quaternion": {q:?}, "velocity": {v}}}"#
        ))
    }
}

#[test]
fn another_protocol_is_another_host() {
    let mut packet = [0; 40];
    packet[..2].copy_from_slice(&18_458_u16.to_le_bytes());
    packet[8..].chunks_exact_mut(2).for_each(|pwm| pwm.copy_from_slice(&1_500_u16.to_le_bytes()));
    let mut host = JsonHost(run(ReleaseTrigger::Time));
    assert_eq!(host.handle_datagram(&[0; 40]), None);
    let mut answer = String::new();
    while !host.0.is_over() {
        answer = host.handle_datagram(&packet).unwrap();
    }
    // The flight is that of the commands without a protocol.
    let mut bare = run(ReleaseTrigger::Time);
    bare.set_armed(true);
    bare.set_throttle([0.5; MAX_ROTORS]);
    step_until(&mut bare, 4_000_000);
    assert_eq!((host.0.log(), host.0.record()), (bare.log(), bare.record()));
    assert!(answer.starts_with(r#"{"timestamp": 4, "imu": {"gyro": ["#), "{answer}");
}
