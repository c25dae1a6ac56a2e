//! Velocity loop: from the velocity error to the wanted acceleration, the collective and the tilt.
//!
//! ```text
//! a = K_p e + I + a_ff ;  up = g - a_D ;  up_s = clip(up, 0, up_max)
//! m = min(up_s tan(tilt), sqrt(max(up_max^2 - up_s^2, 0))) ;  horizontal part clipped to m
//! thrust along (a_H, up_s), of the size m up_s
//! I_D += K_ivz e_D dt unless (up > up_max and e_D < 0) or (up < 0 and e_D > 0)
//! I_H += K_ivx e_H dt unless clipped and a_H . e_H > 0
//! ```
//!
//! With the tilt from gravity ([`TiltFrom`]) the thrust is along `(a_H, g)`, its tilt so limited that it
//! keeps `up_s` upwards:
//!
//! ```text
//! horizontal part clipped to g min(tan(tilt), sqrt(max(up_max^2 - up_s^2, 0))/up_s)
//! thrust along (a_H, g), of the size m up_s/cos(tilt)
//! ```
//!
//! The vertical has priority. Integrals are used before their update. The horizontal gains are the same in
//! every direction, so the loop works in NED; in the vertical plane the radial clip is the planar one.

use super::attitude::within;
use super::{Airframe, ControlLimits, Gains, TiltFrom};
use crate::math;
use crate::real::{Real, straight};
use crate::vector::V3;

/// State of the velocity loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityLoop<S = f64> {
    integral_ned: V3<S>,
}

/// Setpoint of the velocity loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocitySetpoint<S = f64> {
    /// Velocity, NED [m/s].
    pub v_ned: V3<S>,
    /// Acceleration fed forward, NED [m/s^2].
    pub a_ff_ned: V3<S>,
}

/// Output of the velocity loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrustVector<S = f64> {
    /// Acceleration after all limits, NED [m/s^2]; gravity is not part of it.
    pub acceleration_sp_ned: V3<S>,
    /// Direction of the thrust, north, east and up; its size means nothing.
    pub along: V3<S>,
    /// Acceleration that the rotors shall give together [m/s^2].
    pub collective_m_s2: S,
}

/// Bound of the integrals as a multiple of the rotors' largest acceleration. No flight comes near it (the
/// anti-windup stops the integrals first); it lets the loop recover from a setpoint of absurd size.
pub(crate) const INTEGRAL_BOUND: f64 = 10.0;

impl<S: Real> VelocityLoop<S> {
    /// The loop at its beginning, for numbers of a kind of which one is given.
    pub fn new(kind: S) -> Self {
        Self { integral_ned: V3::zero(kind) }
    }

    /// The integrals, NED [m/s^2].
    pub fn integral_ned(&self) -> V3<S> {
        self.integral_ned
    }

    /// Becomes the other where the mask holds.
    #[inline(always)]
    pub(super) fn take(&mut self, mask: S::Mask, other: &Self) {
        self.integral_ned = V3::select(mask, other.integral_ned, self.integral_ned);
    }

    /// One step at the velocity `v_ned` [m/s].
    #[inline(always)]
    pub fn step(
        &mut self,
        airframe: &Airframe,
        gains: &Gains,
        limits: &ControlLimits,
        v_ned: V3<S>,
        setpoint: &VelocitySetpoint<S>,
        dt_s: f64,
    ) -> ThrustVector<S> {
        let e = setpoint.v_ned - v_ned;
        let k_p_e = V3::new(e.x * gains.k_pvx, e.y * gains.k_pvx, e.z * gains.k_pvz);
        let a = k_p_e + self.integral_ned + setpoint.a_ff_ned;
        let (zero, gravity) = (e.x.of(0.0), e.x.of(airframe.gravity_m_s2));
        let up_max_m_s2 = airframe.up_max_m_s2();
        let up_max = zero.of(up_max_m_s2);
        let up = gravity - a.z;
        let up_s = up.at_most(up_max).at_least(zero);
        let rest = (up_max * up_max - up_s * up_s).at_least(zero).sqrt();
        let tan_max = math::tan(limits.tilt_rad);
        let level_max = match limits.tilt_from {
            TiltFrom::Thrust => (up_s * tan_max).at_most(rest),
            TiltFrom::Gravity => (gravity * tan_max).at_most(gravity * (rest / up_s)),
        };
        let length = (a.x * a.x + a.y * a.y).sqrt();
        let clipped = level_max.less(length);
        let share = S::select(clipped, level_max / length, zero.of(1.0));
        let (level_x, level_y) = (a.x * share, a.y * share);
        let bound = INTEGRAL_BOUND * up_max_m_s2;
        let held = (up_max.less(up) & e.z.less(zero)) | (up.less(zero) & zero.less(e.z));
        let old = self.integral_ned;
        let z = S::select(held, old.z, within(old.z + e.z * gains.k_ivz * dt_s, bound));
        let held = clipped & zero.less(a.x * e.x + a.y * e.y);
        let x = S::select(held, old.x, within(old.x + e.x * gains.k_ivx * dt_s, bound));
        let y = S::select(held, old.y, within(old.y + e.y * gains.k_ivx * dt_s, bound));
        self.integral_ned = V3::new(x, y, z);
        let down = gravity - up_s;
        match limits.tilt_from {
            TiltFrom::Thrust => ThrustVector {
                acceleration_sp_ned: V3::new(level_x, level_y, down),
                along: V3::new(level_x, level_y, up_s),
                collective_m_s2: up_s,
            },
            TiltFrom::Gravity => {
                let along = V3::new(level_x, level_y, gravity);
                let part = up_s / gravity;
                ThrustVector {
                    acceleration_sp_ned: V3::new(level_x * part, level_y * part, down),
                    along,
                    collective_m_s2: along.norm() * part,
                }
            }
        }
    }
}

impl<S: Real> ThrustVector<S> {
    /// Roll and pitch [rad] that put the thrust along its direction at the heading `yaw_rad`. In the plane,
    /// `theta_c = atan2(-a_N, up)`; level when nothing is wanted.
    #[inline(always)]
    pub fn roll_pitch(&self, yaw_rad: S) -> (S, S) {
        let (sin, cos) = straight::sin_cos(yaw_rad);
        let (a, zero) = (&self.along, yaw_rad.of(0.0));
        let (ahead, right) = (cos * a.x + sin * a.y, cos * a.y - sin * a.x);
        let wanted = zero.of(1e-9).less(a.z) | zero.less(ahead.abs()) | zero.less(right.abs());
        let roll = right.atan2(straight::hypot(ahead, a.z));
        let pitch = (-ahead).atan2(a.z);
        (S::select(wanted, roll, zero), S::select(wanted, pitch, zero))
    }
}
