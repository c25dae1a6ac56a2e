//! The release found by the fall: releases and descents against closed forms, campaigns, whole drops on the
//! wire in memory.

use std::ops::ControlFlow;
use std::path::Path;

use samara::assess::free_fall::rules::{Rule, RuleKind};
use samara::assess::free_fall::{FallCircumstances, FreeFallStudy};
use samara::config::Mission;
use samara::control::FreeFallSettings;
use samara::link::parties::{self, StreamerChoice};
use samara::link::streamer::Clock;
use samara::link::{Lockstep, StreamerEvent};
use samara::model::MAX_ROTORS;
use samara::plan::SolverOptions;
use samara::report::{FlownDrop, judge_drop};
use samara::sim::{DropSimulation, Phase, SensorSettings, Start};
use samara::study::free_fall::free_fall_figure;
use samara::study::free_fall::report::FreeFallReport;
use samara::study::free_fall::{NoFreeFall, free_fall_study};

const MISSIONS: [&str; 2] = ["titan_no_wire", "x500_no_wire"];

fn study(name: &str) -> FreeFallStudy {
    free_fall_study(&Mission::shipped(name).unwrap()).unwrap()
}

/// In the steady descent riser and air carry the vehicle together: what the air carries after the release is
/// what the riser does not, g - T/M.
#[test]
fn closed_form_the_air_carries_what_the_riser_does_not() {
    for name in MISSIONS {
        let study = study(name);
        let steady = study.parachute.suspension.unwrap();
        let steady = steady.steady_descent(&study.vehicle, &study.environment).unwrap();
        let rest = study.environment.gravity_m_s2 - steady.tension_n / study.vehicle.mass.mass_kg;
        assert!((study.fall_m_s2 / rest - 1.0).abs() < 1e-9, "{name}: {} {rest}", study.fall_m_s2);
    }
}

/// Without swing, tumble, wind and errors the lack after t is `level t - (g t - (v - v_0))`, v the rate of
/// descent, whatever the drag is: each release is found at the first reading, every 4 ms, at which that has
/// reached the lack of a fall.
#[test]
fn closed_form_a_calm_release_is_found_when_its_velocity_says_so() {
    let calm = FallCircumstances {
        swing_rad: 0.0,
        tumble_rad_s: 0.0,
        wind_m_s: 0.0,
        turbulence_m_s: 0.0,
        scale_m: 100.0,
    };
    for name in MISSIONS {
        let study = FreeFallStudy { circumstances: calm, sensors: SensorSettings::default(), ..study(name) };
        let (vehicle, environment) = (study.vehicle.clone(), study.environment.clone());
        let (g, level) = (environment.gravity_m_s2, study.settings.level_m_s2);
        let mut fall = DropSimulation::new(vehicle, environment, study.parachute, 0.0, Start::Release);
        fall.release();
        let v_0 = fall.state().body.v_ned.z;
        let (mut t, dt) = (0.0, 1e-4);
        while level * t - (g * t - (fall.state().body.v_ned.z - v_0)) < study.settings.lack_m_s {
            fall.step(&[0.0; MAX_ROTORS], dt);
            t += dt;
        }
        let trial = study.release(3);
        let after_s = trial.autopilot.after_s.unwrap();
        assert!((after_s - t).abs() < 0.006, "{name}: {after_s} {t}");
        assert!(trial.autopilot.dated_late_s.unwrap().abs() <= 0.0021, "{name}: {trial:?}");
        assert!(trial.companion.dated_late_s.unwrap().abs() <= 0.0081, "{name}: {trial:?}");
        assert!((trial.companion.after_s.unwrap() - t).abs() < 0.02, "{name}: {trial:?}");
        // The rule of the mission's level and time is the detector.
        let same = Rule { kind: RuleKind::Lack, level: level / g, time_s: 0.1 };
        let close = |rule: &Rule| rule.kind == same.kind && (rule.level - same.level).abs() < 1e-9;
        let number = Rule::all().position(|rule| close(&rule) && rule.time_s == same.time_s).unwrap();
        assert!((f64::from(trial.rules_s[number]) - after_s).abs() < 1e-6, "{name}");
    }
}

/// Random releases are found, within a quarter of a second and never before they are; a trial is the same
/// whenever it is flown, and others are others.
#[test]
fn random_releases_are_found_and_depend_on_their_number_alone() {
    for name in MISSIONS {
        let study = study(name);
        let trials: Vec<_> = (0..24).map(|trial| study.release(trial)).collect();
        for trial in &trials {
            for found in [trial.autopilot, trial.companion] {
                let after_s = found.after_s.unwrap_or_else(|| panic!("{name}: {trial:?}"));
                assert!((0.0..0.25).contains(&after_s), "{name}: {trial:?}");
            }
        }
        assert_eq!(study.release(7), trials[7]);
        assert!(trials[7].swing_rad != trials[8].swing_rad && trials[7].rules_s != trials[8].rules_s);
    }
}

