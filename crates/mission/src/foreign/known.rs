//! Numbers of a vehicle with the place that they are from, and what several files come to together.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::error::ConfigError;
use samara_core::model::RotorMount;

/// What a file is, for errors.
pub(super) const ROLE: &str = "file of a vehicle";

/// A number of a vehicle that a file may have, by its key in the vehicle file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Key {
    /// Mass [kg].
    Mass,
    /// Thrust over the square of the rotor speed [N/(rad/s)^2].
    Thrust,
    /// Torque per thrust [m].
    Torque,
    /// Force in the rotor's plane over rotor speed and speed across the axis [N/((rad/s)(m/s))].
    Drag,
    /// Radius of a rotor [m].
    Radius,
    /// Rotor speed at full throttle [rad/s].
    OmegaMax,
    /// Time constant of a motor speeding up [s].
    TauUp,
    /// Time constant of a motor slowing down [s].
    TauDown,
    /// Moment of inertia of a rotor about its shaft [kg m^2].
    RotorInertia,
    /// Share of the full thrust that hovers; no key of the vehicle file.
    Hover,
}

impl Key {
    /// The key's path in the vehicle file; of [`Key::Hover`] PX4's parameter.
    pub fn path(self) -> &'static str {
        match self {
            Self::Mass => "mass_kg",
            Self::Thrust => "rotor.quadratic.thrust_n_per_rad2_s2",
            Self::Torque => "rotor.quadratic.torque_per_thrust_m",
            Self::Drag => "rotor.quadratic.drag_n_s2_per_rad_m",
            Self::Radius => "rotor.quadratic.radius_m",
            Self::OmegaMax => "motor.first_order.omega_max_rad_s",
            Self::TauUp => "motor.first_order.tau_up_s",
            Self::TauDown => "motor.first_order.tau_down_s",
            Self::RotorInertia => "motor.first_order.rotor_inertia_kg_m2",
            Self::Hover => "MPC_THR_HOVER",
        }
    }
}

/// A place in a file, for errors.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) file: PathBuf,
    pub(super) line: usize,
    pub(super) column: usize,
    /// What stands there: a parameter, an element.
    pub(super) what: String,
}

impl Place {
    pub(super) fn refuse(&self, message: impl Into<String>) -> ConfigError {
        let Self { file, line, column, what } = self.clone();
        ConfigError::Content { file, line, column, json_path: what, message: message.into() }
    }
}

/// What a file says, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct Known<T> {
    /// The value that it says.
    pub value: T,
    /// Name of the file, with the folder that it lies in.
    pub file: String,
    /// Where in the file, in words.
    pub words: String,
    place: Place,
}

impl<T> Known<T> {
    pub(super) fn new(value: T, words: String, place: Place) -> Self {
        Self { value, file: short(&place.file), words, place }
    }

    /// Refuses what the file says, with its place there.
    pub fn refuse(&self, message: impl Into<String>) -> ConfigError {
        self.place.refuse(message)
    }
}

/// Rotors as files have them.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownRotors {
    /// The rotors in PX4's order; positions from the centre of mass, body axes, in metres or as directions.
    pub rotors: Vec<RotorMount>,
    /// Whether positions are metres; else they are directions, of which nobody knows the length.
    pub in_metres: bool,
}

impl KnownRotors {
    /// From the centre of mass to the farthest hub, across the vertical axis [m]; of directions without a
    /// unit.
    pub fn arm(&self) -> f64 {
        self.rotors.iter().map(|rotor| rotor.position_body_m.xy().norm()).fold(0.0, f64::max)
    }

    /// The rotors with this distance from the centre of mass to the farthest hub [m].
    #[must_use]
    pub fn with_arm(mut self, arm_m: f64) -> Self {
        let scale = arm_m / self.arm();
        self.rotors.iter_mut().for_each(|rotor| rotor.position_body_m *= scale);
        Self { in_metres: true, ..self }
    }

