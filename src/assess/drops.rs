//! Random drops: what a campaign of whole drops draws for each, and what it measures of each.
//!
//! A drop has the swing of a [`RandomRelease`](super::RandomRelease), which decides pitch and pitch rate at
//! the release, a wind, and noise of its own on every sensor. Trial k draws from stream k, as the releases
//! do: its swing is that of the release of that number.

use nalgebra::Vector3;

use super::Verdict;
use crate::frames::pitch;
use crate::model::parachute::TipOff;
use crate::sim::{Phase, Sample};
use crate::trajectory::Trajectory;

/// Random numbers of a drop: swing, wind, seed of the sensors.
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
}

/// Measures of a drop.
#[derive(Clone, Debug, PartialEq)]
pub struct DropOutcome {
    /// The verdict from the release to the end.
    pub verdict: Verdict,
    /// Pitch at the release [rad].
    pub release_pitch_rad: f64,
    /// Pitch rate at the release [rad/s].
    pub release_pitch_rate_rad_s: f64,
    /// Root of the mean square of `|v - v_plan|` over the plan [m/s].
    pub tracking_rms_m_s: f64,
}

impl DropOutcome {
    /// Measures of a flight log along a plan that came to this verdict; `None` when the vehicle was never
    /// released.
    pub fn of(verdict: Verdict, plan: &Trajectory, log: &[Sample]) -> Option<Self> {
        let end_s = plan.end_s();
        let loose = || log.iter().filter(|sample| sample.phase != Phase::Hanging);
        let release = loose().next()?.state.body;
        let planned = || loose().filter_map(|s| Some((s.t_powered_s.filter(|t| *t <= end_s)?, s.state.body)));
        let (mut sum, mut count) = (0.0, 0u32);
        for (t_s, body) in planned() {
            if t_s >= 0.0 {
                sum += (body.v_ned - plan.velocity_ned(t_s)).norm_squared();
                count += 1;
            }
        }
        Some(Self {
            verdict,
            release_pitch_rad: pitch(release.q_ned_from_body),
            release_pitch_rate_rad_s: release.omega_body.y,
            tracking_rms_m_s: (sum / f64::from(count)).sqrt(),
        })
    }
}
