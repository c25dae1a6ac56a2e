//! What every study of flights is about: one vehicle at one site, in its air, to a target within limits.

use std::sync::Arc;

use nalgebra::Vector3;

use super::limits::Limits;
use crate::model::wind::Wind;
use crate::model::{Environment, Vehicle};
use crate::sim::ElectricBattery;

/// What flies, where, in which air, to which velocity, and within which limits.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The vehicle as planner and controller know it.
    pub vehicle: Arc<Vehicle>,
    /// The site as planner and controller know it.
    pub environment: Environment,
    /// Wind by altitude, gusts and turbulence, which neither knows.
    pub wind: Wind,
    /// The battery that the motors are on, as it is at t = 0; `None`: a stiff supply.
    pub battery: Option<ElectricBattery>,
    /// Velocity to reach, NED [m/s].
    pub target_v_ned: Vector3<f64>,
    /// Limits that a flight is judged by.
    pub limits: Limits,
}
