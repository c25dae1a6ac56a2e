//! What each rotor makes of forces and moments, as PX4 v1.14 and later have it by their parameters
//! CA_ROTORn_* (`ActuatorEffectivenessRotors::computeEffectivenessMatrix`), and the pseudo-inverse of that.

use nalgebra::{Matrix6, SVector, Vector6};

use crate::model::{MAX_ROTORS, Vehicle};

/// CA_ROTORn_CT of a rotor in clean air: only ratios matter, but the allocator takes entries of M below
/// `NEGLIGIBLE` for zero, so that a thrust in newton would make it drop rotors. This is PX4's default.
pub const THRUST_COEFFICIENT: f64 = 6.5;

/// Below this PX4 takes an entry of M for zero when it counts rotors.
pub const NEGLIGIBLE: f64 = 1e-3;

/// A rotor's column or row.
pub type PerRotorVector = SVector<f64, MAX_ROTORS>;

/// Rows Mx, My, Mz, Fx, Fy, Fz of what each rotor makes, in PX4's units, in air of a density [kg/m^3].
pub fn effectiveness(vehicle: &Vehicle, density_kg_m3: f64) -> [PerRotorVector; 6] {
    let mut rows = [PerRotorVector::zeros(); 6];
    for (i, rotor) in vehicle.rotors.iter().enumerate().take(MAX_ROTORS) {
        let moment = rotor.position_body_m.cross(&rotor.axis_body)
            - rotor.axis_body * (rotor.spin.sign() * vehicle.torque_per_thrust_of_m(i, density_kg_m3));
        let coefficient = THRUST_COEFFICIENT * rotor.interference.thrust;
        for axis in 0..3 {
            rows[axis][i] = coefficient * moment[axis];
            rows[3 + axis][i] = coefficient * rotor.axis_body[axis];
        }
    }
    rows
}

/// `pinv(E) = B^T (F^T F)^-1 F^T` with `E = F B`, rows of B orthonormal.
pub struct PseudoInverse {
    basis: Vec<PerRotorVector>,
    /// Rows of F, padded with zeros.
    factor: [Vector6<f64>; 6],
    gram: Matrix6<f64>,
}

/// A column of the pseudo-inverse and how much of its own axis it makes.
pub struct Column {
    /// Share of each rotor in a unit of the axis.
    pub m: PerRotorVector,
    /// How much of the axis that makes.
    pub made: f64,
}

impl PseudoInverse {
    /// Of rows Mx, My, Mz, Fx, Fy, Fz, one number for each rotor.
    pub fn of(rows: &[PerRotorVector; 6]) -> Self {
        let largest = rows.iter().map(|r| r.norm()).fold(0.0, f64::max);
        let mut basis: Vec<PerRotorVector> = Vec::with_capacity(6);
        for row in rows {
            let mut rest = *row;
            // Twice is enough.
            for _ in 0..2 {
                for b in &basis {
                    rest -= b * b.dot(&rest);
                }
            }
            if rest.norm() > 1e-6 * row.norm() && row.norm() > 1e-9 * largest {
                basis.push(rest.normalize());
            }
        }
        let mut factor = [Vector6::zeros(); 6];
        for (f, row) in factor.iter_mut().zip(rows) {
            for (k, b) in basis.iter().enumerate() {
                f[k] = b.dot(row);
            }
        }
        let mut gram = Matrix6::identity();
        for i in 0..basis.len() {
            for j in 0..basis.len() {
                gram[(i, j)] = factor.iter().map(|f| f[i] * f[j]).sum();
            }
        }
        Self { basis, factor, gram }
    }

    /// The column of an axis, in the order of the rows.
    pub fn column(&self, axis: usize) -> Column {
        let f = &self.factor[axis];
        let weights = self.gram.cholesky().map_or_else(Vector6::zeros, |c| c.solve(f));
        let mut m = PerRotorVector::zeros();
        for (b, w) in self.basis.iter().zip(weights.iter()) {
            m += b * *w;
        }
        Column { m, made: f.dot(&weights) }
    }
}

/// PX4's scale of a torque: the root of the shares' squares over half the number of rotors that have one.
pub fn spread(m: &PerRotorVector) -> f64 {
    let counted = m.iter().filter(|x| x.abs() > NEGLIGIBLE).count();
    if counted == 0 { 0.0 } else { (m.norm_squared() / (counted as f64 / 2.0)).sqrt() }
}

/// PX4's scale of the thrust: the mean share of the rotors that have one.
pub fn mean_share(m: &PerRotorVector) -> f64 {
    let counted = m.iter().filter(|x| x.abs() > f64::from(f32::EPSILON)).count();
    m.iter().map(|x| x.abs()).sum::<f64>() / counted as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::test_vehicles::{lander, ring};
    use nalgebra::DMatrix;

    const DENSITY: f64 = 5.4;

    /// The pseudo-inverse by rank factorisation is the one by singular values, also for leaning and for few
    /// rotors.
    #[test]
    fn reference_pseudo_inverse_by_singular_values() {
        for vehicle in [
            lander(true),
            ring(6, [1.0, 1.0], 0.0),
            ring(6, [1.3, 1.3], 0.3),
            ring(8, [1.0, 1.0], 0.2),
            ring(3, [0.7, 0.7], 0.1),
        ] {
            let rows = effectiveness(&vehicle, DENSITY);
            let e = DMatrix::from_fn(6, vehicle.rotors.len(), |i, j| rows[i][j]);
            let reference = e.clone().pseudo_inverse(1e-9).unwrap();
            let inverse = PseudoInverse::of(&rows);
            for axis in 0..6 {
                let column = inverse.column(axis);
                for rotor in 0..vehicle.rotors.len() {
                    assert!((column.m[rotor] - reference[(rotor, axis)]).abs() < 1e-9, "axis {axis}");
                }
                assert!((column.made - (&e * &reference)[(axis, axis)]).abs() < 1e-9);
            }
        }
    }
}
