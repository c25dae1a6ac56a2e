//! The streamer's waits for a PX4 to be ready: estimator (ESTIMATOR_STATUS) and checks before arming
//! (SYS_STATUS) that are never reported, do not hold, hold late, or hold and are lost again. The spans are
//! those of `px4_states.rs`, in steps of 4 ms.

use mavlink::dialects::common::*;

use super::scripted_px4::{ALIGNED, FAIL, HELD, PASS, PREARM_CHECK, S, ScriptedPx4};
use super::scripted_vehicle::{Answers, ScriptedVehicle, WILLING, texts};
use super::*;
use crate::link::Encoder;

/// A vehicle whose estimator is ready, in OFFBOARD, about to be armed.
fn about_to_arm(sensors: Option<[u32; 3]>) -> ScriptedPx4 {
    let mut careful = ScriptedPx4::new(Some(ALIGNED), sensors, WILLING);
    careful.until(StreamerState::Arming);
    careful.reports();
    careful
}

#[test]
fn checks_that_pass_are_waited_for_and_no_longer() {
    let mut careful = about_to_arm(FAIL);
    careful.run(7 * S);
    assert_eq!((careful.script.streamer.state(), careful.armings()), (StreamerState::Arming, 0));
    careful.sensors = PASS;
    let at = careful.script.now;
    // The next SYS_STATUS, the next step, its answer.
    assert!(careful.until(StreamerState::Hanging) <= at + 108_000);
    assert_eq!((careful.reports(), careful.armings()), (vec!["armed".to_owned()], 1));
}

/// What passed before OFFBOARD was the checks of another mode.
#[test]
fn what_was_reported_before_offboard_does_not_count() {
    let mut careful = ScriptedPx4::new(Some(ALIGNED), PASS, WILLING);
    careful.until(StreamerState::RequestingOffboard);
    careful.sensors = None;
    careful.until(StreamerState::Arming);
    careful.run(5 * S);
    assert_eq!((careful.script.streamer.state(), careful.armings()), (StreamerState::Arming, 0));
}

/// After ten seconds arming is asked for all the same: only a refusal says what is wrong. The words say
/// silence from checks that do not pass, and come once. Checks that are not there or not in use are none.
#[test]
fn checks_that_do_not_pass_are_asked_about_after_ten_seconds() {
    const SILENT: &str = "the vehicle tells nothing of its checks before arming (SYS_STATUS); going on";
    const FAILING: &str = "the vehicle's checks before arming do not pass (SYS_STATUS); asking why";
    for (sensors, words) in [
        (None, SILENT),
        (Some([0, PREARM_CHECK, 0]), SILENT),
        (Some([PREARM_CHECK, 0, PREARM_CHECK]), SILENT),
        (Some([!PREARM_CHECK; 3]), SILENT),
        (FAIL, FAILING),
        (Some([u32::MAX, u32::MAX, !PREARM_CHECK]), FAILING),
    ] {
        let mut careful = about_to_arm(sensors);
        let since = careful.script.now;
        careful.script.answers = Answers { arming: Some(1), text: "Preflight Fail: no fix", ..WILLING };
        while careful.armings() == 0 {
            careful.step();
        }
        let waited = careful.script.now - since;
        assert!((10 * S..10 * S + 8_000).contains(&waited), "{sensors:?}: {waited} us");
        careful.until(StreamerState::Failed);
        let reports = careful.reports();
        assert_eq!(reports.iter().filter(|text| *text == words).count(), 1, "{reports:#?}");
        assert_eq!(reports.iter().filter(|text| text.contains("SYS_STATUS")).count(), 1, "{reports:#?}");
        assert_eq!(
            reports.last().unwrap(),
            "gave up: arming was refused (TEMPORARILY_REJECTED) by the autopilot"
        );
        let refusal = "arming refused (TEMPORARILY_REJECTED); the vehicle says: Preflight Fail: no fix";
        assert!(reports.iter().any(|text| text.starts_with(refusal)), "{reports:#?}");
    }
}

/// Once asked for, arming is asked for again without another wait, whatever the checks do meanwhile.
#[test]
fn checks_lost_between_two_tries_do_not_hold_the_next_one_up() {
    let mut careful = about_to_arm(PASS);
    careful.script.answers = Answers { arming: Some(1), ..WILLING };
    while careful.armings() == 0 {
        careful.step();
    }
    careful.sensors = FAIL;
    careful.run(3 * S / 2);
    assert_eq!(careful.armings(), 2);
    careful.script.answers = WILLING;
    careful.until(StreamerState::Hanging);
    assert!(!careful.reports().iter().any(|text| text.contains("SYS_STATUS")));
}

/// A vehicle that disarms itself under the canopy is armed again, and its checks are waited for again.
#[test]
fn checks_lost_under_the_canopy_are_waited_for_anew() {
    let mut careful = about_to_arm(PASS);
    careful.until(StreamerState::Hanging);
    careful.run(2 * S);
    careful.reports();
    careful.sensors = FAIL;
    careful.script.armed = false;
    careful.run(S);
    assert!(careful.reports().contains(&"the vehicle is no longer armed".to_owned()));
    // It hangs until its release is due, and the release waits for it.
    careful.until(StreamerState::RequestingOffboard);
    careful.until(StreamerState::Arming);
    assert_eq!(careful.armings(), 1);
    careful.run(5 * S);
    assert_eq!((careful.script.streamer.state(), careful.armings()), (StreamerState::Arming, 1));
    careful.sensors = PASS;
    careful.until(StreamerState::Hanging);
    careful.until(StreamerState::Releasing);
    assert_eq!(careful.armings(), 2);
}

