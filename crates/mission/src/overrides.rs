//! Keys of a mission's file, its vehicle's or its gains' with other values: `--set limits.pitch_deg=40`.
//!
//! A value is put into the text that was read, on the line where it stands or belongs, so that whatever
//! refuses it says where, and the hash of the inputs is that of the text with it.

use std::fmt;
use std::str::FromStr;

use serde_json::Value;

use super::error::ConfigError;
use super::source::Source;
use samara_core::printable::printable;
use samara_core::units::{in_unit, unit_of};

/// A key of a mission's file, its vehicle's or its gains', as a path, with the value that stands in its
/// place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    key: String,
    value: String,
}

impl Override {
    /// The key as a path from the file's top: `limits.pitch_deg`, `cases[0].pitch_deg`, `mass_kg`.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The value as it was given.
    pub fn value(&self) -> &str {
        &self.value
    }

    /// The key's path where it is of the file that `before` its name stands for: `mission.`, `vehicle.`,
    /// `gains.`.
    pub(super) fn path_behind(&self, before: &str) -> Option<&str> {
        self.key.strip_prefix(before)
    }

    /// An error about it.
    pub(super) fn refuse(&self, message: String) -> ConfigError {
        ConfigError::Override { set: printable(&self.to_string()).into_owned(), message }
    }

    /// The value as JSON: what it is by itself, else a number in the key's unit, a list of such, or a text.
    fn json(&self, path: &str) -> Result<Value, ConfigError> {
        if let Ok(value) = serde_json::from_str(&self.value) {
            return Ok(value);
        }
        let key = path.rsplit('.').next().unwrap_or_default().split('[').next().unwrap_or_default();
        let unit = unit_of(key).unwrap_or_default();
        let listed = self.value.trim().trim_start_matches('[').trim_end_matches(']');
        let numeric = |part: &str| part.trim().starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        if !listed.split(',').all(numeric) {
            return Ok(Value::String(self.value.clone()));
        }
        let numbers: Result<Vec<Value>, _> =
            listed.split(',').map(|part| in_unit(part, unit).map(Value::from)).collect();
        let numbers = numbers.map_err(|error| self.refuse(error.to_string()))?;
        match <[Value; 1]>::try_from(numbers) {
            Ok([number]) if listed == self.value.trim() => Ok(number),
            Ok([number]) => Ok(Value::Array(vec![number])),
            Err(numbers) => Ok(Value::Array(numbers)),
        }
    }

    /// Puts the value into the text of its file.
    fn put(&self, source: &mut Source, path: &str) -> Result<(), ConfigError> {
        let value = self.json(path)?;
        source.put(path, &value, &self.to_string()).map_err(|why| self.refuse(why))
    }
}

impl fmt::Display for Override {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.key, self.value)
    }
}

impl FromStr for Override {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "KEY=VALUE is expected, such as limits.pitch_deg=40 or mass_kg=2.1";
        let (key, value) = text.split_once('=').ok_or(expected)?;
        let plain = |c: char| c.is_ascii_alphanumeric() || "_$.[]".contains(c);
        if key.is_empty() || value.is_empty() || !key.chars().all(plain) {
            return Err(expected.to_owned());
        }
        Ok(Self { key: key.to_owned(), value: value.to_owned() })
    }
}

/// Keys with other values, by the file that each is of, with its path there.
#[derive(Clone, Debug, Default)]
pub(super) struct Overrides {
    /// Of the mission's file.
    pub(super) mission: Vec<(String, Override)>,
    /// Of the vehicle's file.
    pub(super) vehicle: Vec<(String, Override)>,
    /// Of the gains' file.
    pub(super) gains: Vec<(String, Override)>,
    /// All, in the order in which they were given.
    pub(super) all: Vec<Override>,
}

/// Puts values into the text of their file.
pub(super) fn put_all(source: &mut Source, placed: &[(String, Override)]) -> Result<(), ConfigError> {
    placed.iter().try_for_each(|(path, given)| given.put(source, path))
}