    /// Whether the other rotors are in those places, or in those directions, and turn the same ways.
    fn agrees(&self, other: &Self) -> bool {
        let unit = if self.in_metres && other.in_metres { 1.0 } else { self.arm() / other.arm() };
        let close = |(a, b): (&RotorMount, &RotorMount)| {
            let apart = a.position_body_m - b.position_body_m * unit;
            let level = if unit == 1.0 { apart.norm() } else { apart.xy().norm() };
            a.spin == b.spin && level <= 0.02 * self.arm()
        };
        self.rotors.len() == other.rotors.len() && self.rotors.iter().zip(&other.rotors).all(close)
    }
}

/// What files say of a vehicle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KnownVehicle {
    /// Numbers, by their keys.
    pub numbers: BTreeMap<Key, Known<f64>>,
    /// Jxx, Jyy, Jzz, Jxy, Jxz, Jyz about the centre of mass, body axes, off-diagonals as they stand in the
    /// matrix [kg m^2].
    pub inertia_kg_m2: Option<Known<[f64; 6]>>,
    /// The rotors.
    pub rotors: Option<Known<KnownRotors>>,
    /// What is to be told: what two files disagree on, what was not taken and why.
    pub remarks: Vec<String>,
}

/// Share by which two numbers may differ and say the same.
const SAME: f64 = 1e-6;

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(b.abs())
}

impl KnownVehicle {
    /// What a file says of a number.
    pub fn number(&self, key: Key) -> Option<f64> {
        self.numbers.get(&key).map(|known| known.value)
    }

    pub(super) fn put(&mut self, key: Key, known: Known<f64>) {
        self.numbers.insert(key, known);
    }

    /// Takes what a later file says.
    pub(super) fn add(&mut self, later: Self) {
        self.remarks.extend(later.remarks);
        for (key, number) in later.numbers {
            if let Some(before) = self.numbers.get(&key).filter(|before| !same(before.value, number.value)) {
                let (was, is) = (before.value, number.value);
                let remark = disagreement(key.path(), (&number.file, is), (&before.file, was));
                self.remarks.push(remark);
            }
            self.numbers.insert(key, number);
        }
        if let Some(inertia) = later.inertia_kg_m2 {
            let differ = |before: &Known<[f64; 6]>| {
                let largest = before.value.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
                before.value.iter().zip(inertia.value).any(|(a, b)| (a - b).abs() > SAME * largest)
            };
            if let Some(before) = self.inertia_kg_m2.as_ref().filter(|before| differ(before)) {
                self.remarks.push(format!("inertia_kg_m2: {} stands, not {}", inertia.file, before.file));
            }
            self.inertia_kg_m2 = Some(inertia);
        }
        let Some(rotors) = later.rotors else { return };
        let Some(before) = self.rotors.take() else {
            self.rotors = Some(rotors);
            return;
        };
        let earlier_stands = before.value.in_metres && !rotors.value.in_metres;
        let (stands, falls) = if earlier_stands { (before, rotors) } else { (rotors, before) };
        if !stands.value.agrees(&falls.value) {
            self.remarks.push(format!(
                "rotors: {} stands, not {}, where they are elsewhere or turn otherwise",
                stands.file, falls.file
            ));
        }
        self.rotors = Some(stands);
    }
}

fn disagreement(key: &str, stands: (&str, f64), falls: (&str, f64)) -> String {
    format!("{key}: {} of {} stands, not {} of {}", stands.1, stands.0, falls.1, falls.0)
}

/// A file's name with the folder that it lies in, with `/`.
pub(super) fn short(file: &Path) -> String {
    let names: Vec<_> = file
        .components()
        .filter_map(|part| match part {
            std::path::Component::Normal(name) => Some(name.to_string_lossy()),
            _ => None,
        })
        .collect();
    names[names.len().saturating_sub(2)..].join("/")
}
