//! The streamer's waits for a PX4 to be ready: estimator (ESTIMATOR_STATUS) and checks before arming (SYS_STATUS) that are never
//! told, do not hold, hold late, or hold and are lost again. The spans are those of `procedure.rs`, in steps of 4 ms.

use std::f64::consts::{FRAC_PI_4, FRAC_PI_6, PI};

use mavlink::dialects::common::*;

use super::super::{CommandAck, Encoder, TimeUs};
use super::scene::{Answers, Scene, WILLING, texts};
use super::*;
use crate::autopilot::FlightMode;
use crate::params::Value;
use crate::params::procedure::{RULES, TILT_AIR};

const ALIGNED: u16 = 7;
const PREARM_CHECK: u32 = 0x1000_0000;
const S: TimeUs = 1_000_000;
/// For a tilt limit of 45 deg: 45 deg/(0.2 rad/s) + 0.25 s.
const NOT_HELD: &str = "not long enough in HOLD: PX4's tilt limit is not up, and comes with 0.2 rad/s only";
const HELD: &str = "left in HOLD for 4.18 s: PX4's tilt limit comes up there";

/// A careful streamer and a vehicle with fit parameters. Nobody tells of estimator or checks but who is said to.
struct Careful {
    scene: Scene,
    answered: usize,
    /// Flags of ESTIMATOR_STATUS, told every 0.1 s.
    estimator: Option<u16>,
    /// Present, enabled and healthy sensors of SYS_STATUS, told every 0.1 s.
    sensors: Option<[u32; 3]>,
    /// MPC_TILTMAX_LND and MPC_TILTMAX_AIR [deg], if it has them.
    tilt_deg: Option<[f32; 2]>,
}

impl Careful {
    fn new(estimator: Option<u16>, sensors: Option<[u32; 3]>, answers: Answers) -> Self {
        let scene = Scene::new(answers, |c| {
            c.procedure = Some(Procedure::default());
            c.hang_s = 60.0;
        });
        Self { scene, answered: 0, estimator, sensors, tilt_deg: Some([45.0; 2]) }
    }

    /// Until `state` is reached; the time of that.
    fn until(&mut self, state: StreamerState) -> TimeUs {
        while self.scene.streamer.state() != state {
            assert!(self.scene.now < 100 * S, "never {state:?}: {:#?}", texts(&self.scene.events));
            self.step();
        }
        self.scene.now
    }

    fn run(&mut self, span: TimeUs) {
        let until = self.scene.now + span;
        while self.scene.now < until {
            self.step();
        }
    }

    fn step(&mut self) {
        if self.scene.now.is_multiple_of(100_000) {
            self.tell();
        }
        self.scene.run(self.scene.now + 4_000);
        while let Some((_, frame)) = self.scene.sent.get(self.answered) {
            self.answered += 1;
            if let Some(MavMessage::PARAM_REQUEST_READ(m)) = frame.known() {
                let (param_id, name) = (m.param_id, m.param_id.to_str().unwrap());
                let rule = RULES.iter().find(|rule| rule.name == name);
                let wanted = rule.map(|rule| (rule.wanted)(&Default::default()));
                let (param_value, param_type) = match wanted {
                    None => {
                        let of = usize::from(name == TILT_AIR);
                        let Some(tilt_deg) = self.tilt_deg else { continue };
                        (tilt_deg[of], MavParamType::MAV_PARAM_TYPE_REAL32)
                    }
                    Some(Some(Value::Int(i))) => {
                        (f32::from_bits(i as u32), MavParamType::MAV_PARAM_TYPE_INT32)
                    }
                    Some(Some(Value::Real(x))) => (x, MavParamType::MAV_PARAM_TYPE_REAL32),
                    Some(None) => (1.0, MavParamType::MAV_PARAM_TYPE_REAL32),
                };
                let value = PARAM_VALUE_DATA { param_id, param_value, param_type, ..Default::default() };
                self.scene.vehicle_says(&MavMessage::PARAM_VALUE(value));
            }
        }
    }

    fn tell(&mut self) {
        if let Some(flags) = self.estimator {
            let flags = EstimatorStatusFlags::from_bits_retain(flags);
            let status = ESTIMATOR_STATUS_DATA { flags, ..Default::default() };
            self.scene.vehicle_says(&MavMessage::ESTIMATOR_STATUS(status));
        }
        if let Some(sensors) = self.sensors {
            let [present, enabled, health] = sensors.map(MavSysStatusSensor::from_bits_retain);
            self.scene.vehicle_says(&MavMessage::SYS_STATUS(SYS_STATUS_DATA {
                onboard_control_sensors_present: present,
                onboard_control_sensors_enabled: enabled,
                onboard_control_sensors_health: health,
                ..Default::default()
            }));
        }
    }

