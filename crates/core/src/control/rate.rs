//! Rate loop: from the body rate error to the wanted angular acceleration.
//!
//! ```text
//! e = rate_c - rate ;  omega_dot_c = K_pq e + I ;  I = clip(I + K_iq e dt, +-10)
//! ```
//!
//! for roll and pitch; yaw is proportional. The integral is used before its update.

use nalgebra::Vector3;

use super::{ControlLimits, Gains};

/// State of the rate loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RateLoop {
    integral: [f64; 2],
}

impl RateLoop {
    /// The integrals of roll and pitch rate [rad/s^2].
    pub fn integral(&self) -> [f64; 2] {
        self.integral
    }

    /// One step: body rates and their setpoint [rad/s] to the angular acceleration [rad/s^2].
    pub fn step(
        &mut self,
        gains: &Gains,
        limits: &ControlLimits,
        omega_body: &Vector3<f64>,
        rate_sp_body: &Vector3<f64>,
        dt_s: f64,
    ) -> Vector3<f64> {
        let e = rate_sp_body - omega_body;
        let bound = limits.rate_integral_rad_s2;
        let wanted = Vector3::new(
            gains.k_pq * e.x + self.integral[0],
            gains.k_pq * e.y + self.integral[1],
            gains.k_pr * e.z,
        );
        for i in 0..2 {
            self.integral[i] = (self.integral[i] + gains.k_iq * e[i] * dt_s).min(bound).max(-bound);
        }
        wanted
    }
}
