//! The limits that a flight is judged by.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::number::{MeanOverS, Positive};
use samara_core::assess::SAFE_BELOW;
use samara_core::assess::{Limits, SafetyLimits, TouchLimits, steady_within_m_s};
use samara_core::units::RAD_PER_DEG;

/// Safety limits, Table 1: where J_state is 1.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LimitsJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Speed [m/s].
    speed_m_s: Positive<1000>,
    /// Pitch, either way [deg].
    pitch_deg: Positive<180>,
    /// Pitch rate, either way [deg/s].
    pitch_rate_deg_s: Positive<100_000>,
    /// Vertical acceleration [m/s^2]; reported, not judged.
    vertical_acceleration_m_s2: Positive<100_000>,
    /// How close to the target velocity is steady [m/s]; when left out, 1 % of the target and at least 0.02
    /// m/s.
    steady_within_m_s: Option<Positive<100>>,
    /// Time over which the mean of the velocity is to be so close, from the steady time to the end, for
    /// missions in turbulence; the root of the mean square about it is shown [s]; left out, the velocity at
    /// each instant is to be.
    steady_mean_over_s: Option<MeanOverS>,
    /// Whole speed over ground at a touch of the ground [m/s]; 2.1 when left out.
    impact_speed_m_s: Option<Positive<1000>>,
    /// Angle between the body's up axis and the vertical at a touch of the ground [deg]; 15 when left out.
    impact_tilt_deg: Option<Positive<180>>,
    /// Way down from the release to the plan's end [m]; left out, it is reported and not judged.
    altitude_lost_m: Option<Positive<100_000>>,
    /// Angle between the body's up axis and the vertical, from the release on [deg]; left out, it is reported
    /// and not judged.
    tilt_deg: Option<Positive<180>>,
    /// Time after t = 0 by which the flight is steady [s]; left out, it must be steady at the mission's end.
    steady_after_s: Option<Positive<900>>,
    /// Least distance from the canopy (parachute.canopy) to the centre of mass after the release: less is a
    /// contact [m]; left out, the distance is reported and not judged. Flights from t = 0 have no canopy.
    separation_m: Option<Positive<1000>>,
}

impl LimitsJson {
    pub(super) fn limits(&self, target_v_ned: &Vector3<f64>) -> Limits {
        Limits {
            safety: SafetyLimits {
                speed_m_s: self.speed_m_s.get(),
                pitch_rad: self.pitch_deg.get() * RAD_PER_DEG,
                pitch_rate_rad_s: self.pitch_rate_deg_s.get() * RAD_PER_DEG,
                vertical_acceleration_m_s2: self.vertical_acceleration_m_s2.get(),
            },
            j_tpf_below: SAFE_BELOW,
            steady_within_m_s: self
                .steady_within_m_s
                .map_or_else(|| steady_within_m_s(target_v_ned), Positive::get),
            steady_mean_over_s: self.steady_mean_over_s.map(MeanOverS::get),
            must_be_steady: true,
            altitude_lost_m: self.altitude_lost_m.map(Positive::get),
            tilt_rad: self.tilt_deg.map(|limit| limit.get() * RAD_PER_DEG),
            steady_after_s: self.steady_after_s.map(Positive::get),
            touch: TouchLimits {
                speed_m_s: self.impact_speed_m_s.map_or(TouchLimits::USUAL.speed_m_s, Positive::get),
                tilt_rad: self
                    .impact_tilt_deg
                    .map_or(TouchLimits::USUAL.tilt_rad, |limit| limit.get() * RAD_PER_DEG),
            },
            separation_m: self.separation_m.map(Positive::get),
        }
    }
}
