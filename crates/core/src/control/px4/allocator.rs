//! Torque and thrust to any set of rotors, from v1.14 on: the pseudo-inverse of what the rotors make, scaled
//! (`ControlAllocationPseudoInverse`), and what is done where it does not fit
//! (`ControlAllocationSequentialDesaturation`, MC_AIRMODE 0).

use nalgebra::Vector3;

use super::effectiveness::{NEGLIGIBLE, PerRotorVector, PseudoInverse, effectiveness, mean_share, spread};
use super::mixer::{Saturation, desaturated};
use crate::model::{MAX_ROTORS, Vehicle};

/// An axis none of whose entries is beyond this is given up (`update_effectiveness_matrix_if_needed`).
const WEAK: f64 = 0.05;
/// The feedback of what could not be done comes at most so often [s] (`Run`, "Publish status at limited
/// rate").
const STATUS_PERIOD_S: f64 = 0.005;
/// Squared torque that counts as done (`publish_control_allocator_status`).
const ACHIEVED: f64 = 1e-6;
/// FLT_EPSILON.
const NOTHING: f64 = f32::EPSILON as f64;

/// The allocator of a vehicle, with the feedback that it gave last.
#[derive(Clone, Debug)]
pub struct Allocator {
    /// Shares of the rotors in a unit of roll, pitch, yaw and thrust.
    shares: [[f64; MAX_ROTORS]; 4],
    /// Torque about each axis that a rotor's unit makes, in units of the axis.
    made: [PerRotorVector; 3],
    saturation: Saturation,
    since_status_s: f64,
}

impl Allocator {
    /// The allocator of a vehicle's rotors in air of a density [kg/m^3]. An axis about which they make next
    /// to nothing is left out.
    pub fn new(vehicle: &Vehicle, density_kg_m3: f64) -> Self {
        let mut rows = effectiveness(vehicle, density_kg_m3);
        for row in rows.iter_mut().filter(|row| row.amax() <= WEAK) {
            row.fill(0.0);
        }
        let inverse = PseudoInverse::of(&rows);
        let [roll, pitch, yaw, down] = [0, 1, 2, 5].map(|axis| inverse.column(axis).m);
        let tilt = spread(&roll).max(spread(&pitch));
        let scales = [tilt, tilt, yaw.max(), -mean_share(&down)];
        let mut shares = [[0.0; MAX_ROTORS]; 4];
        for ((share, column), scale) in shares.iter_mut().zip([roll, pitch, yaw, down]).zip(scales) {
            let scaled = if scale.abs() > NOTHING { column / scale } else { column };
            let counts = |x: f64| if x.abs() < NEGLIGIBLE { 0.0 } else { x };
            *share = scaled.map(counts).into();
        }
        let made = [rows[0] * scales[0], rows[1] * scales[1], rows[2] * scales[2]];
        Self { shares, made, saturation: Saturation::default(), since_status_s: 0.0 }
    }

    /// The allocator before it has told anything.
    pub fn at_rest(self) -> Self {
        Self { saturation: Saturation::default(), since_status_s: 0.0, ..self }
    }

    /// Thrust of each rotor, 0..1, for normalised torque and thrust, `dt_s` [s] after the last.
    pub fn allocate(&mut self, torque: &Vector3<f64>, thrust: f64, dt_s: f64) -> [f64; MAX_ROTORS] {
        let motors = desaturated(&self.shares, torque, thrust).map(|u| u.clamp(0.0, 1.0));
        self.since_status_s += dt_s;
        if self.since_status_s >= STATUS_PERIOD_S - 1e-9 {
            self.since_status_s = 0.0;
            self.saturation = self.saturation_of(torque, &PerRotorVector::from(motors));
        }
        motors
    }

    /// What could not be done when that was last told.
    pub fn saturation(&self) -> &Saturation {
        &self.saturation
    }

    fn saturation_of(&self, torque: &Vector3<f64>, motors: &PerRotorVector) -> Saturation {
        let left = Vector3::from_fn(|axis, _| torque[axis] - self.made[axis].dot(motors));
        if left.norm_squared() < ACHIEVED {
            return Saturation::default();
        }
        let beyond = |sign: f64| [0, 1, 2].map(|axis| sign * left[axis] > NOTHING);
        Saturation { positive: beyond(1.0), negative: beyond(-1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::px4::mixer::mix;
    use crate::control::test_vehicles::{quadrotor, ring};
    use crate::model::VehicleOptions;

    const DENSITY: f64 = 1.2;

    /// Closed form: on a square the allocator's shares are those of the mixer file.
    #[test]
    fn closed_form_a_square_is_mixed_as_by_the_file() {
        let vehicle = quadrotor([0.2, 0.2], [0.02; 3], [0.0; 3], VehicleOptions::default());
        let mut allocator = Allocator::new(&vehicle, DENSITY);
        for (torque, thrust) in
            [([0.1, -0.2, 0.03], 0.5), ([0.0, 0.4, 0.0], 0.1), ([0.3, 0.2, 0.0], 0.9), ([0.0; 3], 0.0)]
        {
            let torque = Vector3::from(torque);
            let (found, by_file) = (allocator.allocate(&torque, thrust, 0.004), mix(&torque, thrust));
            for (a, b) in found.iter().zip(by_file) {
                assert!((a - b).abs() < 1e-9, "{found:?} {by_file:?}");
            }
        }
    }

    /// Closed form: what six rotors are given makes the torque and the thrust that were asked for; the
    /// feedback names the side of what is left, and comes every other sample.
    #[test]
    fn closed_form_six_rotors_make_what_fits_and_tell_what_does_not() {
        let mut allocator = Allocator::new(&ring(6, [1.0, 1.0], 0.0), DENSITY);
        let torque = Vector3::new(0.05, -0.04, 0.03);
        let motors = allocator.allocate(&torque, 0.5, 0.004);
        let made = Vector3::from_fn(|axis, _| allocator.made[axis].dot(&PerRotorVector::from(motors)));
        assert!((made - torque).norm() < 1e-9, "{made}");
        assert!((motors.iter().sum::<f64>() - 3.0).abs() < 1e-9);
        assert_eq!(*allocator.saturation(), Saturation::default());
        let too_much = Vector3::new(0.0, 0.0, -2.0);
        allocator.allocate(&too_much, 0.1, 0.004);
        assert!(allocator.saturation().negative[2] && !allocator.saturation().positive[2]);
        allocator.allocate(&torque, 0.5, 0.004);
        assert!(allocator.saturation().negative[2], "the next status is not due");
        allocator.allocate(&torque, 0.5, 0.004);
        assert_eq!(*allocator.saturation(), Saturation::default());
    }
}
