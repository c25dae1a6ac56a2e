//! Safety of a flight: the state's cost (47)-(50), its peak J_TPF (51), and the verdict on a drop.
//!
//! ```text
//! J_state = max(|v|/V_max, |theta|/theta_max, |Q|/Q_max)        J_TPF = max over all steps, ends included
//! ```
//!
//! Differs from the paper: motion out of the plane, which the paper does not have, counts too - roll against the limit of pitch, roll
//! rate against that of the pitch rate (in the plane both are zero and nothing changes). (49) and (50) are signed there, so that a nose-down dive would cost nothing; here they are
//! absolute. (48) uses the speed over ground, as the paper does. Table 1's vertical acceleration is reported, not judged: free
//! fall alone passes it on Earth.

use nalgebra::Vector3;

use crate::frames::{bank, pitch};
use crate::model::rigid_body::BodyState;
use crate::sim::{Phase, Sample};
use crate::trajectory::{Node, Trajectory};

/// Table 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafetyLimits {
    /// Speed [m/s].
    pub speed_m_s: f64,
    /// Pitch, either way, and roll [rad].
    pub pitch_rad: f64,
    /// Pitch rate, either way, and roll rate [rad/s].
    pub pitch_rate_rad_s: f64,
    /// Vertical acceleration [m/s^2]; reported, not judged.
    pub vertical_acceleration_m_s2: f64,
}

/// The parts of J_state, each 1 at its limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StateCost {
    /// J_v, (48).
    pub speed: f64,
    /// J_theta, (49).
    pub pitch: f64,
    /// J_Q, (50).
    pub pitch_rate: f64,
    /// As (49), for the roll.
    pub roll: f64,
    /// As (50), for the roll rate.
    pub roll_rate: f64,
}

impl StateCost {
    /// The cost of a state.
    pub fn of(body: &BodyState, limits: &SafetyLimits) -> Self {
        Self {
            speed: body.v_ned.norm() / limits.speed_m_s,
            pitch: pitch(body.q_ned_from_body).abs() / limits.pitch_rad,
            pitch_rate: body.omega_body.y.abs() / limits.pitch_rate_rad_s,
            roll: bank(body.q_ned_from_body).abs() / limits.pitch_rad,
            roll_rate: body.omega_body.x.abs() / limits.pitch_rate_rad_s,
        }
    }

    /// J_state, (47). A cost that is not a number is infinite.
    pub fn max(&self) -> f64 {
        let all = [self.speed, self.pitch, self.pitch_rate, self.roll, self.roll_rate];
        if all.iter().any(|c| c.is_nan()) {
            return f64::INFINITY;
        }
        all.into_iter().fold(0.0, f64::max)
    }

    /// Each part the larger of the two.
    fn worse(&self, other: &Self) -> Self {
        Self {
            speed: self.speed.max(other.speed),
            pitch: self.pitch.max(other.pitch),
            pitch_rate: self.pitch_rate.max(other.pitch_rate),
            roll: self.roll.max(other.roll),
            roll_rate: self.roll_rate.max(other.roll_rate),
        }
    }
}

/// J_TPF of a plan, (51): the largest J_state of its nodes, as the paper evaluates its optimum. The velocity between nodes is
/// not looked at: a coarse plan may pass a limit there.
pub fn plan_j_tpf(plan: &Trajectory, limits: &SafetyLimits) -> f64 {
    let cost = |node: &Node| {
        let body = BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: node.q_ned_from_body,
            v_ned: node.v_ned,
            omega_body: node.omega_body,
        };
        StateCost::of(&body, limits).max()
    };
    plan.nodes().iter().map(cost).fold(0.0, f64::max)
}

