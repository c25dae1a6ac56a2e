//! A new value of a parameter: checked against its type and range, put into effect, and what follows from it.

use super::table::Role;
use super::{Entry, Parameters, range_in_words};
use crate::autopilot::Autopilot;
use crate::control::ControlSettings;
use crate::params::export::OF_THE_CASCADE;
use crate::params::metadata::Kind;
use crate::params::{ParameterFile, Value, adopt};
use crate::units::US_PER_S;

/// A name that somebody has sent, with a question mark for what is not printable ASCII: a short text,
/// whatever was sent.
pub fn legible(name: &str) -> String {
    name.chars().map(|character| if character.is_ascii_graphic() { character } else { '?' }).collect()
}

/// Why a parameter is not changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// There is no such parameter.
    #[error("unknown parameter {}", legible(.0))]
    Unknown(String),
    /// An integer where a float is expected, or the other way round.
    #[error("{name} refused: {expected} expected")]
    WrongType {
        /// The parameter.
        name: String,
        /// The type.
        expected: &'static str,
    },
    /// A NaN, an infinity or a value outside the range.
    #[error("{name} refused: {value} where {range} is expected")]
    OutOfRange {
        /// The parameter.
        name: String,
        /// The value.
        value: Value,
        /// The range in words.
        range: String,
    },
    /// It cannot be changed here.
    #[error("{name} refused: {why}")]
    ReadOnly {
        /// The parameter.
        name: String,
        /// Why it cannot be changed.
        why: String,
    },
}

/// A value that differs from one in effect by the rounding of a file's six digits is the same.
const SAME: f64 = 5e-6;

fn same(a: Value, b: Value) -> bool {
    let (a, b) = (a.as_f64(), b.as_f64());
    (a - b).abs() <= SAME * a.abs().max(b.abs())
}

/// Each rate loop's overall gain, and the gains that it multiplies.
const RATE_LOOPS: [(&str, &[&str]); 2] =
    [("MC_PITCHRATE_K", &["MC_PITCHRATE_P", "MC_PITCHRATE_I"]), ("MC_YAWRATE_K", &["MC_YAWRATE_P"])];

impl Parameters {
    /// Changes a parameter and what flies by it; indices of all that have a new value by it, its own first. A
    /// parameter that cannot be changed takes the value that it has.
    ///
    /// # Errors
    /// [`Refusal`]; nothing is changed then.
    pub fn set(
        &mut self,
        name: &str,
        value: Value,
        autopilot: &mut Autopilot,
    ) -> Result<Vec<usize>, Refusal> {
        let index = self.index_of(name).ok_or_else(|| Refusal::Unknown(name.to_owned()))?;
        let entry = &self.entries[index];
        check(entry, value)?;
        let mut changed = vec![index];
        if !entry.role.is_settable() {
            return Ok(changed);
        }
        let old = std::mem::replace(&mut self.entries[index].value, value);
        if let Err(refusal) = self.put_into_effect(index, autopilot) {
            self.entries[index].value = old;
            return Err(refusal);
        }
        changed.extend(self.follow(index));
        Ok(changed)
    }

    /// Puts in what a file holds; returns remarks on what is not taken. Gains that a mission
    /// has taken from the same file stay what they are, to the bit.
    pub fn load(&mut self, file: &ParameterFile, autopilot: &mut Autopilot) -> Vec<String> {
        let mut remarks = Vec::new();
        let mut unknown = Vec::new();
        for (k, terms) in RATE_LOOPS {
            self.part_as_in(file, k, terms);
        }
        for (name, entry) in file.own() {
            match self.start_from(name, entry.value, autopilot) {
                Ok(()) => {}
                Err(Refusal::Unknown(name)) if OF_THE_CASCADE.contains(&name.as_str()) => {}
                Err(Refusal::Unknown(name)) => unknown.push(name),
                Err(Refusal::ReadOnly { .. }) if self.is_judged_elsewhere(name) => {}
                Err(refusal) => remarks.push(format!("line {}: {refusal}", entry.line)),
            }
        }
        if !unknown.is_empty() {
            remarks.push(format!("not parameters of samara's autopilot, ignored: {}", unknown.join(", ")));
        }
        remarks
    }

