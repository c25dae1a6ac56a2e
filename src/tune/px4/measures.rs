//! Measures of a drop, and their cost beside the same drops under PX4's defaults.

use crate::assess::{Course, LEAST_DIFFERENCE, Verdict, judge};
use crate::sim::{Phase, Sample};

/// The measures of a drop, or the means of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measures {
    /// J_TPF, (51).
    pub j_tpf: f64,
    /// Way down from the release to the plan's end [m].
    pub altitude_lost_m: f64,
    /// Time from the start of powered flight from which the velocity stays near the target's [s]; the whole
    /// flight where it does not.
    pub steady_s: f64,
    /// Largest tilt, either way, from the release on [rad].
    pub peak_tilt_rad: f64,
    /// RMS of the velocity's distance from its setpoint over the plan [m/s].
    pub velocity_rms_m_s: f64,
    /// Share of the drops that were not safe.
    pub unsafe_share: f64,
    /// Share of the drops that were steady at their end.
    pub steady_share: f64,
}

impl Measures {
    /// A flight that was lost.
    pub const LOST: Self = Self {
        j_tpf: f64::INFINITY,
        altitude_lost_m: f64::INFINITY,
        steady_s: f64::INFINITY,
        peak_tilt_rad: f64::INFINITY,
        velocity_rms_m_s: f64::INFINITY,
        unsafe_share: 1.0,
        steady_share: 0.0,
    };

    /// Scales to measure by where no flight came through.
    pub const SCALES: Self = Self {
        j_tpf: 1.0,
        altitude_lost_m: 100.0,
        steady_s: 10.0,
        peak_tilt_rad: 0.5,
        velocity_rms_m_s: 1.0,
        unsafe_share: 0.0,
        steady_share: 1.0,
    };

    /// Of a verdict and the RMS of the velocity's distance from its setpoint [m/s]; `flight_s` [s] is the
    /// length of the powered flight.
    pub fn of(verdict: &Verdict, velocity_rms_m_s: f64, flight_s: f64) -> Self {
        if !(verdict.j_tpf.is_finite() && velocity_rms_m_s.is_finite()) {
            return Self::LOST;
        }
        let safe = judge(Some(verdict), &Course::WHOLE).is_empty();
        Self {
            j_tpf: verdict.j_tpf,
            altitude_lost_m: verdict.altitude_lost_m,
            steady_s: verdict.steady_after_s.unwrap_or(flight_s),
            peak_tilt_rad: verdict.peak_tilt_rad,
            velocity_rms_m_s,
            unsafe_share: f64::from(!safe),
            steady_share: f64::from(verdict.steady_after_s.is_some()),
        }
    }

    /// The means of some drops; lost where there are none.
    pub fn mean(drops: &[Self]) -> Self {
        let n = drops.len() as f64;
        let mean = |of: fn(&Self) -> f64| drops.iter().map(of).sum::<f64>() / n;
        if drops.is_empty() {
            return Self::LOST;
        }
        Self {
            j_tpf: mean(|m| m.j_tpf),
            altitude_lost_m: mean(|m| m.altitude_lost_m),
            steady_s: mean(|m| m.steady_s),
            peak_tilt_rad: mean(|m| m.peak_tilt_rad),
            velocity_rms_m_s: mean(|m| m.velocity_rms_m_s),
            unsafe_share: mean(|m| m.unsafe_share),
            steady_share: mean(|m| m.steady_share),
        }
    }

    /// Whether a flight was lost, or one of those that this is the mean of.
    pub fn is_lost(&self) -> bool {
        ![self.j_tpf, self.altitude_lost_m, self.steady_s, self.peak_tilt_rad, self.velocity_rms_m_s]
            .iter()
            .all(|x| x.is_finite())
    }

    /// J_TPF, altitude lost, time to steady flight, peak tilt and tracking error, each as a multiple of
    /// `reference`'s.
    pub fn ratios(&self, reference: &Self) -> [f64; 5] {
        [
            self.j_tpf / reference.j_tpf,
            self.altitude_lost_m / reference.altitude_lost_m,
            self.steady_s / reference.steady_s,
            self.peak_tilt_rad / reference.peak_tilt_rad,
            self.velocity_rms_m_s / reference.velocity_rms_m_s,
        ]
    }

