//! The release found by the fall; a fall with motors that stand still.

use super::*;
use crate::control::FreeFallSettings;

/// Without being asked it looks for nothing; asked, it says the fall once, and again after a restart.
#[test]
fn a_fall_is_said_once_in_each_flight() {
    let mut bench = Bench::engaged(level(0.0));
    bench.said();
    let fly = |bench: &mut Bench| {
        let force = |ms: u64| Vector3::new(0.0, 0.0, if ms < 2_000 { -9.81 } else { -0.2 });
        let found: Vec<_> = (0..750).filter_map(|i| bench.autopilot.feel(i * 4_000, &force(4 * i))).collect();
        found
    };
    assert_eq!(fly(&mut bench), []);
    bench.autopilot.look_for_a_fall(FreeFallSettings::of(9.81, 0.3, 0.2, 0.1).unwrap());
    assert_eq!(fly(&mut bench).iter().map(|fall| fall.began_at).collect::<Vec<_>>(), [1_998_000]);
    assert_eq!(bench.said(), ["Falls since 1.998 s, found at 2.096 s"]);
    bench.autopilot.restart();
    bench.said();
    assert_eq!(fly(&mut bench).len(), 1);
}

/// One that was armed under a canopy at 5 m/s in a mode, and has fallen for so long with its motors still.
fn released_in(mode: FlightMode, armed: bool, fall_s: f64) -> Bench {
    let mut bench = Bench::new();
    bench.measurement.v_ned.z = 5.0;
    bench.step();
    bench.autopilot.request_mode(bench.now_us, mode).unwrap();
    if armed {
        bench.autopilot.arm(bench.now_us, false).unwrap();
    }
    let g = bench.autopilot.control_settings().airframe.gravity_m_s2;
    for i in 0..250 + (250.0 * fall_s) as usize {
        let falls = i >= 250;
        bench.measurement.v_ned.z += if falls { 0.004 * g } else { 0.0 };
        let force = Vector3::new(0.0, 0.0, if falls { 0.0 } else { -g });
        bench.autopilot.feel(bench.now_us + STEP_US, &force);
        assert_eq!(bench.step(), OFF, "the motors stand");
    }
    bench
}

/// Released in HOLD an armed vehicle fell for 19 s without a word, and LAND was acknowledged and did nothing.
#[test]
fn regress_a_fall_with_motors_that_stand_still_is_said_and_any_mode_starts_them() {
    let words = "Falls, and the motors stand still in HOLD: HOLD, LAND or TAKEOFF, chosen now, starts them";
    for mode in [FlightMode::AutoLoiter, FlightMode::AutoLand, FlightMode::AutoRtl, FlightMode::AutoTakeoff] {
        let mut bench = released_in(FlightMode::AutoLoiter, true, 3.0);
        let critical = std::iter::from_fn(|| bench.autopilot.take_event())
            .filter(|event| event.severity == Severity::Critical)
            .map(|event| event.text.into_owned())
            .collect::<Vec<_>>();
        assert_eq!(critical, [words]);
        bench.autopilot.request_mode(bench.now_us, mode).unwrap();
        assert!(bench.step().iter().any(|&u| u > 0.0), "{mode:?}");
        assert_eq!(
            bench.said().contains(&"Motors started in the fall".to_owned()),
            mode != FlightMode::AutoTakeoff,
            "{mode:?} starts them anywhere"
        );
        drift(&mut bench, 60.0);
        let v_down = bench.measurement.v_ned.z;
        assert!(v_down < 1.0, "{mode:?}: {v_down} m/s");
    }
}

/// Armed only in the fall, it is ordered to fly.
#[test]
fn arming_in_a_fall_starts_the_motors() {
    let mut bench = released_in(FlightMode::AutoLoiter, false, 1.0);
    assert!(!bench.said().iter().any(|text| text.starts_with("Falls")), "it is not armed: others say so");
    bench.autopilot.arm(bench.now_us, false).unwrap();
    assert!(bench.step().iter().any(|&u| u > 0.0));
}

/// On the ground, or under a canopy that had only slackened, HOLD and LAND are as before.
#[test]
fn a_fall_that_is_over_starts_nothing() {
    let mut bench = released_in(FlightMode::AutoLoiter, true, 1.0);
    bench.measurement.v_ned.z = 0.0;
    bench.step();
    for mode in [FlightMode::AutoLand, FlightMode::AutoLoiter] {
        bench.autopilot.request_mode(bench.now_us, mode).unwrap();
        assert_eq!(bench.run(1.0), OFF);
    }
}

/// A vehicle that flies is not told that the motors stand still.
#[test]
fn a_fall_in_flight_is_not_remarked_on() {
    let mut bench = Bench::engaged(level(0.0));
    bench.said();
    for i in 0..500 {
        bench.offer(level(0.0));
        let force = Vector3::new(0.0, 0.0, if i < 250 { -9.81 } else { 0.0 });
        bench.autopilot.feel(bench.now_us + STEP_US, &force);
        bench.step();
    }
    assert!(bench.autopilot.falls());
    assert_eq!(bench.said(), Vec::<String>::new());
}
