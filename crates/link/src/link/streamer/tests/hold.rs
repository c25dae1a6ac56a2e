//! The streamer's wait in HOLD until PX4's tilt limit is up, and what may come between.

use std::f64::consts::{FRAC_PI_4, FRAC_PI_6, PI};

use mavlink::dialects::common::*;

use super::scripted_px4::{ALIGNED, FAIL, HELD, PASS, S, ScriptedPx4};
use super::scripted_vehicle::{Answers, WILLING};
use super::*;
use crate::autopilot::FlightMode;
use crate::link::{CommandAck, TimeUs};

const NOT_HELD: &str = "not long enough in HOLD: PX4's tilt limit is not up, and comes with 0.2 rad/s only";

/// PX4's tilt limit goes by 0.2 rad/s from zero to MPC_TILTMAX_LND, or to MPC_TILTMAX_AIR where that is less;
/// a quarter of a second more is for what the streamer does not see. A vehicle without the first, samara's
/// own, is not held.
#[test]
fn px4_is_left_in_hold_until_its_tilt_limit_is_up() {
    for (tilt_deg, comes_up_s) in [
        (Some([45.0, 45.0]), Some(FRAC_PI_4 / 0.2)),
        (Some([12.0, 45.0]), Some(PI / 15.0 / 0.2)),
        (Some([89.0, 30.0]), Some(FRAC_PI_6 / 0.2)),
        (None, None),
    ] {
        let mut careful = ScriptedPx4::new(Some(ALIGNED), PASS, WILLING);
        careful.tilt_deg = tilt_deg;
        careful.until(StreamerState::Aligning);
        let shut = "MPC_TILTMAX_LND = 12: the drop begins with no more tilt than that";
        assert_eq!(
            careful.reports().iter().any(|text| text.starts_with(shut)),
            tilt_deg == Some([12.0, 45.0]),
            "{tilt_deg:?}"
        );
        careful.estimator = Some(ALIGNED);
        let mut held_us = 0;
        while careful.script.streamer.state() != StreamerState::RequestingOffboard {
            held_us += TimeUs::from(careful.script.streamer.state() == StreamerState::Holding) * 4_000;
            careful.step();
        }
        let expected_us = comes_up_s.map_or(0, |s: f64| (1e6 * (s + 0.25)) as TimeUs);
        assert!((expected_us..=expected_us + 8_000).contains(&held_us), "{tilt_deg:?}: {held_us} us");
        let reports = careful.reports();
        assert_eq!(reports.iter().any(|text| text.starts_with("left in HOLD for ")), comes_up_s.is_some());
    }
}

#[test]
fn an_estimate_that_is_lost_in_hold_is_reported_and_waited_for_again() {
    let mut careful = ScriptedPx4::new(Some(ALIGNED), PASS, WILLING);
    careful.until(StreamerState::Holding);
    careful.run(3 * S);
    careful.reports();
    careful.estimator = Some(1);
    careful.until(StreamerState::Aligning);
    assert_eq!(
        careful.reports(),
        ["the estimator has lost horizontal velocity, vertical velocity: waiting for it"]
    );
    careful.estimator = Some(ALIGNED);
    let at = careful.until(StreamerState::Holding);
    assert!(careful.until(StreamerState::RequestingOffboard) - at > 4 * S, "the whole time again");
}

/// How often the vehicle was asked for a mode of that main number.
fn mode_requests(careful: &ScriptedPx4, main: f32) -> usize {
    let commands = careful.script.sent.iter().filter_map(|(_, frame)| match frame.known() {
        Some(MavMessage::COMMAND_LONG(m)) => Some(m),
        _ => None,
    });
    commands.filter(|m| m.command == MavCmd::MAV_CMD_DO_SET_MODE && m.param2 == main).count()
}

/// A vehicle in a mode of sticks is asked into HOLD, once. Where it does not go there the limit does not come
/// up, and the drop is flown with what there is.
#[test]
fn a_px4_that_is_not_in_hold_is_asked_into_it() {
    for goes in [true, false] {
        let mut careful = ScriptedPx4::new(Some(ALIGNED), PASS, WILLING);
        careful.script.mode_before = FlightMode::Stabilized;
        careful.until(StreamerState::Holding);
        careful.run(S);
        assert_eq!(mode_requests(&careful, 4.0), 1);
        if goes {
            careful.script.mode_before = FlightMode::AutoLoiter;
        }
        careful.reports();
        careful.until(StreamerState::RequestingOffboard);
        let words = if goes { HELD } else { NOT_HELD };
        assert!(careful.reports().last().unwrap().starts_with(words), "{goes}");
        assert_eq!(mode_requests(&careful, 4.0), 1, "it has accepted it");
    }
}

