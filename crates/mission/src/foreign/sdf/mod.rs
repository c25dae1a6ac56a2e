//! Gazebo's SDF: mass, inertia, rotors and motors of a model, with the models beside it that it includes.
//!
//! | file | holds |
//! |---|---|
//! | `element` | an element's children and numbers, with their places |
//! | `pose` | where things are, as their poses say |
//! | `motor` | a motor, as its plugin has it |
//! | `model` | links and motors of a model and of those in it |
//! | `vehicle` | mass, inertia and rotors that they come to |
//!
//! Nothing is fetched, entities are not expanded, and no element is looked at deeper than models are nested.

mod element;
mod model;
mod motor;
mod pose;
mod vehicle;

use std::path::Path;

use super::known::KnownVehicle;
use crate::error::ConfigError;
use model::Model;

pub(super) use model::TEMPLATE;

/// What a model says of a vehicle.
pub(super) fn read(file: &Path) -> Result<KnownVehicle, ConfigError> {
    vehicle::of(&Model::read(file)?)
}
