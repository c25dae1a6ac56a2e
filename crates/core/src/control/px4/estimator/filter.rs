//! The filter at its horizon in the past: EKF2's error-state Kalman filter (`EKF/covariance.cpp`, `ekf.cpp`,
//! `velocity_fusion.cpp`, `position_fusion.cpp`), without the states that hardly move a drop: the Earth's
//! field and the magnetometer's bias, wind, terrain.

use nalgebra::{Matrix3, Vector3};

use super::inertial::Increment;
use super::noise::Noise;
use crate::frames::{
    Quaternion, dcm_body_from_ned, normalized, product, quaternion_from_rotation_vector, rotate_ned_from_body,
};
use crate::kalman::{Covariance, Matrix, identity};
use crate::units::STANDARD_GRAVITY_M_S2 as G0;

/// Size of the error state, three of each in EKF2's order.
const N: usize = 15;
/// Where attitude begins: a rotation vector in NED.
const ATTITUDE: usize = 0;
/// Where velocity begins.
const VELOCITY: usize = 3;
/// Where position begins.
const POSITION: usize = 6;
/// Where the gyroscope's bias begins.
const GYRO_BIAS: usize = 9;
/// Where the accelerometer's bias begins.
const ACCELEROMETER_BIAS: usize = 12;
/// Place of the height.
const DOWN: usize = POSITION + 2;

/// What is estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct State {
    /// Attitude, body to NED.
    pub(super) q_ned_from_body: Quaternion,
    /// Velocity, NED [m/s].
    pub(super) v_ned: Vector3<f64>,
    /// Position, NED [m].
    pub(super) p_ned: Vector3<f64>,
    /// What the gyroscope reads too much, body [rad/s].
    pub(super) gyro_bias: Vector3<f64>,
    /// What the accelerometer reads too much, body [m/s^2].
    pub(super) accelerometer_bias: Vector3<f64>,
}

/// The state at the horizon, and what is known of its error and of the barometer's.
#[derive(Clone, Debug)]
pub(super) struct Filter {
    pub(super) state: State,
    covariance: Covariance<N>,
    /// What the barometer reads too high [m], once it has been read, and its variance [m^2].
    barometer_m: Option<f64>,
    barometer_variance: f64,
}

impl Filter {
    /// At a state, as uncertain as EKF2 begins (`initialiseCovariance`).
    pub(super) fn new(noise: &Noise, state: State) -> Self {
        let mut sigma = [0.0; N];
        sigma[ATTITUDE..ATTITUDE + 3].fill(noise.first_tilt_rad);
        sigma[VELOCITY..VELOCITY + 3].copy_from_slice(&noise.satellite_speed_m_s);
        sigma[POSITION..POSITION + 3].copy_from_slice(&noise.satellite_place_m);
        sigma[GYRO_BIAS..GYRO_BIAS + 3].fill(noise.first_gyro_bias_rad_s);
        sigma[ACCELEROMETER_BIAS..ACCELEROMETER_BIAS + 3].fill(noise.first_accelerometer_bias_m_s2);
        let covariance = Covariance::of_variances(&sigma.map(|s| s * s));
        Self { state, covariance, barometer_m: None, barometer_variance: 0.0 }
    }

