//! The controller of a mission, for the studies that fly it without a wire.

use samara_core::assess::{StudyEntry, StudyReference};
pub use samara_core::control::KeepsHeading;
use samara_core::control::{Airframe, Cascade, ControlError, Controller, Gains};
use samara_mission::Mission;

/// The controller of a mission: the cascade with the mission's own gains, or what was put in its place.
/// Campaigns, effects, the envelope and grids of plans fly it. A controller of another kind is put here.
///
/// # Errors
/// [`ControlError`] for a vehicle that cannot be controlled.
pub fn controller(mission: &Mission) -> Result<Box<dyn Controller>, ControlError> {
    controller_or(mission, &mission.control.gains)
}

/// What was put in the cascade's place, or else the cascade with these gains.
///
/// # Errors
/// [`ControlError`] for a vehicle that cannot be controlled.
pub fn controller_or(mission: &Mission, gains: &Gains) -> Result<Box<dyn Controller>, ControlError> {
    match &mission.control.own {
        Some(own) => Ok(own.clone()),
        None => Ok(Box::new(controller_with(mission, gains)?)),
    }
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
