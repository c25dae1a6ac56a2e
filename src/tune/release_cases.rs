//! The releases under study: Table 3 of the paper, as printed.
//!
//! Six phases of a 9.4 deg swing, (40)-(44), and the nominal release. The printed digits are the tuning set, truncated
//! as they are: the nominal case descends at 3.67 m/s here, where (44) gives 3.675.

use nalgebra::Vector3;

use crate::frames::quaternion_from_euler;
use crate::model::rigid_body::BodyState;
use crate::units::RAD_PER_DEG;

/// State at t = 0, the end of the release delay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReleaseCase {
    /// Velocity north [m/s].
    pub v_north_m_s: f64,
    /// Velocity down [m/s].
    pub v_down_m_s: f64,
    /// Pitch [deg].
    pub pitch_deg: f64,
    /// Pitch rate [deg/s].
    pub pitch_rate_deg_s: f64,
}

/// Table 3; the index is the case's number.
pub const TABLE_3: [ReleaseCase; 7] = [
    case(0.0, 3.67, 0.0, 0.0),
    case(0.32, 3.67, 0.0, 18.8),
    case(0.26, 3.64, 5.5, 15.2),
    case(0.10, 3.65, 8.9, 5.8),
    case(-0.10, 3.69, 8.9, -5.8),
    case(-0.26, 3.70, 5.5, -15.2),
    case(-0.32, 3.67, 0.0, -18.8),
];

const fn case(v_north_m_s: f64, v_down_m_s: f64, pitch_deg: f64, pitch_rate_deg_s: f64) -> ReleaseCase {
    ReleaseCase { v_north_m_s, v_down_m_s, pitch_deg, pitch_rate_deg_s }
}

impl ReleaseCase {
    /// The vehicle's state.
    pub fn state(&self) -> BodyState {
        BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: quaternion_from_euler(0.0, self.pitch_deg * RAD_PER_DEG, 0.0),
            v_ned: Vector3::new(self.v_north_m_s, 0.0, self.v_down_m_s),
            omega_body: Vector3::new(0.0, self.pitch_rate_deg_s * RAD_PER_DEG, 0.0),
        }
    }
}
