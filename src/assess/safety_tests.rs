//! Tests of the state's cost and the verdict.

use nalgebra::Vector3;

use super::safety::*;
use crate::frames::quaternion_from_euler;
use crate::model::ForceBalance;
use crate::model::rigid_body::BodyState;

use crate::sim::limits::*;
use crate::sim::{Phase, PlantState, Sample};

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
    assert!((v.j_tpf - 0.9 / 0.8).abs() < 1e-12);
    assert_eq!(v.limits_passed, ["pitch"]);
    assert!((v.peak_pitch_rad + 0.9).abs() < 1e-12 && v.peak_pitch_rate_rad_s == -0.8);
    assert_eq!(v.peak_vertical_acceleration_m_s2, 1.3);
    assert_eq!(v.altitude_lost_m, 40.0);
    assert_eq!(v.steady_after_s, Some(3.0), "near at 1 s too, but it did not last");
    assert_eq!(v.final_v_ned, Vector3::new(4.0, 0.0, 4.0));
}

/// 10 m a second: from the release at 1 s to the plan's end, 2 s into powered flight, which begins at 1 s.
#[test]
fn closed_form_altitude_is_lost_to_the_plans_end() {
    for (plan_end_s, lost_m) in [(2.0, 20.0), (2.9, 20.0), (9.0, 40.0), (f64::INFINITY, 40.0)] {
        let mut b = VerdictBuilder::new(LIMITS, Vector3::new(4.0, 0.0, 4.0)).to_plans_end(plan_end_s);
        for t in 1..=5 {
            b.observe(&sample(f64::from(t), Phase::Powered, [4.0, 0.0, 4.0], 0.0, 0.0, 0.0));
        }
        assert_eq!(b.finish().unwrap().altitude_lost_m, lost_m);
    }
}

#[test]
fn nothing_observed_gives_no_verdict_and_a_broken_state_the_worst_one() {
    let mut b = VerdictBuilder::new(LIMITS, Vector3::new(4.0, 0.0, 4.0));
    b.observe(&sample(0.0, Phase::Hanging, [0.0; 3], 0.0, 0.0, 0.0));
    assert_eq!(b.clone().finish(), None);
    b.observe(&sample(1.0, Phase::Powered, [f64::NAN, 0.0, 0.0], 0.0, 0.0, 0.0));
    let v = b.finish().unwrap();
    assert_eq!(v.j_tpf, f64::INFINITY);
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
    assert!((pitched.j_tpf - 0.9 / 0.8).abs() < 1e-12 && (rolled.j_tpf - pitched.j_tpf).abs() < 1e-12);
    assert_eq!(pitched.limits_passed, ["pitch", "pitch_rate"]);
    assert_eq!(rolled.limits_passed, ["roll", "roll_rate"]);
    assert!((rolled.peak_roll_rad + 0.9).abs() < 1e-12 && rolled.peak_roll_rate_rad_s == 1.7);
    let over = verdict([0.0, 2.0], [0.0; 3]);
    assert_eq!((over.peak_roll_rad, over.limits_passed.as_slice()), (0.0, ["pitch"].as_slice()));
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
    assert_eq!((v.j_tpf, v.decided_by, v.limits_passed.as_slice()), (most, "pitch", ["pitch"].as_slice()));
    assert!((v.peak_pitch_rad - 6.2).abs() < 1e-12);
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
        b.finish().unwrap().steady_after_s.is_some()
    };
    assert!(steady(0.0, 0.019) && !steady(0.0, 0.021));
    assert!(steady(4.0, 0.039) && !steady(4.0, 0.041));
}

/// A touch counts with the speed before it, the worst of them; what stood there from the start has not come
/// down; and what was steady when it touched the ground stays so.
#[test]
fn closed_form_impacts_are_judged_by_their_speed() {
    let with = |phase, v_down: f64, touching: bool| {
        let mut s = sample(2.0, phase, [0.0, 0.0, v_down], 0.0, 0.0, 0.0);
        s.balance.ground_force_ned.z = if touching { -9.0 } else { 0.0 };
        s
    };
    let verdict = |limit: f64, flight: &[(f64, bool)]| {
        let mut b = VerdictBuilder::new(LIMITS, Vector3::new(0.0, 0.0, 1.5)).judging_impacts(limit);
        flight.iter().for_each(|&(v_down, touching)| b.observe(&with(Phase::Powered, v_down, touching)));
        b.finish().unwrap()
    };
    let stood = verdict(1.0, &[(0.0, true), (-1.0, false), (-1.0, false)]);
    assert_eq!((stood.impact_speed_m_s, stood.limits_passed.is_empty()), (None, true));
    let flight =
        [(0.0, false), (1.5, false), (0.2, true), (-0.5, false), (0.4, false), (0.0, true), (0.0, true)];
    let soft = verdict(1.6, &flight);
    assert_eq!((soft.impact_speed_m_s, soft.limits_passed.is_empty()), (Some(1.5), true));
    assert_eq!(soft.steady_after_s, Some(1.0));
    let hard = verdict(1.4, &flight);
    assert_eq!(hard.limits_passed, ["impact"]);
    assert!(hard.j_tpf < 1.0, "no part of J_TPF");
    let mut b = VerdictBuilder::new(LIMITS, Vector3::zeros());
    b.observe(&with(Phase::Falling, 3.0, true));
    assert_eq!(b.finish().unwrap().impact_speed_m_s, Some(3.0), "under its canopy");
}
