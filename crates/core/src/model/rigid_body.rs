//! The rigid body, (1)-(8): how forces and moments move it.
//!
//! Assumptions: flat, non-rotating planet; constant mass and inertia; one rigid body. Rotors enter as forces
//! and moments, with their angular momentum in `M_rot` (22) when it is switched on.
//!
//! Differs from the paper: its gravity term below (9) lacks the mass; here gravity is an
//! acceleration, `[0 0 g]`.

use nalgebra::{Matrix3, Vector3};

use crate::frames::{Quaternion, Turn, quaternion_rate};
use crate::real::Real;
use crate::vector::V3;

/// State of the rigid body: position, attitude, velocity and body rates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState {
    /// Position from the point of release, NED [m].
    pub p_ned: Vector3<f64>,
    /// Attitude, body to NED, scalar first.
    pub q_ned_from_body: Quaternion,
    /// Velocity over ground, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Body rates [P Q R] [rad/s].
    pub omega_body: Vector3<f64>,
}

/// Time derivative of a [`BodyState`], field by field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyRate {
    /// Derivative of the position, NED [m/s], (1).
    pub p_dot_ned: Vector3<f64>,
    /// Quaternion rate [1/s], (2).
    pub q_dot: Quaternion,
    /// Acceleration, NED [m/s^2], (3).
    pub v_dot_ned: Vector3<f64>,
    /// Angular acceleration, body [rad/s^2], (4).
    pub omega_dot_body: Vector3<f64>,
}

/// What of a [`BodyState`] its own derivative depends on, over any [`Real`].
#[derive(Clone, Copy, Debug)]
pub struct Motion<S> {
    /// Attitude, body to NED, scalar first.
    pub q_ned_from_body: Quaternion<S>,
    /// Velocity over ground, NED [m/s].
    pub v_ned: V3<S>,
    /// Body rates [P Q R] [rad/s].
    pub omega_body: V3<S>,
}

/// Time derivative of a [`Motion`], field by field.
#[derive(Clone, Copy, Debug)]
pub struct MotionRate<S> {
    /// Quaternion rate [1/s], (2).
    pub q_dot: Quaternion<S>,
    /// Acceleration, NED [m/s^2], (3).
    pub v_dot_ned: V3<S>,
    /// Angular acceleration, body [rad/s^2], (4).
    pub omega_dot_body: V3<S>,
}

impl BodyState {
    /// The motion of the body.
    #[inline(always)]
    pub fn motion(&self) -> Motion<f64> {
        Motion {
            q_ned_from_body: self.q_ned_from_body,
            v_ned: self.v_ned.into(),
            omega_body: self.omega_body.into(),
        }
    }

    /// The derivative of the state, by that of its motion.
    #[inline(always)]
    pub fn rate(&self, motion: &MotionRate<f64>) -> BodyRate {
        BodyRate {
            p_dot_ned: self.v_ned,
            q_dot: motion.q_dot,
            v_dot_ned: motion.v_dot_ned.into(),
            omega_dot_body: motion.omega_dot_body.into(),
        }
    }
}

/// Mass and inertia of the vehicle, with the inverse of the inertia.
#[derive(Clone, Debug, PartialEq)]
pub struct MassProperties {
    /// Mass [kg].
    pub mass_kg: f64,
    /// Inertia about the centre of mass, body axes [kg m^2].
    pub inertia_kg_m2: Matrix3<f64>,
    /// Inverse of the inertia matrix, body axes [1/(kg m^2)].
    pub inertia_inverse: Matrix3<f64>,
}

