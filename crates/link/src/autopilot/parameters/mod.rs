//! What is in effect, under PX4's parameter names, and how it is changed in flight.
//!
//! | file | holds |
//! |---|---|
//! | [`mod@table`] | the declaration: every parameter and what it is to the autopilot |
//! | `change` | a new value: checked, put into effect |
//! | [`document`] | the declaration as a page |
//! | [`component_metadata`] | the parameters' meaning as MAVLink's component metadata |
//!
//! Values are those that ground stations see, in single precision. The gains themselves are the mission's, in
//! double precision, until one is set; the others stay to the bit then. Conversions are those of
//! [`crate::params`] for samara's own autopilot.

mod change;
pub mod component_metadata;
pub mod document;
pub mod table;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

pub use change::{Refusal, legible};
use table::{Declaration, ESTIMATOR, GPS_DELAY, Role, table};

use super::estimator::EstimatorSettings;
use super::settings::{SETPOINT_TIMEOUT_US, Settings};
use crate::checksum::crc32;
use crate::control::px4::versions::Number;
use crate::params::metadata::Kind;
use crate::params::{Metadata, Mixing, Parameter, ParamsError, Purpose, Scale, Subject, Value, export};
use crate::units::US_PER_S;

const US_PER_MS: f64 = 1e3;
/// The version of PX4 whose manners the autopilot has.
const PX4: Number = Number { major: 1, minor: 14 };

/// A parameter of the autopilot.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// PX4's name of the parameter.
    pub name: String,
    /// Value in effect.
    pub value: Value,
    /// Value at the start.
    pub start: Value,
    /// The role of the parameter in the autopilot.
    pub role: Role,
    /// PX4's metadata, with the range that holds here.
    pub known: Parameter,
}

/// The parameters of an autopilot by name; an index is a place in that order and never changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    entries: Vec<Entry>,
    scale: Scale,
    /// Mass for a hover thrust of 1 [kg].
    mass_at_full_kg: f64,
}

impl Parameters {
    /// The parameters of an autopilot that flies the subject, with this MAVLink system id.
    ///
    /// # Errors
    /// [`ParamsError`] when a gain or limit is out of range or PX4's mixer finds no unit for the rotors.
    pub fn of(subject: &Subject, system_id: u8) -> Result<Self, ParamsError> {
        let exported = export(subject, Purpose::Samara)?.parameters;
        let metadata = metadata();
        let rotors = subject.vehicle.rotors.len();
        let defaults = Settings::beside(subject.gains);
        let mut entries: Vec<Entry> = table()
            .flat_map(|declared| names(declared.name, rotors).map(move |name| (declared, name)))
            .filter_map(|(declared, name)| entry(&declared, name, &exported, metadata, system_id, &defaults))
            .collect();
        entries.sort_by(|a, b| a.name.cmp(&b.name));
        let units = subject.units(Mixing::Allocated)?;
        let factors = Purpose::Samara.factors(subject.environment.gravity_m_s2);
        Ok(Self {
            entries,
            scale: Scale::new(&units, subject.vehicle, factors),
            mass_at_full_kg: units.thrust_n / subject.environment.gravity_m_s2,
        })
    }

    /// With what says that this estimator is flown on, or none.
    #[must_use]
    pub fn with_estimator(mut self, settings: Option<&EstimatorSettings>) -> Self {
        let delay_us = settings.map_or(0, |settings| settings.gps_delay_us);
        let said = [
            (ESTIMATOR, Value::Int(i32::from(settings.is_some()))),
            (GPS_DELAY, Value::Real((delay_us as f64 / US_PER_MS) as f32)),
        ];
        for (name, value) in said {
            if let Some(index) = self.index_of(name) {
                let entry = &mut self.entries[index];
                (entry.value, entry.start) = (value, value);
            }
        }
        self
    }

