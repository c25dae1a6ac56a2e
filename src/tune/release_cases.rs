//! Releases that gains are tuned on and tried on: states at t = 0, the end of the release delay, rotors at rest.
//!
//! A mission names its cases (Table 3 of the paper, as printed: truncated digits, the nominal case at 3.67 m/s where (44)
//! gives 3.675). Around them, [`swing_releases`] samples the swing (40)-(44) in amplitude and phase, and [`random_releases`]
//! draws from its distribution.

use nalgebra::Vector3;

use super::random::Stream;
use crate::frames::quaternion_from_euler;
use crate::model::Parachute;
use crate::model::parachute::Pendulum;
use crate::model::rigid_body::BodyState;

/// A state at t = 0; rotors at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct ReleaseCase {
    /// Name of the case.
    pub name: String,
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Pitch [rad].
    pub pitch_rad: f64,
    /// Pitch rate [rad/s].
    pub pitch_rate_rad_s: f64,
}

impl ReleaseCase {
    /// The vehicle's state.
    pub fn state(&self) -> BodyState {
        BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: quaternion_from_euler(0.0, self.pitch_rad, 0.0),
            v_ned: self.v_ned,
            omega_body: Vector3::new(0.0, self.pitch_rate_rad_s, 0.0),
        }
    }
}

/// A swing under a parachute whose amplitude is normal about 0 and whose phase is uniform over the turn, (40)-(44).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// Rate of descent under the canopy [m/s].
    pub descent_m_s: f64,
    /// Delay t_d between release and rotor start [s].
    pub delay_s: f64,
    /// Gravity [m/s^2].
    pub gravity_m_s2: f64,
    /// Standard deviation of the amplitude theta_0 [rad].
    pub amplitude_sigma_rad: f64,
    /// Frequency of the swing [rad/s].
    pub omega_rad_s: f64,
    /// Length r of the pendulum [m].
    pub length_m: f64,
}

impl Swing {
    /// The state at t = 0 after a release at this amplitude and phase [rad].
    pub fn state(&self, amplitude_rad: f64, phase_rad: f64) -> BodyState {
        let pendulum =
            Pendulum { amplitude_rad, phase_rad, omega_rad_s: self.omega_rad_s, length_m: self.length_m };
        Parachute { descent_m_s: self.descent_m_s, delay_s: self.delay_s, pendulum }
            .state_at_t0(self.gravity_m_s2)
    }
}

/// Amplitudes of [`swing_releases`] in standard deviations. J_TPF has narrow peaks between them: a coarser sample misses some.
const AMPLITUDES: [f64; 7] = [1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0];
/// Phases of [`swing_releases`], evenly over the turn; those of every other amplitude lie between.
const PHASES: usize = 12;

/// The swing in seven amplitudes (3 to 12 deg with the paper's 3 deg) and twelve phases.
pub fn swing_releases(swing: &Swing) -> Vec<BodyState> {
    let at = |(row, a): (usize, f64)| {
        let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
        let phase = move |k: usize| std::f64::consts::TAU * (k as f64 + shift) / PHASES as f64;
        (0..PHASES).map(move |k| swing.state(a * swing.amplitude_sigma_rad, phase(k)))
    };
    AMPLITUDES.into_iter().enumerate().flat_map(at).collect()
}

/// `count` random releases of a seed; the first ones are the same whatever the count.
pub fn random_releases(swing: &Swing, seed: u64, count: usize) -> Vec<BodyState> {
    let draw = |i: usize| {
        let mut stream = Stream::new(seed, i);
        let amplitude_rad = swing.amplitude_sigma_rad * stream.normal();
        swing.state(amplitude_rad, stream.between(-std::f64::consts::PI, std::f64::consts::PI))
    };
    (0..count).map(draw).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::pitch;
    use crate::units::RAD_PER_DEG;

    const PAPER: Swing = Swing {
        descent_m_s: 3.0,
        delay_s: 0.5,
        gravity_m_s2: 1.35,
        amplitude_sigma_rad: 3.0 * RAD_PER_DEG,
        omega_rad_s: 2.0,
        length_m: 0.34,
    };

    #[test]
    fn closed_form_amplitudes_and_phases_of_the_sampled_swing() {
        let states = swing_releases(&PAPER);
        assert_eq!(states.len(), 84);
        let widest = states.iter().map(|s| pitch(s.q_ned_from_body)).fold(0.0, f64::max);
        assert!((widest - 12.0 * RAD_PER_DEG).abs() < 1e-12);
        assert!((states[0].omega_body.y - 6.0 * RAD_PER_DEG).abs() < 1e-15, "phase 0: fastest");
    }

    /// (40)-(41): the rate has standard deviation omega sigma sqrt(1/2); draws do not depend on how many there are.
    #[test]
    fn prop_random_releases_have_their_distribution() {
        let states = random_releases(&PAPER, 7, 4000);
        assert_eq!(states[..10], random_releases(&PAPER, 7, 10));
        assert_ne!(states[..10], random_releases(&PAPER, 8, 10));
        let rates: Vec<f64> = states.iter().map(|s| s.omega_body.y / RAD_PER_DEG).collect();
        let mean = rates.iter().sum::<f64>() / 4000.0;
        let sigma = (rates.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / 3999.0).sqrt();
        assert!(mean.abs() < 0.25 && (sigma / (6.0 / 2f64.sqrt()) - 1.0).abs() < 0.05, "{mean} {sigma}");
    }
}
