//! Tests of the state's cost and the verdict.

use nalgebra::Vector3;

use super::judge::{self, Course, Objection};
use super::limits::{Limits, TouchLimits};
use super::outcome::Outcome;
use super::safety::*;
use crate::frames::quaternion_from_euler;
use crate::model::ForceBalance;
use crate::model::rigid_body::BodyState;

use crate::sim::limits::*;
use crate::sim::{Phase, PlantState, Sample};
use crate::trajectory::{Node, Trajectory};
use crate::units::DEG_PER_RAD;

const LIMITS: SafetyLimits =
    SafetyLimits { speed_m_s: 12.0, pitch_rad: 0.8, pitch_rate_rad_s: 1.6, vertical_acceleration_m_s2: 3.0 };

fn sample(t_s: f64, phase: Phase, v_ned: [f64; 3], pitch_rad: f64, rate: f64, a_down: f64) -> Sample {
    let body = BodyState {
        p_ned: Vector3::new(0.0, 0.0, 10.0 * t_s),
        q_ned_from_body: quaternion_from_euler(0.0, pitch_rad, 0.0),
        v_ned: v_ned.into(),
        omega_body: Vector3::new(0.0, rate, 0.0),
    };
    Sample {
        t_s,
        t_powered_s: Some(t_s - 1.0),
        phase,
        state: PlantState::rotors_at_rest(body),
        v_sp_ned: None,
        throttle: [0.0; 8],
        balance: ForceBalance::default(),
        a_ned: Vector3::new(0.0, 0.0, a_down),
        wind_ned: Vector3::zeros(),
        canopy: None,
        esc: None,
        bus: None,
        turned_over: false,
    }
}

#[test]
fn paper_state_cost_is_the_largest_share_of_a_limit_either_way() {
    let s = sample(0.0, Phase::Powered, [0.0, 3.0, 4.0], -0.4, 0.4, 0.0);
    let cost = StateCost::of(&s.state.body, &LIMITS);
    assert!((cost.speed - 5.0 / 12.0).abs() < 1e-15);
    assert!((cost.pitch - 0.5).abs() < 1e-15 && (cost.pitch_rate - 0.25).abs() < 1e-15);
    assert_eq!(cost.max(), cost.pitch);
    assert_eq!(StateCost { speed: f64::NAN, ..cost }.max(), f64::INFINITY);
}

#[test]
fn verdict_counts_from_the_release_to_the_end() {
    let mut b = VerdictBuilder::new(LIMITS, Vector3::new(4.0, 0.0, 4.0));
    b.observe(&sample(0.0, Phase::Hanging, [0.0, 0.0, 90.0], 0.7, 1.0, 9.0));
    b.observe(&sample(1.0, Phase::Falling, [0.0, 0.0, 3.0], 0.0, 0.0, 1.3));
    b.observe(&sample(2.0, Phase::Powered, [4.0, 0.0, 4.0], -0.9, 0.3, -0.5));
    b.observe(&sample(3.0, Phase::Powered, [3.0, 0.0, 4.0], 0.2, -0.8, 0.0));
    b.observe(&sample(4.0, Phase::Powered, [4.0, 0.0, 4.05], 0.0, 0.0, 0.0));
    b.observe(&sample(5.0, Phase::Powered, [4.0, 0.0, 4.0], 0.0, 0.0, 0.0));
    let v = b.finish().unwrap();
    assert!((v.outcome.j_tpf - 0.9 / 0.8).abs() < 1e-12);
    assert_eq!(v.limits_passed, ["pitch"]);
    assert!((v.peaks.pitch_rad + 0.9).abs() < 1e-12 && v.peaks.pitch_rate_rad_s == -0.8);
    assert_eq!(v.peak_vertical_acceleration_m_s2, 1.3);
    assert_eq!(v.outcome.altitude_lost_m, 40.0);
    assert_eq!(v.outcome.steady_after_s, Some(3.0), "near at 1 s too, but it did not last");
    assert_eq!(v.outcome.final_v_ned(), Vector3::new(4.0, 0.0, 4.0));
}

