//! The quantities that may be uncertain, and what it does to a flight when they are off.

use crate::sim::planar::Variation;

/// A quantity that may be off what a mission says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UncertainQuantity {
    /// Mass, as a share of the vehicle's.
    Mass,
    /// Moments of inertia, as a share of the vehicle's.
    Inertia,
    /// Drag and side force of the body, as a share of the vehicle's.
    Drag,
    /// Pitching moment of the air on the body, as a share of the vehicle's.
    PitchingMoment,
    /// Density of the air, as a share of the site's.
    Density,
    /// Steady wind to the north in addition to the site's [m/s].
    Wind,
    /// Latency in addition to the vehicle's [s].
    Latency,
    /// Delay between the release and t = 0 in addition to the parachute's [s].
    ReleaseDelay,
    /// Thrusts of the rotors, with their torques as they are, as a share of the vehicle's.
    Thrust,
    /// Time constants of the motors, as a share of the vehicle's.
    MotorLag,
}

impl UncertainQuantity {
    /// Every quantity, in the order in which they are drawn and reported.
    pub const ALL: [Self; 10] = [
        Self::Mass,
        Self::Inertia,
        Self::Drag,
        Self::PitchingMoment,
        Self::Density,
        Self::Wind,
        Self::Latency,
        Self::ReleaseDelay,
        Self::Thrust,
        Self::MotorLag,
    ];

    /// Key of the quantity in files, with its unit unless it is a share.
    pub fn key(self) -> &'static str {
        match self {
            Self::Mass => "mass",
            Self::Inertia => "inertia",
            Self::Drag => "drag",
            Self::PitchingMoment => "pitching_moment",
            Self::Density => "density",
            Self::Wind => "wind_north_m_s",
            Self::Latency => "latency_s",
            Self::ReleaseDelay => "release_delay_s",
            Self::Thrust => "thrust",
            Self::MotorLag => "motor_lag",
        }
    }

    /// The quantity of a key; `None` for any other text.
    pub fn from_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| quantity.key() == key)
    }

    /// Name of the quantity for a reader.
    pub fn words(self) -> &'static str {
        match self {
            Self::Mass => "mass",
            Self::Inertia => "moment of inertia",
            Self::Drag => "drag",
            Self::PitchingMoment => "pitching moment of the air",
            Self::Density => "density of the air",
            Self::Wind => "steady wind",
            Self::Latency => "latency",
            Self::ReleaseDelay => "release delay",
            Self::Thrust => "thrust of the rotors",
            Self::MotorLag => "time constants of the motors",
        }
    }

    /// Unit of a deviation; empty for a share.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Wind => "m/s",
            Self::Latency | Self::ReleaseDelay => "s",
            _ => "",
        }
    }

    /// Whether a deviation is a share of what is known.
    pub fn is_share(self) -> bool {
        self.unit().is_empty()
    }

    /// Whether the quantity is the vehicle's, and not its site's or its release's.
    pub fn is_of_vehicle(self) -> bool {
        !matches!(self, Self::Density | Self::Wind | Self::ReleaseDelay)
    }

    /// Below this no deviation makes sense: nothing would be left of a share, a command came before it is
    /// given. A shorter delay than none at all is none.
    pub fn least(self) -> f64 {
        match self {
            Self::Wind | Self::ReleaseDelay => f64::NEG_INFINITY,
            Self::Latency => 0.0,
            _ => -LARGEST_LOSS,
        }
    }
}

/// A share loses no more than this.
const LARGEST_LOSS: f64 = 0.95;

/// How far quantities are off, each in its unit or as a share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviations([f64; UncertainQuantity::ALL.len()]);

impl Deviations {
    /// How far a quantity is off.
    pub fn of(&self, quantity: UncertainQuantity) -> f64 {
        self.0[quantity as usize]
    }

    /// Puts how far a quantity is off; at least what makes sense ([`UncertainQuantity::least`]).
    pub fn set(&mut self, quantity: UncertainQuantity, deviation: f64) {
        self.0[quantity as usize] = deviation.max(quantity.least());
    }

    /// Whether nothing is off.
    pub fn is_none(&self) -> bool {
        self.0 == [0.0; UncertainQuantity::ALL.len()]
    }

    /// What is off of a flight, but for the delay of its release, without gusts and turbulence.
    pub fn variation(&self) -> Variation {
        let off = |quantity| self.of(quantity);
        Variation {
            mass: 1.0 + off(UncertainQuantity::Mass),
            inertia: 1.0 + off(UncertainQuantity::Inertia),
            aero: [1.0 + off(UncertainQuantity::Drag), 1.0, 1.0 + off(UncertainQuantity::PitchingMoment)],
            density: 1.0 + off(UncertainQuantity::Density),
            thrust: 1.0 + off(UncertainQuantity::Thrust),
            motor_lag: 1.0 + off(UncertainQuantity::MotorLag),
            wind_m_s: [off(UncertainQuantity::Wind), 0.0],
            air: None,
            latency_s: off(UncertainQuantity::Latency),
        }
    }

    /// Delay between the release and t = 0 in addition to the parachute's [s].
    pub fn release_delay_s(&self) -> f64 {
        self.of(UncertainQuantity::ReleaseDelay)
    }
}
