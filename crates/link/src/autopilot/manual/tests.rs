//! What sticks ask for, by closed forms and by PX4's own tests of its functions.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use approx::assert_relative_eq;

use super::*;
use crate::frames::{LEVEL, rotate_ned_from_body, yaw};

const SETTINGS: ManualSettings = ManualSettings::DEFAULT;
const FORWARD: Sticks = Sticks { pitch: 1.0, roll: 0.0, throttle: 0.0, yaw: 0.0 };
const CENTRED: Sticks = Sticks { pitch: 0.0, ..FORWARD };

/// 100 m above home, at rest, nose east.
fn high_up(settings: &ManualSettings) -> Circumstances<'_> {
    Circumstances {
        p_ned: Vector3::new(1.0, 2.0, -100.0),
        v_ned: Vector3::zeros(),
        yaw_rad: FRAC_PI_2,
        dt_s: 0.004,
        home_down_m: 0.0,
        near_ground_m_s: [0.7, 1.5],
        limits: VelocityLimits { level_m_s: 12.0, up_m_s: 3.0, down_m_s: 1.5 },
        yaw_rate_rad_s: 200.0 * RAD_PER_DEG,
        gravity_m_s2: 9.81,
        hover_thrust: 0.4,
        settings,
    }
}

fn place(setpoint: ManualSetpoint) -> ([[Option<f64>; 3]; 3], Heading) {
    match setpoint {
        ManualSetpoint::Place { pva, heading } => (pva, heading),
        ManualSetpoint::Tilt { .. } => panic!("{setpoint:?}"),
    }
}

fn tilt(setpoint: ManualSetpoint) -> (Vector2<f64>, Heading, f64) {
    match setpoint {
        ManualSetpoint::Tilt { tilt_rad, heading, thrust } => (tilt_rad, heading, thrust),
        ManualSetpoint::Place { .. } => panic!("{setpoint:?}"),
    }
}

fn velocity_of(sticks: Sticks, settings: &ManualSettings) -> Vector3<f64> {
    let setpoint = ManualFlight::default().step(FlightMode::Posctl, &sticks, &high_up(settings));
    let ([_, v, _], _) = place(setpoint);
    Vector3::from(v.map(|v| v.unwrap()))
}

/// PX4 v1.14.0, src/lib/mathlib/math/FunctionsTest.cpp: deadzone, expo_deadzone and interpolate.
#[test]
fn reference_stick_curves_are_px4s() {
    for (stick, dead_zone, curve) in [
        (-12.0, 0.5, -1.0),
        (45.0, 0.5, 1.0),
        (0.1, -12.0, 0.1),
        (0.1, 12.0, 0.0),
        (0.2, 0.1, 0.111_111_111_1),
        (-0.2, 0.5, 0.0),
        (0.7, 0.3, 0.571_428_54),
        (-0.9, 0.4, -0.833_333_25),
    ] {
        assert_relative_eq!(curved(stick, 0.0, dead_zone), curve, epsilon = 1e-6);
    }
    for (stick, expo, dead_zone, curve) in [
        (-12.0, 0.5, 0.5, -1.0),
        (0.0, 0.5, 0.5, 0.0),
        (45.0, 0.5, 0.5, 1.0),
        (0.5, 0.0, 0.5, 0.0),
        (-0.5, 0.5, 0.2, -0.213_867_19),
        (0.5, 0.7, 0.3, 0.102_040_81),
        (-0.5, 0.9, 0.4, -0.020_833_336),
    ] {
        assert_relative_eq!(curved(stick, expo, dead_zone), curve, epsilon = 1e-6);
    }
    for (x, y) in [(-12.0, 4.0), (1.0, 4.0), (1.25, 4.5), (1.75, 5.5), (2.0, 6.0), (12.0, 6.0)] {
        assert_eq!(between(x, 1.0, 2.0, 4.0, 6.0), y);
    }
}

