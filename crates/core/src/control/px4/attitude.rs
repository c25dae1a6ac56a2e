//! Thrust vector to attitude (`ControlMath::thrustToAttitude`, `bodyzToAttitude`), attitude error to body
//! rates (`AttitudeControl::update`; Brescianini, Hehn and D'Andrea, "Nonlinear Quadrocopter Attitude
//! Control", 2013).

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::Parameters;
use crate::frames::{Quaternion, conjugate, dcm_body_from_ned, product};
use crate::math;
use crate::units::RAD_PER_DEG;

/// FLT_EPSILON, below which PX4 sees no thrust.
const NO_THRUST: f64 = 1.192_092_9e-7;

/// The attitude that points the rotors along a thrust (NED, not zero) with a heading [rad].
pub fn attitude_for(thrust_ned: Vector3<f64>, yaw_rad: f64) -> Quaternion {
    let z = if thrust_ned.norm_squared() < NO_THRUST { Vector3::z() } else { -thrust_ned.normalize() };
    let y_of_heading = Vector3::new(-math::sin(yaw_rad), math::cos(yaw_rad), 0.0);
    let mut x = y_of_heading.cross(&z);
    if z.z < 0.0 {
        x = -x;
    }
    if z.z.abs() < 1e-6 {
        x = Vector3::z();
    }
    let x = x.normalize();
    let ned_from_body = Matrix3::from_columns(&[x, z.cross(&x), z]);
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(ned_from_body));
    [q.w, q.i, q.j, q.k]
}

/// Body rates [rad/s] for an attitude and its setpoint, and rates that are fed forward [rad/s].
pub fn rates_for(p: &Parameters, q: Quaternion, q_sp: Quaternion, fed_forward: Vector3<f64>) -> Vector3<f64> {
    let z_ned = |q: Quaternion| dcm_body_from_ned(q).row(2).transpose();
    let between = shortest(z_ned(q), z_ned(q_sp));
    let opposite = 1.0 - 1e-5;
    let reduced =
        if between[1].abs() > opposite || between[2].abs() > opposite { q_sp } else { product(between, q) };
    let weight = p.yaw_weight.clamp(0.0, 1.0);
    // What the full setpoint adds to the reduced one: a turn about the body's z axis.
    let mix = canonical(product(conjugate(reduced), q_sp));
    let half = [math::acos(mix[0].clamp(-1.0, 1.0)), math::asin(mix[3].clamp(-1.0, 1.0))].map(|x| weight * x);
    let wanted = product(reduced, [math::cos(half[0]), 0.0, 0.0, math::sin(half[1])]);
    let error = canonical(product(conjugate(q), wanted));
    let yaw_p = if weight > 1e-4 { p.yaw_p / weight } else { p.yaw_p };
    let gain = Vector3::new(p.roll_p, p.pitch_p, yaw_p);
    let error = Vector3::new(error[1], error[2], error[3]) * 2.0;
    let rates = error.component_mul(&gain) + fed_forward;
    let limit = Vector3::new(p.rollrate_max_deg_s, p.pitchrate_max_deg_s, p.yawrate_max_deg_s) * RAD_PER_DEG;
    rates.zip_map(&limit, |rate, limit| rate.max(-limit).min(limit))
}

/// The scalar part not negative: q and -q are one rotation.
pub(super) fn canonical(q: Quaternion) -> Quaternion {
    if q[0] < 0.0 { q.map(|c| -c) } else { q }
}

/// The shortest rotation of one direction to another; by half a turn about x or y where they are opposite
/// (`Quatf(src, dst)`).
fn shortest(from: Vector3<f64>, to: Vector3<f64>) -> Quaternion {
    let across = from.cross(&to);
    let along = from.dot(&to);
    if across.norm() < 1e-5 && along < 0.0 {
        let axis = if from.x.abs() < from.y.abs() { Vector3::x() } else { Vector3::y() };
        let axis = from.cross(&axis).normalize();
        return [0.0, axis.x, axis.y, axis.z];
    }
    let w = along + (from.norm_squared() * to.norm_squared()).sqrt();
    crate::frames::normalized([w, across.x, across.y, across.z])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{LEVEL, pitch, quaternion_from_euler, roll, yaw};

    /// Closed form: thrust up and forward at 45 deg is a pitch of -45 deg, whatever the heading.
    #[test]
    fn closed_form_the_attitude_of_a_thrust() {
        for heading in [0.0, 1.0, -2.0] {
            let (sin, cos) = math::sin_cos(heading);
            let q = attitude_for(Vector3::new(0.3 * cos, 0.3 * sin, -0.3), heading);
            assert!((pitch(q) + std::f64::consts::FRAC_PI_4).abs() < 1e-12);
            assert!(roll(q).abs() < 1e-12 && (yaw(q) - heading).abs() < 1e-12);
        }
        assert_eq!(attitude_for(Vector3::zeros(), 0.0), LEVEL);
    }

    /// Closed form: a tilt error alpha asks for P 2 sin(alpha/2); of a yaw error only the weight counts, and
    /// its gain is divided by it.
    #[test]
    fn closed_form_rates_of_an_error() {
        let p = Parameters::default();
        let rates = rates_for(&p, quaternion_from_euler(0.0, 0.3, 0.0), LEVEL, Vector3::zeros());
        let expected = -6.5 * 2.0 * math::sin(0.15);
        assert!((rates - Vector3::y() * expected).norm() < 1e-12, "{rates}");
        let rates = rates_for(&p, LEVEL, quaternion_from_euler(0.0, 0.0, 0.2), Vector3::zeros());
        let expected = 2.8 / 0.4 * 2.0 * math::sin(0.5 * 0.4 * 0.2);
        assert!((rates - Vector3::z() * expected).norm() < 1e-12, "{rates}");
        let rates = rates_for(&p, LEVEL, quaternion_from_euler(1.5, 0.0, 0.0), Vector3::z() * 0.3);
        assert!((rates - Vector3::new(220.0 * RAD_PER_DEG, 0.0, 0.3)).norm() < 1e-12, "{rates}");
    }
}