/// 10 m a second: from the release at 1 s to the plan's end, 2 s into powered flight, which begins at 1 s.
#[test]
fn closed_form_altitude_is_lost_to_the_plans_end() {
    for (plan_end_s, lost_m) in [(2.0, 20.0), (2.9, 20.0), (9.0, 40.0), (f64::INFINITY, 40.0)] {
        let mut b = VerdictBuilder::new(LIMITS, Vector3::new(4.0, 0.0, 4.0)).to_plans_end(plan_end_s);
        for t in 1..=5 {
            b.observe(&sample(f64::from(t), Phase::Powered, [4.0, 0.0, 4.0], 0.0, 0.0, 0.0));
        }
        assert_eq!(b.finish().unwrap().outcome.altitude_lost_m, lost_m);
    }
}

#[test]
fn nothing_observed_gives_no_verdict_and_a_broken_state_the_worst_one() {
    let mut b = VerdictBuilder::new(LIMITS, Vector3::new(4.0, 0.0, 4.0));
    b.observe(&sample(0.0, Phase::Hanging, [0.0; 3], 0.0, 0.0, 0.0));
    assert_eq!(b.clone().finish(), None);
    b.observe(&sample(1.0, Phase::Powered, [f64::NAN, 0.0, 0.0], 0.0, 0.0, 0.0));
    let v = b.finish().unwrap();
    assert_eq!(v.outcome.j_tpf, f64::INFINITY);
    assert_eq!(v.limits_passed, ["state is not finite"]);
}

/// A motion turned out of the plane costs the same; beyond the vertical in the plane there is still no
/// roll.
#[test]
fn closed_form_roll_is_judged_as_pitch_is() {
    let verdict = |euler: [f64; 2], omega: [f64; 3]| {
        let mut s = sample(1.0, Phase::Powered, [4.0, 0.0, 4.0], 0.0, 0.0, 0.0);
        s.state.body.q_ned_from_body = quaternion_from_euler(euler[0], euler[1], 0.0);
        s.state.body.omega_body = omega.into();
        let mut b = VerdictBuilder::new(LIMITS, Vector3::new(4.0, 0.0, 4.0));
        b.observe(&s);
        b.finish().unwrap()
    };
    let (pitched, rolled) = (verdict([0.0, -0.9], [0.0, 1.7, 0.0]), verdict([-0.9, 0.0], [1.7, 0.0, 0.0]));
    assert!(
        (pitched.outcome.j_tpf - 0.9 / 0.8).abs() < 1e-12
            && (rolled.outcome.j_tpf - pitched.outcome.j_tpf).abs() < 1e-12
    );
    assert_eq!(pitched.limits_passed, ["pitch", "pitch_rate"]);
    assert_eq!(rolled.limits_passed, ["roll", "roll_rate"]);
    assert!((rolled.peaks.roll_rad + 0.9).abs() < 1e-12 && rolled.peaks.roll_rate_rad_s == 1.7);
    let over = verdict([0.0, 2.0], [0.0; 3]);
    assert_eq!((over.peaks.roll_rad, over.limits_passed.as_slice()), (0.0, ["pitch"].as_slice()));
}

/// Half a turn is the most that a pitch counts, and a flight that has turned over counts it however it
/// stands; its peak is the angle that it turned by.
#[test]
fn closed_form_a_flight_that_has_turned_over_counts_half_a_turn() {
    let most = std::f64::consts::PI / LIMITS.pitch_rad;
    let at = |pitch_rad: f64, turned_over: bool| Sample {
        turned_over,
        ..sample(1.0, Phase::Powered, [4.0, 0.0, 4.0], pitch_rad, 0.0, 0.0)
    };
    for (pitch_rad, turned_over, share) in [
        (3.0, false, 3.0 / LIMITS.pitch_rad),
        (-3.2, true, most),
        (6.2, true, most),
        (0.0, true, most),
        (0.4, false, 0.5),
    ] {
        let cost = StateCost::of_sample(&at(pitch_rad, turned_over), &LIMITS);
        assert!((cost.pitch - share).abs() < 1e-12, "{pitch_rad}: {}", cost.pitch);
    }
    let mut b = VerdictBuilder::new(LIMITS, Vector3::new(4.0, 0.0, 4.0));
    [at(0.0, false), at(3.0, false), at(4.0, true), at(6.2, true), at(0.1, true)]
        .iter()
        .for_each(|s| b.observe(s));
    let v = b.finish().unwrap();
    assert_eq!(
        (v.outcome.j_tpf, v.decided_by, v.limits_passed.as_slice()),
        (most, "pitch", ["pitch"].as_slice())
    );
    assert!((v.peaks.pitch_rad - 6.2).abs() < 1e-12);
    let mut broken = at(0.1, true);
    broken.state.body.q_ned_from_body = [f64::NAN; 4];
    assert_eq!(StateCost::of_sample(&broken, &LIMITS).max(), f64::INFINITY);
}

