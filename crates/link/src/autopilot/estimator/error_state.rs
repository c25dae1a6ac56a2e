//! The error state: which number is what, and its covariance.

use crate::kalman;

/// Size of the error state: position, velocity, attitude, accelerometer bias, gyro bias (three each, Sola's
/// order), and the barometer's offset.
pub const N: usize = 16;
/// Where position begins.
pub const POSITION: usize = 0;
/// Where velocity begins.
pub const VELOCITY: usize = 3;
/// Where attitude begins: a rotation vector in body axes.
pub const ATTITUDE: usize = 6;
/// Where the accelerometer's bias begins.
pub const ACCELEROMETER_BIAS: usize = 9;
/// Where the gyro's bias begins.
pub const GYRO_BIAS: usize = 12;
/// The barometer's offset.
pub const BARO_OFFSET: usize = 15;

/// A column of the error state's size.
pub type Column = [f64; N];
/// A matrix of the error state's size, by rows.
pub type Matrix = kalman::Matrix<N>;
/// A covariance of the error state.
pub type Covariance = kalman::Covariance<N>;
/// The identity.
pub const IDENTITY: Matrix = kalman::identity();
