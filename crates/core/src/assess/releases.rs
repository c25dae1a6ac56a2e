//! Random releases, (40)-(44): the space of initial conditions that a campaign samples.
//!
//! The swing's amplitude is normal about 0, its phase uniform over the turn; pitch, pitch rate and velocity
//! at t = 0 follow from them, the rotors are at rest. Trial k draws from streams of its own: it is the same
//! whichever trials are flown beside it, in whatever order.

use std::sync::Arc;

use nalgebra::Vector3;

use super::RandomDrop;
use crate::model::Parachute;
use crate::model::parachute::TipOff;
use crate::model::rigid_body::BodyState;
use crate::random::{Purpose, Stream};
use crate::uncertain::{Deviations, Uncertainty};

/// Distribution of releases.
#[derive(Clone, Debug, PartialEq)]
pub struct ReleaseDistribution {
    /// Descent, delay, and the pendulum's frequency and length; its amplitude and phase are replaced.
    pub parachute: Parachute,
    /// Gravity [m/s^2], for the speed gained in the delay, (44).
    pub gravity_m_s2: f64,
    /// Velocity over ground of what hangs in the wind, NED [m/s]; the paper's air is still.
    pub drift_ned_m_s: Vector3<f64>,
    /// Standard deviation of the amplitude theta_0 [rad].
    pub amplitude_sigma_rad: f64,
    /// Standard deviations of what the cut gives the vehicle, in addition to the parachute's tip-off.
    pub tip_off_sigma: TipOff,
    /// How far what is known of the vehicle and its air may be off; `None`: not at all.
    pub uncertain: Option<Arc<Uncertainty>>,
}

/// A drawn release.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomRelease {
    /// Number of the trial.
    pub trial: u64,
    /// Amplitude theta_0 [rad].
    pub amplitude_rad: f64,
    /// Phase phi [rad].
    pub phase_rad: f64,
    /// State at t = 0.
    pub state: BodyState,
    /// How far what is known of the vehicle and its air is off.
    pub off: Deviations,
}

impl ReleaseDistribution {
    /// The release of a trial.
    pub fn draw(&self, seed: u64, trial: u64) -> RandomRelease {
        let (amplitude_rad, phase_rad) = self.swing(&mut Stream::new(seed, Purpose::Release, trial));
        let off = self.deviations(seed, trial);
        let state = self.delayed(self.tip_off(seed, trial).after(self.state(amplitude_rad, phase_rad)), &off);
        RandomRelease { trial, amplitude_rad, phase_rad, state, off }
    }

    /// The drop of a trial: its release's swing and tip-off, then a wind whose parts in north and in east
    /// have the standard deviation `wind_sigma_m_s`, then the seed of the sensors' noise.
    pub fn draw_drop(&self, seed: u64, trial: u64, wind_sigma_m_s: f64) -> RandomDrop {
        let mut stream = Stream::new(seed, Purpose::Release, trial);
        let (amplitude_rad, phase_rad) = self.swing(&mut stream);
        let [north, east] = std::array::from_fn(|_| wind_sigma_m_s * stream.normal());
        let wind_ned_m_s = Vector3::new(north, east, 0.0);
        let (tip_off, off) = (self.tip_off(seed, trial), self.deviations(seed, trial));
        RandomDrop { trial, amplitude_rad, phase_rad, wind_ned_m_s, tip_off, seed: stream.bits(), off }
    }

    /// These releases with another idea of what is uncertain.
    pub fn with_uncertain(&self, uncertain: Option<Arc<Uncertainty>>) -> Self {
        Self { uncertain, ..self.clone() }
    }

    /// The state at t = 0 of a release whose delay is off: it has fallen for so much longer.
    pub fn delayed(&self, mut state: BodyState, off: &Deviations) -> BodyState {
        state.v_ned.z += self.gravity_m_s2 * off.release_delay_s().max(-self.parachute.delay_s);
        state
    }

    /// How far what is known is off in a trial, from a stream of its own.
    fn deviations(&self, seed: u64, trial: u64) -> Deviations {
        let drawn =
            |uncertain: &Arc<Uncertainty>| uncertain.draw(&mut Stream::new(seed, Purpose::Unknowns, trial));
        self.uncertain.as_ref().map_or_else(Deviations::default, drawn)
    }

    /// What the cut gives the vehicle of a trial, from a stream of its own.
    fn tip_off(&self, seed: u64, trial: u64) -> TipOff {
        if self.tip_off_sigma.is_none() {
            return TipOff::default();
        }
        let mut stream = Stream::new(seed, Purpose::TipOff, trial);
        let mut drawn = |sigma: &Vector3<f64>| sigma.component_mul(&stream.normals::<3>());
        TipOff {
            omega_body: drawn(&self.tip_off_sigma.omega_body),
            v_body: drawn(&self.tip_off_sigma.v_body),
        }
    }

    fn swing(&self, stream: &mut Stream) -> (f64, f64) {
        let amplitude_rad = self.amplitude_sigma_rad * stream.normal();
        let phase_rad = std::f64::consts::PI * (2.0 * stream.uniform() - 1.0);
        (amplitude_rad, phase_rad)
    }