    /// What was told since the last time it was asked, without the simulated times.
    fn told(&mut self) -> Vec<String> {
        let told = texts(&std::mem::take(&mut self.scene.events));
        told.iter().map(|text| text.split_once(" s  ").unwrap().1.to_owned()).collect()
    }

    /// How often arming has been asked for.
    fn armings(&self) -> usize {
        self.scene.sent.iter().filter_map(|(_, f)| f.command()).filter(|c| c.command == 400).count()
    }
}

const PASS: Option<[u32; 3]> = Some([PREARM_CHECK; 3]);
const FAIL: Option<[u32; 3]> = Some([PREARM_CHECK, PREARM_CHECK, 0]);

/// A vehicle whose estimator is ready, in OFFBOARD, about to be armed.
fn about_to_arm(sensors: Option<[u32; 3]>) -> Careful {
    let mut careful = Careful::new(Some(ALIGNED), sensors, WILLING);
    careful.until(StreamerState::Arming);
    careful.told();
    careful
}

#[test]
fn checks_that_pass_are_waited_for_and_no_longer() {
    let mut careful = about_to_arm(FAIL);
    careful.run(7 * S);
    assert_eq!((careful.scene.streamer.state(), careful.armings()), (StreamerState::Arming, 0));
    careful.sensors = PASS;
    let at = careful.scene.now;
    // The next SYS_STATUS, the next step, its answer.
    assert!(careful.until(StreamerState::Hanging) <= at + 108_000);
    assert_eq!((careful.told(), careful.armings()), (vec!["armed".to_owned()], 1));
}

/// What passed before OFFBOARD was the checks of another mode.
#[test]
fn what_was_told_before_offboard_does_not_count() {
    let mut careful = Careful::new(Some(ALIGNED), PASS, WILLING);
    careful.until(StreamerState::RequestingOffboard);
    careful.sensors = None;
    careful.until(StreamerState::Arming);
    careful.run(5 * S);
    assert_eq!((careful.scene.streamer.state(), careful.armings()), (StreamerState::Arming, 0));
}

/// After ten seconds arming is asked for all the same: only a refusal says what is wrong. The words tell silence from checks that
/// do not pass, and come once. Checks that are not there or not in use are none.
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
        let since = careful.scene.now;
        careful.scene.answers = Answers { arming: Some(1), text: "Preflight Fail: no fix", ..WILLING };
        while careful.armings() == 0 {
            careful.step();
        }
        let waited = careful.scene.now - since;
        assert!((10 * S..10 * S + 8_000).contains(&waited), "{sensors:?}: {waited} us");
        careful.until(StreamerState::Failed);
        let told = careful.told();
        assert_eq!(told.iter().filter(|text| *text == words).count(), 1, "{told:#?}");
        assert_eq!(told.iter().filter(|text| text.contains("SYS_STATUS")).count(), 1, "{told:#?}");
        assert_eq!(
            told.last().unwrap(),
            "gave up: arming was refused (TEMPORARILY_REJECTED) by the autopilot"
        );
        let refusal = "arming refused (TEMPORARILY_REJECTED); the vehicle says: Preflight Fail: no fix";
        assert!(told.iter().any(|text| text.starts_with(refusal)), "{told:#?}");
    }
}

/// Once asked for, arming is asked for again without another wait, whatever the checks do meanwhile.
#[test]
fn checks_lost_between_two_tries_do_not_hold_the_next_one_up() {
    let mut careful = about_to_arm(PASS);
    careful.scene.answers = Answers { arming: Some(1), ..WILLING };
    while careful.armings() == 0 {
        careful.step();
    }
    careful.sensors = FAIL;
    careful.run(3 * S / 2);
    assert_eq!(careful.armings(), 2);
    careful.scene.answers = WILLING;
    careful.until(StreamerState::Hanging);
    assert!(!careful.told().iter().any(|text| text.contains("SYS_STATUS")));
}