/// MPC_VEL_MANUAL along the nose, which points east; half way beyond the dead zone 0.4 x + 0.6 x^3 of it;
/// both sticks together no faster.
#[test]
fn closed_form_posctl_flies_where_the_stick_points() {
    let v = |pitch, roll| velocity_of(Sticks { pitch, roll, ..CENTRED }, &SETTINGS);
    assert_relative_eq!(v(1.0, 0.0), Vector3::new(0.0, 10.0, 0.0), epsilon = 1e-12);
    assert_relative_eq!(v(0.0, 1.0), Vector3::new(-10.0, 0.0, 0.0), epsilon = 1e-12);
    assert_relative_eq!(v(0.55, 0.0), Vector3::new(0.0, 2.75, 0.0), epsilon = 1e-12);
    let both = 10.0 * math::cos(FRAC_PI_4);
    assert_relative_eq!(v(-1.0, 1.0), Vector3::new(-both, -both, 0.0), epsilon = 1e-12);
    assert_eq!(v(0.1, -0.1), Vector3::zeros(), "MPC_HOLD_DZ");
    let slower = ManualSettings { side_speed_m_s: 4.0, back_speed_m_s: 2.0, ..SETTINGS };
    let v = |pitch, roll| velocity_of(Sticks { pitch, roll, ..CENTRED }, &slower);
    assert_relative_eq!(v(-1.0, 0.0), Vector3::new(0.0, -2.0, 0.0), epsilon = 1e-12);
    assert_relative_eq!(v(1.0, 0.0), Vector3::new(0.0, 10.0, 0.0), epsilon = 1e-12);
    assert_relative_eq!(v(0.0, -1.0), Vector3::new(4.0, 0.0, 0.0), epsilon = 1e-12);
}

/// Up at MPC_Z_VEL_MAX_UP, down at MPC_Z_VEL_MAX_DN; from MPC_LAND_ALT1 to MPC_LAND_ALT2 above home linearly
/// down to MPC_TKO_SPEED and MPC_LAND_SPEED.
#[test]
fn closed_form_climb_rates_shrink_near_the_ground() {
    let climb = |throttle, height_m: f64| {
        let c = Circumstances { p_ned: Vector3::new(0.0, 0.0, -height_m), ..high_up(&SETTINGS) };
        let sticks = Sticks { throttle, ..CENTRED };
        place(ManualFlight::default().step(FlightMode::Altctl, &sticks, &c)).0[1][2].unwrap()
    };
    for (throttle, height_m, down_m_s) in [
        (1.0, 50.0, -3.0),
        (-1.0, 50.0, 1.5),
        (0.55, 50.0, -0.825),
        (1.0, 7.5, -2.25),
        (-1.0, 7.5, 1.1),
        (1.0, 5.0, -1.5),
        (-1.0, 0.0, 0.7),
        (-1.0, -20.0, 0.7),
    ] {
        assert_relative_eq!(climb(throttle, height_m), down_m_s, epsilon = 1e-12);
    }
}

/// The place is that of the beginning; moved sticks let it go; let go themselves they lock where the vehicle
/// is slower than MPC_HOLD_MAX_XY and MPC_HOLD_MAX_Z.
#[test]
fn closed_form_sticks_in_the_middle_keep_the_place_once_it_is_slow() {
    let mut flight = ManualFlight::default();
    let mut position = |sticks: &Sticks, p: [f64; 3], v: [f64; 3]| {
        let c = Circumstances { p_ned: p.into(), v_ned: v.into(), ..high_up(&SETTINGS) };
        place(flight.step(FlightMode::Posctl, sticks, &c)).0[0]
    };
    let there = [Some(1.0), Some(2.0), Some(-30.0)];
    assert_eq!(position(&CENTRED, [1.0, 2.0, -30.0], [5.0, 0.0, 2.0]), there);
    assert_eq!(position(&CENTRED, [9.0, 9.0, -39.0], [0.0; 3]), there, "kept");
    let up_and_ahead = Sticks { throttle: 0.5, ..FORWARD };
    assert_eq!(position(&up_and_ahead, [3.0, 2.0, -31.0], [1.0, 0.0, 0.0]), [None; 3]);
    assert_eq!(position(&CENTRED, [4.0, 2.0, -32.0], [0.81, 0.0, 0.61]), [None; 3], "still moving");
    let level = [Some(5.0), Some(2.0), None];
    assert_eq!(position(&CENTRED, [5.0, 2.0, -33.0], [0.79, 0.0, 0.61]), level);
    assert_eq!(position(&CENTRED, [6.0, 2.0, -34.0], [0.79, 0.0, 0.59]), [Some(5.0), Some(2.0), Some(-34.0)]);
}

