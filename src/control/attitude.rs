//! Attitude loop: from the attitude error to wanted body rates.
//!
//! The error is split into the **tilt**, the shortest rotation that brings the thrust axis where it shall be, and the
//! **twist** about the thrust axis that remains. Each has its own gain; a heading error does not delay the tilt. In the
//! vertical plane the tilt error is exactly `theta_c - theta` (within half a turn): `q_c = clip(K_ptheta (theta_c - theta))`.

use nalgebra::Vector3;

use super::{ControlLimits, Gains};
use crate::frames::{Quaternion, conjugate, product, wrap_pi};

/// Wanted body rates [rad/s] at an attitude and its setpoint.
pub fn rate_setpoint(
    gains: &Gains,
    limits: &ControlLimits,
    q_ned_from_body: Quaternion,
    q_sp_ned_from_body: Quaternion,
) -> Vector3<f64> {
    let e = tilt_and_twist(q_ned_from_body, q_sp_ned_from_body);
    let (rate, yaw) = (limits.rate_command_rad_s, limits.yaw_rate_command_rad_s);
    Vector3::new(
        (gains.k_ptheta * e.x).min(rate).max(-rate),
        (gains.k_ptheta * e.y).min(rate).max(-rate),
        (gains.k_ppsi * e.z).min(yaw).max(-yaw),
    )
}

/// Tilt error about body x and y and twist error about the thrust axis [rad].
pub fn tilt_and_twist(q_ned_from_body: Quaternion, q_sp_ned_from_body: Quaternion) -> Vector3<f64> {
    let [w, x, y, z] = product(conjugate(q_ned_from_body), q_sp_ned_from_body);
    let upright = w.hypot(z);
    let lying = x.hypot(y);
    // q_body_from_sp = swing * twist; the swing's axis lies in the body's x-y plane.
    let (cos, sin) = if upright > 0.0 { (w / upright, z / upright) } else { (1.0, 0.0) };
    let angle_per_length = if lying > 0.0 { 2.0 * lying.atan2(upright) / lying } else { 0.0 };
    Vector3::new(
        angle_per_length * (x * cos - y * sin),
        angle_per_length * (x * sin + y * cos),
        wrap_pi(2.0 * sin.atan2(cos)),
    )
}
