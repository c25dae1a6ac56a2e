//! PX4's parameters of an airframe script, a parameter file or a log: the rotors of its control allocation,
//! and where it hovers.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use super::known::{Key, Known, KnownRotors, KnownVehicle, Place, short};
use super::rotors;
use crate::error::ConfigError;
use crate::params_file::load_parameters;
use samara_core::model::{Interference, RotationSense, RotorMount};

/// What CA_AIRFRAME says beside 0, a multirotor, from 1 on (PX4 v1.16, control_allocator/module.yaml).
const AIRFRAMES: [&str; 15] = [
    "a fixed-wing aircraft",
    "a standard VTOL",
    "a tiltrotor VTOL",
    "a tailsitter VTOL",
    "a rover",
    "a rover",
    "a vehicle with motors in six directions",
    "a multirotor whose rotors tilt",
    "a custom airframe",
    "a helicopter",
    "a helicopter",
    "a helicopter",
    "a rover",
    "a spacecraft",
    "a spacecraft",
];
/// PX4's defaults of CA_ROTORn_KM and MPC_THR_HOVER, which say nothing of a vehicle.
const DEFAULT_KM: f64 = 0.05;
const DEFAULT_HOVER: f64 = 0.5;
/// Arms of PX4's generic airframes [m].
const GENERIC_ARM_M: f64 = 0.5;
/// Files that run one another.
const DEEPEST: usize = 8;

/// A parameter's value, and its file and line.
struct Set {
    value: f64,
    file: PathBuf,
    line: usize,
}

#[derive(Default)]
struct Parameters {
    set: BTreeMap<String, Set>,
    remarks: Vec<String>,
}

impl Parameters {
    fn get(&self, name: &str) -> Option<f64> {
        self.set.get(name).map(|set| set.value)
    }

    fn place(&self, name: &str, file: &Path) -> Place {
        let (file, line) = self.set.get(name).map_or((file, 1), |set| (&set.file, set.line));
        Place { file: file.to_owned(), line, column: 1, what: name.to_owned() }
    }

    /// Takes a file's parameters over those of the airframes beside it that it runs.
    fn take(&mut self, file: &Path, depth: usize) -> Result<(), ConfigError> {
        let parameters = load_parameters(file)?;
        for (line, script) in parameters.scripts() {
            let name = script.rsplit('/').next().unwrap_or(script);
            let place = Place { file: file.to_owned(), line: *line, column: 1, what: name.to_owned() };
            if let Some(kind) = name.strip_prefix("rc.").and_then(|rest| rest.strip_suffix("_defaults")) {
                if kind != "mc" && kind != "board" {
                    return Err(place.refuse("expected rc.mc_defaults: multirotors alone are read"));
                }
            } else if name.starts_with(|c: char| c.is_ascii_digit()) {
                let beside = file.with_file_name(name);
                if depth >= DEEPEST {
                    return Err(place.refuse(format!("more than {DEEPEST} airframes run one another")));
                }
                if beside.is_file() {
                    self.take(&beside, depth + 1)?;
                } else {
                    let file = short(file);
                    self.remarks.push(format!("{file} runs {name}, which is not beside it: passed over"));
                }
            }
        }
        for (name, entry) in parameters.own() {
            // The shortest text has the digits that the file had before they were single precision.
            let value = entry.value.to_string().parse().unwrap_or_else(|_| entry.value.as_f64());
            self.set.insert(name.to_owned(), Set { value, file: file.to_owned(), line: entry.line });
        }
        Ok(())
    }
}

/// What the parameters of a file say of a vehicle.
pub(super) fn read(file: &Path) -> Result<KnownVehicle, ConfigError> {
    let mut all = Parameters::default();
    all.take(file, 0)?;
    let kind = all.get("CA_AIRFRAME").unwrap_or(0.0);
    if kind != 0.0 {
        let name = AIRFRAMES.get((kind as usize).wrapping_sub(1)).unwrap_or(&"no airframe of PX4's");
        let message = format!("expected 0, a multirotor, found {kind}, {name}");
        return Err(all.place("CA_AIRFRAME", file).refuse(message));
    }
    let mut known = KnownVehicle { remarks: std::mem::take(&mut all.remarks), ..KnownVehicle::default() };
    if let Some(rotors) = allocated(&all, file, &mut known)? {
        known.rotors = Some(rotors);
    }
    if let Some(hover) = all.get("MPC_THR_HOVER").filter(|hover| *hover != DEFAULT_HOVER) {
        let place = all.place("MPC_THR_HOVER", file);
        if !(hover > 0.0 && hover < 1.0) {
            return Err(place.refuse(format!("expected a share between 0 and 1, found {hover}")));
        }
        let factor = all.get("THR_MDL_FAC").unwrap_or(0.0);
        let words = format!("MPC_THR_HOVER {hover}, THR_MDL_FAC {factor}");
        known.put(Key::Hover, Known::new(hover, words, place));
    }
    if known.rotors.is_none() && known.numbers.is_empty() {
        let name = short(file);
        known.remarks.push(format!("{name} says nothing of rotors (CA_ROTOR_COUNT, CA_ROTOR0_PX, ..)"));
    }
    Ok(known)
}