/// 1 % of the target, but of a hover a fixed 0.02 m/s.
#[test]
fn closed_form_a_hover_can_be_steady() {
    let steady = |target: f64, off: f64| {
        let mut b = VerdictBuilder::new(LIMITS, Vector3::new(0.0, 0.0, target));
        b.observe(&sample(1.0, Phase::Powered, [0.0, off, target], 0.0, 0.0, 0.0));
        b.finish().unwrap().outcome.steady_after_s.is_some()
    };
    assert!(steady(0.0, 0.019) && !steady(0.0, 0.021));
    assert!(steady(4.0, 0.039) && !steady(4.0, 0.041));
}

/// A sample of a touch, or none, with a velocity and a tilt.
fn touching(t_s: f64, phase: Phase, v_ned: [f64; 3], pitch_rad: f64, touches: bool) -> Sample {
    let mut s = sample(t_s, phase, v_ned, pitch_rad, 0.0, 0.0);
    s.balance.ground_force_ned.z = if touches { -9.0 } else { 0.0 };
    s
}

fn touch_limits(speed_m_s: f64, tilt_rad: f64) -> Limits {
    Limits { touch: TouchLimits { speed_m_s, tilt_rad }, ..Limits::of_j_state(LIMITS, 0.02) }
}

/// A touch counts with the whole velocity before it, the worst of them; what stood there from the start has
/// not come down; and what was steady when it touched the ground stays so.
#[test]
fn closed_form_impacts_are_judged_by_their_whole_speed() {
    let verdict = |limit: f64, flight: &[(f64, bool)]| {
        let limits = touch_limits(limit, 1.0);
        let mut b = VerdictBuilder::judging(limits, Vector3::new(0.0, 0.0, 1.5));
        flight.iter().for_each(|&(v_down, touches)| {
            b.observe(&touching(2.0, Phase::Powered, [0.0, 0.0, v_down], 0.0, touches));
        });
        b.finish().unwrap()
    };
    let stood = verdict(1.0, &[(0.0, true), (-1.0, false), (-1.0, false)]);
    assert_eq!((stood.outcome.impact_speed_m_s, stood.limits_passed.is_empty()), (None, true));
    let flight =
        [(0.0, false), (1.5, false), (0.2, true), (-0.5, false), (0.4, false), (0.0, true), (0.0, true)];
    let soft = verdict(1.6, &flight);
    assert_eq!((soft.outcome.impact_speed_m_s, soft.limits_passed.is_empty()), (Some(1.5), true));
    assert_eq!(soft.outcome.steady_after_s, Some(1.0));
    let hard = verdict(1.4, &flight);
    assert_eq!(hard.limits_passed, ["impact"]);
    assert!(hard.outcome.j_tpf < 1.0, "no part of J_TPF");
    let mut b = VerdictBuilder::judging(touch_limits(2.9, 1.0), Vector3::zeros());
    b.observe(&touching(2.0, Phase::Falling, [0.0, 0.0, 3.0], 0.0, true));
    assert_eq!(b.finish().unwrap().outcome.impact_speed_m_s, Some(3.0), "under its canopy");
}