    /// The state at t = 0 after a release at a phase of a swing, (40)-(44).
    pub fn state(&self, amplitude_rad: f64, phase_rad: f64) -> BodyState {
        let mut parachute = self.parachute;
        parachute.pendulum.amplitude_rad = amplitude_rad;
        parachute.pendulum.phase_rad = phase_rad;
        let mut state = parachute.state_at_t0(self.gravity_m_s2);
        state.v_ned += self.drift_ned_m_s;
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assess::Summary;
    use crate::model::parachute::Pendulum;
    use crate::units::RAD_PER_DEG;

    fn titan() -> ReleaseDistribution {
        let pendulum = Pendulum { amplitude_rad: 1.0, phase_rad: 1.0, omega_rad_s: 2.0, length_m: 0.34 };
        ReleaseDistribution {
            parachute: Parachute::new(3.0, 0.5, pendulum).unwrap(),
            gravity_m_s2: 1.35,
            drift_ned_m_s: Vector3::zeros(),
            amplitude_sigma_rad: 3.0 * RAD_PER_DEG,
            tip_off_sigma: TipOff::default(),
            uncertain: None,
        }
    }

    /// Means 0, deviations 3 deg and pi/sqrt(3), each within four standard errors of 20 000 draws.
    #[test]
    fn closed_form_moments_of_the_draws() {
        let (mut amplitude, mut phase) = (Summary::default(), Summary::default());
        for k in 0..20_000 {
            let r = titan().draw(7, k);
            amplitude.push(r.amplitude_rad / (3.0 * RAD_PER_DEG));
            phase.push(r.phase_rad / std::f64::consts::PI);
        }
        assert!(amplitude.mean().abs() < 0.029 && (amplitude.std() - 1.0).abs() < 0.02, "{amplitude:?}");
        assert!(phase.mean().abs() < 0.017 && (phase.std() - 1.0 / 3f64.sqrt()).abs() < 0.008, "{phase:?}");
        assert!(phase.min() >= -1.0 && phase.max() < 1.0);
    }

    /// A drop has its release's swing; the wind's parts have mean 0 and their deviation within four standard
    /// errors of 20 000 draws.
    #[test]
    fn closed_form_moments_of_the_wind() {
        let mut parts = [Summary::default(); 2];
        for k in 0..20_000 {
            let (drop, release) = (titan().draw_drop(7, k, 1.5), titan().draw(7, k));
            assert_eq!((drop.amplitude_rad, drop.phase_rad), (release.amplitude_rad, release.phase_rad));
            parts[0].push(drop.wind_ned_m_s.x / 1.5);
            parts[1].push(drop.wind_ned_m_s.y / 1.5);
        }
        for part in parts {
            assert!(part.mean().abs() < 0.029 && (part.std() - 1.0).abs() < 0.02, "{part:?}");
        }
        assert_ne!(titan().draw_drop(7, 1, 1.5).seed, titan().draw_drop(7, 2, 1.5).seed);
    }

    /// Rates and velocities have mean 0 and their deviations within four standard errors of 20 000 draws; the
    /// same in the drop and in the release of a trial, and swing, wind and noise as without.
    #[test]
    fn closed_form_moments_of_the_tip_off() {
        let sigma = TipOff { omega_body: Vector3::new(0.1, 0.2, 0.3), v_body: Vector3::new(0.4, 0.5, 0.0) };
        let tipped = ReleaseDistribution { tip_off_sigma: sigma, ..titan() };
        let mut parts = [Summary::default(); 5];
        for k in 0..20_000 {
            let (drop, plain) = (tipped.draw_drop(7, k, 1.5), titan().draw_drop(7, k, 1.5));
            assert_eq!(RandomDrop { tip_off: TipOff::default(), ..drop }, plain);
            let (release, still) = (tipped.draw(7, k).state, titan().draw(7, k).state);
            assert_eq!(release, drop.tip_off.after(still));
            let (w, v) = (drop.tip_off.omega_body, drop.tip_off.v_body);
            assert_eq!(v.z, 0.0);
            for (part, x) in parts.iter_mut().zip([w.x / 0.1, w.y / 0.2, w.z / 0.3, v.x / 0.4, v.y / 0.5]) {
                part.push(x);
            }
        }
        for part in parts {
            assert!(part.mean().abs() < 0.029 && (part.std() - 1.0).abs() < 0.02, "{part:?}");
        }
    }

    #[test]
    fn prop_a_trial_is_its_own_whatever_else_is_drawn() {
        let release = titan().draw(1, 17);
        assert_eq!(release, titan().draw(1, 17));
        assert_ne!(release.amplitude_rad, titan().draw(1, 18).amplitude_rad);
        assert_ne!(release.amplitude_rad, titan().draw(2, 17).amplitude_rad);
        assert_eq!(release.state, titan().state(release.amplitude_rad, release.phase_rad));
    }

    /// The first draw by another ChaCha8, in Python: another generator or order of draws would change every
    /// campaign.
    #[test]
    fn data_first_draws() {
        let r = titan().draw(1, 0);
        assert_eq!(
            (format!("{:.6}", r.amplitude_rad), format!("{:.6}", r.phase_rad)),
            ("0.018427".into(), "-0.047391".into())
        );
    }
}
