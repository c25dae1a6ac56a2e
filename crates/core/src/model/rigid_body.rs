//! The rigid body, (1)-(8): how forces and moments move it.
//!
//! Assumptions: flat, non-rotating planet; constant mass and inertia; one rigid body. Rotors enter as forces
//! and moments, with their angular momentum in `M_rot` (22) when it is switched on.
//!
//! Differs from the paper: its gravity term below (9) lacks the mass; here gravity is an
//! acceleration, `[0 0 g]`.

use nalgebra::{Matrix3, Vector3};

use crate::frames::{Quaternion, quaternion_rate, rotate_ned_from_body};
use crate::real::Real;

/// State of the rigid body: position, attitude, velocity and body rates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState<S = f64> {
    /// Position from the point of release, NED [m].
    pub p_ned: Vector3<S>,
    /// Attitude, body to NED, scalar first.
    pub q_ned_from_body: Quaternion<S>,
    /// Velocity over ground, NED [m/s].
    pub v_ned: Vector3<S>,
    /// Body rates [P Q R] [rad/s].
    pub omega_body: Vector3<S>,
}

/// Time derivative of a [`BodyState`], field by field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyRate<S = f64> {
    /// Derivative of the position, NED [m/s], (1).
    pub p_dot_ned: Vector3<S>,
    /// Quaternion rate [1/s], (2).
    pub q_dot: Quaternion<S>,
    /// Acceleration, NED [m/s^2], (3).
    pub v_dot_ned: Vector3<S>,
    /// Angular acceleration, body [rad/s^2], (4).
    pub omega_dot_body: Vector3<S>,
}

impl Default for BodyRate {
    fn default() -> Self {
        let zero = Vector3::zeros();
        Self { p_dot_ned: zero, q_dot: [0.0; 4], v_dot_ned: zero, omega_dot_body: zero }
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

fn lift<S: Real>(m: &Matrix3<f64>) -> Matrix3<S> {
    m.map(S::from_f64)
}

/// Derivative of the state under a body force [N] and moment [N m] (body axes, gravity excluded):
/// (1)-(4) with `v_dot = C^T F/m + [0 0 g]` and `omega_dot = J^-1 (M - omega x J omega)`.
#[inline(always)]
pub fn derivative<S: Real>(
    mass: &MassProperties,
    gravity_m_s2: f64,
    state: &BodyState<S>,
    force_body: Vector3<S>,
    moment_body: Vector3<S>,
) -> BodyRate<S> {
    let omega = state.omega_body;
    let mut v_dot = rotate_ned_from_body(state.q_ned_from_body, force_body * S::from_f64(1.0 / mass.mass_kg));
    v_dot.z += S::from_f64(gravity_m_s2);
    let momentum = lift::<S>(&mass.inertia_kg_m2) * omega;
    BodyRate {
        p_dot_ned: state.v_ned,
        q_dot: quaternion_rate(state.q_ned_from_body, omega),
        v_dot_ned: v_dot,
        omega_dot_body: lift::<S>(&mass.inertia_inverse) * (moment_body - omega.cross(&momentum)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