/// The rotors of PX4's control allocation, where the file has some.
fn allocated(
    all: &Parameters,
    file: &Path,
    known: &mut KnownVehicle,
) -> Result<Option<Known<KnownRotors>>, ConfigError> {
    let has = |i: usize| {
        let axes = ["PX", "PY"].map(|axis| format!("CA_ROTOR{i}_{axis}"));
        axes.into_iter().find(|name| all.set.contains_key(name))
    };
    let count = match all.get("CA_ROTOR_COUNT") {
        Some(count) => count.max(0.0) as usize,
        None => (0..).take_while(|i| has(*i).is_some()).count(),
    };
    if count == 0 {
        return Ok(None);
    }
    let counted = all.place("CA_ROTOR_COUNT", file);
    rotors::check_count(count, &counted)?;
    let (mut mounts, mut places, mut moments) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..count {
        let value = |what: &str, default: f64| all.get(&format!("CA_ROTOR{i}_{what}")).unwrap_or(default);
        let vector = |what: &str, [x, y, z]: [f64; 3]| {
            let at = |axis: char, default| value(&format!("{what}{axis}"), default);
            Vector3::new(at('X', x), at('Y', y), at('Z', z))
        };
        let Some(name) = has(i) else {
            let message = format!("{count} rotors, but CA_ROTOR{i}_PX and CA_ROTOR{i}_PY are not set");
            return Err(counted.refuse(message));
        };
        let (axis, moment) = (vector("A", [0.0, 0.0, -1.0]), value("KM", DEFAULT_KM));
        let refused =
            |what: &str, message: &str| Err(all.place(&format!("CA_ROTOR{i}_{what}"), file).refuse(message));
        if axis.norm() < 1e-6 {
            return refused("AZ", "expected a direction of the thrust, found the vector 0");
        }
        if moment == 0.0 {
            return refused("KM", "expected a number other than 0, whose sign is the sense of rotation");
        }
        mounts.push(RotorMount {
            position_body_m: vector("P", [0.0; 3]),
            axis_body: axis / axis.norm(),
            spin: if moment > 0.0 { RotationSense::Ccw } else { RotationSense::Cw },
            interference: Interference::NONE,
        });
        places.push(all.place(&name, file));
        moments.push(moment.abs());
    }
    rotors::check(&mounts, &places)?;
    let in_metres = !mounts.iter().all(|mount| is_direction(mount.position_body_m));
    let place = places.swap_remove(0);
    let at = |words: String, value| Known::new(value, words, place.clone());
    let last = count - 1;
    let one = |of: &[f64]| of.iter().all(|x| *x == of[0]).then_some(of[0]);
    if let Some(moment) = one(&moments).filter(|moment| in_metres && *moment != DEFAULT_KM) {
        known.put(Key::Torque, at(format!("CA_ROTOR0_KM to CA_ROTOR{last}_KM"), moment));
    }
    let rotors = KnownRotors { rotors: mounts, in_metres };
    if in_metres
        && rotors.rotors.iter().all(|mount| (mount.position_body_m.xy().norm() - GENERIC_ARM_M).abs() < 0.01)
    {
        known.remarks.push(format!(
            "{}: arms of {GENERIC_ARM_M} m, which PX4's generic airframes have whatever the vehicle; --arm replaces them",
            short(&place.file)
        ));
    }
    let words = format!(
        "CA_ROTOR0 to CA_ROTOR{last}{}",
        if in_metres { "" } else { ", which are directions, with the arm that was told" }
    );
    Ok(Some(Known::new(rotors, words, place)))
}

/// Whether a position has the length of 1 on each axis or altogether, which says the direction alone.
fn is_direction(position: Vector3<f64>) -> bool {
    let level = position.xy();
    let ones = level.iter().all(|x| *x == 0.0 || x.abs() == 1.0);
    ones || (level.norm() - 1.0).abs() < 0.005
}
