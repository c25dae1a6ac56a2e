//! From when on a flight is steady: its velocity stays at the target, or the mean of it over a time does.
//!
//! In still air each instant counts. In turbulence no vehicle keeps a velocity at each instant, and a loop
//! that tried to would shake: there a mission may ask for the mean,
//!
//! ```text
//! |1/T integral of v - v_target over [t, t + T]| <= within   for all t from the steady time to the end - T
//! ```
//!
//! and the root of the mean square about that mean, from the steady time to the end, is shown beside it.

use std::collections::VecDeque;

use nalgebra::Vector3;

use super::limits::Limits;

/// Windows that begin in the time of one.
const BEGUN_IN_ONE: f64 = 40.0;
/// Times are the same within this [s].
const SAME_S: f64 = 1e-9;

/// Whether the mean of a flight's velocity over each window of a length comes to stay at the target.
#[derive(Clone, Debug)]
pub(super) struct MeanVelocity {
    target_v_ned: Vector3<f64>,
    within_m_s: f64,
    over_s: f64,
    /// Integrals to the last sample, and the velocity off the target there [m/s].
    last: Option<(Integrals, Vector3<f64>)>,
    /// Integrals at times of the last window, the first a whole window old once there is one.
    past: VecDeque<Integrals>,
    /// Integrals where the first window began of those that are all at the target.
    steady_from: Option<Integrals>,
}

/// Integrals over a flight up to a time.
#[derive(Clone, Copy, Debug)]
struct Integrals {
    t_s: f64,
    /// Of the velocity off the target [m].
    off_m: Vector3<f64>,
    /// Of the square of its size [m^2/s].
    off2_m2_s: f64,
}

impl Integrals {
    /// Those of the trapezoid rule up to the next sample.
    fn then(&self, before: &Vector3<f64>, t_s: f64, now: &Vector3<f64>) -> Self {
        let half_s = 0.5 * (t_s - self.t_s);
        Self {
            t_s,
            off_m: self.off_m + half_s * (before + now),
            off2_m2_s: self.off2_m2_s + half_s * (before.norm_squared() + now.norm_squared()),
        }
    }

    /// The mean velocity off the target since an earlier time [m/s].
    fn mean_since(&self, earlier: &Self) -> Vector3<f64> {
        (self.off_m - earlier.off_m) / (self.t_s - earlier.t_s)
    }
}

impl MeanVelocity {
    /// Nothing yet, of flights to a velocity, NED [m/s]; `None` where the limits ask for each instant.
    pub(super) fn by(limits: &Limits, target_v_ned: &Vector3<f64>) -> Option<Self> {
        Some(Self {
            target_v_ned: *target_v_ned,
            within_m_s: limits.steady_within_m_s,
            over_s: limits.steady_mean_over_s?,
            last: None,
            past: VecDeque::new(),
            steady_from: None,
        })
    }

    /// Takes the next velocity, NED [m/s]; without a time [s] steadiness is not counted, and begins anew.
    pub(super) fn observe(&mut self, t_s: Option<f64>, v_ned: &Vector3<f64>) {
        let Some(t_s) = t_s else {
            self.past.clear();
            (self.last, self.steady_from) = (None, None);
            return;
        };
        let off = v_ned - self.target_v_ned;
        let now = match &self.last {
            Some((integrals, before)) => integrals.then(before, t_s, &off),
            None => Integrals { t_s, off_m: Vector3::zeros(), off2_m2_s: 0.0 },
        };
        self.last = Some((now, off));
        let next_s = |last: &Integrals| last.t_s + self.over_s / BEGUN_IN_ONE - SAME_S;
        if self.past.back().is_some_and(|last| t_s < next_s(last)) {
            return;
        }
        self.past.push_back(now);
        let begins_s = t_s - self.over_s + SAME_S;
        while self.past.get(1).is_some_and(|next| next.t_s <= begins_s) {
            self.past.pop_front();
        }
        let first = self.past[0];
        if first.t_s <= begins_s {
            let is_near = now.mean_since(&first).norm() <= self.within_m_s;
            self.steady_from = is_near.then(|| self.steady_from.unwrap_or(first));
        }
    }

