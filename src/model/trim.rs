//! Trim: the steady state at a commanded velocity, found by solving for it.
//!
//! Unknowns are roll, pitch and the thrusts; the equations are zero acceleration and zero angular
//! acceleration at zero rates, at the given heading. Newton's method with minimum-norm steps copes with more
//! rotors than needed, and with a yaw moment that nothing can produce (reaction torques off).

use nalgebra::{DMatrix, DVector, Vector3};

use super::rigid_body::BodyState;
use super::{Environment, MAX_ROTORS, PerRotor, Vehicle};
use crate::frames::{Quaternion, quaternion_from_euler};

/// A steady flight condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trim {
    /// Attitude, body to NED.
    pub q_ned_from_body: Quaternion,
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Roll [rad].
    pub roll_rad: f64,
    /// Pitch [rad].
    pub pitch_rad: f64,
    /// Thrust of each rotor [N].
    pub thrust_n: PerRotor,
    /// Largest remaining acceleration [m/s^2 or rad/s^2].
    pub residual: f64,
}

/// Why there is no trim.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrimError {
    /// The equations have no solution near level flight.
    #[error(
        "no steady flight at v_ned = [{:.3} {:.3} {:.3}] m/s: the best balance leaves {residual:.3e} m/s^2 \
         (pitch {pitch_deg:.1} deg, roll {roll_deg:.1} deg)",
        v_ned_m_s[0], v_ned_m_s[1], v_ned_m_s[2]
    )]
    NoSolution {
        /// The commanded velocity, NED [m/s].
        v_ned_m_s: [f64; 3],
        /// Largest remaining acceleration.
        residual: f64,
        /// Pitch where the search stopped [deg].
        pitch_deg: f64,
        /// Roll where the search stopped [deg].
        roll_deg: f64,
    },
}

/// Steady state at `v_ned` [m/s] with the given heading [rad].
///
/// Thrusts may come out negative or beyond what a rotor can give: whether they are within limits is the
/// caller's question (the planner asks it).
///
/// # Errors
/// [`TrimError::NoSolution`] when Newton's method does not reach a residual of 1e-9.
pub fn trim(
    vehicle: &Vehicle,
    environment: &Environment,
    v_ned: Vector3<f64>,
    heading_rad: f64,
) -> Result<Trim, TrimError> {
    let n = vehicle.rotors.len();
    let hover = vehicle.mass.mass_kg * environment.gravity_m_s2 / n as f64;
    // Thrusts in units of the hover thrust, so that all unknowns are of order one.
    let mut unknowns = DVector::zeros(2 + n);
    unknowns.rows_mut(2, n).fill(1.0);
    let state = |z: &DVector<f64>| BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: quaternion_from_euler(z[0], z[1], heading_rad),
        v_ned,
        omega_body: Vector3::zeros(),
    };
    let residual = |z: &DVector<f64>| {
        let mut thrust = [0.0; MAX_ROTORS];
        for i in 0..n {
            thrust[i] = hover * z[2 + i];
        }
        let rate = vehicle.thrust_derivative(environment, &state(z), &thrust[..n]);
        DVector::from_iterator(6, rate.v_dot_ned.iter().chain(rate.omega_dot_body.iter()).copied())
    };
    let mut r = residual(&unknowns);
    for _ in 0..50 {
        if r.amax() < 1e-14 {
            break;
        }
        let mut jacobian = DMatrix::zeros(6, 2 + n);
        let h = 1e-6;
        for j in 0..2 + n {
            let probe = |s: f64| {
                let mut z = unknowns.clone();
                z[j] += s;
                residual(&z)
            };
            let column = (probe(h) - probe(-h)) / (2.0 * h);
            jacobian.set_column(j, &column);
        }
        if !jacobian.iter().chain(r.iter()).all(|x| x.is_finite()) {
            break;
        }
        let Some(svd) = jacobian.try_svd(true, true, f64::EPSILON, 500) else { break };
        let Ok(step) = svd.solve(&r, 1e-9) else { break };
        // Attitude moves by at most a quarter turn, thrust by a few hover thrusts a step.
        let scale = (1.0 / step.amax()).min(1.0);
        let next = &unknowns - step * scale;
        let next_r = residual(&next);
        if !next_r.iter().all(|x| x.is_finite())
            || (scale == 1.0 && next_r.amax() >= r.amax() && r.amax() < 1e-10)
        {
            break;
        }
        (unknowns, r) = (next, next_r);
    }
    if !(r.amax() < 1e-9) || unknowns[0].abs() > 1.5 || unknowns[1].abs() > 1.5 {
        return Err(TrimError::NoSolution {
            v_ned_m_s: v_ned.into(),
            residual: r.amax(),
            pitch_deg: unknowns[1] * crate::units::DEG_PER_RAD,
            roll_deg: unknowns[0] * crate::units::DEG_PER_RAD,
        });
    }
    let mut thrust_n = [0.0; MAX_ROTORS];
    for i in 0..n {
        thrust_n[i] = hover * unknowns[2 + i];
    }
    Ok(Trim {
        q_ned_from_body: state(&unknowns).q_ned_from_body,
        v_ned,
        roll_rad: unknowns[0],
        pitch_rad: unknowns[1],
        thrust_n,
        residual: r.amax(),
    })
}