/// Sliding onto the ground at 7.9 m/s, of which 1 m/s is down, is an impact at 7.9632 m/s; a soft one on its
/// side is one on its side; and the bump itself, however it throws the vehicle about, is no peak of the
/// flight, which is over.
#[test]
fn closed_form_a_slide_and_a_tumble_are_no_landing() {
    let flown = |v_ned: [f64; 3], pitch_rad: f64| {
        let mut b = VerdictBuilder::judging(touch_limits(2.1, 0.26), Vector3::zeros()).to_plans_end(4.0);
        b.observe(&touching(1.0, Phase::Falling, [0.0, 0.0, 2.0], 0.0, false));
        b.observe(&touching(1.5, Phase::Powered, v_ned, pitch_rad, false));
        let mut bump = touching(2.0, Phase::Powered, [1.0, 0.0, -1.0], 0.7, true);
        bump.state.body.omega_body.y = 50.0;
        b.observe(&bump);
        let mut after = bump;
        after.balance.ground_force_ned.z = 0.0;
        after.t_powered_s = Some(1.1);
        b.observe(&after);
        b.finish().unwrap()
    };
    let slid = flown([7.9, 0.0, 1.0], 0.1);
    assert!((slid.outcome.impact_speed_m_s.unwrap() - 63.41f64.sqrt()).abs() < 1e-12);
    assert_eq!(slid.limits_passed, ["impact"]);
    assert!(
        (slid.outcome.j_tpf - 63.41f64.sqrt() / 12.0).abs() < 1e-12,
        "the bump does not count: {}",
        slid.outcome.j_tpf
    );
    let tumbled = flown([0.0, 0.0, 0.5], 0.5);
    assert!((tumbled.outcome.impact_tilt_deg.unwrap() / DEG_PER_RAD - 0.5).abs() < 1e-12);
    assert_eq!(tumbled.limits_passed, ["impact_tilt"]);
    let words = |v: &Verdict, course: &Course| judge::words(&judge(Some(v), course)).unwrap_or_default();
    assert_eq!(
        words(&slid, &Course { must_be_steady: false, ..Course::WHOLE }),
        "on the ground after 1.0 s, before the plan's end; impact 7.96 m/s, limit 2.10"
    );
    let soft = flown([0.0, 0.0, 0.5], 0.1);
    assert_eq!(words(&soft, &Course::WHOLE), "on the ground after 1.0 s, before the plan's end");
    // LAND was commanded, or it began on the ground.
    assert_eq!(words(&soft, &Course { may_land: true, ..Course::WHOLE }), "");
}

/// A flight is over at its touch, and goes on a metre above it.
#[test]
fn closed_form_what_flies_again_is_judged_again() {
    let rate = |heights: &[f64]| {
        let mut b = VerdictBuilder::judging(touch_limits(2.1, 1.0), Vector3::zeros());
        b.observe(&touching(1.0, Phase::Powered, [0.0, 0.0, 1.0], 0.0, false));
        b.observe(&touching(2.0, Phase::Powered, [0.0, 0.0, 0.0], 0.0, true));
        for height_m in heights {
            let mut s = touching(2.0, Phase::Powered, [0.0, 0.0, -1.0], 0.0, false);
            s.state.body.p_ned.z -= height_m;
            s.state.body.omega_body.y = 3.2;
            b.observe(&s);
        }
        b.finish().unwrap().outcome.j_tpf
    };
    assert!(rate(&[0.2, 0.99]) < 1.0);
    assert!((rate(&[0.5, 1.01]) - 2.0).abs() < 1e-12);
}

