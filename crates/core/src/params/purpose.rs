//! The purpose of a parameter file. PX4 has 9.80665 m/s^2 compiled in, so under another gravity the same
//! names hold different numbers for different autopilots, and a file must say which it means (`# For: ...` in
//! its header):
//!
//! - **samara**: samara's own autopilot. SI gains; an acceleration command is met in full under the site's
//!   gravity.
//! - **px4**: unmodified PX4. It turns an acceleration command into tilt and thrust with `g0`, so under `g`
//!   it is met with `g/g0` of it: the velocity loop's gains carry the factor `g0/g`.
//! - **px4-froude**: PX4 by dynamic similarity. With `k = sqrt(g0/g)` PX4's clock runs k times slower than
//!   the site's (`dt_px4 = dt/k`), velocities and body rates reach it times k, accelerations times k^2;
//!   lengths, attitude and motor commands stay. A gain in 1/s^n carries `k^n`: k for 1/s, k^2 for 1/s^2, and
//!   the rate loop's, in normalised torque (which is a motor command and stays) per rad/s or rad, `1/k` and
//!   1.
//!
//! Under standard gravity the three are the same.

use crate::units::STANDARD_GRAVITY_M_S2;

/// Key of the site's gravity in a file's header.
pub const GRAVITY_KEY: &str = "Gravity";

/// The autopilot, and its way of dealing with gravity, that a parameter file is written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// samara's own autopilot.
    Samara,
    /// Unmodified PX4.
    Px4,
    /// PX4 by Froude scaling.
    Px4Froude,
}

/// Factors between samara's numbers and those for a purpose. A normalised torque per angle has the factor 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors {
    /// Factor on an acceleration per velocity [1/s].
    pub acceleration_per_velocity: f64,
    /// Factor on an acceleration per distance [1/s^2].
    pub acceleration_per_distance: f64,
    /// Froude's k, 1 where nothing is scaled: the factor on a velocity [m/s], a body rate [rad/s] and a body
    /// rate per angle [1/s].
    pub k: f64,
}

impl Factors {
    /// Factor on a normalised torque per body rate [s].
    pub fn torque_per_rate(&self) -> f64 {
        1.0 / self.k
    }
}

impl Purpose {
    /// Key of the purpose in a file's header.
    pub const KEY: &'static str = "For";

    /// All purposes.
    pub const ALL: [Self; 3] = [Self::Samara, Self::Px4, Self::Px4Froude];

    /// The name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Samara => "samara",
            Self::Px4 => "px4",
            Self::Px4Froude => "px4-froude",
        }
    }

    /// The purpose of that name; `None` for any other name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|p| p.name() == name)
    }

    /// The purpose in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Samara => "samara's own autopilot: SI gains under the site's gravity",
            Self::Px4 => "unmodified PX4, which takes 9.80665 m/s^2 for gravity",
            Self::Px4Froude => {
                "PX4 by Froude scaling: its clock, velocities and rates are scaled to 9.80665 m/s^2"
            }
        }
    }

    /// The factors between samara's numbers and the purpose's at a site's gravity [m/s^2].
    pub fn factors(self, gravity_m_s2: f64) -> Factors {
        let k2 = STANDARD_GRAVITY_M_S2 / gravity_m_s2;
        let (acceleration_per_velocity, acceleration_per_distance, k) = match self {
            Self::Samara => (1.0, 1.0, 1.0),
            Self::Px4 => (k2, k2, 1.0),
            Self::Px4Froude => (k2.sqrt(), k2, k2.sqrt()),
        };
        Factors { acceleration_per_velocity, acceleration_per_distance, k }
    }
}