/// What was lost on the way is asked for again, thrice.
#[test]
fn hold_is_asked_for_three_times() {
    let deaf = Answers { offboard: None, ..WILLING };
    let mut careful = ScriptedPx4::new(Some(ALIGNED), PASS, deaf);
    careful.script.mode_before = FlightMode::Manual;
    let at = careful.until(StreamerState::Holding);
    let waited = careful.until(StreamerState::RequestingOffboard) - at;
    assert!((3 * S..3 * S + 40_000).contains(&waited), "{waited} us");
    assert_eq!(mode_requests(&careful, 4.0), 3);
    assert_eq!(careful.reports().last().unwrap(), NOT_HELD);
}

/// Time in another mode does not count: whoever takes the vehicle out of HOLD makes the wait begin again.
#[test]
fn regress_time_outside_hold_does_not_count() {
    let mut careful = ScriptedPx4::new(Some(ALIGNED), PASS, WILLING);
    careful.until(StreamerState::Holding);
    careful.run(2 * S);
    careful.script.mode_before = FlightMode::Stabilized;
    careful.run(3 * S / 2);
    careful.script.mode_before = FlightMode::AutoLoiter;
    careful.reports();
    while !careful.reports().contains(&HELD.to_owned()) {
        careful.step();
    }
    let at = careful.script.now;
    assert!(careful.until(StreamerState::RequestingOffboard) - at > 4 * S);
}

/// A vehicle that flies in OFFBOARD is left there; one that stands in it disarmed has a limit that is shut.
#[test]
fn only_a_vehicle_that_flies_in_offboard_is_not_held() {
    for armed in [true, false] {
        let mut careful = ScriptedPx4::new(Some(0), PASS, WILLING);
        careful.script.armed = armed;
        careful.script.mode_before = FlightMode::Offboard;
        careful.until(StreamerState::Aligning);
        careful.run(2 * S);
        careful.estimator = Some(ALIGNED);
        let next = if armed { StreamerState::RequestingOffboard } else { StreamerState::Holding };
        while careful.script.streamer.state() == StreamerState::Aligning {
            careful.step();
        }
        let reached = careful.script.streamer.state();
        assert!(reached == next || armed && reached == StreamerState::Arming, "{armed}: {reached:?}");
    }
}

/// An answer to HOLD that is under way when the vehicle is released is not taken for one to OFFBOARD.
#[test]
fn regress_a_late_answer_to_hold_is_not_one_to_offboard() {
    let mut careful = ScriptedPx4::new(Some(ALIGNED), PASS, Answers { offboard: None, ..WILLING });
    careful.script.mode_before = FlightMode::Stabilized;
    careful.until(StreamerState::Holding);
    careful.run(20_000);
    let at = careful.script.now;
    careful.script.report_release(at);
    careful.run(20_000);
    let ack = CommandAck {
        command: 176,
        target_system: STREAMER_SYSTEM,
        target_component: STREAMER_COMPONENT,
        ..Default::default()
    };
    let bytes = careful.script.vehicle.encode_command_ack(&ack);
    careful.script.hear(&bytes);
    careful.run(S / 2);
    assert_eq!(careful.script.streamer.state(), StreamerState::RequestingOffboard);
    assert_eq!(mode_requests(&careful, 6.0), 1);
}

/// What no tilt limit can be holds nobody up.
#[test]
fn prop_a_nonsensical_tilt_limit_is_no_endless_hold() {
    for tilt_deg in [1e30, f32::INFINITY, f32::NAN, -5.0, f32::MIN] {
        let mut careful = ScriptedPx4::new(Some(ALIGNED), PASS, WILLING);
        careful.tilt_deg = Some([tilt_deg; 2]);
        assert!(careful.until(StreamerState::RequestingOffboard) < 15 * S, "{tilt_deg}");
    }
}

/// A vehicle that has been released already is armed as fast as it goes, whatever the estimator, the tilt
/// limit and the checks.
#[test]
fn regress_a_vehicle_that_is_released_too_soon_is_not_held() {
    for (state, estimator) in [(StreamerState::Aligning, Some(0)), (StreamerState::Holding, Some(ALIGNED))] {
        let mut careful = ScriptedPx4::new(estimator, FAIL, WILLING);
        careful.until(state);
        careful.run(S / 2);
        let at = careful.script.now;
        careful.script.report_release(at);
        // Its checks do not pass yet: the first tries are refused.
        careful.script.answers = Answers { arming: Some(1), ..WILLING };
        careful.run(S / 2);
        assert!((2..=3).contains(&careful.armings()), "{state:?}");
        careful.script.answers = WILLING;
        careful.run(S / 4);
        let reached = careful.script.streamer.state();
        assert!(matches!(reached, StreamerState::Falling | StreamerState::Tracking), "{reached:?}");
    }
}

/// A release that the streamer commands later than it was to says so.
#[test]
fn a_release_that_comes_late_is_reported() {
    let mut careful = ScriptedPx4::new(Some(ALIGNED), PASS, WILLING);
    careful.script.streamer.flight.config.hang_s = 5.0;
    let at = careful.until(StreamerState::Releasing);
    let late = format!("the release comes {:.1} s after hang_s", at as f64 * 1e-6 - 5.0);
    assert!(careful.reports().contains(&late), "{late}");
}
