//! Safety limits of a flight and a state's share of them: the cost of a state, (47)-(50).
//!
//! ```text
//! J_state = max(|v|/V_max, |theta|/theta_max, |Q|/Q_max)
//! ```
//!
//! Differs from the paper: motion out of the plane, which the paper does not have, counts too - roll against
//! the limit of pitch, roll rate against that of the pitch rate (in the plane both are zero and nothing
//! changes). (49) and (50) are signed there, so that a nose-down dive would cost nothing; here they are
//! absolute. (48) uses the speed over ground, as the paper does. Table 1's vertical acceleration is reported,
//! not judged: free fall alone passes it on Earth.
//!
//! An angle counts as half a turn at the most, and a flight that has turned over
//! ([`super::turning_over`]) counts at least 180 deg of pitch from then on, however it stands: otherwise a
//! turn and a half would cost nothing again, and one that is a little short of a turn nearly two half turns.

use std::f64::consts::PI;

use super::record::Sample;
use crate::frames::pitch_and_bank;
use crate::model::rigid_body::BodyState;
use crate::real::Real;
use crate::vector::V3;

/// Name of what decides J_TPF, and is passed, when a state was no number.
pub const NOT_FINITE: &str = "state is not finite";

/// Limits of a safe flight, Table 1.
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

/// J_theta, (49): the share of its limit that a pitch [rad] takes, counted through the vertical and on; as
/// half a turn where it is more.
#[inline(always)]
pub(crate) fn pitch_share<S: Real>(pitch_rad: S, limits: &SafetyLimits) -> S {
    let (angle_rad, pi) = (pitch_rad.abs(), pitch_rad.of(PI));
    S::select(pi.less(angle_rad), pi, angle_rad) / pi.of(limits.pitch_rad)
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
    /// Share of the pitch's limit that the roll takes, as (49).
    pub roll: f64,
    /// Share of the pitch rate's limit that the roll rate takes, as (50).
    pub roll_rate: f64,
}

/// The parts of J_state: speed, pitch, pitch rate, roll, roll rate, over any [`Real`]; in a flight that has
/// turned over where the mask holds.
#[inline(always)]
pub(crate) fn shares<S: Real>(
    speed_m_s: S,
    [pitch_rad, roll_rad]: [S; 2],
    omega_body: V3<S>,
    turned_over: S::Mask,
    limits: &SafetyLimits,
) -> [S; 5] {
    let (pi, pitch) = (speed_m_s.of(PI), speed_m_s.of(limits.pitch_rad));
    let rate = speed_m_s.of(limits.pitch_rate_rad_s);
    let share = pitch_share(pitch_rad, limits);
    // An angle that is none stays so.
    let over = turned_over & share.less(pi.of(f64::INFINITY));
    [
        speed_m_s / pi.of(limits.speed_m_s),
        S::select(over, pi / pitch, share),
        omega_body.y.abs() / rate,
        roll_rad.abs() / pitch,
        omega_body.x.abs() / rate,
    ]
}

impl From<[f64; 5]> for StateCost {
    fn from([speed, pitch, pitch_rate, roll, roll_rate]: [f64; 5]) -> Self {
        Self { speed, pitch, pitch_rate, roll, roll_rate }
    }
}

impl StateCost {
    /// The cost of a state by itself: of a sample of a flight it is [`Self::of_sample`].
    pub fn of(body: &BodyState, limits: &SafetyLimits) -> Self {
        let (pitch_rad, roll_rad) = pitch_and_bank(body.q_ned_from_body);
        let (speed_m_s, omega_body) = (body.v_ned.norm(), body.omega_body.into());
        shares(speed_m_s, [pitch_rad, roll_rad], omega_body, false, limits).into()
    }

    /// The cost of a flight's state, which knows whether the flight has turned over.
    pub fn of_sample(sample: &Sample, limits: &SafetyLimits) -> Self {
        let cost = Self::of(&sample.state.body, limits);
        if sample.turned_over { cost.turned_over(limits) } else { cost }
    }

    /// The cost of this state in a flight that has turned over.
    pub fn turned_over(self, limits: &SafetyLimits) -> Self {
        Self { pitch: if self.pitch.is_nan() { self.pitch } else { PI / limits.pitch_rad }, ..self }
    }

    /// J_state, (47). A cost that is not a number is infinite.
    pub fn max(&self) -> f64 {
        let all = self.parts().map(|(_, cost)| cost);
        if all.iter().any(|c| c.is_nan()) {
            return f64::INFINITY;
        }
        all.into_iter().fold(0.0, f64::max)
    }

    /// Each part with its name.
    pub fn parts(&self) -> [(&'static str, f64); 5] {
        [
            ("speed", self.speed),
            ("pitch", self.pitch),
            ("pitch_rate", self.pitch_rate),
            ("roll", self.roll),
            ("roll_rate", self.roll_rate),
        ]
    }

    /// Name of the largest part, the first of equals; [`NOT_FINITE`] for what is not a number.
    pub fn decided_by(&self) -> &'static str {
        let worst =
            self.parts().into_iter().reduce(|worst, part| if part.1 > worst.1 { part } else { worst });
        if self.max().is_finite() { worst.map_or("", |(name, _)| name) } else { NOT_FINITE }
    }
}