/// Without a procedure nothing is waited for.
#[test]
fn a_streamer_without_a_procedure_asks_at_once() {
    let mut script = ScriptedVehicle::new(WILLING, |_| ());
    script.run(S);
    assert_eq!(script.streamer.state(), StreamerState::Hanging);
}

/// Ready for a second on end; what is lost in it begins it anew.
#[test]
fn an_estimator_must_hold_for_a_second() {
    let mut careful = ScriptedPx4::new(Some(0), PASS, WILLING);
    careful.until(StreamerState::Aligning);
    careful.estimator = Some(ALIGNED);
    careful.run(900_000);
    careful.estimator = Some(1);
    careful.run(200_000);
    assert_eq!(careful.script.streamer.state(), StreamerState::Aligning, "it was lost again");
    careful.reports();
    careful.estimator = Some(ALIGNED);
    let at = careful.script.now;
    let waited = careful.until(StreamerState::Holding) - at;
    assert!((S..S + 108_000).contains(&waited), "{waited} us");
    assert_eq!(careful.reports(), ["the estimator has attitude and velocity", HELD]);
}

/// What is lacking is named every five seconds, with the vehicle's words; it is waited for as long as it
/// takes.
#[test]
fn what_an_estimator_lacks_is_named() {
    let mut careful = ScriptedPx4::new(Some(1), PASS, WILLING);
    let since = careful.until(StreamerState::Aligning);
    careful.reports();
    careful.run(2 * S);
    let text = STATUSTEXT_DATA { text: "EKF waiting".into(), ..Default::default() };
    careful.script.vehicle_says(&MavMessage::STATUSTEXT(text));
    careful.run(since + 16 * S - careful.script.now);
    careful.estimator = Some(3);
    careful.run(5 * S);
    let waiting = "waiting for the estimator: no";
    assert_eq!(
        careful.reports(),
        [
            "> EKF waiting".to_owned(),
            format!("{waiting} horizontal velocity, vertical velocity yet; the vehicle says: EKF waiting"),
            format!("{waiting} horizontal velocity, vertical velocity yet"),
            format!("{waiting} horizontal velocity, vertical velocity yet"),
            format!("{waiting} vertical velocity yet"),
        ]
    );
}

/// An autopilot that does not know the message is not waited for: ten seconds, and the second that everybody
/// is given.
#[test]
fn an_estimator_that_reports_nothing_is_believed() {
    let mut careful = ScriptedPx4::new(None, PASS, WILLING);
    let since = careful.until(StreamerState::Aligning);
    careful.reports();
    let waited = careful.until(StreamerState::Holding) - since;
    assert!((11 * S..11 * S + 8_000).contains(&waited), "{waited} us");
    assert_eq!(
        careful.reports(),
        [
            "waiting for the estimator: no ESTIMATOR_STATUS yet",
            "the estimator tells nothing (ESTIMATOR_STATUS); going on",
            HELD
        ]
    );
}

/// samara's own autopilot looks for a landing once its rotors have turned.
#[test]
fn what_only_px4_does_is_not_said_of_samaras_autopilot() {
    for (build, said) in [(*b"samara\0\0", false), ([0x5A; 8], true)] {
        let mut careful = ScriptedPx4::new(Some(ALIGNED), PASS, WILLING);
        careful.disarm_after_landing_s = 2.0;
        careful.until(StreamerState::Parameters);
        let version = AUTOPILOT_VERSION_DATA { flight_custom_version: build, ..Default::default() };
        careful.script.vehicle_says(&MavMessage::AUTOPILOT_VERSION(version));
        careful.until(StreamerState::Aligning);
        let reports = careful.reports();
        assert_eq!(reports.iter().any(|r| r.starts_with("COM_DISARM_LAND = 2: PX4")), said, "{reports:#?}");
    }
}

/// A vehicle that says nothing of its parameters cannot be judged, and is not released.
#[test]
fn a_vehicle_without_parameters_is_given_up() {
    let mut script = ScriptedVehicle::new(WILLING, |c| c.procedure = Some(Procedure::default()));
    script.run(5 * S);
    let reports = texts(&script.events);
    assert_eq!(script.streamer.state(), StreamerState::Failed);
    let words = "gave up: no PARAM_VALUE has come: the vehicle's parameters are not known";
    assert!(reports.last().unwrap().ends_with(words), "{reports:#?}");
}

/// Another vehicle's word, or another component's, is not the autopilot's.
#[test]
fn others_reports_on_checks_are_not_the_autopilots() {
    let mut careful = about_to_arm(None);
    let all = MavSysStatusSensor::from_bits_retain(PREARM_CHECK);
    let status = MavMessage::SYS_STATUS(SYS_STATUS_DATA {
        onboard_control_sensors_present: all,
        onboard_control_sensors_enabled: all,
        onboard_control_sensors_health: all,
        ..Default::default()
    });
    for (system, component) in [(2, 1), (1, 154)] {
        let bytes = Encoder::new(system, component).encode(&status);
        careful.script.hear(&bytes);
    }
    careful.run(5 * S);
    assert_eq!((careful.script.streamer.state(), careful.armings()), (StreamerState::Arming, 0));
}