/// A vehicle that disarms itself under the canopy is armed again, and its checks are waited for again.
#[test]
fn checks_lost_under_the_canopy_are_waited_for_anew() {
    let mut careful = about_to_arm(PASS);
    careful.until(StreamerState::Hanging);
    careful.run(2 * S);
    careful.told();
    careful.sensors = FAIL;
    careful.scene.armed = false;
    careful.run(S);
    assert!(careful.told().contains(&"the vehicle is no longer armed".to_owned()));
    // It hangs until its release is due, and the release waits for it.
    careful.until(StreamerState::RequestingOffboard);
    careful.until(StreamerState::Arming);
    assert_eq!(careful.armings(), 1);
    careful.run(5 * S);
    assert_eq!((careful.scene.streamer.state(), careful.armings()), (StreamerState::Arming, 1));
    careful.sensors = PASS;
    careful.until(StreamerState::Hanging);
    careful.until(StreamerState::Releasing);
    assert_eq!(careful.armings(), 2);
}

/// Without a procedure nothing is waited for.
#[test]
fn a_streamer_without_a_procedure_asks_at_once() {
    let mut scene = Scene::new(WILLING, |_| ());
    scene.run(S);
    assert_eq!(scene.streamer.state(), StreamerState::Hanging);
}

/// Ready for a second on end; what is lost in it begins it anew.
#[test]
fn an_estimator_must_hold_for_a_second() {
    let mut careful = Careful::new(Some(0), PASS, WILLING);
    careful.until(StreamerState::Aligning);
    careful.estimator = Some(ALIGNED);
    careful.run(900_000);
    careful.estimator = Some(1);
    careful.run(200_000);
    assert_eq!(careful.scene.streamer.state(), StreamerState::Aligning, "it was lost again");
    careful.told();
    careful.estimator = Some(ALIGNED);
    let at = careful.scene.now;
    let waited = careful.until(StreamerState::Holding) - at;
    assert!((S..S + 108_000).contains(&waited), "{waited} us");
    assert_eq!(careful.told(), ["the estimator has attitude and velocity", HELD]);
}

/// PX4's tilt limit goes by 0.2 rad/s from zero to MPC_TILTMAX_LND, or to MPC_TILTMAX_AIR where that is less; a quarter of a second more
/// is for what the streamer does not see. A vehicle without the first, samara's own, is not held.
#[test]
fn px4_is_left_in_hold_until_its_tilt_limit_is_up() {
    for (tilt_deg, comes_up_s) in [
        (Some([45.0, 45.0]), Some(FRAC_PI_4 / 0.2)),
        (Some([12.0, 45.0]), Some(PI / 15.0 / 0.2)),
        (Some([89.0, 30.0]), Some(FRAC_PI_6 / 0.2)),
        (None, None),
    ] {
        let mut careful = Careful::new(Some(ALIGNED), PASS, WILLING);
        careful.tilt_deg = tilt_deg;
        careful.until(StreamerState::Aligning);
        let shut = "MPC_TILTMAX_LND = 12: the drop begins with no more tilt than that";
        assert_eq!(
            careful.told().iter().any(|text| text.starts_with(shut)),
            tilt_deg == Some([12.0, 45.0]),
            "{tilt_deg:?}"
        );
        careful.estimator = Some(ALIGNED);
        let mut held_us = 0;
        while careful.scene.streamer.state() != StreamerState::RequestingOffboard {
            held_us += TimeUs::from(careful.scene.streamer.state() == StreamerState::Holding) * 4_000;
            careful.step();
        }
        let expected_us = comes_up_s.map_or(0, |s: f64| (1e6 * (s + 0.25)) as TimeUs);
        assert!((expected_us..=expected_us + 8_000).contains(&held_us), "{tilt_deg:?}: {held_us} us");
        let told = careful.told();
        assert_eq!(told.iter().any(|text| text.starts_with("left in HOLD for ")), comes_up_s.is_some());
    }
}

#[test]
fn an_estimate_that_is_lost_in_hold_is_told_and_waited_for_again() {
    let mut careful = Careful::new(Some(ALIGNED), PASS, WILLING);
    careful.until(StreamerState::Holding);
    careful.run(3 * S);
    careful.told();
    careful.estimator = Some(1);
    careful.until(StreamerState::Aligning);
    assert_eq!(
        careful.told(),
        ["the estimator has lost horizontal velocity, vertical velocity: waiting for it"]
    );
    careful.estimator = Some(ALIGNED);
    let at = careful.until(StreamerState::Holding);
    assert!(careful.until(StreamerState::RequestingOffboard) - at > 4 * S, "the whole time again");
}

/// How often the vehicle was asked for a mode of that main number.
fn mode_requests(careful: &Careful, main: f32) -> usize {
    let commands = careful.scene.sent.iter().filter_map(|(_, frame)| match frame.known() {
        Some(MavMessage::COMMAND_LONG(m)) => Some(m),
        _ => None,
    });
    commands.filter(|m| m.command == MavCmd::MAV_CMD_DO_SET_MODE && m.param2 == main).count()
}

