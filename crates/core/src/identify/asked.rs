//! What is asked of logs, and why there is no answer.

/// What is known of where the logs were flown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Gravity [m/s^2].
    pub gravity_m_s2: f64,
    /// Density of the air where a log has none [kg/m^3].
    pub density_kg_m3: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { gravity_m_s2: crate::units::STANDARD_GRAVITY_M_S2, density_kg_m3: 1.225 }
    }
}

/// Why logs say nothing of a vehicle.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum IdentifyError {
    /// A quantity was not logged.
    #[error("the log has no {0}, which is needed")]
    Lacks(&'static str),
    /// Another number of rotors was commanded.
    #[error(
        "{moved} rotors were commanded in the log, and the vehicle has {rotors}: it is another vehicle's"
    )]
    Rotors {
        /// Rotors of the log.
        moved: usize,
        /// Rotors of the vehicle.
        rotors: usize,
    },
    /// More instants than are looked at.
    #[error("a log of at most {most} instants is expected: an hour at 250 Hz")]
    Long {
        /// Instants at most.
        most: usize,
    },
    /// Nothing was flown that could be looked at.
    #[error("no flight was found in the log: neither a hover nor seconds of flight without gaps")]
    NotFlown,
}
