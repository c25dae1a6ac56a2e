//! When: the closed loop in simulated time. No IO, no clock.
//!
//! | file | holds |
//! |---|---|
//! | [`integrator`] | state of the vehicle with its rotors; classical Runge-Kutta step |
//! | `stage` | everything that acts on a vehicle in a stage of its integration |
//! | [`plant`] | the vehicle as the controller meets it: ideal thrusts or real actuators |
//! | [`drop`](mod@drop), `drop/forces` | hang, release, fall, powered flight; what acts in each phase |
//! | `drop/course`, `drop/hang` | when each phase ends; a hang that is prescribed |
//! | [`drop_run`] | a drop under its mission's trigger, with log, record and events |
//! | `latency` | throttle commands on their way to the speed controllers |
//! | `ring` | what fluctuation in the vortex ring makes of thrusts, and they of the motion |
//! | [`limits`], [`turning_over`] | safety limits, a state's share of them; turning over |
//! | [`faults`] | faults by name: what fails, when, and what that makes of motors and release |
//! | [`flight`] | a whole flight, controller and vehicle, without MAVLink frames |
//! | [`fleet`] | vehicles that are stepped together under throttles that are given |
//! | [`many`], [`watch`] | many flights, eight side by side where they may be; what watches them |
//! | [`two_bodies`] | vehicle and canopy under one riser, and the canopy after the release |
//! | [`ground`] | what a vehicle stands on |
//! | [`battery`], [`electric_battery`] | what the rotors take, of a store of energy; of a pack on a bus |
//! | [`px4_senses`] | what PX4 believes of a drop, by its estimator on the sensors |
//! | [`record`] | one row of a flight's record |
//! | [`sensors`] | what the sensors read |
//! | [`rotor_start`] | the start of each rotor of a flight |
//! | [`planar`] | many flights at once, side by side in the vertical plane |

pub mod battery;
pub mod drop;
pub mod drop_run;
pub mod electric_battery;
pub mod faults;
pub mod fleet;
pub mod flight;
pub mod ground;
pub mod integrator;
mod latency;
pub mod limits;
pub mod many;
pub mod planar;
pub mod plant;
pub mod px4_senses;
pub mod record;
mod ring;
pub mod rotor_start;
pub mod sensors;
mod stage;
pub mod turning_over;
pub mod two_bodies;
pub mod watch;

#[cfg(test)]
mod drop_run_tests;
#[cfg(test)]
mod drop_tests;
#[cfg(test)]
mod electric_battery_tests;
#[cfg(test)]
mod fleet_tests;
#[cfg(test)]
mod flight_tests;
#[cfg(test)]
mod ground_tests;
#[cfg(test)]
mod rotor_start_tests;
#[cfg(test)]
pub(crate) mod test_site;
#[cfg(test)]
mod wind_tests;

pub use battery::Battery;
pub use drop::{DropSimulation, Phase, ReleaseTrigger, Start, nominal_state_at_t0};
pub use drop_run::{DropEvent, DropRun, DropRunConfig, FlightRecord, PARAMETER, ReleaseCause};
pub use electric_battery::ElectricBattery;
pub use faults::{Fault, FaultKind, FaultOrder};
pub use fleet::{Fleet, FleetState};
pub use flight::{FlightPlan, Reference, fly, fly_by, fly_sensing, measured};
pub use ground::Ground;
pub use integrator::PlantState;
pub use limits::{SafetyLimits, StateCost};
pub use many::fly_many;
pub use plant::PlantKind;
pub use px4_senses::Px4Senses;
pub use record::Sample;
pub use rotor_start::{EscState, RotorStarted};
pub use sensors::SensorSettings;
pub use turning_over::TurningOver;
pub use two_bodies::{CanopyFlight, CanopySample};
pub use watch::{ABREAST, Flight, Watch};