/// A plan that sinks at 4 m/s, the slower the later, comes to rest after 3 s: 6 m of the way down, after the
/// 2.5 m of the fall, where there were 4.
#[test]
fn closed_form_the_ground_names_the_height_that_the_plan_needs() {
    let node = |t_s: f64, v_down: f64| Node {
        t_s,
        q_ned_from_body: [1.0, 0.0, 0.0, 0.0],
        v_ned: Vector3::new(0.0, 0.0, v_down),
        omega_body: Vector3::zeros(),
        thrust_n: [1.0; 8],
        a_ned: Vector3::new(0.0, 0.0, -4.0 / 3.0),
    };
    let plan = Trajectory::new(vec![node(0.0, 4.0), node(3.0, 0.0)], 4).unwrap();
    let mut b = VerdictBuilder::judging(touch_limits(9.0, 1.0), Vector3::zeros()).along(&plan);
    let at = |t_s: f64, phase, down_m: f64, touches| {
        let mut s = touching(t_s, phase, [0.0, 0.0, 4.0], 0.0, touches);
        s.state.body.p_ned.z = down_m;
        s
    };
    b.observe(&at(0.5, Phase::Falling, 0.0, false));
    b.observe(&at(1.0, Phase::Powered, 2.5, false));
    b.observe(&at(1.5, Phase::Powered, 4.0, true));
    let ground = b.finish().unwrap().on_the_ground.unwrap();
    assert!((ground.after_s - 1.0).abs() < 1e-12 && (ground.height_m - 4.0).abs() < 1e-12);
    let (needed_m, pulls_out) = ground.needed.unwrap();
    assert!((needed_m - 8.5).abs() < 1e-12 && pulls_out, "{needed_m}");
    let words = Objection::OnTheGround(ground).to_string();
    assert_eq!(words, "on the ground after 1.0 s: the pull-out needs 9 m, there were 4");
}

/// Each limit alone, at it and a hair beyond; what is never steady fails only where that is judged.
#[test]
fn an_objection_names_what_was_passed() {
    let o = Outcome {
        j_tpf: 0.5,
        peak_tilt_deg: 30.0 / DEG_PER_RAD * DEG_PER_RAD,
        altitude_lost_m: 20.0,
        steady_after_s: Some(4.0),
        ..Outcome::default()
    };
    let given = |altitude: f64, tilt_deg: f64, steady: f64| Limits {
        altitude_lost_m: Some(altitude),
        tilt_rad: Some(tilt_deg / DEG_PER_RAD),
        steady_after_s: Some(steady),
        must_be_steady: true,
        ..Limits::of_j_state(LIMITS, 0.1)
    };
    let why = |o: &Outcome, limits: &Limits| judge::words(&judge_trial(o, limits));
    assert_eq!(why(&o, &given(20.0, 30.0, 4.0)), None);
    for (limits, expected) in [
        (given(19.99, 30.0, 4.0), "altitude lost 20.00 m, limit 19.99"),
        (given(20.0, 29.99, 4.0), "tilt 30.00 deg, limit 29.99"),
        (given(20.0, 30.0, 3.99), "steady after 4.00 s, limit 3.99"),
        (given(20.0, 30.0, 3.995), "steady after 4.00 s, limit 3.995"),
        (given(19.5, 30.0, 4.0), "altitude lost 20.00 m, limit 19.50"),
        (given(19.999, 30.0, 4.0), "altitude lost 20.00 m, limit 19.999"),
        (given(19.5, 29.0, 4.0), "altitude lost 20.00 m, limit 19.50; tilt 30.00 deg, limit 29.00"),
        (Limits { j_tpf_below: 0.5, ..given(20.0, 30.0, 4.0) }, "J_TPF 0.500, not below 0.5"),
    ] {
        assert_eq!(why(&o, &limits).as_deref(), Some(expected));
    }
    let just = Outcome { altitude_lost_m: 20.0004, ..o };
    let told = why(&just, &given(20.0, 30.0, 4.0));
    assert_eq!(
        told.as_deref(),
        Some("altitude lost 20.0004 m, limit 20.00"),
        "they differ as they are shown"
    );
    let restless = Outcome { steady_after_s: None, ..o };
    let limits = given(20.0, 30.0, 4.0);
    assert_eq!(why(&restless, &limits).as_deref(), Some("never steady within 0.1 m/s of the target"));
    assert_eq!(why(&restless, &Limits { must_be_steady: false, ..limits }), None);
    let lost = Outcome { j_tpf: f64::NAN, ..o };
    assert_eq!(why(&lost, &limits).as_deref(), Some("state is not finite"));
}
