//! A battery as a store of energy: what the rotors' shafts take is gone, `E_dot = -sum Q_i omega_i`.
//!
//! No voltage, no losses, no recovery: the capacity is the energy that reaches the shafts. A battery that is
//! empty does not stop the motors; what to do about it is the autopilot's business. A rotor that the air
//! turns takes nothing; what a try to start one takes is left out.

use super::Sample;

/// Joule per watt hour.
pub const J_PER_WH: f64 = 3600.0;

/// A battery.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Battery {
    capacity_j: f64,
    left_j: f64,
}

impl Battery {
    /// A battery of this capacity [J] with a share of it left, 0..1.
    pub fn new(capacity_j: f64, share_left: f64) -> Self {
        Self { capacity_j, left_j: capacity_j * share_left.clamp(0.0, 1.0) }
    }

    /// Takes what the rotors take in `dt_s` [s] at the powers of a sample.
    pub fn discharge(&mut self, sample: &Sample, dt_s: f64) {
        let power_w: f64 =
            sample.balance.torque_nm.iter().zip(sample.driven_speed()).map(|(q, w)| q.abs() * w).sum();
        if power_w.is_finite() {
            self.left_j = (self.left_j - power_w * dt_s).max(0.0);
        }
    }

    /// Share of the capacity that is left, 0..1.
    pub fn charge(&self) -> f64 {
        self.left_j / self.capacity_j
    }

    /// What is left [J].
    pub fn left_j(&self) -> f64 {
        self.left_j
    }

    /// What has been taken [J].
    pub fn consumed_j(&self) -> f64 {
        self.capacity_j - self.left_j
    }
}
