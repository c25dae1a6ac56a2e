//! The controller's model of the vehicle: mass, inertia, gravity, the rotors' thrust limit and their
//! allocation.
//!
//! It knows no aerodynamics and no actuator dynamics; thrust is taken as what a rotor gives in still air,
//! `T = T_static throttle^2`, or a line that meets it at hover ([`ThrustCurve`]). Of a rotor in another's
//! wake that is the thrust that it would give alone, and
//! its interference is in the allocation: as PX4's allocator does with CA_ROTORn_CT, the better rotor gets
//! more.

use nalgebra::{Matrix3, Matrix4, SMatrix};

use super::mixer::Mixer;
use super::{ControlError, ThrustCurve};
use crate::model::{Environment, MAX_ROTORS, Vehicle};

/// The controller's model of the vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct Airframe {
    /// Mass [kg].
    pub mass_kg: f64,
    /// Inertia, body axes [kg m^2].
    pub inertia_kg_m2: Matrix3<f64>,
    /// Gravity [m/s^2].
    pub gravity_m_s2: f64,
    /// Largest thrust along the body's up axis, all rotors together [N].
    pub lift_max_n: f64,
    /// Allocation of collective and moments to rotors.
    pub mixer: Mixer,
}

impl Airframe {
    /// The airframe of a vehicle at a site (the density scales the thrust).
    ///
    /// # Errors
    /// [`ControlError`] when the rotors cannot lift or cannot make roll and pitch moments.
    pub fn new(vehicle: &Vehicle, environment: &Environment) -> Result<Self, ControlError> {
        let n = vehicle.rotors.len().min(MAX_ROTORS);
        let limit = vehicle.static_thrust_n(environment.density_kg_m3);
        // Rows: lift, roll, pitch and yaw moment per newton that each rotor would give alone.
        let mut effectiveness = SMatrix::<f64, 4, MAX_ROTORS>::zeros();
        for i in 0..n {
            let share = vehicle.rotors[i].interference.thrust;
            let moment = vehicle.moment_per_thrust(i, environment.density_kg_m3) * share;
            effectiveness[(0, i)] = -vehicle.rotors[i].axis_body.z * share;
            effectiveness.fixed_view_mut::<3, 1>(1, i).copy_from(&moment);
        }
        let lift_max_n = limit * effectiveness.row(0).sum();
        if !(lift_max_n.is_finite() && lift_max_n > 0.0) {
            return Err(ControlError::NoLift { lift_n: lift_max_n });
        }
        let allocation = minimum_norm_inverse(&effectiveness)?;
        Ok(Self {
            mass_kg: vehicle.mass.mass_kg,
            inertia_kg_m2: vehicle.mass.inertia_kg_m2,
            gravity_m_s2: environment.gravity_m_s2,
            lift_max_n,
            mixer: Mixer::new(n, limit, &allocation)?,
        })
    }

    /// This airframe with rotors whose thrust is taken for this curve. With `n` rotors alike, the line has
    /// `T_hover = m g/n`, `throttle_hover = sqrt(T_hover/T_static)` and `sqrt(T_static T_hover)` at full
    /// throttle. It is that of the mass that the airframe has now, and stays when the mass is changed.
    #[must_use]
    pub fn with_thrust_curve(self, curve: ThrustCurve) -> Self {
        if curve == self.mixer.curve() {
            return self;
        }
        let (weight_n, before_n) = (self.weight_n(), self.mixer.thrust_limit_n());
        let mixer = self.mixer.with_curve(curve, weight_n);
        Self { lift_max_n: self.lift_max_n * (mixer.thrust_limit_n() / before_n), mixer, ..self }
    }

    /// Weight [N].
    pub fn weight_n(&self) -> f64 {
        self.mass_kg * self.gravity_m_s2
    }

    /// Most upward acceleration that the rotors give, `4 T_lim/m` of a quadrotor [m/s^2].
    pub fn up_max_m_s2(&self) -> f64 {
        self.lift_max_n / self.mass_kg
    }
}

/// Columns that make one unit of lift, roll, pitch, yaw moment with the least sum of squares of thrust: `B^T
/// (B B^T)^-1` over the rows that the rotors can make. A yaw row that they cannot make (reaction torques off)
/// gives a zero column.
fn minimum_norm_inverse(
    effectiveness: &SMatrix<f64, 4, MAX_ROTORS>,
) -> Result<SMatrix<f64, MAX_ROTORS, 4>, ControlError> {
    let mut gram: Matrix4<f64> = effectiveness * effectiveness.transpose();
    // An axis is unreachable when nothing of its row is left after projection on the rows before it.
    for (row, axis) in [(1, Some("roll")), (2, Some("pitch")), (3, None)] {
        let independent = {
            let before = gram.view((0, 0), (row, row)).into_owned();
            let cross = gram.view((0, row), (row, 1)).into_owned();
            let solved = before.lu().solve(&cross);
            solved.is_some_and(|s| gram[(row, row)] - cross.dot(&s) > 1e-9 * gram[(row, row)])
        };
        if independent {
            continue;
        }
        match axis {
            Some(axis) => return Err(ControlError::NotSteerable { axis }),
            None => {
                gram.fill_row(row, 0.0);
                gram.fill_column(row, 0.0);
                gram[(row, row)] = 1.0;
                let mut reachable = *effectiveness;
                reachable.fill_row(row, 0.0);
                return invert(&gram, &reachable);
            }
        }
    }
    invert(&gram, effectiveness)
}

fn invert(
    gram: &Matrix4<f64>,
    effectiveness: &SMatrix<f64, 4, MAX_ROTORS>,
) -> Result<SMatrix<f64, MAX_ROTORS, 4>, ControlError> {
    let inverse = gram.try_inverse().ok_or(ControlError::NotSteerable { axis: "yaw" })?;
    Ok(effectiveness.transpose() * inverse)
}