/// A vehicle in a mode of sticks is asked into HOLD, once. Where it does not go there the limit does not come up, and the drop is flown
/// with what there is.
#[test]
fn a_px4_that_is_not_in_hold_is_asked_into_it() {
    for goes in [true, false] {
        let mut careful = Careful::new(Some(ALIGNED), PASS, WILLING);
        careful.scene.mode_before = FlightMode::Stabilized;
        careful.until(StreamerState::Holding);
        careful.run(S);
        assert_eq!(mode_requests(&careful, 4.0), 1);
        if goes {
            careful.scene.mode_before = FlightMode::AutoLoiter;
        }
        careful.told();
        careful.until(StreamerState::RequestingOffboard);
        let words = if goes { HELD } else { NOT_HELD };
        assert!(careful.told().last().unwrap().starts_with(words), "{goes}");
        assert_eq!(mode_requests(&careful, 4.0), 1, "it has accepted it");
    }
}

/// What was lost on the way is asked for again, thrice.
#[test]
fn hold_is_asked_for_three_times() {
    let deaf = Answers { offboard: None, ..WILLING };
    let mut careful = Careful::new(Some(ALIGNED), PASS, deaf);
    careful.scene.mode_before = FlightMode::Manual;
    let at = careful.until(StreamerState::Holding);
    let waited = careful.until(StreamerState::RequestingOffboard) - at;
    assert!((3 * S..3 * S + 40_000).contains(&waited), "{waited} us");
    assert_eq!(mode_requests(&careful, 4.0), 3);
    assert_eq!(careful.told().last().unwrap(), NOT_HELD);
}

/// Time in another mode does not count: whoever takes the vehicle out of HOLD makes the wait begin again.
#[test]
fn regress_time_outside_hold_does_not_count() {
    let mut careful = Careful::new(Some(ALIGNED), PASS, WILLING);
    careful.until(StreamerState::Holding);
    careful.run(2 * S);
    careful.scene.mode_before = FlightMode::Stabilized;
    careful.run(3 * S / 2);
    careful.scene.mode_before = FlightMode::AutoLoiter;
    careful.told();
    while !careful.told().contains(&HELD.to_owned()) {
        careful.step();
    }
    let at = careful.scene.now;
    assert!(careful.until(StreamerState::RequestingOffboard) - at > 4 * S);
}

/// Who flies in OFFBOARD is left there; who stands in it disarmed has a limit that is shut.
#[test]
fn only_a_vehicle_that_flies_in_offboard_is_not_held() {
    for armed in [true, false] {
        let mut careful = Careful::new(Some(0), PASS, WILLING);
        careful.scene.armed = armed;
        careful.scene.mode_before = FlightMode::Offboard;
        careful.until(StreamerState::Aligning);
        careful.run(2 * S);
        careful.estimator = Some(ALIGNED);
        let next = if armed { StreamerState::RequestingOffboard } else { StreamerState::Holding };
        while careful.scene.streamer.state() == StreamerState::Aligning {
            careful.step();
        }
        let reached = careful.scene.streamer.state();
        assert!(reached == next || armed && reached == StreamerState::Arming, "{armed}: {reached:?}");
    }
}

/// An answer to HOLD that is under way when the vehicle is released is not taken for one to OFFBOARD.
#[test]
fn regress_a_late_answer_to_hold_is_not_one_to_offboard() {
    let mut careful = Careful::new(Some(ALIGNED), PASS, Answers { offboard: None, ..WILLING });
    careful.scene.mode_before = FlightMode::Stabilized;
    careful.until(StreamerState::Holding);
    careful.run(20_000);
    let at = careful.scene.now;
    careful.scene.tell_release(at);
    careful.run(20_000);
    let ack = CommandAck {
        command: 176,
        target_system: STREAMER_SYSTEM,
        target_component: STREAMER_COMPONENT,
        ..Default::default()
    };
    let bytes = careful.scene.vehicle.encode_command_ack(&ack);
    careful.scene.hear(&bytes);
    careful.run(S / 2);
    assert_eq!(careful.scene.streamer.state(), StreamerState::RequestingOffboard);
    assert_eq!(mode_requests(&careful, 6.0), 1);
}