impl MassProperties {
    /// Checks mass [kg] and inertia matrix [kg m^2] and inverts the latter.
    ///
    /// # Errors
    /// [`super::ModelError`] when the mass is not positive, the matrix is not symmetric positive definite, or
    /// the principal inertias break the triangle inequality.
    pub fn new(mass_kg: f64, inertia_kg_m2: Matrix3<f64>) -> Result<Self, super::ModelError> {
        super::check_positive("mass", mass_kg)?;
        let asymmetry = (inertia_kg_m2 - inertia_kg_m2.transpose()).amax();
        let symmetric = asymmetry <= 1e-9 * inertia_kg_m2.amax();
        super::check(symmetric, "inertia", "a symmetric matrix", asymmetry)?;
        let principal = inertia_kg_m2.symmetric_eigenvalues();
        for p in principal.iter() {
            super::check_positive("principal inertia", *p)?;
        }
        let sum: f64 = principal.iter().sum();
        if principal.iter().any(|p| 2.0 * p > sum * (1.0 + 1e-12)) {
            return Err(super::ModelError::InertiaTriangle([principal[0], principal[1], principal[2]]));
        }
        let inertia_inverse = inertia_kg_m2.try_inverse().ok_or(super::ModelError::OutOfRange {
            what: "determinant of the inertia",
            expected: "positive",
            value: 0.0,
        })?;
        Ok(Self { mass_kg, inertia_kg_m2, inertia_inverse })
    }
}

/// Derivative of the motion under a body force [N] and moment [N m] (body axes, gravity excluded): (1)-(4)
/// with `v_dot = C^T F/m + [0 0 g]` and `omega_dot = J^-1 (M - omega x J omega)`. `turn` is the attitude's.
#[inline(always)]
pub fn derivative<S: Real>(
    mass: &MassProperties,
    gravity_m_s2: S,
    motion: &Motion<S>,
    turn: &Turn<S>,
    force_body: V3<S>,
    moment_body: V3<S>,
) -> MotionRate<S> {
    let omega = motion.omega_body;
    let mut v_dot = turn.to_ned(force_body * gravity_m_s2.of(1.0 / mass.mass_kg));
    v_dot.z += gravity_m_s2;
    let momentum = omega.times(&mass.inertia_kg_m2);
    MotionRate {
        q_dot: quaternion_rate(motion.q_ned_from_body, omega),
        v_dot_ned: v_dot,
        omega_dot_body: (moment_body - omega.cross(momentum)).times(&mass.inertia_inverse),
    }
}

/// Angular acceleration under a body moment [N m] of a body whose inertia is `F J F`: J the known one, F
/// diagonal with these roots of the factors on the moments of inertia.
#[inline(always)]
pub fn turned<S: Real>(mass: &MassProperties, roots: V3<S>, omega: V3<S>, moment_body: V3<S>) -> V3<S> {
    let momentum = by(by(omega, roots).times(&mass.inertia_kg_m2), roots);
    let one = omega.x.of(1.0);
    let over = V3::new(one / roots.x, one / roots.y, one / roots.z);
    by(by(moment_body - omega.cross(momentum), over).times(&mass.inertia_inverse), over)
}

/// A vector with each component times another's.
#[inline(always)]
fn by<S: Real>(v: V3<S>, factors: V3<S>) -> V3<S> {
    V3::new(v.x * factors.x, v.y * factors.y, v.z * factors.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body that is off is the body of the inertia that it has then.
    #[test]
    fn closed_form_factors_on_the_inertia() {
        let inertia = Matrix3::new(2.0, 0.1, -0.2, 0.1, 2.5, 0.3, -0.2, 0.3, 3.0);
        let roots = Vector3::new(1.1, 0.9, 1.05);
        let known = MassProperties::new(1.0, inertia).unwrap();
        let off = Matrix3::from_fn(|i, j| roots[i] * inertia[(i, j)] * roots[j]);
        let (omega, moment) = (Vector3::new(0.3, -2.0, 1.2), Vector3::new(4.0, 1.0, -2.0));
        let expected = off.try_inverse().unwrap() * (moment - omega.cross(&(off * omega)));
        let found = Vector3::from(turned(&known, roots.into(), omega.into(), moment.into()));
        assert!((found - expected).norm() < 1e-13, "{found} {expected}");
    }

    #[test]
    fn inertia_must_be_possible() {
        let bad = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 2.5));
        assert!(matches!(MassProperties::new(1.0, bad), Err(super::super::ModelError::InertiaTriangle(_))));
        let flat = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 2.0));
        assert!(MassProperties::new(1.0, flat).is_ok(), "a flat plate is the limit and allowed");
        assert!(MassProperties::new(-1.0, flat).is_err());
        assert!(MassProperties::new(f64::NAN, flat).is_err());
    }
}
