//! Each release trigger through a whole drop: simulator, parachute, autopilot and streamer; and what is
//! remembered of it.

use samara::link::{StreamerEvent, TimeUs, Timed, microseconds};
use samara::sim::{DropEvent, Phase, ReleaseTrigger};

use super::bench::{Flown, fly, mission, simulation, simulator_of, streamer_that};
use super::verdict;

fn drop_by(trigger: ReleaseTrigger) -> Flown {
    let commands_release = trigger == ReleaseTrigger::Command;
    fly(simulator_of(simulation(), trigger), streamer_that(commands_release), |_, _, _| {})
}

/// Start of the fall and of the powered flight in the flight log.
fn phases(flown: &Flown) -> [TimeUs; 2] {
    [Phase::Falling, Phase::Powered]
        .map(|phase| microseconds(flown.log.iter().find(|s| s.phase == phase).unwrap().t_s))
}

/// When the vehicle was released, and when the plan began, as the streamer knows it.
fn told(flown: &Flown) -> [TimeUs; 2] {
    let released = flown.events.iter().find_map(|e| match e.event {
        StreamerEvent::Released { released_at, reported: true } => Some(released_at),
        _ => None,
    });
    let tracking = flown.events.iter().find(|e| e.event == StreamerEvent::Tracking).map(|e| e.at);
    [released.unwrap(), tracking.unwrap()]
}

#[test]
fn every_trigger_releases_at_its_time_and_the_plan_follows() {
    let m = mission();
    let delay = microseconds(m.release.parachute.delay_s);
    // The hang begins `hang_s` of descent above the point of release: 12 s later it is 2 s of descent below.
    let after_12_s =
        m.site.environment.anchor.altitude_m - (12.0 - m.release.hang_s) * m.release.parachute.descent_m_s;
    for (trigger, expected, cause) in [
        (ReleaseTrigger::Command, 10_000_000, "released by command"),
        (ReleaseTrigger::Time, 10_000_000, "released at the mission's time"),
        (ReleaseTrigger::Altitude(after_12_s + 1e-6), 12_000_000, "released at the altitude"),
        // Half a second of setpoints, OFFBOARD, arming, and a step for each to be heard.
        (ReleaseTrigger::ArmedOffboard, 516_000, "released armed in OFFBOARD"),
    ] {
        let flown = drop_by(trigger);
        let [released, free] = phases(&flown);
        assert_eq!((released, free), (expected, expected + delay), "{trigger:?}");
        // Setpoints are sent one step ahead of their time.
        assert_eq!(told(&flown), [released, free - 4_000], "{trigger:?}");
        let verdict = verdict(&flown.log);
        assert!(
            verdict.limits_passed.is_empty() && (verdict.outcome.j_tpf / 0.5551 - 1.0).abs() < 0.005,
            "{verdict:?}"
        );
        let happened: Vec<String> = flown.record.events.iter().map(|e| e.event.to_string()).collect();
        assert_eq!(happened, ["armed", cause, "rotors free"]);
        assert!(!flown.record.failsafe);
    }
}

/// Setpoints that stop in the middle of the plan.
#[test]
fn a_streamer_that_ends_leaves_a_failsafe_on_record() {
    let m = mission();
    let config = samara::link::StreamerConfig {
        hang_s: m.release.hang_s,
        delay_s: m.release.parachute.delay_s,
        target_v_ned: m.target_v_ned,
        end_s: Some(5.0),
        ..samara::link::StreamerConfig::default()
    };
    let streamer = samara::link::StreamerSession::new(config, super::bench::plan());
    let flown = fly(simulator_of(simulation(), ReleaseTrigger::Command), streamer, |_, _, _| {});
    let happened = &flown.record.events;
    // The last setpoint, of 15.496 s, lives for a second; a step later its loss is heard.
    let failsafe = Timed { at: 16_500_000, event: DropEvent::Failsafe { active: true } };
    assert_eq!(happened[3..], [failsafe], "{happened:?}");
    assert!(flown.record.failsafe);
}
