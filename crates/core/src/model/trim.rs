//! Trim: the steady state at a commanded velocity, found by solving for it.
//!
//! Unknowns are roll, pitch and the thrusts; the equations are zero acceleration and zero angular
//! acceleration at zero rates, at the given heading. Newton's method with minimum-norm steps copes with more
//! rotors than needed, and with a yaw moment that nothing can produce (reaction torques off).

use nalgebra::{DMatrix, DVector, Vector3};

use super::rigid_body::BodyState;
use super::{Environment, PerRotor, Vehicle};
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
    /// Every rotor's torque turns the vehicle the same way.
    #[error(
        "no steady flight about yaw: the rotors' torques do not cancel, for each of them turns the vehicle the same way; some \
         that turn clockwise and some counter-clockwise (spin_from_above) are expected"
    )]
    Yaw,
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
/// [`TrimError::NoSolution`] when Newton's method does not reach a residual of 1e-9, [`TrimError::Yaw`] when
/// that is because all rotors turn the vehicle the same way.
pub fn trim(
    vehicle: &Vehicle,
    environment: &Environment,
    v_ned: Vector3<f64>,
    heading_rad: f64,
) -> Result<Trim, TrimError> {
    let equations = Equations { vehicle, environment, v_ned, heading_rad };
    let (unknowns, r) = equations.solve();
    if !(r.amax() < 1e-9) || unknowns[0].abs() > 1.5 || unknowns[1].abs() > 1.5 {
        let yaw = |i: usize| vehicle.moment_per_thrust(i, environment.density_kg_m3).z;
        let mut rotors = 0..vehicle.rotors.len();
        if rotors.clone().all(|i| yaw(i) > 0.0) || rotors.all(|i| yaw(i) < 0.0) {
            return Err(TrimError::Yaw);
        }
        return Err(TrimError::NoSolution {
            v_ned_m_s: v_ned.into(),
            residual: r.amax(),
            pitch_deg: unknowns[1] * crate::units::DEG_PER_RAD,
            roll_deg: unknowns[0] * crate::units::DEG_PER_RAD,
        });
    }
    Ok(Trim {
        q_ned_from_body: equations.attitude(&unknowns),
        v_ned,
        roll_rad: unknowns[0],
        pitch_rad: unknowns[1],
        thrust_n: equations.thrust_n(&unknowns),
        residual: r.amax(),
    })
}

/// The equations of steady flight, in roll, pitch and the thrusts over the hover thrust, so that all unknowns
/// are of order one.
struct Equations<'a> {
    vehicle: &'a Vehicle,
    environment: &'a Environment,
    v_ned: Vector3<f64>,
    heading_rad: f64,
}

impl Equations<'_> {
    fn attitude(&self, unknowns: &DVector<f64>) -> Quaternion {
        quaternion_from_euler(unknowns[0], unknowns[1], self.heading_rad)
    }

    fn thrust_n(&self, unknowns: &DVector<f64>) -> PerRotor {
        let n = self.vehicle.rotors.len();
        let hover = self.vehicle.mass.mass_kg * self.environment.gravity_m_s2 / n as f64;
        std::array::from_fn(|i| if i < n { hover * unknowns[2 + i] } else { 0.0 })
    }

    /// Acceleration [m/s^2] and angular acceleration [rad/s^2], which are to vanish.
    fn residual(&self, unknowns: &DVector<f64>) -> DVector<f64> {
        let state = BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: self.attitude(unknowns),
            v_ned: self.v_ned,
            omega_body: Vector3::zeros(),
        };
        let thrust_n = &self.thrust_n(unknowns)[..self.vehicle.rotors.len()];
        let rate = self.vehicle.thrust_derivative(self.environment, &state, thrust_n);
        DVector::from_iterator(6, rate.v_dot_ned.iter().chain(rate.omega_dot_body.iter()).copied())
    }

    /// The residual's Jacobian by central differences.
    fn jacobian(&self, unknowns: &DVector<f64>) -> DMatrix<f64> {
        let h = 1e-6;
        let mut jacobian = DMatrix::zeros(6, unknowns.len());
        for j in 0..unknowns.len() {
            let probe = |s: f64| {
                let mut z = unknowns.clone();
                z[j] += s;
                self.residual(&z)
            };
            jacobian.set_column(j, &((probe(h) - probe(-h)) / (2.0 * h)));
        }
        jacobian
    }

    /// Newton's method with minimum-norm steps from level hover: where it stopped, and the residual there.
    fn solve(&self) -> (DVector<f64>, DVector<f64>) {
        let mut unknowns = DVector::from_element(2 + self.vehicle.rotors.len(), 1.0);
        unknowns.rows_mut(0, 2).fill(0.0);
        let mut r = self.residual(&unknowns);
        for _ in 0..50 {
            if r.amax() < 1e-14 {
                break;
            }
            let jacobian = self.jacobian(&unknowns);
            if !jacobian.iter().chain(r.iter()).all(|x| x.is_finite()) {
                break;
            }
            let Some(svd) = jacobian.try_svd(true, true, f64::EPSILON, 500) else { break };
            let Ok(step) = svd.solve(&r, 1e-9) else { break };
            // Attitude moves by at most a quarter turn, thrust by a few hover thrusts a step.
            let scale = (1.0 / step.amax()).min(1.0);
            let next = &unknowns - step * scale;
            let next_r = self.residual(&next);
            if !next_r.iter().all(|x| x.is_finite())
                || (scale == 1.0 && next_r.amax() >= r.amax() && r.amax() < 1e-10)
            {
                break;
            }
            (unknowns, r) = (next, next_r);
        }
        (unknowns, r)
    }
}
