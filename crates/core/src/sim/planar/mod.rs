//! Many flights at once: vehicles that are symmetric about their x-z plane, side by side in the vertical
//! plane, for tuning and campaigns.
//!
//! | file | holds |
//! |---|---|
//! | [`lanes`] | numbers of several flights side by side |
//! | [`model`] | what all flights share: vehicle, site and controller, checked to stay in the plane |
//! | [`flight`] | the inputs of one flight: gains, release, variation |
//! | `groups` | rotors that do the same in the plane |
//! | [`setpoint_table`] | the setpoints, tabulated once for all flights |
//! | `air`, `rotors` | loads on the body; thrust, torque and motors |
//! | `cascade` | the cascade in the plane |
//! | [`engine`] | integration, control step by control step |
//!
//! The state of a flight is `v_N, v_D, q0, q2, Q`, the rotor speed of each group of rotors that are mirror
//! images at one place fore and aft, and the integrals of the cascade. The equations are those of
//! [`super::fly`] with `v_E = P = R = q1 = q3 = 0`:
//!
//! ```text
//! U = c v_N - s v_D,  W = s v_N + c v_D  (air-relative),  c = q0^2 - q2^2,  s = 2 q0 q2
//! v_N' = (c F_x + s F_z)/m,  v_D' = (c F_z - s F_x)/m + g,  q0' = -q2 Q/2,  q2' = q0 Q/2,  Q' = M/J_yy
//! ```
//!
//! and tests hold it to that code. Angles beyond the vertical are therefore no special case, and no sine is
//! needed. What a vehicle must be for this is in [`Model::new`]; one that is not is refused, not
//! approximated.
#![expect(
    clippy::needless_range_loop,
    reason = "a loop over lanes indexes many arrays at once, the same way throughout"
)]

mod air;
mod cascade;
pub mod engine;
pub mod flight;
mod groups;
pub mod lanes;
pub mod model;
mod rotors;
pub mod setpoint_table;

#[cfg(test)]
mod tests;

pub use engine::{Observer, State, fly};
pub use flight::{Flight, Release, Variation};
pub use lanes::{LANES, Lanes};
pub use model::Model;
pub use setpoint_table::SetpointTable;

use crate::control::ControlError;

/// Why a flight cannot be flown in the vertical plane.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotPlanar {
    /// The rotors sit at too many places fore and aft.
    #[error(
        "the batch engine flies rotors at {most} places fore and aft at most, mirror images counted once; found {found}"
    )]
    Groups {
        /// Number of places.
        found: usize,
        /// Most places that are flown.
        most: usize,
    },
    /// The motors are on a battery with a voltage.
    #[error("the batch engine flies motors on a stiff supply; these are on a battery with a voltage")]
    Battery,
    /// A rotor does not push straight up.
    #[error("rotor {rotor} does not push along the body's up axis")]
    RotorAxis {
        /// Number of the rotor, from 1.
        rotor: usize,
    },
    /// A rotor has no mirror image.
    #[error("rotor {rotor} has no mirror image on the other side of the x-z plane")]
    RotorPlacement {
        /// Number of the rotor, from 1.
        rotor: usize,
    },
    /// A rotor in the plane of symmetry has a torque that nothing cancels.
    #[error(
        "rotor {rotor} sits in the x-z plane: with reaction torque or rotor momentum it turns the vehicle out of it"
    )]
    LoneRotation {
        /// Number of the rotor, from 1.
        rotor: usize,
    },
    /// The rotors of a pair turn the same way although that matters.
    #[error(
        "rotors {first} and {second} turn the same way: with reaction torque or rotor momentum they turn the vehicle out of the plane"
    )]
    PairRotation {
        /// Number of one rotor of the pair, from 1.
        first: usize,
        /// Number of the other rotor of the pair, from 1.
        second: usize,
    },
    /// Products of inertia couple pitch to roll or yaw.
    #[error("the products of inertia J_xy and J_yz couple pitch to roll and yaw")]
    Inertia,
    /// Wind, velocity, setpoint or release has a lateral part.
    #[error("{what} leaves the vertical plane to the north")]
    Sideways {
        /// Name of the quantity.
        what: &'static str,
    },
    /// A time is not positive, or longer than can be tabulated.
    #[error("{what} must be {expected}, found {value}")]
    OutOfRange {
        /// Name of the quantity.
        what: &'static str,
        /// The range that was expected.
        expected: &'static str,
        /// The value given.
        value: f64,
    },
    /// The rotors cannot be controlled at all.
    #[error(transparent)]
    Control(#[from] ControlError),
}
