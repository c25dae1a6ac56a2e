//! Velocity loop: from the velocity error to the wanted acceleration, the collective and the tilt.
//!
//! ```text
//! a = K_p e + I + a_ff ;  up = g - a_D ;  up_s = clip(up, 0, up_max)
//! m = min(up_s tan(tilt), sqrt(max(up_max^2 - up_s^2, 0))) ;  horizontal part clipped to m
//! I_D += K_ivz e_D dt unless (up > up_max and e_D < 0) or (up < 0 and e_D > 0)
//! I_H += K_ivx e_H dt unless clipped and a_H . e_H > 0
//! ```
//!
//! The vertical has priority. Integrals are used before their update. The horizontal gains are the same in
//! every direction, so the loop works in NED; in the vertical plane the radial clip is the planar one.

use nalgebra::{Vector2, Vector3};

use super::{Airframe, Gains};
use crate::math;
use crate::real::straight;

/// State of the velocity loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VelocityLoop {
    integral_ned: Vector3<f64>,
}

/// Setpoint of the velocity loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocitySetpoint {
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Acceleration fed forward, NED [m/s^2].
    pub a_ff_ned: Vector3<f64>,
}

/// Output of the velocity loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrustVector {
    /// Acceleration after all limits, NED [m/s^2]; gravity is not part of it.
    pub acceleration_sp_ned: Vector3<f64>,
    /// Acceleration that the rotors shall give upwards, `up_s` [m/s^2].
    pub up_m_s2: f64,
}

/// Bound of the integrals as a multiple of the rotors' largest acceleration. No flight comes near it (the
/// anti-windup stops the integrals first); it lets the loop recover from a setpoint of absurd size.
pub(crate) const INTEGRAL_BOUND: f64 = 10.0;

impl VelocityLoop {
    /// The integrals, NED [m/s^2].
    pub fn integral_ned(&self) -> Vector3<f64> {
        self.integral_ned
    }

    /// One step at the velocity `v_ned` [m/s].
    pub fn step(
        &mut self,
        airframe: &Airframe,
        gains: &Gains,
        tilt_rad: f64,
        v_ned: &Vector3<f64>,
        setpoint: &VelocitySetpoint,
        dt_s: f64,
    ) -> ThrustVector {
        let e = setpoint.v_ned - v_ned;
        let k_p = Vector3::new(gains.k_pvx, gains.k_pvx, gains.k_pvz);
        let a = k_p.component_mul(&e) + self.integral_ned + setpoint.a_ff_ned;
        let up = airframe.gravity_m_s2 - a.z;
        let up_max = airframe.up_max_m_s2();
        let up_s = up.min(up_max).max(0.0);
        let level_max = (up_s * math::tan(tilt_rad)).min((up_max * up_max - up_s * up_s).max(0.0).sqrt());
        let (level, clipped) = clip_radially(a.xy(), level_max);
        let bound = INTEGRAL_BOUND * up_max;
        if !((up > up_max && e.z < 0.0) || (up < 0.0 && e.z > 0.0)) {
            self.integral_ned.z = (self.integral_ned.z + gains.k_ivz * e.z * dt_s).min(bound).max(-bound);
        }
        if !(clipped && a.xy().dot(&e.xy()) > 0.0) {
            for i in 0..2 {
                self.integral_ned[i] =
                    (self.integral_ned[i] + gains.k_ivx * e[i] * dt_s).min(bound).max(-bound);
            }
        }
        ThrustVector {
            acceleration_sp_ned: Vector3::new(level.x, level.y, airframe.gravity_m_s2 - up_s),
            up_m_s2: up_s,
        }
    }
}

/// `a` shortened to the length `limit`, and whether it was longer.
fn clip_radially(a: Vector2<f64>, limit: f64) -> (Vector2<f64>, bool) {
    let length = a.norm();
    if length > limit { (a * (limit / length), true) } else { (a, false) }
}

impl ThrustVector {
    /// Roll and pitch [rad] that put the thrust along the wanted acceleration at the heading `yaw_rad`. In
    /// the plane, `theta_c = atan2(-a_N, up)`; level when nothing is wanted.
    pub fn roll_pitch(&self, yaw_rad: f64) -> (f64, f64) {
        let (sin, cos) = straight::sin_cos(yaw_rad);
        let a = &self.acceleration_sp_ned;
        let (ahead, right) = (cos * a.x + sin * a.y, cos * a.y - sin * a.x);
        if self.up_m_s2 <= 1e-9 && ahead == 0.0 && right == 0.0 {
            return (0.0, 0.0);
        }
        (straight::atan2(right, straight::hypot(ahead, self.up_m_s2)), straight::atan2(-ahead, self.up_m_s2))
    }
}