/// What no tilt limit can be holds nobody up.
#[test]
fn prop_a_nonsensical_tilt_limit_is_no_endless_hold() {
    for tilt_deg in [1e30, f32::INFINITY, f32::NAN, -5.0, f32::MIN] {
        let mut careful = Careful::new(Some(ALIGNED), PASS, WILLING);
        careful.tilt_deg = Some([tilt_deg; 2]);
        assert!(careful.until(StreamerState::RequestingOffboard) < 15 * S, "{tilt_deg}");
    }
}

/// Who has been released already is armed as fast as it goes, whatever the estimator, the tilt limit and the checks.
#[test]
fn regress_a_vehicle_that_is_released_too_soon_is_not_held() {
    for (state, estimator) in [(StreamerState::Aligning, Some(0)), (StreamerState::Holding, Some(ALIGNED))] {
        let mut careful = Careful::new(estimator, FAIL, WILLING);
        careful.until(state);
        careful.run(S / 2);
        let at = careful.scene.now;
        careful.scene.tell_release(at);
        // Its checks do not pass yet: the first tries are refused.
        careful.scene.answers = Answers { arming: Some(1), ..WILLING };
        careful.run(S / 2);
        assert!((2..=3).contains(&careful.armings()), "{state:?}");
        careful.scene.answers = WILLING;
        careful.run(S / 4);
        let reached = careful.scene.streamer.state();
        assert!(matches!(reached, StreamerState::Falling | StreamerState::Tracking), "{reached:?}");
    }
}

/// A release that the streamer commands later than it was to says so.
#[test]
fn a_release_that_comes_late_is_told() {
    let mut careful = Careful::new(Some(ALIGNED), PASS, WILLING);
    careful.scene.streamer.config.hang_s = 5.0;
    let at = careful.until(StreamerState::Releasing);
    let late = format!("the release comes {:.1} s after hang_s", at as f64 * 1e-6 - 5.0);
    assert!(careful.told().contains(&late), "{late}");
}

/// What is lacking is named every five seconds, with the vehicle's words; it is waited for as long as it takes.
#[test]
fn what_an_estimator_lacks_is_named() {
    let mut careful = Careful::new(Some(1), PASS, WILLING);
    let since = careful.until(StreamerState::Aligning);
    careful.told();
    careful.run(2 * S);
    let text = STATUSTEXT_DATA { text: "EKF waiting".into(), ..Default::default() };
    careful.scene.vehicle_says(&MavMessage::STATUSTEXT(text));
    careful.run(since + 16 * S - careful.scene.now);
    careful.estimator = Some(3);
    careful.run(5 * S);
    let waiting = "waiting for the estimator: no";
    assert_eq!(
        careful.told(),
        [
            "> EKF waiting".to_owned(),
            format!("{waiting} horizontal velocity, vertical velocity yet; the vehicle says: EKF waiting"),
            format!("{waiting} horizontal velocity, vertical velocity yet"),
            format!("{waiting} horizontal velocity, vertical velocity yet"),
            format!("{waiting} vertical velocity yet"),
        ]
    );
}

/// An autopilot that does not know the message is not waited for: ten seconds, and the second that everybody is given.
#[test]
fn an_estimator_that_tells_nothing_is_believed() {
    let mut careful = Careful::new(None, PASS, WILLING);
    let since = careful.until(StreamerState::Aligning);
    careful.told();
    let waited = careful.until(StreamerState::Holding) - since;
    assert!((11 * S..11 * S + 8_000).contains(&waited), "{waited} us");
    assert_eq!(
        careful.told(),
        [
            "waiting for the estimator: no ESTIMATOR_STATUS yet",
            "the estimator tells nothing (ESTIMATOR_STATUS); going on",
            HELD
        ]
    );
}

/// Who says nothing of its parameters cannot be judged, and is not released.
#[test]
fn a_vehicle_without_parameters_is_given_up() {
    let mut scene = Scene::new(WILLING, |c| c.procedure = Some(Procedure::default()));
    scene.run(5 * S);
    let told = texts(&scene.events);
    assert_eq!(scene.streamer.state(), StreamerState::Failed);
    let words = "gave up: no PARAM_VALUE has come: the vehicle's parameters are not known";
    assert!(told.last().unwrap().ends_with(words), "{told:#?}");
}

/// Another vehicle's word, or another component's, is not the autopilot's.
#[test]
fn others_words_on_checks_are_not_the_autopilots() {
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
        careful.scene.hear(&bytes);
    }
    careful.run(5 * S);
    assert_eq!((careful.scene.streamer.state(), careful.armings()), (StreamerState::Arming, 0));
}