/// The yaw stick turns at MPC_MAN_Y_MAX behind a filter of MPC_MAN_Y_TAU; when the rate has died away the
/// heading of that time is kept, whatever becomes of the vehicle's.
#[test]
fn closed_form_the_yaw_stick_turns_and_the_heading_is_kept_after_it() {
    let settings = ManualSettings { yaw_expo: 0.0, dead_zone: 0.0, ..SETTINGS };
    let mut flight = ManualFlight::default();
    let mut turn = |stick, yaw_rad| {
        let sticks = Sticks { yaw: stick, ..CENTRED };
        place(flight.step(FlightMode::Posctl, &sticks, &Circumstances { yaw_rad, ..high_up(&settings) })).1
    };
    assert_eq!(turn(0.0, 0.3), Heading { yaw_rad: 0.3, rate_rad_s: 0.0 });
    assert_eq!(turn(0.0, 0.4), Heading { yaw_rad: 0.3, rate_rad_s: 0.0 });
    let mut rate = 0.0;
    for _ in 0..50 {
        rate += 0.004 / 0.084 * (75.0 * RAD_PER_DEG - rate);
        let heading = turn(0.5, 1.0);
        assert_relative_eq!(heading.rate_rad_s, rate, epsilon = 1e-12);
        assert_eq!(heading.yaw_rad, 1.0, "the present one");
    }
    let steps = (0..1000).find(|_| turn(0.0, 2.0).rate_rad_s == 0.0).unwrap();
    // From 1.2 rad/s to 0.001 rad/s: ln(0.001/rate)/ln(0.08/0.084) steps.
    let expected = (math::ln(0.001 / rate) / math::ln(0.08 / 0.084)).floor() as usize;
    assert_eq!(steps, expected);
    assert_eq!(turn(0.0, 2.5).yaw_rad, 2.0);
    // MC_YAWRATE_MAX is the most.
    let slow = Circumstances { yaw_rate_rad_s: 0.2, ..high_up(&settings) };
    assert_eq!((slow.yaw_rate(1.0), slow.yaw_rate(-1.0)), (0.2, -0.2));
}

/// A proportional loop of gain k that is asked for yaw + rate/k turns at the rate; with a weak loop the lead
/// stays below half a turn.
#[test]
fn closed_form_the_lead_turns_a_proportional_loop_at_the_rate() {
    let heading = Heading { yaw_rad: 3.0, rate_rad_s: -0.6 };
    assert_eq!(heading.lead_rad(2.0), -0.3);
    assert_eq!((heading.lead_rad(0.01), heading.lead_rad(0.0)), (-FRAC_PI_2, 0.0));
}

/// Full stick is the acceleration of a tilt of MPC_MAN_TILT_MAX at hover, along the nose, without dead zone
/// and curve; height and heading are kept as in POSCTL.
#[test]
fn closed_form_altctl_accelerates_as_a_tilt_does() {
    let mut flight = ManualFlight::default();
    let c = high_up(&SETTINGS);
    let (pva, heading) = place(flight.step(FlightMode::Altctl, &Sticks { pitch: 0.5, ..CENTRED }, &c));
    let [p, v, a] = pva;
    assert_eq!((p, v), ([None, None, Some(-100.0)], [None, None, Some(0.0)]));
    let full = 9.81 * math::tan(35.0 * RAD_PER_DEG);
    assert_relative_eq!(a[1].unwrap(), 0.5 * full, epsilon = 1e-12);
    assert!(a[0].unwrap().abs() < 1e-12 && a[2].is_none());
    assert_eq!(heading, Heading { yaw_rad: FRAC_PI_2, rate_rad_s: 0.0 });
    // MC_MAN_TILT_TAU: a filter of first order, here of as long as the step.
    let filtered = ManualSettings { tilt_tau_s: 0.004, ..SETTINGS };
    let mut flight = ManualFlight::default();
    let mut east = || place(flight.step(FlightMode::Altctl, &FORWARD, &high_up(&filtered))).0[2][1].unwrap();
    assert_relative_eq!(east(), full / 2.0, epsilon = 1e-12);
    assert_relative_eq!(east(), full * 0.75, epsilon = 1e-12);
}

