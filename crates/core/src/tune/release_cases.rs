//! Releases that gains are tuned on and tried on: states at t = 0, the end of the release delay, rotors at
//! rest.
//!
//! A mission names its cases (Table 3 of the paper, as printed: truncated digits, the nominal case at 3.67
//! m/s where (44) gives 3.675). Around them, [`swing_releases`] samples the swing (40)-(44) in amplitude and
//! phase.

use nalgebra::Vector3;

use crate::assess::ReleaseDistribution;
use crate::frames::{pitch, quaternion_from_euler};
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

/// Amplitude of [`cases_of_swing`], in standard deviations.
const CASE_AMPLITUDE: f64 = 3.0;
/// Steps of phase over half a turn in [`cases_of_swing`].
const CASE_STEPS: usize = 5;

/// Release cases made as Table 3 is: `case_0` without a swing, `case_1` to `case_6` a swing of three standard
/// deviations at the phases 0, 36 .. 180 deg. Without a swing `case_0` alone.
pub fn cases_of_swing(swing: &ReleaseDistribution) -> Vec<ReleaseCase> {
    let case = |number: usize, state: BodyState| ReleaseCase {
        name: format!("case_{number}"),
        v_ned: state.v_ned,
        pitch_rad: pitch(state.q_ned_from_body),
        pitch_rate_rad_s: state.omega_body.y,
    };
    let mut cases = vec![case(0, swing.state(0.0, 0.0))];
    if swing.amplitude_sigma_rad != 0.0 {
        let phase_rad = |step: usize| std::f64::consts::PI * step as f64 / CASE_STEPS as f64;
        let amplitude_rad = CASE_AMPLITUDE * swing.amplitude_sigma_rad;
        cases
            .extend((0..=CASE_STEPS).map(|step| case(step + 1, swing.state(amplitude_rad, phase_rad(step)))));
    }
    cases
}

/// Amplitudes of [`swing_releases`] that are taken unless others are asked for, in standard deviations.
pub const AMPLITUDES: [f64; 4] = [0.8, 1.6, 2.4, 3.2];
/// Phases of [`swing_releases`], evenly over the turn; those of every other amplitude lie between.
const PHASES: usize = 12;

/// The swing at these amplitudes, in standard deviations, and twelve phases each.
pub fn swing_releases(swing: &ReleaseDistribution, amplitudes: &[f64]) -> Vec<BodyState> {
    let at = |(row, &a): (usize, &f64)| {
        let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
        let phase = move |k: usize| std::f64::consts::TAU * (k as f64 + shift) / PHASES as f64;
        (0..PHASES).map(move |k| swing.state(a * swing.amplitude_sigma_rad, phase(k))).collect::<Vec<_>>()
    };
    amplitudes.iter().enumerate().flat_map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use crate::model::Parachute;
    use crate::model::parachute::{Pendulum, TipOff};
    use crate::units::RAD_PER_DEG;

    fn paper() -> ReleaseDistribution {
        let pendulum = Pendulum { amplitude_rad: 0.0, phase_rad: 0.0, omega_rad_s: 2.0, length_m: 0.34 };
        ReleaseDistribution {
            parachute: Parachute::new(3.0, 0.5, pendulum).unwrap(),
            gravity_m_s2: 1.35,
            drift_ned_m_s: Vector3::zeros(),
            amplitude_sigma_rad: 3.0 * RAD_PER_DEG,
            tip_off_sigma: TipOff::default(),
            uncertain: None,
        }
    }

    /// (40) to (44) by hand: at phase 0 the swing is fastest and upright, and the vehicle has fallen half a
    /// second from 3 m/s; at 180 deg it swings back; without a swing there is one case.
    #[test]
    fn closed_form_cases_of_a_swing() {
        let cases = cases_of_swing(&paper());
        let names: Vec<&str> = cases.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["case_0", "case_1", "case_2", "case_3", "case_4", "case_5", "case_6"]);
        assert!((cases[0].v_ned - Vector3::new(0.0, 0.0, 3.675)).norm() < 1e-12 && cases[0].pitch_rad == 0.0);
        let theta_0 = 9.0 * RAD_PER_DEG;
        assert!((cases[1].pitch_rate_rad_s - 2.0 * theta_0).abs() < 1e-12, "{:?}", cases[1]);
        assert!(cases[1].pitch_rad.abs() < 1e-12 && cases[6].pitch_rad.abs() < 1e-12);
        assert!((cases[6].pitch_rate_rad_s + 2.0 * theta_0).abs() < 1e-12);
        assert!((cases[3].pitch_rad - theta_0 * math::sin(72.0 * RAD_PER_DEG)).abs() < 1e-12);
        let still = ReleaseDistribution { amplitude_sigma_rad: 0.0, ..paper() };
        assert_eq!(cases_of_swing(&still).len(), 1);
    }

    #[test]
    fn closed_form_amplitudes_and_phases_of_the_sampled_swing() {
        let states = swing_releases(&paper(), &AMPLITUDES);
        assert_eq!(states.len(), 48);
        let widest = states.iter().map(|s| pitch(s.q_ned_from_body)).fold(0.0, f64::max);
        // The last amplitude's phases lie half a step, 15 deg, beside the peak.
        let beside = math::cos(15.0 * RAD_PER_DEG);
        assert!((widest - 3.2 * 3.0 * RAD_PER_DEG * beside).abs() < 1e-12);
        assert!((states[0].omega_body.y - 0.8 * 6.0 * RAD_PER_DEG).abs() < 1e-15, "phase 0: fastest");
    }
}
