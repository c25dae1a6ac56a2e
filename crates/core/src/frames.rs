//! Frames and rotations: the only place that builds a rotation.
//!
//! Frames: **NED** (north, east, down; local, inertial, flat Earth) and **body** (FRD: x forward, y right, z
//! down). A quaternion is Hamilton's, scalar first, and turns body components into NED components:
//! `v_ned = rotate_ned_from_body(q, v_body)`. In files and on the wire it is `[w, x, y, z]`.
//!
//! The rotation matrix is the paper's (7), which is a rotation only for a unit quaternion. Nothing here
//! normalises: the planner optimises over all four numbers, and its derivatives must see the same function
//! that the simulator integrates (the simulator normalises after each step, outside the dynamics).

use nalgebra::{Matrix3, Vector3};

use crate::math;
use crate::real::{Mask as _, Real, straight};
use crate::vector::V3;

/// A quaternion `[w, x, y, z]`, body to NED; not necessarily of unit length.
pub type Quaternion<S = f64> = [S; 4];

/// The identity: body axes along north, east, down.
pub const LEVEL: Quaternion = [1.0, 0.0, 0.0, 0.0];

/// The matrix in (7), `v_body = C(q) v_ned`, by rows. For a non-unit `q` it is `|q|^2` times a rotation.
#[derive(Clone, Copy, Debug)]
pub struct Turn<S>([V3<S>; 3]);

impl<S: Real> Turn<S> {
    /// The matrix of an attitude.
    #[inline(always)]
    pub fn of(q_ned_from_body: Quaternion<S>) -> Self {
        let [q0, q1, q2, q3] = q_ned_from_body;
        Self([
            V3::new(
                q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3,
                (q1 * q2 + q0 * q3) * 2.0,
                (q1 * q3 - q0 * q2) * 2.0,
            ),
            V3::new(
                (q1 * q2 - q0 * q3) * 2.0,
                q0 * q0 - q1 * q1 + q2 * q2 - q3 * q3,
                (q2 * q3 + q0 * q1) * 2.0,
            ),
            V3::new(
                (q1 * q3 + q0 * q2) * 2.0,
                (q2 * q3 - q0 * q1) * 2.0,
                q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3,
            ),
        ])
    }

    /// Body components of a vector given in NED: `C(q) v`.
    #[inline(always)]
    pub fn to_body(&self, v_ned: V3<S>) -> V3<S> {
        let [x, y, z] = self.0;
        V3::new(x.dot(v_ned), y.dot(v_ned), z.dot(v_ned))
    }

    /// NED components of a vector given in body axes: `C(q)^T v`. Differs from the paper: (7) writes the
    /// inverse, which is the same for a unit quaternion and has no business in the derivatives of a non-unit
    /// one.
    #[inline(always)]
    pub fn to_ned(&self, v_body: V3<S>) -> V3<S> {
        let [x, y, z] = self.0;
        x * v_body.x + y * v_body.y + z * v_body.z
    }
}

/// The matrix in (7): `v_body = C(q) v_ned`. For a non-unit `q` it is `|q|^2` times a rotation.
#[inline(always)]
pub fn dcm_body_from_ned(q: Quaternion) -> Matrix3<f64> {
    let rows = Turn::of(q).0.map(|row| Vector3::from(row).transpose());
    Matrix3::from_rows(&rows)
}

/// Body components of a vector given in NED: `C(q) v`, (7).
#[inline(always)]
pub fn rotate_body_from_ned(q: Quaternion, v_ned: Vector3<f64>) -> Vector3<f64> {
    Turn::of(q).to_body(v_ned.into()).into()
}

/// NED components of a vector given in body axes: [`Turn::to_ned`].
#[inline(always)]
pub fn rotate_ned_from_body(q: Quaternion, v_body: Vector3<f64>) -> Vector3<f64> {
    Turn::of(q).to_ned(v_body.into()).into()
}

/// Time derivative of the attitude quaternion, (2): `1/2 Omega(omega) q`, body rates in rad/s.
#[inline(always)]
pub fn quaternion_rate<S: Real>(q: Quaternion<S>, omega_body: V3<S>) -> Quaternion<S> {
    let [q0, q1, q2, q3] = q;
    let (p, r_q, r) = (omega_body.x, omega_body.y, omega_body.z);
    [
        (-(p * q1) - r_q * q2 - r * q3) * 0.5,
        (p * q0 + r * q2 - r_q * q3) * 0.5,
        (r_q * q0 - r * q1 + p * q3) * 0.5,
        (r * q0 + r_q * q1 - p * q2) * 0.5,
    ]
}

