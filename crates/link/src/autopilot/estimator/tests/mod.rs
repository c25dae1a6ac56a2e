//! The estimator against true flights, chi-square bounds and central differences.

#![expect(
    clippy::needless_range_loop,
    reason = "indices are rows and columns, or samples and their neighbours"
)]

mod consistency;
mod derivatives;
mod flight;
mod robustness;
mod sensors;

use nalgebra::SMatrix;

use super::EstimatorSettings;
use super::error_state::{Column, Covariance, N};
use super::nominal::NominalState;
use crate::frames::{conjugate, product, rotation_vector};
use flight::Site;

const GPS_DELAY_US: u64 = 120_000;

fn settings(site: &Site) -> EstimatorSettings {
    EstimatorSettings {
        gps_delay_us: GPS_DELAY_US,
        ..EstimatorSettings::at_site(site.gravity_m_s2, site.field_ned_gauss)
    }
}

/// The error of a state: what would have to be injected to make it the truth.
fn error(truth: &NominalState, state: &NominalState) -> Column {
    let turn = rotation_vector(product(conjugate(state.q_ned_from_body), truth.q_ned_from_body));
    let parts = [
        truth.p_ned - state.p_ned,
        truth.v_ned - state.v_ned,
        turn,
        truth.accelerometer_bias - state.accelerometer_bias,
        truth.gyro_bias - state.gyro_bias,
    ];
    let mut e = [0.0; N];
    for (i, part) in parts.iter().enumerate() {
        e[3 * i..3 * i + 3].copy_from_slice(part.as_slice());
    }
    e[N - 1] = truth.baro_offset_m - state.baro_offset_m;
    e
}

/// `e^T P^-1 e`; `None` when P is not positive definite.
fn squared_error(e: &Column, covariance: &Covariance) -> Option<f64> {
    let p = SMatrix::<f64, N, N>::from_fn(|i, j| covariance.at(i, j));
    let e = nalgebra::SVector::<f64, N>::from_column_slice(e);
    p.cholesky().map(|factor| e.dot(&factor.solve(&e)))
}