    /// Cost that the search makes small: the mean of the ratios by their weights; 10 for each unit that J_TPF
    /// is above the reference's, and for the share of the drops that are not safe. Infinite for what is lost,
    /// also beside a reference that is.
    pub fn cost(&self, reference: &Self) -> f64 {
        if self.is_lost() {
            return f64::INFINITY;
        }
        let mean = self.ratios(reference).iter().zip(WEIGHTS).map(|(r, w)| r * w).sum::<f64>();
        let above = (self.j_tpf / reference.j_tpf - 1.0).max(0.0);
        let cost = mean + HARD * (above + self.unsafe_share);
        if cost.is_nan() { f64::INFINITY } else { cost }
    }

    /// Whether J_TPF is no worse than the reference's, every drop is safe and at least two of the other four
    /// ratios are 0.9 or less.
    pub fn beats(&self, reference: &Self) -> bool {
        let better = self.ratios(reference)[1..].iter().filter(|ratio| **ratio <= WELL_BETTER).count();
        !self.is_lost()
            && self.j_tpf <= reference.j_tpf * (1.0 + SAME)
            && self.unsafe_share == 0.0
            && better >= 2
    }
}

/// How far the velocity of a flight is from its setpoints, sample by sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tracking {
    plan_end_s: f64,
    sum_of_squares: f64,
    samples: u32,
}

impl Tracking {
    /// Along a plan of some length [s].
    pub(super) fn new(plan_end_s: f64) -> Self {
        Self { plan_end_s, sum_of_squares: 0.0, samples: 0 }
    }

    /// Takes a sample; what happens before the plan begins or after its end does not count.
    pub(super) fn observe(&mut self, sample: &Sample) {
        let Some(t) = sample.t_powered_s.filter(|_| sample.phase != Phase::Hanging) else { return };
        if let Some(v_sp) = sample.v_sp_ned.filter(|_| t <= self.plan_end_s) {
            self.sum_of_squares += (sample.state.body.v_ned - v_sp).norm_squared();
            self.samples += 1;
        }
    }

    /// RMS of the velocity's distance from its setpoint [m/s].
    pub(super) fn rms_m_s(&self) -> f64 {
        (self.sum_of_squares / f64::from(self.samples.max(1))).sqrt()
    }
}

/// Weights of the ratios. Altitude and tilt are mostly the release's and the plan's own; on Earth so is
/// J_TPF.
const WEIGHTS: [f64; 5] = [0.2, 0.1, 0.2, 0.1, 0.4];

/// Cost of what is not to be.
const HARD: f64 = 10.0;
/// A ratio that counts as better.
const WELL_BETTER: f64 = 0.9;
/// J_TPF is no worse within this: where the release sets it, two controllers differ by rounding.
const SAME: f64 = LEAST_DIFFERENCE;

#[cfg(test)]
mod tests {
    use super::*;

    const DEFAULTS: Measures = Measures {
        j_tpf: 0.5,
        altitude_lost_m: 25.0,
        steady_s: 8.0,
        peak_tilt_rad: 0.2,
        velocity_rms_m_s: 0.8,
        unsafe_share: 0.0,
        steady_share: 1.0,
    };

    /// Closed form: the defaults cost 1 beside themselves and do not beat themselves; two measures well
    /// better do.
    #[test]
    fn closed_form_what_measures_are_worth() {
        assert!((DEFAULTS.cost(&DEFAULTS) - 1.0).abs() < 1e-12 && !DEFAULTS.beats(&DEFAULTS));
        let better = Measures { steady_s: 4.0, velocity_rms_m_s: 0.6, ..DEFAULTS };
        assert!((better.cost(&DEFAULTS) - (0.4 + 0.2 * 0.5 + 0.4 * 0.75)).abs() < 1e-12);
        assert!(better.beats(&DEFAULTS));
        assert!(!Measures { j_tpf: 0.51, ..better }.beats(&DEFAULTS));
        assert!(!Measures { unsafe_share: 0.02, ..better }.beats(&DEFAULTS));
        assert!(Measures { j_tpf: 0.55, ..better }.cost(&DEFAULTS) > 1.5, "J_TPF comes first");
        assert_eq!(Measures::mean(&[DEFAULTS, better]).steady_s, 6.0);
        assert!(!Measures::mean(&[DEFAULTS, Measures::LOST]).j_tpf.is_finite());
    }

    /// A flight that was lost costs infinitely much and beats nothing, also beside another one.
    #[test]
    fn regress_what_is_lost_is_never_a_number_less_than_another() {
        for reference in [DEFAULTS, Measures::LOST] {
            assert_eq!(Measures::LOST.cost(&reference), f64::INFINITY);
            assert!(!Measures::LOST.beats(&reference));
        }
        assert!(DEFAULTS.beats(&Measures::LOST));
    }
}