    /// Puts the settings of the start into effect, in an autopilot that knows none of them.
    pub fn settle(&self, autopilot: &mut Autopilot) {
        for entry in self.entries.iter().filter(|entry| entry.role == Role::Setting) {
            autopilot.settings.set(&entry.name, entry.value.as_f64());
        }
    }

    /// Parts the gains of a rate loop between K and the rest as a file does, K being 1 where it has none;
    /// what the file leaves out keeps its product with K.
    fn part_as_in(&mut self, file: &ParameterFile, k: &str, terms: &[&str]) {
        if !terms.iter().chain([&k]).any(|name| file.get(name).is_some()) {
            return;
        }
        let new = file.get(k).map_or(1.0, Value::as_f64);
        let Some(index) = self.index_of(k).filter(|_| new > 0.0 && new.is_finite()) else { return };
        let old = self.entries[index].value.as_f64();
        let factors = terms.iter().map(|term| (*term, old / new)).chain([(k, new / old)]);
        for (name, factor) in factors {
            if let Some(index) = self.index_of(name) {
                let entry = &mut self.entries[index];
                entry.value = Value::Real((entry.value.as_f64() * factor) as f32);
                entry.start = entry.value;
            }
        }
    }

    /// Sets a parameter, and what follows from it, as if it had been so from the start.
    fn start_from(&mut self, name: &str, value: Value, autopilot: &mut Autopilot) -> Result<(), Refusal> {
        for index in self.set(name, value, autopilot)? {
            let entry = &mut self.entries[index];
            // The file's last digit.
            if entry.name == name {
                entry.value = value;
            }
            entry.start = entry.value;
        }
        Ok(())
    }

    /// Whether [`crate::params::import`] has something to say of it when it differs.
    fn is_judged_elsewhere(&self, name: &str) -> bool {
        self.index_of(name).is_some_and(|i| {
            matches!(self.entries[i].role, Role::Follows(_) | Role::Vehicle | Role::Fact(Value::Real(_)))
        })
    }

    /// Back to the values of the start; indices of all that have a new value by it.
    pub fn reset(&mut self, autopilot: &mut Autopilot) -> Vec<usize> {
        let mut changed = Vec::new();
        for index in 0..self.entries.len() {
            let Entry { value, start, role, .. } = self.entries[index];
            if value != start && role.is_settable() {
                self.entries[index].value = start;
                // The value was in effect once.
                if self.put_into_effect(index, autopilot).is_ok() {
                    changed.push(index);
                    changed.extend(self.follow(index));
                } else {
                    self.entries[index].value = value;
                }
            }
        }
        changed
    }

    fn put_into_effect(&self, index: usize, autopilot: &mut Autopilot) -> Result<(), Refusal> {
        let entry = &self.entries[index];
        match entry.role {
            Role::Controller => {
                let touched = touched(&entry.name);
                let number = |name: &str| touched.contains(&name).then(|| self.number(name)).flatten();
                let ControlSettings { gains, limits, .. } = autopilot.control_settings();
                let (gains, limits) =
                    adopt(&self.scale, &number, (gains, limits)).map_err(|error| Refusal::OutOfRange {
                        name: entry.name.clone(),
                        value: entry.value,
                        range: error.to_string(),
                    })?;
                autopilot.configure(|settings| (settings.gains, settings.limits) = (gains, limits));
            }
            Role::Hover => {
                let mass_kg = entry.value.as_f64() * self.mass_at_full_kg;
                autopilot.configure(|settings| settings.airframe.mass_kg = mass_kg);
            }
            Role::Setting => {
                // What its range lets through it takes.
                autopilot.settings.set(&entry.name, entry.value.as_f64());
            }
            Role::SetpointLife => {
                autopilot.settings.setpoint_timeout_us = (entry.value.as_f64() * US_PER_S).round() as u64;
            }
            Role::AtBeginning(_)
            | Role::Vehicle
            | Role::Fact(_)
            | Role::Follows(_)
            | Role::SystemId
            | Role::Estimator => {}
        }
        Ok(())
    }