/// The whole report of a small campaign: counts are those of the trials, the figure has its lines, and a
/// missed release or an alarm is an answer of no.
#[test]
fn the_report_counts_what_was_flown() {
    let mission = Mission::shipped("titan_no_wire").unwrap();
    let study = study("titan_no_wire");
    let releases: Vec<_> = (0..6).map(|trial| study.release(trial)).collect();
    let descents = vec![study.descend(0)];
    let mut report = FreeFallReport { mission: &mission, study, releases, descents };
    assert!(report.holds());
    let json: serde_json::Value = serde_json::from_str(&report.json()).unwrap();
    assert_eq!((&json["releases"], &json["hours"]), (&6.into(), &1.0.into()));
    // -ln(0.05) an hour.
    assert!((json["alarms_per_h_high"].as_f64().unwrap() - 2.995_732).abs() < 1e-6);
    let rows = |csv: String| csv.lines().filter(|line| !line.starts_with('#')).count() - 1;
    let counts = [report.releases_csv(), report.descents_csv(), report.rules_csv()].map(rows);
    assert_eq!(counts, [6, 1, Rule::all().count()]);
    assert!(
        report.document().text().contains("6 releases")
            && report.document().text().contains("1 h of descent")
    );
    let svg = free_fall_figure(&report).unwrap();
    assert!(svg.contains("false alarms an hour") && svg.contains("median until found"));
    report.descents[0].alarms = 1;
    assert!(!report.holds());
    report.descents[0].alarms = 0;
    report.releases[2].autopilot.after_s = None;
    assert!(!report.holds());
    report.descents.clear();
    assert!(free_fall_figure(&report).is_err());
}

/// A rule's level under what the air carries, no canopy, the ground: nothing to study.
#[test]
fn missions_without_a_descent_have_no_study() {
    let refused = |name: &str| free_fall_study(&Mission::shipped(name).unwrap()).unwrap_err();
    assert_eq!(refused("titan_paper"), NoFreeFall::NoCanopy);
    assert_eq!(refused("x500_ground"), NoFreeFall::Standing);
    assert!(free_fall_study(&Mission::shipped("x500_drop").unwrap()).is_ok());
    let usual = study("x500_no_wire");
    let g = usual.environment.gravity_m_s2;
    let of = FreeFallSettings::of(g, FreeFallSettings::LEVEL, usual.fall_m_s2, FreeFallSettings::TIME_S);
    assert_eq!(Some(usual.settings), of);
}

/// Whole drops to which no wire leads: the fall is found, the plan begins within a reading of t = 0, and the
/// drop is as safe as with a wire. The parachute's report, which the streamer hears, does not count.
#[test]
fn drops_without_a_wire_fly_their_plans_from_the_fall_on() {
    for name in MISSIONS {
        let mission = Mission::shipped(name).unwrap();
        let plan = mission.solve(&SolverOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
        let (autopilot, _) = parties::autopilot(&mission, None::<&Path>, false, 1).unwrap();
        let choice = StreamerChoice { clock: Clock::Caller, ..StreamerChoice::default() };
        let mut wire = Lockstep::new(
            parties::simulator(&mission, 1, None, None),
            autopilot,
            parties::streamer(&mission, plan.trajectory.clone(), 1, choice),
        );
        while wire.step(&mut |_, _, _| ()).unwrap() {}
        let mut events = std::iter::from_fn(|| wire.streamer.poll_event());
        let reported = events.find(|e| matches!(e.event, StreamerEvent::Released { .. }));
        assert_eq!(reported, None, "{name}");
        let fall = wire.streamer.fall().unwrap();
        let release_us = samara::time::microseconds(mission.release.hang_s);
        assert!(fall.began_at.abs_diff(release_us) <= 8_000, "{name}: {fall:?}");
        assert!((80_000..150_000).contains(&(fall.found_at - release_us)), "{name}: {fall:?}");
        let run = wire.simulator.run();
        let flown = FlownDrop {
            log: run.log(),
            record: run.record(),
            plan: Some(&plan.trajectory),
            by: None,
            trouble: wire.streamer.failure(),
        };
        let (verdict, mut drop) = judge_drop(&mission, &flown);
        let verdict = verdict.unwrap();
        assert!(verdict.outcome.j_tpf < 0.6 && verdict.limits_passed.is_empty(), "{name}: {verdict:?}");
        assert!(verdict.outcome.steady_after_s.is_some() && drop.reason(Some(&verdict)).is_none(), "{name}");
        assert!(run.log().iter().any(|sample| sample.phase == Phase::Powered));
        drop.note_fall(fall);
        let texts: Vec<&str> = drop.events.iter().map(|event| event.text.as_str()).collect();
        let begin = format!("falls since {:.3} s, found by the accelerometer", fall.began_at as f64 / 1e6);
        assert_eq!(texts, ["armed", "released at the mission's time", &begin, "rotors free"], "{name}");
    }
}
