//! The nominal state, its motion under inertial measurements, and the error state's transition.
//!
//! Sola (2017): (260) nominal kinematics, (265) noise impulses, (270) error-state transition, (283)
//! injection, (287) reset. Differs from (260): the force of a step is turned by the attitude of its middle
//! and measurements are means over the step, so that the step is of second order; (270) has the terms that go
//! with it. Gravity is a parameter, along down.

use nalgebra::{Matrix3, Vector3};

use super::error_state::{
    ACCELEROMETER_BIAS, ATTITUDE, BARO_OFFSET, Column, GYRO_BIAS, IDENTITY, Matrix, POSITION, VELOCITY,
};
use super::settings::Noise;
use crate::frames::{
    Quaternion, dcm_body_from_ned, normalized, product, quaternion_from_rotation_vector, rotate_ned_from_body,
};

/// What an inertial unit measures: mean values over a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// Specific force, body [m/s^2].
    pub specific_force_body: Vector3<f64>,
    /// Body rates [rad/s].
    pub omega_body: Vector3<f64>,
}

impl Inertial {
    /// The mean of the measurements at the ends of a step.
    pub fn mean(a: &Self, b: &Self) -> Self {
        Self {
            specific_force_body: (a.specific_force_body + b.specific_force_body) * 0.5,
            omega_body: (a.omega_body + b.omega_body) * 0.5,
        }
    }
}

/// The state that the errors are about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NominalState {
    /// Position from the local origin, NED [m].
    pub p_ned: Vector3<f64>,
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Attitude, body to NED.
    pub q_ned_from_body: Quaternion,
    /// What the accelerometer reads too much, body [m/s^2].
    pub accelerometer_bias: Vector3<f64>,
    /// What the gyro reads too much, body [rad/s].
    pub gyro_bias: Vector3<f64>,
    /// What the barometer reads too high [m].
    pub baro_offset_m: f64,
}

impl NominalState {
    /// One step of `dt_s` [s] under inertial measurements, (260).
    pub fn predict(&mut self, inertial: &Inertial, gravity_m_s2: f64, dt_s: f64) {
        let omega = inertial.omega_body - self.gyro_bias;
        let force_body = inertial.specific_force_body - self.accelerometer_bias;
        let q_middle = product(self.q_ned_from_body, quaternion_from_rotation_vector(omega * (0.5 * dt_s)));
        let mut a_ned = rotate_ned_from_body(q_middle, force_body);
        a_ned.z += gravity_m_s2;
        self.p_ned += self.v_ned * dt_s + a_ned * (0.5 * dt_s * dt_s);
        self.v_ned += a_ned * dt_s;
        let q = product(self.q_ned_from_body, quaternion_from_rotation_vector(omega * dt_s));
        self.q_ned_from_body = normalized(q);
    }

    /// The transition of the error state over the same step, (270), to be taken before [`Self::predict`].
    pub fn transition(&self, inertial: &Inertial, dt_s: f64) -> Matrix {
        let turn = (inertial.omega_body - self.gyro_bias) * dt_s;
        let force_body = inertial.specific_force_body - self.accelerometer_bias;
        let half_turn = dcm_body_from_ned(quaternion_from_rotation_vector(turn * 0.5)).transpose();
        let ned_from_body = dcm_body_from_ned(self.q_ned_from_body).transpose();
        let ned_from_middle = ned_from_body * half_turn;
        let by_attitude = ned_from_body * (half_turn * force_body).cross_matrix() * -dt_s;
        let by_force = ned_from_middle * -dt_s;
        let by_rate = ned_from_middle * force_body.cross_matrix() * (0.5 * dt_s * dt_s);
        let mut f = IDENTITY;
        put(&mut f, POSITION, VELOCITY, &(Matrix3::identity() * dt_s));
        for (column, block) in [(ATTITUDE, by_attitude), (ACCELEROMETER_BIAS, by_force), (GYRO_BIAS, by_rate)]
        {
            put(&mut f, VELOCITY, column, &block);
            put(&mut f, POSITION, column, &(block * (0.5 * dt_s)));
        }
        let back = dcm_body_from_ned(quaternion_from_rotation_vector(turn));
        put(&mut f, ATTITUDE, ATTITUDE, &back);
        put(&mut f, ATTITUDE, GYRO_BIAS, &(Matrix3::identity() * -dt_s));
        f
    }

    /// Adds an error to the state: `x <- x (+) dx`, (283).
    pub fn inject(&mut self, dx: &Column) {
        let part = |at: usize| Vector3::new(dx[at], dx[at + 1], dx[at + 2]);
        self.p_ned += part(POSITION);
        self.v_ned += part(VELOCITY);
        let turn = quaternion_from_rotation_vector(part(ATTITUDE));
        self.q_ned_from_body = normalized(product(self.q_ned_from_body, turn));
        self.accelerometer_bias += part(ACCELEROMETER_BIAS);
        self.gyro_bias += part(GYRO_BIAS);
        self.baro_offset_m += dx[BARO_OFFSET];
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        let vectors = [&self.p_ned, &self.v_ned, &self.accelerometer_bias, &self.gyro_bias];
        vectors.iter().all(|v| v.iter().all(|x| x.is_finite()))
            && self.q_ned_from_body.iter().all(|c| c.is_finite())
            && self.baro_offset_m.is_finite()
    }
}

/// How the errors are seen after `dx` has been injected, (287): the attitude's are counted from the new
/// attitude.
pub fn reset(dx: &Column) -> Matrix {
    let half = Vector3::new(dx[ATTITUDE], dx[ATTITUDE + 1], dx[ATTITUDE + 2]) * 0.5;
    let mut g = IDENTITY;
    put(&mut g, ATTITUDE, ATTITUDE, &(Matrix3::identity() - half.cross_matrix()));
    g
}

/// Variances that a step of `dt_s` [s] adds to the errors: the impulses (265).
pub fn impulses(noise: &Noise, dt_s: f64) -> Column {
    let mut q = [0.0; super::error_state::N];
    for (at, density) in [
        (VELOCITY, noise.accelerometer),
        (ATTITUDE, noise.gyro),
        (ACCELEROMETER_BIAS, noise.accelerometer_walk),
        (GYRO_BIAS, noise.gyro_walk),
    ] {
        q[at..at + 3].fill(density * density * dt_s);
    }
    q[BARO_OFFSET] = noise.baro_walk * noise.baro_walk * dt_s;
    q
}

fn put(m: &mut Matrix, row: usize, column: usize, block: &Matrix3<f64>) {
    for i in 0..3 {
        for j in 0..3 {
            m[row + i][column + j] = block[(i, j)];
        }
    }
}