    /// From when on it is steady [s], if it is.
    pub(super) fn steady_after_s(&self) -> Option<f64> {
        self.steady_from.map(|from| from.t_s)
    }

    /// Root of the mean square of the velocity about its mean from the steady time on [m/s], where there is
    /// one.
    pub(super) fn rms_m_s(&self) -> Option<f64> {
        let (from, (now, _)) = self.steady_from.as_ref().zip(self.last.as_ref())?;
        let mean_square = (now.off2_m2_s - from.off2_m2_s) / (now.t_s - from.t_s);
        Some((mean_square - now.mean_since(from).norm_squared()).max(0.0).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use crate::sim::limits::SafetyLimits;

    fn flown(seconds: f64, over_s: f64, within_m_s: f64, v_down: impl Fn(f64) -> f64) -> MeanVelocity {
        let safety = SafetyLimits {
            speed_m_s: 10.0,
            pitch_rad: 1.0,
            pitch_rate_rad_s: 1.0,
            vertical_acceleration_m_s2: 10.0,
        };
        let limits = Limits { steady_mean_over_s: Some(over_s), ..Limits::of_j_state(safety, within_m_s) };
        let mut mean = MeanVelocity::by(&limits, &Vector3::new(0.0, 0.0, 3.0)).unwrap();
        for k in 0..=(200.0 * seconds) as u32 {
            let t_s = f64::from(k) / 200.0;
            mean.observe(Some(t_s), &Vector3::new(0.0, 0.0, v_down(t_s)));
        }
        mean
    }

    /// By hand: 3 + 10 exp(-t) is off by 5 (exp(-t) - exp(-t - 2)) in the mean over 2 s from t on, 0.1 from
    /// t = ln(50 (1 - exp(-2))) = 3.767 on; a window begins every 0.05 s.
    #[test]
    fn closed_form_a_decay_is_steady_when_its_mean_is() {
        let mean = flown(15.0, 2.0, 0.1, |t_s| 3.0 + 10.0 * math::exp(-t_s));
        let steady_s = mean.steady_after_s().unwrap();
        assert!((3.767..3.767 + 0.051).contains(&steady_s), "{steady_s}");
    }

    /// By hand: a swing of amplitude a with a whole number of periods in the window has no mean, and a root
    /// of the mean square of a/sqrt(2); it is never within a tenth of it at each instant.
    #[test]
    fn closed_form_a_swing_about_the_target_is_steady_with_its_rms() {
        let mean = flown(12.0, 2.0, 0.03, |t_s| 3.0 + 0.3 * math::sin_cos(std::f64::consts::TAU * t_s).0);
        assert_eq!(mean.steady_after_s(), Some(0.0));
        assert!((mean.rms_m_s().unwrap() - 0.3 / 2f64.sqrt()).abs() < 1e-3, "{:?}", mean.rms_m_s());
    }

    /// By hand: what leaves the target at the end is not steady, nor what flies shorter than a window; where
    /// time is not counted it begins anew.
    #[test]
    fn closed_form_what_leaves_the_target_is_not_steady() {
        assert_eq!(flown(12.0, 2.0, 0.1, |t_s| if t_s < 11.0 { 3.0 } else { 3.5 }).steady_after_s(), None);
        assert_eq!(flown(1.9, 2.0, 0.1, |_| 3.0).steady_after_s(), None);
        let mut mean = flown(12.0, 2.0, 0.1, |_| 3.0);
        assert_eq!(mean.steady_after_s(), Some(0.0));
        mean.observe(None, &Vector3::zeros());
        assert_eq!((mean.steady_after_s(), mean.rms_m_s()), (None, None));
    }

    /// A property: a velocity that is no number is not steady, then or later.
    #[test]
    fn prop_no_number_is_never_steady() {
        assert_eq!(
            flown(12.0, 2.0, 0.1, |t_s| if t_s == 5.0 { f64::NAN } else { 3.0 }).steady_after_s(),
            None
        );
    }
}
