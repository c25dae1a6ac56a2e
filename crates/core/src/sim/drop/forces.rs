//! What acts on a vehicle in each phase of its drop, and the rows of the record that hold it.
//!
//! Under the canopy the motion is prescribed and the canopy's force is what is missing from `m a`, or the
//! canopy is a body of its own and its riser pulls; in the study's fall, [`Start::T0`](super::super::Start),
//! there is gravity alone.

use nalgebra::Vector3;

use super::super::faults::FaultCourse;
use super::super::plant::Loads;
use super::super::record::{RowStart, Sample};
use super::super::rotor_start::StartCourse;
use super::{DropSimulation, Phase};
use crate::frames::{rotate_body_from_ned, rotate_ned_from_body};
use crate::model::{ForceBalance, PerRotor};

/// The commands that come to the motors of those that are given.
fn commands(faults: Option<&FaultCourse>, throttle: &PerRotor) -> PerRotor {
    faults.map_or(*throttle, |faults| faults.commands(throttle))
}

/// What acts on the vehicle now, under commands as they come to the motors.
fn loads_under(drop: &DropSimulation, throttle: &PerRotor) -> Loads {
    let gravity = gravity_ned(drop);
    let mass = drop.vehicle().mass.mass_kg * drop.plant.factors.map_or(1.0, |factors| factors.mass);
    match drop.course.phase {
        Phase::Falling if !drop.course.falls_in_air() => {
            let balance = ForceBalance { gravity_force_ned: gravity * mass, ..ForceBalance::default() };
            drop.plant.acting(gravity, balance)
        }
        phase if let Some(canopy) = drop.canopy.as_ref().filter(|canopy| canopy.line.is_some()) => {
            canopy.loads(&drop.plant, &drop.state, throttle, phase != Phase::Powered)
        }
        Phase::Hanging => {
            let a_ned = drop.hang.a_ned(&drop.course, &drop.hanging_in());
            let mut balance = drop.plant.loads(&drop.state, throttle, true).balance;
            let others =
                rotate_ned_from_body(drop.state.body.q_ned_from_body, balance.force_body()) + gravity * mass;
            balance.canopy_force_ned = a_ned * mass - others;
            drop.plant.acting(a_ned, balance)
        }
        Phase::Falling => drop.plant.loads(&drop.state, throttle, true),
        Phase::Powered => drop.plant.loads(&drop.state, throttle, false),
    }
}

/// Gravity at the vehicle's altitude, NED [m/s^2]; in the study's fall, that of the release.
fn gravity_ned(drop: &DropSimulation) -> Vector3<f64> {
    match drop.course.phase {
        Phase::Falling if !drop.course.falls_in_air() => drop.environment().gravity_ned(),
        _ => Vector3::new(0.0, 0.0, drop.plant.ambient(&drop.state.body.p_ned).gravity_m_s2),
    }
}

impl DropSimulation {
    /// What acts on the vehicle now, under the last commands: acceleration, forces and moments, wind, and the
    /// bus where the battery has a voltage.
    pub fn loads(&self) -> Loads {
        loads_under(self, &self.throttle)
    }

    /// Every force and moment on the vehicle now, under the given commands.
    pub fn balance(&self, throttle: &PerRotor) -> ForceBalance {
        loads_under(self, &commands(self.faults(), throttle)).balance
    }

    /// What an accelerometer at the centre of mass reads, body [m/s^2]: acceleration without gravity.
    pub fn specific_force_body(&self) -> Vector3<f64> {
        let a = self.loads().a_ned - gravity_ned(self);
        rotate_body_from_ned(self.state.body.q_ned_from_body, a)
    }

    /// A row of the record: the state now under the given commands and setpoint.
    pub fn sample(&self, throttle: &PerRotor, v_sp_ned: Option<Vector3<f64>>) -> Sample {
        self.row_start().sample(loads_under(self, &commands(self.faults(), throttle)), throttle, v_sp_ned)
    }

    /// Advances by `dt_s` [s] as [`Self::step`] does; the row of the record for the step's beginning.
    pub fn advance_sampled(
        &mut self,
        throttle: &PerRotor,
        v_sp_ned: Option<Vector3<f64>>,
        dt_s: f64,
    ) -> Sample {
        let row = self.row_start();
        let loads = self.step(throttle, dt_s);
        row.sample(loads, throttle, v_sp_ned)
    }

    /// The state now, for a record whose forces come with the next step.
    pub(in crate::sim) fn row_start(&self) -> RowStart {
        RowStart {
            t_s: self.course.clock.time_s,
            t_powered_s: self.time_powered_s(),
            phase: self.course.phase,
            state: self.state,
            canopy: self.canopy.map(|c| c.sample(&self.state.body)),
            esc: self.plant.start().map(StartCourse::states),
            turned_over: self.has_turned_over(),
        }
    }
}