    /// One step (`predictCovariance`, `predictState`).
    pub(super) fn predict(&mut self, noise: &Noise, step: &Increment) {
        let (state, dt_s) = (&mut self.state, step.dt_s);
        let ned_from_body = dcm_body_from_ned(state.q_ned_from_body).transpose();
        let dv_body = step.velocity_body - state.accelerometer_bias * dt_s;
        let mut f = identity();
        put(&mut f, VELOCITY, ATTITUDE, &-(ned_from_body * dv_body).cross_matrix());
        put(&mut f, POSITION, VELOCITY, &(Matrix3::identity() * dt_s));
        put(&mut f, ATTITUDE, GYRO_BIAS, &(ned_from_body * -dt_s));
        put(&mut f, VELOCITY, ACCELEROMETER_BIAS, &(ned_from_body * -dt_s));
        self.covariance.transform(&f);
        let mut q = [0.0; N];
        q[ATTITUDE..ATTITUDE + 3].fill((dt_s * noise.gyro_rad_s).powi(2));
        q[VELOCITY..VELOCITY + 3].fill((dt_s * noise.accelerometer_m_s2).powi(2));
        for (at, walk, most) in [
            (GYRO_BIAS, noise.gyro_bias_rad_s2, noise.gyro_rad_s),
            (ACCELEROMETER_BIAS, noise.accelerometer_bias_m_s3, noise.accelerometer_m_s2),
        ] {
            for (i, q) in q.iter_mut().enumerate().skip(at).take(3) {
                *q = if self.covariance.at(i, i) < most * most { (dt_s * walk).powi(2) } else { 0.0 };
            }
        }
        self.covariance.add_variances(&q);
        let grown = self.barometer_variance + noise.barometer_walk_m.powi(2) * dt_s;
        self.barometer_variance = grown.min(noise.barometer_m.powi(2));

        let turn = step.angle_body - state.gyro_bias * dt_s;
        let q = product(state.q_ned_from_body, quaternion_from_rotation_vector(turn));
        state.q_ned_from_body = normalized(q);
        let before = state.v_ned;
        state.v_ned += rotate_ned_from_body(state.q_ned_from_body, dv_body) + Vector3::z() * (G0 * dt_s);
        state.p_ned += (before + state.v_ned) * (0.5 * dt_s);
    }

    /// Takes the velocity [m/s] and position [m] of a satellite fix, NED (`fuseVelocity`,
    /// `fuseHorizontalPosition`, `controlGnssHeightFusion`).
    pub(super) fn take_fix(&mut self, noise: &Noise, v_ned: &Vector3<f64>, p_ned: &Vector3<f64>) {
        self.take_all(noise, VELOCITY, v_ned - self.state.v_ned, noise.satellite_speed_m_s);
        self.take_all(noise, POSITION, p_ned - self.state.p_ned, noise.satellite_place_m);
    }

    /// Takes three numbers, all or none.
    fn take_all(&mut self, noise: &Noise, at: usize, innovation: Vector3<f64>, sigma: [f64; 3]) {
        let believed = (0..3).all(|i| {
            let s = self.covariance.at(at + i, at + i) + sigma[i] * sigma[i];
            innovation[i] * innovation[i] <= noise.gate * noise.gate * s
        });
        if believed {
            (0..3).for_each(|i| self.correct(at + i, innovation[i], sigma[i] * sigma[i]));
        }
    }

    /// Takes a barometer's altitude [m], whose bias is estimated beside (`controlBaroHeightFusion`,
    /// `BiasEstimator`).
    pub(super) fn take_altitude(&mut self, noise: &Noise, altitude_m: f64) {
        let too_high_m = altitude_m + self.state.p_ned.z;
        let bias_m = self.barometer_m.unwrap_or(too_high_m);
        let (variance, r) = (self.barometer_variance, noise.barometer_m.powi(2));
        let gain = variance / (variance + r + self.covariance.at(DOWN, DOWN));
        self.barometer_m = Some(bias_m + gain * (too_high_m - bias_m));
        self.barometer_variance -= gain * variance;
        self.correct(DOWN, bias_m - too_high_m, r + variance);
    }

    /// Takes how far the heading is off [rad] by the magnetometer, with this standard deviation [rad].
    pub(super) fn take_heading(&mut self, off_rad: f64, sigma_rad: f64) {
        self.correct(ATTITUDE + 2, off_rad, sigma_rad * sigma_rad);
    }

    /// Corrects by one number of the state that was measured (`fuseDirectStateMeasurement`, `fuse`).
    fn correct(&mut self, at: usize, innovation: f64, r: f64) {
        let mut h = [0.0; N];
        h[at] = 1.0;
        let dx = self.covariance.update(&h, r).map(|k| k * innovation);
        let part = |at: usize| Vector3::new(dx[at], dx[at + 1], dx[at + 2]);
        let state = &mut self.state;
        let turn = quaternion_from_rotation_vector(part(ATTITUDE));
        state.q_ned_from_body = normalized(product(turn, state.q_ned_from_body));
        state.v_ned += part(VELOCITY);
        state.p_ned += part(POSITION);
        state.gyro_bias += part(GYRO_BIAS);
        state.accelerometer_bias += part(ACCELEROMETER_BIAS);
    }
}

fn put(m: &mut Matrix<N>, row: usize, column: usize, block: &Matrix3<f64>) {
    for i in 0..3 {
        for j in 0..3 {
            m[row + i][column + j] = block[(i, j)];
        }
    }
}
