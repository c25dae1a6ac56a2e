//! Jacobians against central differences, and the covariance's algebra against nalgebra's.

use nalgebra::{SMatrix, Vector3};
use proptest::prelude::*;

use super::super::error_state::{ATTITUDE, Column, Covariance, N};
use super::super::nominal::{NominalState, reset};
use super::super::{EstimatorSettings, Filter, Inertial};
use super::{error, squared_error};
use crate::frames::{quaternion_from_euler, rotation_vector};
use crate::math;

const DT_S: f64 = 0.004;
/// Step of the differences: small against curvature, large against rounding.
const H: f64 = 1e-5;

fn vector(x: [f64; 3]) -> Vector3<f64> {
    Vector3::from(x)
}

fn state(angles: [f64; 3], v: [f64; 3]) -> NominalState {
    NominalState {
        p_ned: Vector3::new(3.0, -2.0, -40.0),
        v_ned: vector(v),
        q_ned_from_body: quaternion_from_euler(angles[0], angles[1], angles[2]),
        accelerometer_bias: Vector3::new(0.1, -0.2, 0.05),
        gyro_bias: Vector3::new(0.01, 0.02, -0.03),
        baro_offset_m: 1.5,
    }
}

fn nudge(j: usize, h: f64) -> Column {
    let mut dx = [0.0; N];
    dx[j] = h;
    dx
}

/// Level, nose north, in a field without declination: one that points beside north says that the heading is
/// wrong, and by symmetry nothing of the pitch, however steep it is.
#[test]
fn closed_form_a_field_that_points_beside_turns_the_heading_alone() {
    let settings = EstimatorSettings::at_site(9.8, Vector3::new(0.2, 0.0, 0.45));
    for beside_rad in [0.05f64, -0.05] {
        let mut filter = Filter::new(0, state([0.0; 3], [0.0; 3]), &[1e-3; N]);
        let (sin, cos) = math::sin_cos(beside_rad);
        filter.take_field(&settings, &Vector3::new(0.2 * cos, 0.2 * sin, 0.45));
        let turn = rotation_vector(filter.state.q_ned_from_body);
        assert!(turn.y.abs() < 1e-12 && turn.z * beside_rad < 0.0, "{turn}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// (270): what becomes of an error in one step.
    #[test]
    fn prop_the_transition_is_the_derivative_of_the_step(
        angles in prop::array::uniform3(-1.4f64..1.4), v in prop::array::uniform3(-20.0f64..20.0),
        force in prop::array::uniform3(-20.0f64..20.0), omega in prop::array::uniform3(-2.0f64..2.0),
    ) {
        let inertial = Inertial { specific_force_body: vector(force), omega_body: vector(omega) };
        let start = state(angles, v);
        let f = start.transition(&inertial, DT_S);
        let mut there = start;
        there.predict(&inertial, 1.35, DT_S);
        for j in 0..N {
            let after = |h: f64| {
                let mut x = start;
                x.inject(&nudge(j, h));
                x.predict(&inertial, 1.35, DT_S);
                error(&x, &there)
            };
            let (plus, minus) = (after(H), after(-H));
            for i in 0..N {
                let numeric = (plus[i] - minus[i]) / (2.0 * H);
                // What is left out: the gyro bias's turn within the step, |omega| dt^2 / 2, and third orders.
                prop_assert!((f[i][j] - numeric).abs() < 4e-5, "F[{i}][{j}] {} {numeric}", f[i][j]);
            }
        }
    }

    /// The field's direction by the attitude, at any attitude.
    #[test]
    fn prop_the_heading_row_is_the_derivative_of_the_field_direction(
        angles in prop::array::uniform3(-3.1f64..3.1), field in prop::array::uniform3(-0.5f64..0.5),
    ) {
        let filter = |x: NominalState| Filter::new(0, x, &[1.0; N]);
        let start = state(angles, [0.0; 3]);
        let Some((_, row, horizontal)) = filter(start).field_direction(&vector(field)) else {
            return Ok(());
        };
        prop_assume!(horizontal > 0.05);
        for j in 0..N {
            let at = |h: f64| {
                let mut x = start;
                x.inject(&nudge(j, h));
                filter(x).field_direction(&vector(field)).unwrap().0
            };
            let numeric = crate::frames::wrap_pi(at(H) - at(-H)) / (2.0 * H);
            prop_assert!((row[j] - numeric).abs() < 1e-6, "h[{j}] {} {numeric}", row[j]);
        }
    }

    /// (287): errors counted from the state after an injection. Sola's G is of first order in what is
    /// injected.
    #[test]
    fn prop_the_reset_is_the_derivative_of_counting_anew(
        angles in prop::array::uniform3(-1.4f64..1.4), turn in prop::array::uniform3(-0.05f64..0.05),
    ) {
        let start = state(angles, [0.0; 3]);
        let mut dx = [0.0; N];
        dx[ATTITUDE..ATTITUDE + 3].copy_from_slice(&turn);
        let mut after = start;
        after.inject(&dx);
        let g = reset(&dx);
        for j in ATTITUDE..ATTITUDE + 3 {
            let anew = |h: f64| {
                let (mut x, mut moved) = (start, dx);
                moved[j] += h;
                x.inject(&moved);
                error(&x, &after)
            };
            let (plus, minus) = (anew(H), anew(-H));
            for i in 0..N {
                let numeric = (plus[i] - minus[i]) / (2.0 * H);
                prop_assert!((g[i][j] - numeric).abs() < vector(turn).norm_squared() + 1e-8);
            }
        }
    }

    /// Joseph's form and the propagation against the same in matrices; positive definite after both.
    #[test]
    fn prop_the_covariance_agrees_with_matrix_algebra(
        entries in prop::collection::vec(-1.0f64..1.0, N * N), row in prop::collection::vec(-1.0f64..1.0, N),
        r in 1e-4f64..10.0,
    ) {
        type Square = SMatrix<f64, N, N>;
        let dense = |p: &Covariance| Square::from_fn(|i, j| p.at(i, j));
        let mut p = Covariance::of_variances(&std::array::from_fn(|i| 0.1 + i as f64));
        let f: [Column; N] = std::array::from_fn(|i| std::array::from_fn(|j| entries[N * i + j]));
        let (full, before) = (Square::from_fn(|i, j| f[i][j]), dense(&p));
        p.transform(&f);
        p.add_variances(&[1e-3; N]);
        let predicted = full * before * full.transpose() + Square::identity() * 1e-3;
        prop_assert!((dense(&p) - predicted).norm() < 1e-10 * predicted.norm());
        let h: Column = std::array::from_fn(|i| row[i]);
        let column = nalgebra::SVector::<f64, N>::from_column_slice(&h);
        let s = column.dot(&(predicted * column)) + r;
        prop_assert!((p.innovation_variance(&h, r) - s).abs() < 1e-10 * s);
        let gain = predicted * column / s;
        let found = p.update(&h, r);
        prop_assert!((0..N).all(|i| (found[i] - gain[i]).abs() < 1e-9 * (1.0 + gain.norm())));
        let updated = predicted - gain * gain.transpose() * s;
        prop_assert!((dense(&p) - updated).norm() < 1e-9 * predicted.norm());
        prop_assert!((0..N).all(|i| (0..N).all(|j| p.at(i, j) == p.at(j, i))));
        prop_assert!(squared_error(&[1.0; N], &p).is_some());
    }
}
