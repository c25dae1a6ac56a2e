//! What is seen of a vehicle of a fleet.

use super::super::integrator::PlantState;

/// A vehicle of a fleet at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FleetState {
    /// State of body and rotors.
    pub state: PlantState,
    /// J_state, (47); from where the flight has turned over the pitch counts as 180 deg.
    pub j_state: f64,
    /// Voltage of the bus that the motors are on [V], where there is a battery.
    pub bus_v: Option<f64>,
}
