//! One row of a flight's record: state, setpoint, commands and every term of the balance of forces.

use nalgebra::Vector3;

use super::drop::Phase;
use super::integrator::PlantState;
use super::plant::Loads;
use super::rotor_start::EscState;
use super::two_bodies::CanopySample;
use crate::model::supply::BusState;
use crate::model::{ForceBalance, MAX_ROTORS, PerRotor};

/// One row of a flight's record: the vehicle at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the simulation began [s].
    pub t_s: f64,
    /// Time since the rotors were freed, the plan's time [s]; negative before; `None` while the release is
    /// not known.
    pub t_powered_s: Option<f64>,
    /// Phase of the drop.
    pub phase: Phase,
    /// State of body and rotors.
    pub state: PlantState,
    /// Velocity setpoint, NED [m/s], when there is one.
    pub v_sp_ned: Option<Vector3<f64>>,
    /// Throttle commands, 0..1.
    pub throttle: PerRotor,
    /// Every force and moment.
    pub balance: ForceBalance,
    /// Acceleration, NED [m/s^2]: the sum of the balance's forces over the mass.
    pub a_ned: Vector3<f64>,
    /// Velocity of the air over ground in the step that begins here, NED [m/s].
    pub wind_ned: Vector3<f64>,
    /// The canopy, where it is a body of its own.
    pub canopy: Option<CanopySample>,
    /// What the speed controllers do, where the rotors' start is modelled.
    pub esc: Option<[EscState; MAX_ROTORS]>,
    /// The bus, where the battery has a voltage.
    pub bus: Option<BusState>,
    /// Whether the flight has turned over since its release, as
    /// [`TurningOver`](super::turning_over::TurningOver) has it.
    pub turned_over: bool,
}

impl Sample {
    /// Speeds of the rotors that are driven by their motors [rad/s], zero of the others.
    pub fn driven_speed(&self) -> PerRotor {
        let speed = self.state.rotor_speed;
        let Some(states) = &self.esc else { return speed };
        std::array::from_fn(|i| if states[i] == EscState::Running { speed[i] } else { 0.0 })
    }
}

/// The part of a [`Sample`] that is known before the forces are.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowStart {
    pub(super) t_s: f64,
    pub(super) t_powered_s: Option<f64>,
    pub(super) phase: Phase,
    pub(super) state: PlantState,
    pub(super) canopy: Option<CanopySample>,
    pub(super) esc: Option<[EscState; MAX_ROTORS]>,
    pub(super) turned_over: bool,
}

impl RowStart {
    pub(super) fn sample(self, loads: Loads, throttle: &PerRotor, v_sp_ned: Option<Vector3<f64>>) -> Sample {
        Sample {
            t_s: self.t_s,
            t_powered_s: self.t_powered_s,
            phase: self.phase,
            state: self.state,
            v_sp_ned,
            throttle: *throttle,
            balance: loads.balance,
            a_ned: loads.a_ned,
            wind_ned: loads.wind_ned,
            canopy: self.canopy,
            esc: self.esc,
            bus: loads.bus,
            turned_over: self.turned_over,
        }
    }
}
