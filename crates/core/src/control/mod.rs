//! How it is flown: a controller takes a measurement and a setpoint and gives rotor throttles.
//!
//! | file | holds |
//! |---|---|
//! | [`controller`] | the trait that every controller implements, and what goes in and out |
//! | [`gains`] | the gains of Table 4, yaw gains, limits |
//! | [`airframe`] | what a controller knows of the vehicle |
//! | [`position`] | position error to wanted velocity |
//! | [`velocity`] | velocity error to wanted acceleration, collective and tilt |
//! | [`attitude`] | attitude error to wanted body rates |
//! | [`rate`] | body rate error to wanted angular acceleration |
//! | [`mixer`] | moments and collective to rotor thrusts |
//! | [`cascade`] | the four in a row, and what survives a broken input |
//! | [`free_fall`] | whether the vehicle falls, from its accelerometer |
//! | [`px4`] | a model of PX4's own controller, to tune and predict PX4 |
//!
//! The cascade is acceleration-normalised: gains are in SI and carry neither mass nor inertia. The same code
//! flies in tuning, in campaigns and behind MAVLink. It is pure: no clock, no allocation after construction,
//! no panic on any input.
//!
//! In the vertical plane (no lateral motion, heading north) the cascade gives the numbers of the planar
//! controller that the paper's study uses; each file says its part of it.

pub mod airframe;
pub mod attitude;
pub mod cascade;
pub mod controller;
pub mod free_fall;
pub mod gains;
pub mod loops;
pub mod mixer;
pub mod position;
pub mod px4;
pub mod rate;
pub mod velocity;

#[cfg(test)]
mod cascade_tests;
#[cfg(test)]
mod planar_tests;
#[cfg(test)]
pub(crate) mod test_vehicles;

pub use airframe::Airframe;
pub use cascade::Cascade;
pub use controller::{
    AsCascade, CloneController, ControlOutput, ControlSettings, Controller, KeepsHeading, Measurement,
    Setpoint, WithVelocityError,
};
pub use free_fall::{Fall, FreeFallDetector, FreeFallSettings};
pub use gains::{ControlLimits, Gains, ThrustCurve, TiltFrom};
pub use position::{PositionGains, VelocityLimits};

/// Why a controller cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ControlError {
    /// The rotors give no thrust along the body's up axis at full throttle.
    #[error("the rotors give no lift at full throttle ({lift_n} N)")]
    NoLift {
        /// Sum of thrusts along the body's up axis at full throttle [N].
        lift_n: f64,
    },
    /// Rotor `rotor` would have to pull down for the others to push up: no collective for this mixer.
    #[error("rotor {rotor} takes no positive share of the lift; the mixer needs every rotor to carry")]
    RotorWithoutLift {
        /// Number of the rotor, from 1.
        rotor: usize,
    },
    /// The rotors cannot make a moment about an axis that the attitude needs.
    #[error("the rotors cannot make a {axis} moment without disturbing lift or the other axes")]
    NotSteerable {
        /// "roll" or "pitch".
        axis: &'static str,
    },
    /// A gain or limit that is negative or not finite.
    #[error("{what} must be {expected}, found {value}")]
    OutOfRange {
        /// Name of the gain or limit.
        what: &'static str,
        /// Range that was expected.
        expected: &'static str,
        /// Value that was found.
        value: f64,
    },
}
