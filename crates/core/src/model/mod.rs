//! The vehicle and its surroundings: physics as pure functions and data.
//!
//! | file | holds | paper |
//! |---|---|---|
//! | [`rigid_body`] | translation and rotation of the body | (1)-(8) |
//! | [`body_aero`] | body forces and moment from coefficient tables | (13)-(18) |
//! | `axis` | the axis of a table | |
//! | [`rotor`] | thrust and torque of one rotor, inflow at the hub | (10)-(12), III.A |
//! | [`inflow`] | induced velocity from climb to windmill brake, with the vortex ring | |
//! | [`blade_element`] | thrust, in-plane force and torque of known blades | |
//! | [`coefficient_table`] | those as a table that flies | |
//! | [`disk_state`] | climb and edgewise motion of a rotor over its induced velocity | |
//! | [`motor`] | speed controller and motor: rotor speed from throttle | III.B, (23)-(24) |
//! | [`rotor_start`] | rotors that nobody drives, and how a speed controller starts a motor | |
//! | [`drives`] | what turns the rotors: motors on a stiff supply or on a bus | |
//! | [`supply`] | battery and bus: what is left to each motor | |
//! | [`vehicle`] | the vehicle: all of the above with its geometry; force balance | (5)-(9), (19)-(22) |
//! | `rotor_load` | thrust, torque and in-plane force of a rotor | |
//! | [`rotor_limits`] | the greatest thrust of a rotor, and how fast it comes | |
//! | [`atmosphere`] | air and gravity by altitude | |
//! | [`environment`] | gravity, density, wind, the site's place on the globe | |
//! | [`planet`] | gravity and density at a release on Earth, Titan, Mars, for drafts of missions | |
//! | [`magnetic_field`] | Earth's field from the World Magnetic Model; a dipole's | |
//! | [`wind`] | mean wind by altitude, gusts, turbulence; fluctuation of thrusts in the vortex ring | |
//! | [`parachute`] | descent and swing before the release | (40)-(44) |
//! | [`canopy`] | the canopy as a body of its own, and its riser | |
//! | [`trim`](mod@trim) | the steady state at a commanded velocity | (31) |

pub mod atmosphere;
pub(crate) mod axis;
pub mod blade_element;
#[cfg(test)]
pub(crate) mod blade_tests;
pub mod body_aero;
pub mod canopy;
pub mod coefficient_table;
pub mod disk_state;
pub mod drives;
pub mod environment;
pub mod factors;
pub mod inflow;
pub mod magnetic_field;
pub mod motor;
pub mod parachute;
pub mod planet;
pub mod rigid_body;
pub mod rotor;
pub mod rotor_limits;
mod rotor_load;
pub mod rotor_start;
pub mod spline;
pub mod supply;
pub mod trim;
pub mod vehicle;
pub mod wind;

pub use atmosphere::Atmosphere;
pub use blade_element::{Airfoil, BladeStation, Blades};
pub use body_aero::BodyAero;
pub use coefficient_table::CoefficientTable;
pub use disk_state::DiskState;
pub use environment::Environment;
pub use motor::{EscDc, Motor, MotorCondition};
pub use parachute::Parachute;
pub use planet::Planet;
pub use rotor::{Rotor, RotorTable};
pub use rotor_limits::RotorLimits;
pub use rotor_start::RotorStart;
pub use trim::{Trim, TrimError, trim};
pub use vehicle::{
    ForceBalance, Interference, RotationSense, RotorMount, SAME_AXIS, Vehicle, VehicleOptions,
};

/// Most rotors that a vehicle may have; per-rotor arrays have this length, so that nothing allocates in
/// flight.
pub const MAX_ROTORS: usize = 8;

/// One number per rotor; entries beyond the vehicle's rotor count are zero.
pub type PerRotor = [f64; MAX_ROTORS];

/// Why a part of the vehicle or its surroundings cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// A quantity is not finite or outside its range.
    #[error("{what} must be {expected}, found {value}")]
    OutOfRange {
        /// Name of the quantity.
        what: &'static str,
        /// The range that was expected.
        expected: &'static str,
        /// The value given.
        value: f64,
    },
    /// Principal inertias of a rigid body satisfy `a + b >= c` in every order; these do not.
    #[error(
        "inertia {0:?} kg m^2 breaks the triangle inequality: each must be at most the sum of the others"
    )]
    InertiaTriangle([f64; 3]),
    /// A table has the wrong shape, is not increasing or is not finite.
    #[error("{0}")]
    Table(String),
    /// The rotor set cannot carry or steer the vehicle.
    #[error("{0}")]
    Rotors(String),
    /// The magnetic field is not known at that place or time.
    #[error("World Magnetic Model: {0}")]
    MagneticField(String),
}

/// Refuses a `value` for which what is `expected` does not hold.
///
/// # Errors
/// [`ModelError::OutOfRange`], which names what the value is of.
pub fn check(holds: bool, what: &'static str, expected: &'static str, value: f64) -> Result<(), ModelError> {
    if holds { Ok(()) } else { Err(ModelError::OutOfRange { what, expected, value }) }
}

/// Refuses a `value` that is not finite and positive.
///
/// # Errors
/// [`ModelError::OutOfRange`], which names what the value is of.
pub fn check_positive(what: &'static str, value: f64) -> Result<(), ModelError> {
    check(value.is_finite() && value > 0.0, what, "positive", value)
}

fn check_increasing(knots: &[f64]) -> Result<(), ModelError> {
    match knots.windows(2).position(|w| w[1].partial_cmp(&w[0]) != Some(std::cmp::Ordering::Greater)) {
        None => Ok(()),
        Some(i) => Err(ModelError::Table(format!(
            "the grid must increase, but entry {} ({}) follows {}",
            i + 1,
            knots[i + 1],
            knots[i]
        ))),
    }
}
