//! What of a flight is seen at each of its samples, over any [`Real`]: peaks, and sums along a plan.
//!
//! [`super::safety`] makes its verdict of it, of one flight or of flights side by side.

use nalgebra::Vector3;

use super::limits::Limits;
use super::steady::MeanVelocity;
use crate::frames::{pitch_and_bank, tilt};
use crate::model::rigid_body::Motion;
use crate::real::Real;
use crate::sim::limits::{SafetyLimits, StateCost, shares};
use crate::vector::V3;

/// What has been seen of a flight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Watched<S: Real> {
    /// The parts of J_state, each at its peak: speed, pitch, pitch rate, roll, roll rate.
    pub(super) cost: [S; 5],
    /// Whether one of them was infinite, or no number.
    pub(super) infinite: S::Mask,
    /// Greatest speed [m/s].
    pub(super) speed_m_s: S,
    /// Pitch [rad], pitch rate [rad/s], roll [rad], roll rate [rad/s] of the largest size, either way.
    pub(super) peaks: [S; 4],
    /// Largest angle between the body's up axis and the vertical [rad].
    pub(super) tilt_rad: S,
    /// Vertical acceleration of the largest size, either way [m/s^2].
    pub(super) a_down_m_s2: S,
    /// Least distance of the canopy [m]; infinite: none was seen.
    pub(super) canopy_m: S,
    /// Time since when it has been steady [s]; infinite: it is not.
    pub(super) steady_from_s: S,
    /// Sum of the squares of the velocity's distance from the plan's [m^2/s^2].
    pub(super) distance2: S,
}

/// What is seen at an instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight<'a, S: Real> {
    pub(super) motion: &'a Motion<S>,
    /// Where the flight has turned over.
    pub(super) turned_over: S::Mask,
    /// Where the flight is over, because the vehicle has come to the ground.
    pub(super) over: S::Mask,
    /// Acceleration, down [m/s^2].
    pub(super) a_down_m_s2: S,
    /// Distance of the canopy [m], where there is one.
    pub(super) canopy_m: Option<S>,
    /// Time by which steadiness is counted [s]; `None`: it is not steady.
    pub(super) steady_at_s: Option<f64>,
    /// The plan's velocity, NED [m/s], while there is one.
    pub(super) plan_v_ned: Option<V3<S>>,
}

impl Watched<f64> {
    /// J_TPF, (51), of what has been seen.
    pub(super) fn j_tpf(&self) -> f64 {
        if self.infinite { f64::INFINITY } else { StateCost::from(self.cost).max() }
    }
}

/// What has been seen of one flight.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    pub(super) watched: Watched<f64>,
    /// The mean of its velocity, where steady flight is told by that.
    pub(super) mean: Option<MeanVelocity>,
}

impl Seen {
    /// Nothing yet, of a flight by these limits to a velocity, NED [m/s].
    pub(super) fn nothing(limits: &Limits, v_cmd_ned: &Vector3<f64>) -> Self {
        Self { watched: Watched::nothing(0.0), mean: MeanVelocity::by(limits, v_cmd_ned) }
    }

    /// Sees the next instant, by the limits that it began with.
    pub(super) fn see(&mut self, now: &Sight<'_, f64>, limits: &Limits, v_cmd_ned: &Vector3<f64>) {
        self.watched.see(now, &limits.safety, (*v_cmd_ned).into(), limits.steady_within_m_s);
        if let Some(mean) = &mut self.mean
            && !now.over
        {
            mean.observe(now.steady_at_s, &now.motion.v_ned.into());
        }
    }

    /// When it became steady [s], if it is.
    pub(super) fn steady_after_s(&self) -> Option<f64> {
        let from_s = self.watched.steady_from_s;
        self.mean.as_ref().map_or(from_s.is_finite().then_some(from_s), MeanVelocity::steady_after_s)
    }

    /// Root of the mean square of the velocity about its mean since then [m/s], where steady flight is told
    /// by the mean.
    pub(super) fn steady_rms_m_s(&self) -> Option<f64> {
        self.mean.as_ref()?.rms_m_s()
    }
}

impl<S: Real> Watched<S> {
    /// Nothing yet, for numbers of a kind of which one is given.
    #[inline(always)]
    pub(super) fn nothing(kind: S) -> Self {
        let (zero, infinite) = (kind.of(0.0), kind.of(f64::INFINITY));
        Self {
            cost: [zero; 5],
            infinite: zero.less(zero),
            speed_m_s: zero,
            peaks: [zero; 4],
            tilt_rad: zero,
            a_down_m_s2: zero,
            canopy_m: infinite,
            steady_from_s: infinite,
            distance2: zero,
        }
    }

    /// Sees the next instant; steady means within `within_m_s` of the velocity `v_cmd_ned`, NED [m/s].
    #[inline(always)]
    pub(super) fn see(
        &mut self,
        now: &Sight<'_, S>,
        limits: &SafetyLimits,
        v_cmd_ned: V3<S>,
        within_m_s: f64,
    ) {
        let Motion { q_ned_from_body, v_ned, omega_body } = *now.motion;
        let infinite = v_ned.x.of(f64::INFINITY);
        let (pitch_rad, roll_rad) = pitch_and_bank(q_ned_from_body);
        let speed_m_s = v_ned.norm();
        self.speed_m_s = S::select(now.over, self.speed_m_s, speed_m_s.at_least(self.speed_m_s));
        let cost = shares(speed_m_s, [pitch_rad, roll_rad], omega_body, now.turned_over, limits);
        for (peak, share) in self.cost.iter_mut().zip(cost) {
            self.infinite = self.infinite | !share.less(infinite);
            *peak = S::select(now.over, *peak, share.at_least(*peak));
        }
        for (peak, value) in self.peaks.iter_mut().zip([pitch_rad, omega_body.y, roll_rad, omega_body.x]) {
            *peak = S::select(now.over, *peak, larger(*peak, value));
        }
        self.tilt_rad = S::select(now.over, self.tilt_rad, tilt(q_ned_from_body).at_least(self.tilt_rad));
        let a_down = larger(self.a_down_m_s2, now.a_down_m_s2);
        self.a_down_m_s2 = S::select(now.over, self.a_down_m_s2, a_down);
        if let Some(canopy_m) = now.canopy_m {
            self.canopy_m = canopy_m.at_most(self.canopy_m);
        }
        // What was steady when it came to the ground stays so.
        let steady_from_s = match now.steady_at_s {
            Some(t_s) => {
                let off = (v_ned - v_cmd_ned).norm();
                let near = !infinite.of(within_m_s).less(off) & off.less(infinite);
                S::select(near, self.steady_from_s.at_most(infinite.of(t_s)), infinite)
            }
            None => infinite,
        };
        self.steady_from_s = S::select(now.over, self.steady_from_s, steady_from_s);
        if let Some(plan_v_ned) = now.plan_v_ned {
            let off = v_ned - plan_v_ned;
            self.distance2 += off.dot(off);
        }
    }
}

/// The number of the larger size, the first of equals.
#[inline(always)]
fn larger<S: Real>(peak: S, now: S) -> S {
    S::select(peak.abs().less(now.abs()), now, peak)
}