/// PX4's throttle_curve (mc_att_control_main.cpp, v1.14.0): MPC_MANTHR_MIN, the hover thrust in the middle,
/// MPC_THR_MAX, linear between; or linear from end to end.
#[test]
fn closed_form_the_throttle_stick_hovers_in_the_middle() {
    let thrust = |throttle| SETTINGS.thrust(throttle, 0.4);
    for (throttle, wanted) in [(-1.0, 0.08), (-0.5, 0.24), (0.0, 0.4), (0.5, 0.7), (1.0, 1.0), (-9.0, 0.08)] {
        assert_relative_eq!(thrust(throttle), wanted, epsilon = 1e-12);
    }
    let linear = ManualSettings { linear_thrust: true, most_thrust: 0.9, ..SETTINGS };
    assert_relative_eq!(linear.thrust(0.0, 0.4), 0.49, epsilon = 1e-12);
}

/// The stick's direction is that of the tilt, its length the angle, MPC_MAN_TILT_MAX at most; the heading is
/// where it was, and goes on by the yaw stick's rate but at idle.
#[test]
fn closed_form_stabilized_tilts_to_where_the_stick_points() {
    let c = high_up(&SETTINGS);
    let full = 35.0 * RAD_PER_DEG;
    let mut flight = ManualFlight::default();
    let (forward, heading, thrust) = tilt(flight.step(FlightMode::Stabilized, &FORWARD, &c));
    assert_relative_eq!(forward, Vector2::new(0.0, -full), epsilon = 1e-12);
    assert_eq!((heading.yaw_rad, thrust), (FRAC_PI_2, 0.4));
    let both = Sticks { roll: 1.0, ..FORWARD };
    let (tilted, ..) = tilt(flight.step(FlightMode::Manual, &both, &c));
    assert_relative_eq!(tilted.norm(), full, epsilon = 1e-12);
    assert_relative_eq!(tilted.x, -tilted.y, epsilon = 1e-12);
    let turning = Sticks { yaw: 0.5, ..CENTRED };
    for step in 1..=100 {
        let (_, heading, _) = tilt(flight.step(FlightMode::Stabilized, &turning, &c));
        let turned = f64::from(step) * 0.004 * 75.0 * RAD_PER_DEG;
        assert_relative_eq!(heading.yaw_rad, FRAC_PI_2 + turned, epsilon = 1e-9);
    }
    let idle = Sticks { throttle: -1.0, ..turning };
    assert_eq!(tilt(flight.step(FlightMode::Stabilized, &idle, &c)).1.yaw_rad, FRAC_PI_2);
}

/// The thrust axis leans by the tilt into the direction that the heading gives it, whatever the lead.
#[test]
fn closed_form_the_attitude_leans_along_the_heading() {
    let angle = 0.3;
    let forward = Vector2::new(0.0, -angle);
    for (yaw_rad, rate_rad_s) in [(0.0, 0.0), (1.2, 0.0), (1.2, 0.4), (-2.5, -0.7)] {
        let q = Heading { yaw_rad, rate_rad_s }.attitude(&forward, 2.0);
        let up = rotate_ned_from_body(q, -Vector3::z());
        let lean = math::sin(angle);
        let wanted = Vector3::new(lean * math::cos(yaw_rad), lean * math::sin(yaw_rad), -math::cos(angle));
        assert_relative_eq!(up, wanted, epsilon = 1e-12);
    }
    let level = Heading { yaw_rad: 0.0, rate_rad_s: 0.4 }.attitude(&Vector2::zeros(), 2.0);
    assert_relative_eq!(yaw(level), 0.2, epsilon = 1e-12);
    assert_eq!(Heading { yaw_rad: 0.0, rate_rad_s: 0.0 }.attitude(&Vector2::zeros(), 2.0), LEVEL);
}
