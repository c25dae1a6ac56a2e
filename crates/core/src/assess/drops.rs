//! Random drops: what a campaign of whole drops draws for each.
//!
//! A drop has the swing of a [`RandomRelease`](super::RandomRelease), which decides pitch and pitch rate at
//! the release, a wind, and noise of its own on every sensor. Trial k draws from streams of its own, as the
//! releases do: its swing is that of the release of that number.

use nalgebra::Vector3;

use crate::model::parachute::TipOff;
use crate::uncertain::Deviations;

/// Random numbers of a drop: swing, wind, seed of the sensors, what is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomDrop {
    /// Number of the trial.
    pub trial: u64,
    /// Amplitude of the swing theta_0 [rad].
    pub amplitude_rad: f64,
    /// Phase of the swing at the nominal release phi [rad].
    pub phase_rad: f64,
    /// Wind, on top of the site's, NED [m/s].
    pub wind_ned_m_s: Vector3<f64>,
    /// What the cut gives the vehicle, on top of the mission's.
    pub tip_off: TipOff,
    /// Seed of the sensors' noise.
    pub seed: u64,
    /// How far what is known of the vehicle and its air is off.
    pub off: Deviations,
}