    /// How old a satellite fix is when it comes [us], for the estimator when it begins.
    pub fn gps_delay_us(&self) -> u64 {
        self.number(GPS_DELAY).map_or(0, |ms| (ms * US_PER_MS).round() as u64)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The parameter at an index.
    pub fn at(&self, index: usize) -> Option<&Entry> {
        self.entries.get(index)
    }

    /// Index of a name.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.entries.binary_search_by(|entry| entry.name.as_str().cmp(name)).ok()
    }

    /// The value of a name.
    pub fn get(&self, name: &str) -> Option<Value> {
        Some(self.entries[self.index_of(name)?].value)
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter()
    }

    /// PX4's `_HASH_CHECK`: the checksum over each name's bytes and its value's four, little-endian, in
    /// order.
    pub fn hash(&self) -> u32 {
        self.entries.iter().fold(0, |crc, entry| {
            let value = match entry.value {
                Value::Int(i) => i.to_le_bytes(),
                Value::Real(x) => x.to_le_bytes(),
            };
            crc32(crc32(crc, entry.name.as_bytes()), &value)
        })
    }

    /// Names and values, for a file.
    pub fn values(&self) -> BTreeMap<String, Value> {
        self.entries.iter().map(|entry| (entry.name.clone(), entry.value)).collect()
    }

    fn number(&self, name: &str) -> Option<f64> {
        self.get(name).map(Value::as_f64)
    }
}

/// The names that a declared one stands for.
fn names(declared: &str, rotors: usize) -> impl Iterator<Item = String> {
    let count = if declared.contains('#') { rotors } else { 1 };
    (0..count).map(|rotor| declared.replace('#', &rotor.to_string()))
}

/// `None` for what this vehicle has not (the yaw rate gains of rotors without torque).
fn entry(
    declared: &Declaration,
    name: String,
    exported: &BTreeMap<String, Value>,
    metadata: Metadata,
    system_id: u8,
    defaults: &Settings,
) -> Option<Entry> {
    let value = match declared.role {
        Role::Fact(value) | Role::AtBeginning(value) => value,
        Role::Estimator => Value::Int(0),
        Role::Setting => match exported.get(&name) {
            Some(value) => *value,
            None => {
                let value = defaults.get(&name)?;
                match metadata.nearest(&name)?.kind {
                    Kind::Int => Value::Int(value as i32),
                    Kind::Float => Value::Real(value as f32),
                }
            }
        },
        Role::SetpointLife => Value::Real((SETPOINT_TIMEOUT_US as f64 / US_PER_S) as f32),
        Role::SystemId => Value::Int(i32::from(system_id)),
        Role::Controller | Role::Follows(_) | Role::Hover | Role::Vehicle => *exported.get(&name)?,
    };
    let mut known = described(declared, metadata)?;
    // What a mission brings may lie outside: a vehicle's geometry, the gains of one that is no PX4 quadrotor,
    // a drop's speeds. It can be set again, and the range says so.
    let begins = value.as_f64() as f32;
    known.min = known.min.map(|min| min.min(begins));
    known.max = known.max.map(|max| max.max(begins));
    Some(Entry { name, value, start: value, role: declared.role, known })
}

/// A parameter's range in words; an action of which there is one only says so.
fn range_in_words(known: &Parameter) -> String {
    match (known.min, known.max) {
        (Some(min), Some(max)) if min == max => format!("{min} only"),
        _ => known.range(),
    }
}

/// The parameters of the version of PX4 whose manners the autopilot has.
pub fn metadata() -> Metadata {
    Metadata::of(PX4)
}

/// PX4's metadata of a declared parameter, with the range that holds here; of one that the version does not
/// have, the nearest version's.
pub fn described(declared: &Declaration, metadata: Metadata) -> Option<Parameter> {
    let mut known = metadata.nearest(declared.name)?;
    if let Some((least, most)) = declared.range {
        (known.min, known.max) = (Some(least), Some(most));
    }
    Some(known)
}
