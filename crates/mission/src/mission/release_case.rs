//! A mission's release cases (Table 3) as drops: the swing that brings the vehicle to t = 0 with a case's
//! pitch and pitch rate.
//!
//! A case is a state at t = 0. A drop comes there from its canopy, through the fall, turning on as it was
//! released; so its swing is chosen: amplitude and phase at the end of the hang, with the mission's frequency
//! and length. The velocity is then what the drop makes of it: within 0.1 m/s of Table 3's, whose pitch and
//! rate are those of the release.

use std::sync::Arc;

use nalgebra::{Matrix2, Vector2};

use super::release::Release;
use samara_core::math;
use samara_core::model::parachute::Pendulum;
use samara_core::model::{Environment, Parachute, Vehicle};
use samara_core::sim::nominal_state_at_t0;
use samara_core::tune::ReleaseCase;

/// Corrections that are tried.
const ATTEMPTS: usize = 20;
/// Step of the difference quotients [rad].
const DIFFERENCE_RAD: f64 = 1e-5;
/// Accuracy of pitch [rad] and of pitch rate in parts of the frequency [rad].
const TOLERANCE_RAD: f64 = 1e-9;
/// A swing beyond a quarter of the turn is none.
const LARGEST_SWING_RAD: f64 = std::f64::consts::FRAC_PI_2;

/// Why a mission cannot be dropped in a case.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CaseError {
    /// There is no case of that name.
    #[error("no release case `{name}` in the mission: expected one of {known}")]
    Unknown {
        /// The name.
        name: String,
        /// Those that there are.
        known: String,
    },
    /// No swing leads there.
    #[error("no swing of the mission's pendulum comes to the pitch and pitch rate of `{name}` at t = 0")]
    OutOfReach {
        /// The case.
        name: String,
    },
}

impl Release {
    /// The parachute whose swing comes to t = 0 with the pitch and the pitch rate of a release case, if there
    /// is such a swing.
    pub(super) fn swinging_to(
        &self,
        case: &ReleaseCase,
        vehicle: &Arc<Vehicle>,
        environment: &Environment,
    ) -> Option<Parachute> {
        let omega = self.parachute.pendulum.omega_rad_s;
        // Pitch, and pitch rate over omega, at t = 0 after a swing [rad].
        let comes_to = |swing: &Vector2<f64>| {
            let (parachute, environment) = (self.parachute_swinging(swing), environment.clone());
            let state = nominal_state_at_t0(vehicle.clone(), environment, parachute, self.start);
            let q = state.q_ned_from_body;
            Vector2::new(2.0 * math::atan2(q[2], q[0]), state.omega_body.y / omega)
        };
        let wanted = Vector2::new(case.pitch_rad, case.pitch_rate_rad_s / omega);
        // Angle and rate over omega at the release, by Newton's method: what comes to t = 0 is nearly linear
        // in them.
        let mut swing = wanted;
        for _ in 0..ATTEMPTS {
            let miss = wanted - comes_to(&swing);
            if miss.norm() < TOLERANCE_RAD {
                return Some(self.parachute_swinging(&swing));
            }
            let slope = |of: Vector2<f64>| {
                (comes_to(&(swing + of)) - comes_to(&(swing - of))) / (2.0 * DIFFERENCE_RAD)
            };
            let slopes =
                Matrix2::from_columns(&[Vector2::x(), Vector2::y()].map(|axis| slope(axis * DIFFERENCE_RAD)));
            swing += slopes.try_inverse()? * miss;
            if !(swing.norm() < LARGEST_SWING_RAD) {
                return None;
            }
        }
        None
    }

    fn parachute_swinging(&self, swing: &Vector2<f64>) -> Parachute {
        let pendulum = Pendulum {
            amplitude_rad: swing.norm(),
            phase_rad: math::atan2(swing.x, swing.y),
            ..self.parachute.pendulum
        };
        Parachute { pendulum, ..self.parachute }
    }
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::{Effect, Mission};

    fn state_at_t0(mission: &Mission) -> (f64, f64, nalgebra::Vector3<f64>) {
        let (vehicle, environment) = (mission.vehicle.clone(), mission.site.environment.clone());
        let s = nominal_state_at_t0(vehicle, environment, mission.release.parachute, mission.release.start);
        (2.0 * math::atan2(s.q_ned_from_body[2], s.q_ned_from_body[0]), s.omega_body.y, s.v_ned)
    }

    /// Table 3: pitch and rate to the last digit, velocities as the swing makes them.
    #[test]
    fn reference_a_drop_comes_to_table_3() {
        for (file, near_m_s) in [("titan_paper", 0.1), ("x500_drop", 1.0)] {
            let mission = Mission::shipped(file).unwrap().with_effects(&[Effect::RotorInflow]);
            for case in &mission.study.cases {
                let mut swinging = mission.clone();
                swinging.use_release_case(&case.name).unwrap();
                let (pitch, rate, v_ned) = state_at_t0(&swinging);
                assert!((pitch - case.pitch_rad).abs() < 1e-8, "{file} {}", case.name);
                assert!((rate - case.pitch_rate_rad_s).abs() < 1e-8, "{file} {}", case.name);
                assert!((v_ned - case.v_ned).norm() < near_m_s, "{file} {} {v_ned:?}", case.name);
                assert_ne!(swinging.inputs.hash, mission.inputs.hash);
            }
        }
    }

    #[test]
    fn a_case_that_is_not_there_or_cannot_be_reached_is_refused() {
        let mut mission = Mission::shipped("titan_drop").unwrap();
        let before = mission.release.parachute;
        let error = mission.use_release_case("case_7").unwrap_err().to_string();
        assert!(error.contains("case_0, case_1") && error.contains("case_7"), "{error}");
        mission.study.cases[3].pitch_rate_rad_s = 50.0;
        let error = mission.use_release_case("case_3").unwrap_err();
        assert_eq!(error, CaseError::OutOfReach { name: "case_3".into() });
        mission.release.parachute.pendulum.omega_rad_s = 0.0;
        assert!(mission.use_release_case("case_1").is_err());
        mission.release.parachute.pendulum = before.pendulum;
        assert_eq!(mission.release.parachute, before);
    }
}
