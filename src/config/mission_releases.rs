//! A mission's random releases, (40)-(44), and the drops of a campaign that come of them.

use super::Mission;
use crate::assess::{RandomDrop, ReleaseDistribution};
use crate::model::parachute::Pendulum;

/// Random releases, (40)-(44): the swing's amplitude is normal about 0, its phase uniform over the turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonteCarlo {
    /// Releases in a campaign.
    pub trials: usize,
    /// Standard deviation of the amplitude theta_0 [rad].
    pub amplitude_sigma_rad: f64,
    /// Frequency of the swing [rad/s].
    pub omega_rad_s: f64,
    /// Length r of the pendulum [m].
    pub length_m: f64,
    /// Standard deviation of the wind in north and in east, in campaigns of whole drops [m/s].
    pub wind_sigma_m_s: f64,
}

impl Mission {
    /// The random releases, (40)-(44).
    pub fn releases(&self) -> ReleaseDistribution {
        let mc = &self.study.monte_carlo;
        let mut parachute = self.release.parachute;
        parachute.pendulum = Pendulum {
            amplitude_rad: 0.0,
            phase_rad: 0.0,
            omega_rad_s: mc.omega_rad_s,
            length_m: mc.length_m,
        };
        ReleaseDistribution {
            parachute,
            gravity_m_s2: self.site.environment.gravity_m_s2,
            drift_ned_m_s: self.site.environment.drift_ned_m_s(),
            amplitude_sigma_rad: mc.amplitude_sigma_rad,
        }
    }

    /// The drop of a trial of a campaign.
    pub fn draw_drop(&self, trial: u64) -> RandomDrop {
        self.releases().draw_drop(self.seed, trial, self.study.monte_carlo.wind_sigma_m_s)
    }

    /// The mission with what was drawn for a drop: swing, wind and noise. It keeps its name and the hash of its inputs; the plan's
    /// start is not what was drawn, since nobody knows that beforehand.
    pub fn with_drop(&self, drop: &RandomDrop) -> Self {
        let mut mission = self.clone();
        mission.release.parachute.pendulum = Pendulum {
            amplitude_rad: drop.amplitude_rad,
            phase_rad: drop.phase_rad,
            omega_rad_s: self.study.monte_carlo.omega_rad_s,
            length_m: self.study.monte_carlo.length_m,
        };
        mission.site.environment.wind_ned_m_s += drop.wind_ned_m_s;
        mission.seed = drop.seed;
        mission
    }
}
