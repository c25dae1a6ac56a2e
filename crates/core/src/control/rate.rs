//! Rate loop: from the body rate error to the wanted angular acceleration.
//!
//! ```text
//! e = rate_c - rate ;  omega_dot_c = K_pq e + I ;  I = clip(I + K_iq e dt, +-10)
//! ```
//!
//! for roll and pitch; yaw is proportional. The integral is used before its update.

use super::attitude::within;
use super::{ControlLimits, Gains};
use crate::real::Real;
use crate::vector::V3;

/// State of the rate loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateLoop<S = f64> {
    integral: [S; 2],
}

impl<S: Real> RateLoop<S> {
    /// The loop at its beginning, for numbers of a kind of which one is given.
    pub fn new(kind: S) -> Self {
        Self { integral: [kind.of(0.0); 2] }
    }

    /// The integrals of roll and pitch rate [rad/s^2].
    pub fn integral(&self) -> [S; 2] {
        self.integral
    }

    /// Becomes the other where the mask holds.
    #[inline(always)]
    pub(super) fn take(&mut self, mask: S::Mask, other: &Self) {
        for (integral, now) in self.integral.iter_mut().zip(other.integral) {
            *integral = S::select(mask, now, *integral);
        }
    }

    /// One step: body rates and their setpoint [rad/s] to the angular acceleration [rad/s^2].
    #[inline(always)]
    pub fn step(
        &mut self,
        gains: &Gains,
        limits: &ControlLimits,
        omega_body: V3<S>,
        rate_sp_body: V3<S>,
        dt_s: f64,
    ) -> V3<S> {
        let e = rate_sp_body - omega_body;
        let bound = limits.rate_integral_rad_s2;
        let [roll, pitch] = self.integral;
        self.integral =
            [within(roll + e.x * gains.k_iq * dt_s, bound), within(pitch + e.y * gains.k_iq * dt_s, bound)];
        V3::new(e.x * gains.k_pq + roll, e.y * gains.k_pq + pitch, e.z * gains.k_pr)
    }
}
