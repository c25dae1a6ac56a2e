//! What a flight is judged by: the limits of a mission.

use crate::math::with_digits;
use crate::sim::limits::SafetyLimits;
use crate::units::DEG_PER_RAD;

/// J_state that a safe flight stays below, as the paper asks of it (V).
pub const SAFE_BELOW: f64 = 1.0;

/// Everything that a flight is judged by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Safety limits, Table 1: where J_state is 1.
    pub safety: SafetyLimits,
    /// J_TPF that a safe flight stays below.
    pub j_tpf_below: f64,
    /// How close to the target velocity is steady [m/s].
    pub steady_within_m_s: f64,
    /// Time over which the mean of the velocity is to be so close [s]; `None`: the velocity at each instant.
    pub steady_mean_over_s: Option<f64>,
    /// Whether a flight that is not steady at its end is not safe.
    pub must_be_steady: bool,
    /// Way down from the release to the plan's end [m].
    pub altitude_lost_m: Option<f64>,
    /// Angle between the body's up axis and the vertical [rad].
    pub tilt_rad: Option<f64>,
    /// Time after t = 0 by which the flight is steady [s].
    pub steady_after_s: Option<f64>,
    /// Fastest that a vehicle may come to the ground, and its largest tilt there.
    pub touch: TouchLimits,
    /// Least distance from the canopy to the vehicle's centre of mass after the release [m].
    pub separation_m: Option<f64>,
}

/// How close to the target velocity is steady [m/s], and the time over which its mean counts [s], if one
/// does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyWithin {
    /// How close to the target velocity is steady [m/s].
    pub m_s: f64,
    /// Time over which the mean of the velocity is to be so close [s]; `None`: the velocity at each instant.
    pub mean_over_s: Option<f64>,
}

impl SteadyWithin {
    /// It in words, of a target in words: "0.3 m/s of the target in the mean over 2 s".
    pub fn of(&self, target: &str) -> String {
        let within = format!("{} m/s of {target}", with_digits(self.m_s, 3));
        self.mean_over_s.map_or(within.clone(), |over_s| {
            format!("{within} in the mean over {} s", with_digits(over_s, 3))
        })
    }
}

/// Limits of a touch of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchLimits {
    /// Whole speed over ground at the touch [m/s].
    pub speed_m_s: f64,
    /// Angle between the body's up axis and the vertical at the touch [rad].
    pub tilt_rad: f64,
}

impl TouchLimits {
    /// Limits of a touch where a mission gives none: three times PX4's landing speed; 15 deg, from which feet
    /// of a quarter of the height of the centre of mass apart still come to stand.
    pub const USUAL: Self = Self { speed_m_s: 2.1, tilt_rad: 15.0 / DEG_PER_RAD };
}

impl Limits {
    /// J_state alone is judged, by these limits; steady is what is so close [m/s] to the target velocity.
    pub fn of_j_state(safety: SafetyLimits, steady_within_m_s: f64) -> Self {
        Self {
            safety,
            j_tpf_below: SAFE_BELOW,
            steady_within_m_s,
            steady_mean_over_s: None,
            must_be_steady: false,
            altitude_lost_m: None,
            tilt_rad: None,
            steady_after_s: None,
            touch: TouchLimits { speed_m_s: f64::INFINITY, tilt_rad: f64::INFINITY },
            separation_m: None,
        }
    }

    /// What is steady.
    pub fn steady_within(&self) -> SteadyWithin {
        SteadyWithin { m_s: self.steady_within_m_s, mean_over_s: self.steady_mean_over_s }
    }

    /// What is judged in a way of its own: the bound on J_TPF, and whether a flight must be steady. All else
    /// is judged by its row in [`QUANTITIES`](super::outcome::QUANTITIES): a new limit has one.
    pub(super) fn judged_apart(&self) -> (f64, bool) {
        let Self {
            safety: _,
            j_tpf_below,
            steady_within_m_s: _,
            steady_mean_over_s: _,
            must_be_steady,
            altitude_lost_m: _,
            tilt_rad: _,
            steady_after_s: _,
            touch: _,
            separation_m: _,
        } = *self;
        (j_tpf_below, must_be_steady)
    }
}
