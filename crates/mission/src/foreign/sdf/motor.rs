//! A motor, as the plugin of Gazebo's multicopter motor model has it.

use super::element::Element;
use crate::error::ConfigError;
use crate::foreign::known::{Key, Place};
use samara_core::model::RotationSense;

/// Constants that all motors share: the plugin's element, the key, and bounds as the vehicle file has them.
pub(super) const CONSTANTS: [(&str, Key, f64, f64); 6] = [
    ("motorConstant", Key::Thrust, 0.0, 1000.0),
    ("momentConstant", Key::Torque, 0.0, 100.0),
    ("rotorDragCoefficient", Key::Drag, 0.0, 1000.0),
    ("maxRotVelocity", Key::OmegaMax, 0.0, 100_000.0),
    ("timeConstantUp", Key::TauUp, 0.0005, 100.0),
    ("timeConstantDown", Key::TauDown, 0.0005, 100.0),
];

/// A motor's plugin.
pub(super) struct Motor {
    /// From 0, in PX4's order.
    pub(super) number: usize,
    /// Name of the link that turns.
    pub(super) link: String,
    pub(super) spin: RotationSense,
    /// As [`CONSTANTS`] has them, where the plugin does, with their places.
    pub(super) constants: [Option<(f64, Place)>; CONSTANTS.len()],
    pub(super) place: Place,
}

impl Motor {
    pub(super) fn read(plugin: Element, prefix: &str) -> Result<Self, ConfigError> {
        if let Some(kind) = plugin.child("motorType").filter(|kind| kind.text() != "velocity") {
            return Err(kind.refuse("expected `velocity`: other motors are not read"));
        }
        if let Some(slowed) = plugin.child("rotorVelocitySlowdownSim") {
            // What turns slower is the picture: all other numbers are those of the rotor itself.
            slowed.positive(1e6)?;
        }
        let direction = plugin.needed("turningDirection")?;
        let spin = match direction.text() {
            "ccw" | "1" => RotationSense::Ccw,
            "cw" | "-1" => RotationSense::Cw,
            _ => return Err(direction.refuse("expected `cw` or `ccw`")),
        };
        let number = plugin.needed("motorNumber")?;
        let [index] = number.numbers()?;
        if index.fract() != 0.0 || !(0.0..1000.0).contains(&index) {
            return Err(number.refuse(format!("expected a whole number from 0 on, found {index}")));
        }
        let mut constants = [const { None }; CONSTANTS.len()];
        for ((name, key, low, high), constant) in CONSTANTS.into_iter().zip(&mut constants) {
            let element = match key {
                Key::Thrust | Key::OmegaMax => Some(plugin.needed(name)?),
                _ => plugin.child(name),
            };
            let Some(element) = element else { continue };
            let value = match key {
                Key::Torque | Key::Drag | Key::TauUp | Key::TauDown => element.from(low, high)?,
                _ => element.positive(high)?,
            };
            *constant = Some((value, element.place()));
        }
        let link = format!("{prefix}{}", plugin.needed("linkName")?.text());
        Ok(Self { number: index as usize, link, spin, constants, place: plugin.place() })
    }
}
