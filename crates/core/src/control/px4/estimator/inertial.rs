//! Readings of the inertial sensors to increments of angle and velocity (`lib/.../Integrator.hpp`,
//! `EKF/imu_down_sampler`).

use nalgebra::Vector3;

use crate::frames::{
    LEVEL, Quaternion, conjugate, product, quaternion_from_rotation_vector, rotate_ned_from_body,
    rotation_vector,
};

/// What an inertial unit has turned and been pushed by in a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Increment {
    /// Rotation vector, body [rad].
    pub(super) angle_body: Vector3<f64>,
    /// Specific force over the time, in the body axes of its end [m/s].
    pub(super) velocity_body: Vector3<f64>,
    /// Length [s].
    pub(super) dt_s: f64,
}

/// Several increments as one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sum {
    turned: Quaternion,
    velocity_body: Vector3<f64>,
    dt_s: f64,
}

impl Default for Sum {
    fn default() -> Self {
        Self { turned: LEVEL, velocity_body: Vector3::zeros(), dt_s: 0.0 }
    }
}

impl Sum {
    /// Adds an increment (`ImuDownSampler::update`).
    pub(super) fn add(&mut self, new: &Increment) {
        let turn = quaternion_from_rotation_vector(new.angle_body);
        let into_new_axes = |v: Vector3<f64>| rotate_ned_from_body(conjugate(turn), v);
        let new_velocity = (new.velocity_body + into_new_axes(new.velocity_body)) * 0.5;
        self.velocity_body = into_new_axes(self.velocity_body) + new_velocity;
        self.turned = product(self.turned, turn);
        self.dt_s += new.dt_s;
    }

    /// The sum so far.
    pub(super) fn increment(&self) -> Increment {
        Increment {
            angle_body: rotation_vector(self.turned),
            velocity_body: self.velocity_body,
            dt_s: self.dt_s,
        }
    }
}
