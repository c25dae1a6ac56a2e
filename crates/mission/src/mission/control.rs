//! The cascade that flies the mission: gains and limits.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::gains_file::GainsFile;
use crate::number::{Positive, TiltDeg};
use samara_core::control::{ControlLimits, Gains};
use samara_core::units::RAD_PER_DEG;

/// Limits of the cascade.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ControlJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Largest commanded tilt [deg].
    tilt_limit_deg: TiltDeg,
    /// Largest commanded roll and pitch rate [deg/s].
    rate_command_limit_deg_s: Positive<100_000>,
    /// Largest commanded yaw rate [deg/s].
    yaw_rate_command_limit_deg_s: Positive<100_000>,
    /// Bound of the rate loops' integrals [rad/s^2].
    rate_integral_limit_rad_s2: Positive<100_000>,
    /// Whether the plan's acceleration is sent with its velocity, and fed forward; no when left out, as in
    /// the paper.
    feed_forward: Option<bool>,
}

/// Gains and limits of the cascade that flies the mission.
#[derive(Clone, Debug)]
pub struct Control {
    /// Limits of the cascade.
    pub limits: ControlLimits,
    /// Gains of the cascade.
    pub gains: Gains,
    /// Name of the set of gains.
    pub gains_name: String,
    /// Whether the plan's acceleration is fed forward.
    pub feed_forward: bool,
}

impl Control {
    pub(super) fn from_json(json: &ControlJson, gains: GainsFile) -> Self {
        Self {
            limits: ControlLimits {
                tilt_rad: json.tilt_limit_deg.get() * RAD_PER_DEG,
                rate_command_rad_s: json.rate_command_limit_deg_s.get() * RAD_PER_DEG,
                yaw_rate_command_rad_s: json.yaw_rate_command_limit_deg_s.get() * RAD_PER_DEG,
                rate_integral_rad_s2: json.rate_integral_limit_rad_s2.get(),
            },
            gains: gains.gains,
            gains_name: gains.name,
            feed_forward: json.feed_forward.unwrap_or(false),
        }
    }
}