    /// Roll's parameters after a change of pitch's. Roll keeps its overall gain K; its P and I carry the
    /// difference.
    fn follow(&mut self, leader: usize) -> Vec<usize> {
        let leader = self.entries[leader].name.clone();
        let per_torque = self.scale.pitch / self.scale.roll;
        let of = |name: &str| self.number(name).unwrap_or(1.0);
        let (k, roll_k) = (of("MC_PITCHRATE_K"), of("MC_ROLLRATE_K"));
        let rate = |term: &str| of(term) * k * per_torque / roll_k;
        let followers = match leader.as_str() {
            "MC_PITCH_P" => vec![("MC_ROLL_P", of("MC_PITCH_P"))],
            "MC_PITCHRATE_MAX" => vec![("MC_ROLLRATE_MAX", of("MC_PITCHRATE_MAX"))],
            "MC_PR_INT_LIM" => vec![("MC_RR_INT_LIM", of("MC_PR_INT_LIM") * per_torque)],
            "MC_PITCHRATE_P" => vec![("MC_ROLLRATE_P", rate("MC_PITCHRATE_P"))],
            "MC_PITCHRATE_I" => vec![("MC_ROLLRATE_I", rate("MC_PITCHRATE_I"))],
            "MC_PITCHRATE_K" => {
                vec![("MC_ROLLRATE_P", rate("MC_PITCHRATE_P")), ("MC_ROLLRATE_I", rate("MC_PITCHRATE_I"))]
            }
            _ => Vec::new(),
        };
        let mut changed = Vec::new();
        for (name, value) in followers {
            if let Some(index) = self.index_of(name) {
                self.entries[index].value = Value::Real(value as f32);
                changed.push(index);
            }
        }
        changed
    }
}

/// The parameters that must be read together with one to know its gain: K of a rate loop multiplies its P and
/// I.
fn touched(name: &str) -> Vec<&str> {
    match name {
        "MC_PITCHRATE_P" => vec!["MC_PITCHRATE_K", "MC_PITCHRATE_P"],
        "MC_PITCHRATE_I" => vec!["MC_PITCHRATE_K", "MC_PITCHRATE_I"],
        "MC_PITCHRATE_K" => vec!["MC_PITCHRATE_K", "MC_PITCHRATE_P", "MC_PITCHRATE_I"],
        "MC_YAWRATE_P" | "MC_YAWRATE_K" => vec!["MC_YAWRATE_K", "MC_YAWRATE_P"],
        name => vec![name],
    }
}

fn check_type(entry: &Entry, value: Value) -> Result<(), Refusal> {
    let expected = match (entry.known.kind, value) {
        (Kind::Int, Value::Real(_)) => "type 6 (INT32)",
        (Kind::Float, Value::Int(_)) => "type 9 (REAL32)",
        _ => return Ok(()),
    };
    Err(Refusal::WrongType { name: entry.name.clone(), expected })
}

fn check(entry: &Entry, value: Value) -> Result<(), Refusal> {
    check_type(entry, value)?;
    let (name, x) = (entry.name.clone(), value.as_f64());
    if x.is_finite() && same(value, entry.value) {
        Ok(())
    } else if x.is_finite() && !entry.role.is_settable() {
        Err(Refusal::ReadOnly { name, why: entry.role.words() })
    } else if !(x.is_finite() && entry.known.contains(x)) {
        Err(Refusal::OutOfRange { name, value, range: range_in_words(&entry.known) })
    } else {
        Ok(())
    }
}
