//! Measures of a drop, and their cost beside the same drops under PX4's defaults.

use crate::assess::outcome::{ALTITUDE_LOST, J_TPF, PEAK_TILT, Quantity, STEADY_AFTER};
use crate::assess::{Course, LEAST_DIFFERENCE, Verdict, judge};
use crate::sim::{Phase, Sample};
use crate::units::DEG_PER_RAD;

/// Quantities that parameters are measured by.
pub const MEASURED: [Quantity; 4] = [J_TPF, ALTITUDE_LOST, STEADY_AFTER, PEAK_TILT];

/// The measures of a drop, or the means of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measures {
    /// Each of [`MEASURED`], in its unit; what is never steady counts as steady after the whole flight.
    pub measured: [f64; MEASURED.len()],
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
        measured: [f64::INFINITY; MEASURED.len()],
        velocity_rms_m_s: f64::INFINITY,
        unsafe_share: 1.0,
        steady_share: 0.0,
    };

    /// Scales to measure by where no flight came through.
    pub const SCALES: Self = Self {
        measured: [1.0, 100.0, 10.0, 0.5 * DEG_PER_RAD],
        velocity_rms_m_s: 1.0,
        unsafe_share: 0.0,
        steady_share: 1.0,
    };

    /// Of a verdict and the RMS of the velocity's distance from its setpoint [m/s]; `flight_s` [s] is the
    /// length of the powered flight.
    pub fn of(verdict: &Verdict, velocity_rms_m_s: f64, flight_s: f64) -> Self {
        let outcome = &verdict.outcome;
        if !(outcome.j_tpf.is_finite() && velocity_rms_m_s.is_finite()) {
            return Self::LOST;
        }
        let safe = judge(Some(verdict), &Course::WHOLE).is_empty();
        let steady_s = outcome.steady_after_s.unwrap_or(flight_s);
        Self {
            measured: [outcome.j_tpf, outcome.altitude_lost_m, steady_s, outcome.peak_tilt_deg],
            velocity_rms_m_s,
            unsafe_share: f64::from(!safe),
            steady_share: f64::from(outcome.steady_after_s.is_some()),
        }
    }

    /// The means of some drops; lost where there are none.
    pub fn mean(drops: &[Self]) -> Self {
        let n = drops.len() as f64;
        let mean = |of: &dyn Fn(&Self) -> f64| drops.iter().map(of).sum::<f64>() / n;
        if drops.is_empty() {
            return Self::LOST;
        }
        Self {
            measured: std::array::from_fn(|place| mean(&|m| m.measured[place])),
            velocity_rms_m_s: mean(&|m| m.velocity_rms_m_s),
            unsafe_share: mean(&|m| m.unsafe_share),
            steady_share: mean(&|m| m.steady_share),
        }
    }

    /// J_TPF, or its mean.
    fn j_tpf(&self) -> f64 {
        self.measured[0]
    }

    /// Whether a flight was lost, or one of those that this is the mean of.
    pub fn is_lost(&self) -> bool {
        !self.measured.iter().chain([&self.velocity_rms_m_s]).all(|x| x.is_finite())
    }

    /// Each of [`MEASURED`] and the tracking error, as a multiple of `reference`'s.
    pub fn ratios(&self, reference: &Self) -> [f64; MEASURED.len() + 1] {
        let all = |m: &Self| {
            let [j_tpf, altitude, steady, tilt] = m.measured;
            [j_tpf, altitude, steady, tilt, m.velocity_rms_m_s]
        };
        let (own, of_reference) = (all(self), all(reference));
        std::array::from_fn(|place| own[place] / of_reference[place])
    }

    /// Cost that the search makes small: the mean of the ratios by their weights; 10 for each unit that J_TPF
    /// is above the reference's, and for the share of the drops that are not safe. Infinite for what is lost,
    /// also beside a reference that is.
    pub fn cost(&self, reference: &Self) -> f64 {
        if self.is_lost() {
            return f64::INFINITY;
        }
        let mean = self.ratios(reference).iter().zip(WEIGHTS).map(|(r, w)| r * w).sum::<f64>();
        let above = (self.j_tpf() / reference.j_tpf() - 1.0).max(0.0);
        let cost = mean + HARD * (above + self.unsafe_share);
        if cost.is_nan() { f64::INFINITY } else { cost }
    }

    /// Whether J_TPF is no worse than the reference's, every drop is safe and at least two of the other four
    /// ratios are 0.9 or less.
    pub fn beats(&self, reference: &Self) -> bool {
        let better = self.ratios(reference)[1..].iter().filter(|ratio| **ratio <= WELL_BETTER).count();
        !self.is_lost()
            && self.j_tpf() <= reference.j_tpf() * (1.0 + SAME)
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
        measured: [0.5, 25.0, 8.0, 12.0],
        velocity_rms_m_s: 0.8,
        unsafe_share: 0.0,
        steady_share: 1.0,
    };

    fn with(place: usize, value: f64, mut measures: Measures) -> Measures {
        measures.measured[place] = value;
        measures
    }

    /// Closed form: the defaults cost 1 beside themselves and do not beat themselves; two measures well
    /// better do.
    #[test]
    fn closed_form_what_measures_are_worth() {
        assert!((DEFAULTS.cost(&DEFAULTS) - 1.0).abs() < 1e-12 && !DEFAULTS.beats(&DEFAULTS));
        let better = with(2, 4.0, Measures { velocity_rms_m_s: 0.6, ..DEFAULTS });
        assert!((better.cost(&DEFAULTS) - (0.4 + 0.2 * 0.5 + 0.4 * 0.75)).abs() < 1e-12);
        assert!(better.beats(&DEFAULTS));
        assert!(!with(0, 0.51, better).beats(&DEFAULTS));
        assert!(!Measures { unsafe_share: 0.02, ..better }.beats(&DEFAULTS));
        assert!(with(0, 0.55, better).cost(&DEFAULTS) > 1.5, "J_TPF comes first");
        assert_eq!(Measures::mean(&[DEFAULTS, better]).measured[2], 6.0);
        assert!(!Measures::mean(&[DEFAULTS, Measures::LOST]).j_tpf().is_finite());
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
