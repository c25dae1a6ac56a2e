//! Attitude loop: from the attitude error to wanted body rates.
//!
//! The error is split into the **tilt**, the shortest rotation that brings the thrust axis where it shall be,
//! and the **twist** about the thrust axis that remains. Each has its own gain; a heading error does not
//! delay the tilt. In the vertical plane the tilt error is exactly `theta_c - theta` (within half a turn):
//! `q_c = clip(K_ptheta (theta_c - theta))`.

use super::{ControlLimits, Gains};
use crate::frames::{Quaternion, conjugate, product, wrap_pi};
use crate::real::{Real, straight};
use crate::vector::V3;

/// Wanted body rates [rad/s] at an attitude and its setpoint.
#[inline(always)]
pub fn rate_setpoint<S: Real>(
    gains: &Gains,
    limits: &ControlLimits,
    q_ned_from_body: Quaternion<S>,
    q_sp_ned_from_body: Quaternion<S>,
) -> V3<S> {
    let e = tilt_and_twist(q_ned_from_body, q_sp_ned_from_body);
    let (rate, yaw) = (limits.rate_command_rad_s, limits.yaw_rate_command_rad_s);
    V3::new(
        within(e.x * gains.k_ptheta, rate),
        within(e.y * gains.k_ptheta, rate),
        within(e.z * gains.k_ppsi, yaw),
    )
}

/// A number, or the nearest one that is no larger than a bound, either way.
#[inline(always)]
pub(super) fn within<S: Real>(x: S, bound: f64) -> S {
    x.at_most(x.of(bound)).at_least(x.of(-bound))
}

/// Tilt error about body x and y and twist error about the thrust axis [rad].
#[inline(always)]
pub fn tilt_and_twist<S: Real>(q_ned_from_body: Quaternion<S>, q_sp_ned_from_body: Quaternion<S>) -> V3<S> {
    let [w, x, y, z] = product(conjugate(q_ned_from_body), q_sp_ned_from_body);
    let upright = straight::hypot(w, z);
    let lying = straight::hypot(x, y);
    // q_body_from_sp = swing * twist; the swing's axis lies in the body's x-y plane.
    let (zero, one) = (w.of(0.0), w.of(1.0));
    let stands = zero.less(upright);
    let (cos, sin) = (S::select(stands, w / upright, one), S::select(stands, z / upright, zero));
    let angle_per_length = S::select(zero.less(lying), lying.atan2(upright) * 2.0 / lying, zero);
    V3::new(
        angle_per_length * (x * cos - y * sin),
        angle_per_length * (x * sin + y * cos),
        wrap_pi(sin.atan2(cos) * 2.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{LEVEL, quaternion_from_euler, rotate_ned_from_body};
    use crate::math;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    fn about(axis: Vector3<f64>, angle: f64) -> Quaternion {
        let (sin, cos) = math::sin_cos(0.5 * angle);
        [cos, sin * axis.x, sin * axis.y, sin * axis.z]
    }

    #[test]
    fn closed_form_in_the_plane_the_error_is_the_difference_of_angles() {
        for (theta, theta_c) in [(0.0, 0.3), (-0.6, 0.6), (1.2, -1.4), (2.9, 0.1)] {
            let e = tilt_and_twist(about(Vector3::y(), theta), about(Vector3::y(), theta_c));
            assert!((e - V3::new(0.0, theta_c - theta, 0.0)).norm() < 1e-15, "{e:?}");
        }
    }

    /// The heading error does not leak into the tilt error.
    #[test]
    fn closed_form_pure_heading_error_is_all_twist() {
        let e = tilt_and_twist(quaternion_from_euler(0.3, -0.2, 0.1), quaternion_from_euler(0.3, -0.2, 0.1));
        assert!(e.norm() < 1e-15);
        let e = tilt_and_twist(LEVEL, about(Vector3::z(), 2.0));
        assert!((e - V3::new(0.0, 0.0, 2.0)).norm() < 1e-15);
    }

    #[test]
    fn upside_down_and_zero_quaternions_give_numbers() {
        let e = tilt_and_twist(LEVEL, about(Vector3::x(), std::f64::consts::PI));
        assert!((e - V3::new(std::f64::consts::PI, 0.0, 0.0)).norm() < 1e-15);
        assert_eq!(tilt_and_twist([0.0; 4], LEVEL), V3::zero(0.0));
    }

    proptest! {
        /// Turning by the tilt, then by the twist, arrives at the setpoint; the tilt alone brings the thrust
        /// axis there.
        #[test]
        fn prop_tilt_then_twist_is_the_whole_error(
            a in -3.0f64..3.0, b in -1.5f64..1.5, c in -3.0f64..3.0,
            d in -3.0f64..3.0, e in -1.5f64..1.5, f in -3.0f64..3.0, sign in prop::bool::ANY,
        ) {
            let q = quaternion_from_euler(a, b, c);
            let q_sp = quaternion_from_euler(d, e, f).map(|x| if sign { x } else { -x });
            let error = tilt_and_twist(q, q_sp);
            let tilt = Vector3::new(error.x, error.y, 0.0);
            let swing = about(tilt.try_normalize(1e-12).unwrap_or_else(Vector3::x), tilt.norm());
            let down = rotate_ned_from_body(product(q, swing), Vector3::z());
            prop_assert!((down - rotate_ned_from_body(q_sp, Vector3::z())).norm() < 1e-12);
            let all = product(product(q, swing), about(Vector3::z(), error.z));
            let dot: f64 = all.iter().zip(&q_sp).map(|(x, y)| x * y).sum();
            prop_assert!((dot.abs() - 1.0).abs() < 1e-12);
            prop_assert!(tilt.norm() <= std::f64::consts::PI + 1e-12);
        }
    }
}