/// Hamilton's product: `q_a_from_c = product(q_a_from_b, q_b_from_c)`.
#[inline(always)]
pub fn product<S: Real>(a: Quaternion<S>, b: Quaternion<S>) -> Quaternion<S> {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// The conjugate: the opposite rotation.
#[inline(always)]
pub fn conjugate<S: Real>(q: Quaternion<S>) -> Quaternion<S> {
    [q[0], -q[1], -q[2], -q[3]]
}

/// `q` scaled to unit length.
#[inline(always)]
pub fn normalized<S: Real>(q: Quaternion<S>) -> Quaternion<S> {
    let length2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    let per_length = length2.of(1.0) / length2.sqrt();
    [q[0] * per_length, q[1] * per_length, q[2] * per_length, q[3] * per_length]
}

/// Roll, pitch, yaw [rad] to a quaternion (rotations in the order yaw, pitch, roll).
#[inline(always)]
pub fn quaternion_from_euler<S: Real>(roll: S, pitch: S, yaw: S) -> Quaternion<S> {
    let (sr, cr) = straight::sin_cos(roll * 0.5);
    let (sp, cp) = straight::sin_cos(pitch * 0.5);
    let (sy, cy) = straight::sin_cos(yaw * 0.5);
    [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
}

/// The rotation by `|rotation|` [rad] about its direction: the exponential map, Sola (2017), (101).
pub fn quaternion_from_rotation_vector(rotation: Vector3<f64>) -> Quaternion {
    let half = 0.5 * rotation.norm();
    // sin(x) / x, which is 1 to the last bit where the division would fail.
    let sinc = if half < 1e-9 { 1.0 } else { math::sin(half) / half };
    let v = rotation * (0.5 * sinc);
    [math::cos(half), v.x, v.y, v.z]
}

/// The rotation vector [rad] of a unit quaternion, at most pi long: the inverse of
/// [`quaternion_from_rotation_vector`].
pub fn rotation_vector(q: Quaternion) -> Vector3<f64> {
    // q and -q are one rotation: the shorter way round.
    let [w, x, y, z] = if q[0] < 0.0 { q.map(|c| -c) } else { q };
    let v = Vector3::new(x, y, z);
    let sin = v.norm();
    if sin < 1e-12 { v * 2.0 } else { v * (2.0 * math::atan2(sin, w) / sin) }
}

/// Roll [rad], in (-pi, pi].
#[inline(always)]
pub fn roll<S: Real>(q: Quaternion<S>) -> S {
    let one = q[0].of(1.0);
    ((q[0] * q[1] + q[2] * q[3]) * 2.0).atan2(one - (q[1] * q[1] + q[2] * q[2]) * 2.0)
}

/// Lateral parts of a quaternion below this are the rounding of planar flight: sums over the rotors cancel to
/// 1e-16 only. The two formulas of [`pitch`] differ by its square.
const PLANAR_TOLERANCE: f64 = 1e-9;

/// Pitch [rad]. Without lateral motion (`q1 = q3 = 0` but for rounding) it is `2 atan2(q2, q0)`, which counts
/// through the vertical and beyond, as the paper's planar angle does; otherwise Euler's, within +-pi/2.
#[inline(always)]
pub fn pitch<S: Real>(q: Quaternion<S>) -> S {
    pitch_and_bank(q).0
}

/// Roll [rad] as a companion of [`pitch`]: zero without lateral motion, also beyond the vertical; otherwise
/// [`roll`].
#[inline(always)]
pub fn bank<S: Real>(q: Quaternion<S>) -> S {
    pitch_and_bank(q).1
}

/// [`pitch`] and [`bank`] [rad].
#[inline(always)]
pub fn pitch_and_bank<S: Real>(q: Quaternion<S>) -> (S, S) {
    let zero = q[0].of(0.0);
    let planar = q[3].abs().at_least(q[1].abs()).less(zero.of(PLANAR_TOLERANCE));
    if planar.all() {
        return (q[2].atan2(q[0]) * 2.0, zero);
    }
    let (pitch, roll) = (straight::asin((q[0] * q[2] - q[3] * q[1]) * 2.0), roll(q));
    if !planar.any() {
        return (pitch, roll);
    }
    (S::select(planar, q[2].atan2(q[0]) * 2.0, pitch), S::select(planar, zero, roll))
}

/// Angle between the body's up axis and the vertical [rad], in [0, pi].
#[inline(always)]
pub fn tilt<S: Real>(q: Quaternion<S>) -> S {
    let zero = q[0].of(0.0);
    let up_ned = Turn::of(q).to_ned(-V3::new(zero, zero, zero.of(1.0)));
    straight::acos(-up_ned.z)
}

/// Yaw (heading) [rad], in (-pi, pi], north to east positive.
pub fn yaw(q: Quaternion) -> f64 {
    straight::atan2(2.0 * (q[0] * q[3] + q[1] * q[2]), 1.0 - 2.0 * (q[2] * q[2] + q[3] * q[3]))
}

/// An angle folded into [-pi, pi).
#[inline(always)]
pub fn wrap_pi<S: Real>(angle: S) -> S {
    use std::f64::consts::{PI, TAU};
    angle - ((angle + PI) * (1.0 / TAU)).floor() * TAU
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    #[test]
    fn closed_form_pitch_up_turns_the_nose_above_the_horizon() {
        let q = quaternion_from_euler(0.0, 0.3, 0.0);
        let nose_ned = rotate_ned_from_body(q, Vector3::x());
        assert_relative_eq!(
            nose_ned,
            Vector3::new(math::cos(0.3f64), 0.0, -(math::sin(0.3f64))),
            epsilon = 1e-15
        );
    }

    #[test]
    fn closed_form_positive_yaw_turns_the_nose_east() {
        let q = quaternion_from_euler(0.0, 0.0, 0.5);
        let nose_ned = rotate_ned_from_body(q, Vector3::x());
        assert!(nose_ned.y > 0.0);
    }

    #[test]
    fn closed_form_planar_pitch_counts_through_the_vertical() {
        let q = [math::cos(2.0f64 / 2.0), 0.0, math::sin(2.0f64 / 2.0), 0.0];
        assert_relative_eq!(pitch(q), 2.0, epsilon = 1e-15);
    }

    proptest! {
        #[test]
        fn prop_euler_angles_come_back(r in -3.0f64..3.0, p in -1.5f64..1.5, y in -3.0f64..3.0) {
            let q = quaternion_from_euler(r, p, y);
            prop_assert!((roll(q) - r).abs() < 1e-9);
            prop_assert!((pitch(q) - p).abs() < 1e-9);
            prop_assert!((yaw(q) - y).abs() < 1e-9);
        }

        #[test]
        fn prop_rotation_vectors_come_back(x in -1.7f64..1.7, y in -1.7f64..1.7, z in -1.7f64..1.7) {
            let v = Vector3::new(x, y, z);
            let q = quaternion_from_rotation_vector(v);
            prop_assert!((normalized(q)[0] - q[0]).abs() < 1e-15);
            prop_assert!((rotation_vector(q) - v).norm() < 1e-12);
            prop_assert!((rotation_vector(q.map(|c| -c)) - v).norm() < 1e-12);
        }

        #[test]
        fn prop_rotation_round_trip(r in -3.0f64..3.0, p in -1.5f64..1.5, y in -3.0f64..3.0,
                                    a in -9.0f64..9.0, b in -9.0f64..9.0, c in -9.0f64..9.0) {
            let q = quaternion_from_euler(r, p, y);
            let v = Vector3::new(a, b, c);
            let back = rotate_body_from_ned(q, rotate_ned_from_body(q, v));
            prop_assert!((back - v).norm() < 1e-13);
        }

        /// (2) is the derivative of the attitude: d/dt (C^T b) = C^T (omega x b) for a body-fixed b.
        #[test]
        fn prop_quaternion_rate_turns_body_vectors(
            r in -3.0f64..3.0, p in -1.4f64..1.4, y in -3.0f64..3.0,
            wx in -2.0f64..2.0, wy in -2.0f64..2.0, wz in -2.0f64..2.0,
        ) {
            let q = quaternion_from_euler(r, p, y);
            let omega = Vector3::new(wx, wy, wz);
            let rate = quaternion_rate(q, omega.into());
            let h = 1e-6;
            let step = |s: f64| std::array::from_fn(|i| q[i] + s * h * rate[i]);
            let b = Vector3::new(0.3, -0.7, 0.2);
            let turned = |s: f64| rotate_ned_from_body(step(s), b);
            let numeric = (turned(1.0) - turned(-1.0)) / (2.0 * h);
            prop_assert!((numeric - rotate_ned_from_body(q, omega.cross(&b))).norm() < 1e-8);
        }
    }
}
