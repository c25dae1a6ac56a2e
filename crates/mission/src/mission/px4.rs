//! A PX4 that flies the mission: how it is connected, and its parameter file.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::error::ConfigError;
use crate::source::Source;

/// Connection of a PX4, which takes 9.80665 m/s^2 for gravity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Px4Clock {
    /// In the site's units and time; where gravity differs from Earth's, PX4's estimator does not start.
    Real,
    /// By Froude's similarity: time, velocities, accelerations and rates are scaled on the wire to 9.80665
    /// m/s^2.
    Froude,
}

/// How a PX4 flies the mission.
#[derive(Clone, Debug)]
pub struct Px4 {
    /// How it is connected.
    pub clock: Px4Clock,
    /// The parameter file that PX4 flies the mission with, unless another or gains are chosen. Not read yet.
    pub params: Option<PathBuf>,
}

/// Gravity that can be scaled to the standard's [m/s^2]: steps of the simulation from 1 to 40 ms.
const FROUDE_GRAVITY_M_S2: std::ops::RangeInclusive<f64> = 0.1..=100.0;

impl Px4 {
    pub(super) fn from_json(
        source: &Source,
        clock: Option<Px4Clock>,
        params: Option<&str>,
        gravity_m_s2: f64,
    ) -> Result<Self, ConfigError> {
        let clock = clock.unwrap_or(Px4Clock::Real);
        if clock == Px4Clock::Froude && !FROUDE_GRAVITY_M_S2.contains(&gravity_m_s2) {
            let message = format!(
                "expected \"real\" where site.gravity_m_s2 is {gravity_m_s2}: below 0.1 the steps get too long"
            );
            return Err(source.refuse("px4_clock", message));
        }
        Ok(Self { clock, params: params.map(|path| source.resolve(path)) })
    }
}
