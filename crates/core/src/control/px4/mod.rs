//! PX4's multicopter controller in OFFBOARD, v1.12's and those of later versions ([`Law`]), written anew from
//! what its sources do: for tuning PX4's gains and for predicting its flights.
//! [`Px4Controller`] is the whole; `docs/px4_model.md` lists what it has and has not.
//!
//! | file | holds | in PX4 v1.12 |
//! |---|---|---|
//! | [`parameters`] | names and defaults | `mc_*_params.c`, `imu_gyro_parameters.c`, `motor_params.c` |
//! | [`velocity`] | velocity error to thrust vector, tilt | `PositionControl`, `MulticopterPositionControl` |
//! | [`attitude`] | thrust vector to attitude to body rates | `bodyzToAttitude`, `AttitudeControl::update` |
//! | [`reference`](mod@reference) | an attitude tracked for a setpoint's, v1.18 | `AttitudeControl` |
//! | [`rate`] | body rates to torque | `RateControl::update`, `updateIntegral` |
//! | [`estimator`] | what PX4 believes of attitude and velocity | `EKF2` |
//! | [`battery`] | torque and thrust scaled by the battery's voltage | `Battery::computeScale` |
//! | [`law`] | what differs in the law between versions | |
//! | [`allocator`] | torque and thrust to any rotors, v1.14 on | `ControlAllocationSequentialDesaturation` |
//! | [`effectiveness`] | what the rotors make, its pseudo-inverse | `ActuatorEffectivenessRotors`, `geninv` |
//! | [`mixer`] | torque and thrust to motors, saturation | `MultirotorMixer::mix_airmode_disabled` |
//! | [`output`] | thrust curve, arming ramp, command steps | `MultirotorMixer::mix`, `output_limit_calc` |
//! | [`filter`](mod@filter) | filters of gyroscope and derivative | `LowPassFilter2p`, `BlockDerivative` |
//! | [`versions`] | what differs between versions of PX4 for a drop | |
//! | [`timing`] | periods and limits that others count on | |
//! | [`controller`] | the loops in order and at their rates | queues `rate_ctrl`, `nav_and_controllers` |
//!
//! Numbers are PX4's: normalised torque and thrust, gravity of 9.80665 m/s^2 wherever it flies.

pub mod allocator;
pub mod attitude;
pub mod battery;
pub mod controller;
pub mod effectiveness;
pub mod estimator;
pub mod filter;
pub mod law;
pub mod mixer;
pub mod output;
pub mod parameters;
pub mod rate;
pub mod reference;
pub mod timing;
pub mod velocity;
pub mod versions;

#[cfg(test)]
mod controller_replay_tests;
#[cfg(test)]
mod replay_tests;

pub use controller::{Px4Controller, Trace};
pub use law::{CellVoltage, Law, Window};
pub use parameters::Parameters;
pub use versions::{NotModelled, Version};

use crate::model::{RotationSense, Vehicle};

/// Why PX4's mixer for a quadrotor in X cannot fly a vehicle.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotQuadX {
    /// Not four rotors.
    #[error("PX4's mixer for a quadrotor in X has four rotors, the vehicle has {found}")]
    Rotors {
        /// Number of rotors.
        found: usize,
    },
    /// A rotor is not where the mixer has it, or turns the other way.
    #[error("rotor {rotor} must be {expected} in PX4's quadrotor in X")]
    Place {
        /// Number of the rotor, from 1.
        rotor: usize,
        /// Place and turn.
        expected: &'static str,
    },
}

/// PX4's quadrotor in X: signs of the rotors' x and y, turn, in words.
const QUAD_X: [(f64, f64, RotationSense, &str); 4] = [
    (1.0, 1.0, RotationSense::Ccw, "front right and turn counterclockwise"),
    (-1.0, -1.0, RotationSense::Ccw, "rear left and turn counterclockwise"),
    (1.0, -1.0, RotationSense::Cw, "front left and turn clockwise"),
    (-1.0, 1.0, RotationSense::Cw, "rear right and turn clockwise"),
];

/// Whether PX4's mixer for a quadrotor in X is the vehicle's.
///
/// # Errors
/// [`NotQuadX`] where it is not.
pub fn is_quad_x(vehicle: &Vehicle) -> Result<(), NotQuadX> {
    let rotors = &vehicle.rotors;
    if rotors.len() != QUAD_X.len() {
        return Err(NotQuadX::Rotors { found: rotors.len() });
    }
    for (i, (rotor, (x, y, spin, expected))) in rotors.iter().zip(QUAD_X).enumerate() {
        let place = rotor.position_body_m;
        if !(place.x * x > 0.0 && place.y * y > 0.0 && rotor.spin == spin) {
            return Err(NotQuadX::Place { rotor: i + 1, expected });
        }
    }
    Ok(())
}