/// What a drop came to, from the release to the end.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// J_TPF, (51).
    pub j_tpf: f64,
    /// Largest speed [m/s].
    pub peak_speed_m_s: f64,
    /// Largest pitch, either way, with its sign [rad].
    pub peak_pitch_rad: f64,
    /// Largest pitch rate, either way, with its sign [rad/s].
    pub peak_pitch_rate_rad_s: f64,
    /// Largest roll, either way, with its sign [rad].
    pub peak_roll_rad: f64,
    /// Largest roll rate, either way, with its sign [rad/s].
    pub peak_roll_rate_rad_s: f64,
    /// Largest vertical acceleration, either way, with its sign (down is positive) [m/s^2].
    pub peak_vertical_acceleration_m_s2: f64,
    /// Way down from the release to the end [m].
    pub altitude_lost_m: f64,
    /// Time after the rotors were freed [s] from which `|v - v_cmd| <=` [`steady_within_m_s`] holds to the end.
    pub steady_after_s: Option<f64>,
    /// Names of the limits that were passed: "speed", "pitch", "pitch_rate", "roll", "roll_rate"; "state is not finite" when a state was no number,
    /// "impact".
    pub limits_passed: Vec<&'static str>,
    /// Velocity at the end, NED [m/s].
    pub final_v_ned: Vector3<f64>,
    /// Fastest that it came to the ground, if it did [m/s].
    pub impact_speed_m_s: Option<f64>,
}

/// Steady within this fraction of the commanded velocity.
const STEADY_FRACTION: f64 = 0.01;

/// Steady within this velocity [m/s] at the least: 1 % of a hover would be nothing.
const STEADY_LEAST_M_S: f64 = 0.02;

/// How close to a commanded velocity is steady [m/s]: 1 % of it, and 0.02 m/s at the least.
pub fn steady_within_m_s(v_cmd_ned: &Vector3<f64>) -> f64 {
    (STEADY_FRACTION * v_cmd_ned.norm()).max(STEADY_LEAST_M_S)
}

/// Makes a [`Verdict`] of a flight's samples, given one by one in order of time.
#[derive(Clone, Debug)]
pub struct VerdictBuilder {
    limits: SafetyLimits,
    v_cmd_ned: Vector3<f64>,
    peak: StateCost,
    infinite: bool,
    pitch_rad: f64,
    pitch_rate_rad_s: f64,
    roll_rad: f64,
    roll_rate_rad_s: f64,
    vertical_acceleration_m_s2: f64,
    steady_since_s: Option<f64>,
    first_down_m: Option<f64>,
    last: Option<BodyState>,
    impact_limit_m_s: Option<f64>,
    impact_speed_m_s: Option<f64>,
    touching: bool,
}

impl VerdictBuilder {
    /// Judges against `limits`; steady means close to `v_cmd_ned` [m/s].
    pub fn new(limits: SafetyLimits, v_cmd_ned: Vector3<f64>) -> Self {
        Self {
            limits,
            v_cmd_ned,
            peak: StateCost::default(),
            infinite: false,
            pitch_rad: 0.0,
            pitch_rate_rad_s: 0.0,
            roll_rad: 0.0,
            roll_rate_rad_s: 0.0,
            vertical_acceleration_m_s2: 0.0,
            steady_since_s: None,
            first_down_m: None,
            last: None,
            impact_limit_m_s: None,
            impact_speed_m_s: None,
            touching: false,
        }
    }

    /// Judges also how fast the vehicle comes to the ground [m/s]: a limit of its own, no part of J_TPF.
    pub fn judging_impacts(mut self, limit_m_s: f64) -> Self {
        self.impact_limit_m_s = Some(limit_m_s);
        self
    }

    /// A touch counts with the speed of the sample before it; what stood there from the start has not come down.
    fn observe_ground(&mut self, sample: &Sample) {
        let touching = sample.balance.ground_force_ned.z < 0.0;
        let sank_m_s = match self.last {
            Some(last) => last.v_ned.z,
            None if sample.phase == Phase::Falling => sample.state.body.v_ned.z,
            None => 0.0,
        };
        if touching && !self.touching && sank_m_s > 0.0 {
            self.impact_speed_m_s = Some(self.impact_speed_m_s.map_or(sank_m_s, |worst| worst.max(sank_m_s)));
        }
        self.touching = touching;
    }

