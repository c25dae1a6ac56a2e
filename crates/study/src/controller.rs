//! The controller of a mission, for the studies that fly it without a wire.

use samara_core::assess::{StudyEntry, StudyReference};
use samara_core::control::{
    Airframe, AsCascade, Cascade, ControlError, ControlOutput, Controller, Gains, Measurement, Setpoint,
};
use samara_core::frames::yaw;
use samara_mission::Mission;

/// The controller of a mission, with the mission's own gains: campaigns, effects, the envelope and grids of
/// plans fly it. A controller of another kind is put here.
///
/// # Errors
/// [`ControlError`] for a vehicle that cannot be controlled.
pub fn controller(mission: &Mission) -> Result<Box<dyn Controller>, ControlError> {
    Ok(Box::new(controller_with(mission, &mission.control.gains)?))
}

/// The cascade of a mission with other gains.
///
/// # Errors
/// [`ControlError`] for a vehicle that cannot be controlled.
pub fn controller_with(mission: &Mission, gains: &Gains) -> Result<Cascade, ControlError> {
    let airframe = Airframe::new(&mission.vehicle, &mission.site.environment)?;
    Ok(Cascade::new(airframe, *gains, mission.control.limits))
}

/// The mission's controller along its plan, under a name.
///
/// # Errors
/// [`ControlError`] for a vehicle that cannot be controlled.
pub fn along_plan(mission: &Mission, name: &'static str) -> Result<StudyEntry, ControlError> {
    let (gains_name, reference) = (mission.control.gains_name.clone(), StudyReference::Optimal);
    Ok(StudyEntry { name, gains_name, controller: controller(mission)?, reference })
}

/// A controller as the autopilot has it for setpoints without a heading: it keeps the one at which velocity
/// control began.
#[derive(Clone, Debug)]
pub struct KeepsHeading {
    controller: Box<dyn Controller>,
    heading_rad: Option<f64>,
}

impl KeepsHeading {
    /// This controller, which has no heading yet.
    pub fn new(controller: Box<dyn Controller>) -> Self {
        Self { controller, heading_rad: None }
    }
}

impl Controller for KeepsHeading {
    fn reset(&mut self) {
        self.controller.reset();
        self.heading_rad = None;
    }

    fn step(&mut self, measurement: &Measurement, setpoint: &Setpoint, dt_s: f64) -> ControlOutput {
        let mut setpoint = *setpoint;
        if let Setpoint::Velocity { yaw_rad: yaw_rad @ None, .. } = &mut setpoint {
            *yaw_rad = Some(*self.heading_rad.get_or_insert_with(|| yaw(measurement.q_ned_from_body)));
        }
        self.controller.step(measurement, &setpoint, dt_s)
    }

    fn as_cascade(&self) -> Option<AsCascade<'_>> {
        Some(AsCascade { keeps_heading: true, ..self.controller.as_cascade()? })
    }
}