    /// Takes the next sample; what happens under the canopy does not count.
    pub fn observe(&mut self, sample: &Sample) {
        if sample.phase == Phase::Hanging {
            return;
        }
        let body = &sample.state.body;
        let cost = StateCost::of(body, &self.limits);
        self.infinite |= cost.max() == f64::INFINITY;
        self.peak = self.peak.worse(&cost);
        for (peak, now) in [
            (&mut self.pitch_rad, pitch(body.q_ned_from_body)),
            (&mut self.pitch_rate_rad_s, body.omega_body.y),
            (&mut self.roll_rad, bank(body.q_ned_from_body)),
            (&mut self.roll_rate_rad_s, body.omega_body.x),
            (&mut self.vertical_acceleration_m_s2, sample.a_ned.z),
        ] {
            if now.abs() > peak.abs() {
                *peak = now;
            }
        }
        let near = (body.v_ned - self.v_cmd_ned).norm() <= steady_within_m_s(&self.v_cmd_ned);
        self.observe_ground(sample);
        match sample.t_powered_s {
            // What was steady when it came to the ground stays so.
            _ if self.impact_speed_m_s.is_some() => {}
            Some(t) if near && sample.phase == Phase::Powered => {
                self.steady_since_s.get_or_insert(t);
            }
            _ => self.steady_since_s = None,
        }
        self.first_down_m.get_or_insert(body.p_ned.z);
        self.last = Some(*body);
    }

    /// J_TPF of what was observed so far.
    pub fn j_tpf(&self) -> f64 {
        if self.infinite { f64::INFINITY } else { self.peak.max() }
    }

    /// The verdict; `None` when nothing was observed from the release on.
    pub fn finish(self) -> Option<Verdict> {
        let (last, first_down_m) = (self.last?, self.first_down_m?);
        let parts = [
            ("speed", self.peak.speed > 1.0),
            ("pitch", self.peak.pitch > 1.0),
            ("pitch_rate", self.peak.pitch_rate > 1.0),
            ("roll", self.peak.roll > 1.0),
            ("roll_rate", self.peak.roll_rate > 1.0),
            ("state is not finite", self.infinite),
            (
                "impact",
                self.impact_speed_m_s.zip(self.impact_limit_m_s).is_some_and(|(speed, limit)| speed > limit),
            ),
        ];
        Some(Verdict {
            j_tpf: self.j_tpf(),
            peak_speed_m_s: self.peak.speed * self.limits.speed_m_s,
            peak_pitch_rad: self.pitch_rad,
            peak_pitch_rate_rad_s: self.pitch_rate_rad_s,
            peak_roll_rad: self.roll_rad,
            peak_roll_rate_rad_s: self.roll_rate_rad_s,
            peak_vertical_acceleration_m_s2: self.vertical_acceleration_m_s2,
            altitude_lost_m: last.p_ned.z - first_down_m,
            steady_after_s: self.steady_since_s,
            limits_passed: parts.iter().filter(|(_, passed)| *passed).map(|(name, _)| *name).collect(),
            final_v_ned: last.v_ned,
            impact_speed_m_s: self.impact_speed_m_s,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::quaternion_from_euler;
    use crate::model::ForceBalance;
    use crate::sim::PlantState;

    const LIMITS: SafetyLimits = SafetyLimits {
        speed_m_s: 12.0,
        pitch_rad: 0.8,
        pitch_rate_rad_s: 1.6,
        vertical_acceleration_m_s2: 3.0,
    };

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

    /// The same motion turned out of the plane costs the same; beyond the vertical in the plane there is still no roll.
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
        let (pitched, rolled) =
            (verdict([0.0, -0.9], [0.0, 1.7, 0.0]), verdict([-0.9, 0.0], [1.7, 0.0, 0.0]));
        assert!((pitched.j_tpf - 0.9 / 0.8).abs() < 1e-12 && (rolled.j_tpf - pitched.j_tpf).abs() < 1e-12);
        assert_eq!(pitched.limits_passed, ["pitch", "pitch_rate"]);
        assert_eq!(rolled.limits_passed, ["roll", "roll_rate"]);
        assert!((rolled.peak_roll_rad + 0.9).abs() < 1e-12 && rolled.peak_roll_rate_rad_s == 1.7);
        let over = verdict([0.0, 2.0], [0.0; 3]);
        assert_eq!((over.peak_roll_rad, over.limits_passed.as_slice()), (0.0, ["pitch"].as_slice()));
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

    /// A touch counts with the speed before it, the worst of them; what stood there from the start has not come down; and what was
    /// steady when it touched the ground stays so.
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
}
