//! The vehicle file: `params/vehicles/*.json`, with the rotor table in a CSV beside it.
//!
//! The structs whose names end in `Json` are the file as it is written; [`load_vehicle`] checks what serde
//! cannot (relations between numbers) and builds the model. Angles are in degrees in the file and in radians
//! inside. Rotors, body aerodynamics and motor have a file each.

use std::path::{Path, PathBuf};

use nalgebra::Matrix3;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value;

use self::aero::{BodyAeroJson, build_aero};
pub use self::blade_element::BladeFile;
use self::motor::{MotorJson, build_motor, check_longest_step};
use self::rotors::{
    CoaxialJson, RotorFactorsJson, RotorJson, RotorModelJson, build_mounts, build_rotor, check_static_thrust,
    set_interference, turning_backwards,
};
use self::start::{RotorStartJson, build_start};
use super::error::ConfigError;
use super::estimated::{Origin, OriginJson, origins_and_estimates};
use super::number::{Exactly, Name, Positive, Within};
use super::source::{InputHash, Source};
use super::uncertain::UncertainJson;
use samara_core::model::rigid_body::MassProperties;
use samara_core::model::{Rotor, Vehicle, VehicleOptions};
use samara_core::uncertain::{UncertainQuantity, Uncertainty};

mod aero;
mod blade_element;
mod motor;
mod rotors;
mod start;

/// A multirotor: mass, rotors, body aerodynamics, rotor and motor models. Body axes: x forward, y right, z
/// down.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct VehicleJson {
    /// JSON schema of the file, for editors; samara does not read it.
    #[serde(rename = "$schema")]
    _schema: Option<String>,
    /// Description of the vehicle, for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Name of the vehicle.
    name: Name,
    /// Mass [kg].
    mass_kg: Positive<100_000>,
    /// Moments of inertia about the centre of mass, Jxx, Jyy, Jzz [kg m^2]. Each is at most the sum of the
    /// others.
    inertia_kg_m2: Exactly<Positive<10_000_000>, 3>,
    /// Off-diagonal entries Jxy, Jxz, Jyz of the inertia matrix [kg m^2], with the sign that they have in the
    /// matrix; 0 when left out.
    inertia_off_diagonal_kg_m2: Option<Exactly<Within<10_000_000>, 3>>,
    /// The rotors, 1 to 8, in PX4's order (quad-X: front right, rear left, front left, rear right).
    #[schemars(length(min = 1, max = 8))]
    rotors: Vec<RotorJson>,
    /// What the upper rotor of a coaxial pair leaves to the lower one; without it each rotor works as if
    /// alone.
    coaxial: Option<CoaxialJson>,
    /// Which reactions of the rotors on the body are modelled.
    effects: EffectsJson,
    /// Body aerodynamics, (13)-(18); none when left out.
    body_aero: Option<BodyAeroJson>,
    /// The rotor model, the same for all rotors.
    rotor: RotorModelJson,
    /// Factors on thrust and torque of the rotor model, as flights have shown them; 1 when left out.
    rotor_factors: Option<RotorFactorsJson>,
    /// The motor model, the same for all rotors.
    motor: MotorJson,
    /// Rotors before their motors drive them, and their start; without it rotors are held at rest until t =
    /// 0, and driven from there on.
    rotor_start: Option<RotorStartJson>,
    /// How far numbers of the vehicle may be off; missions draw it, and may override it.
    uncertain: Option<UncertainJson>,
    /// Keys of this file whose numbers are estimated or guessed, neither measured nor given by a data sheet,
    /// as paths (`inertia_kg_m2`, `motor.first_order.tau_up_s`); a section's key stands for all that is in
    /// it. None: `[]`. A release card asks for their acceptance, also where this key is left out, since
    /// nobody knows then.
    estimated: Option<Vec<String>>,
    /// Where numbers of this file are from, as data: each key once. Those estimated or guessed count as
    /// `estimated`, too.
    origins: Option<Vec<OriginJson>>,
    /// Where the numbers come from, for the reader.
    #[serde(rename = "provenance")]
    _provenance: Option<Vec<String>>,
}

/// A vehicle as its file describes it.
#[derive(Clone, Debug)]
pub struct VehicleFile {
    /// The vehicle's name.
    pub name: String,
    /// The model.
    pub vehicle: Vehicle,
    /// Radius of a rotor [m], where the file gives one.
    pub rotor_radius_m: Option<f64>,
    /// Where the file says that its numbers are from.
    pub origins: Vec<Origin>,
    /// Keys of its file whose numbers are estimated; `None`: the file does not say.
    pub estimated: Option<Vec<String>>,
    /// How far what the file says may be off; `None`: the file does not say.
    pub uncertain: Option<Uncertainty>,
}

/// Reads a vehicle file and its tables.
///
/// # Errors
/// [`ConfigError`] with the place in the file, when it cannot be read or is not a vehicle.
pub fn load_vehicle(path: &Path) -> Result<VehicleFile, ConfigError> {
    vehicle_of(&Source::read(path, "vehicle file", None)?, &mut InputHash::default(), None)
}

/// The blades of a vehicle file, whether or not there is a table of their coefficients.
///
/// # Errors
/// [`ConfigError`] with the place in the file, when it cannot be read, is not a vehicle or has no blades.
pub fn blade_file(path: &Path) -> Result<BladeFile, ConfigError> {
    let source = Source::read(path, "vehicle file", None)?;
    let json: VehicleJson = source.parse()?;
    match &json.rotor {
        RotorModelJson::BladeElement(rotor) => rotor.file(&source),
        _ => {
            let message = "expected `blade_element`, a rotor whose blades are known, found another model";
            Err(source.refuse("rotor", message.to_owned()))
        }
    }
}

/// The rotor that was read last, whose table has thousands of lines: where the keys of the next one are the
/// same, in a vehicle of the same path, it is that one.
#[derive(Clone, Debug, Default)]
pub(super) struct KnownRotor(Option<(PathBuf, Value, Rotor)>);

impl KnownRotor {
    fn rotor(&mut self, source: &Source, json: &RotorModelJson) -> Result<Rotor, ConfigError> {
        let keys = source.value("rotor").unwrap_or_default();
        if let Some((file, known, rotor)) = &self.0
            && (file, known) == (&source.file, &keys)
        {
            return Ok(rotor.clone());
        }
        let rotor = build_rotor(source, json, &mut InputHash::default())?;
        self.0 = Some((source.file.clone(), keys, rotor.clone()));
        Ok(rotor)
    }
}

/// The vehicle of a text, with its tables; all that is read goes into `hash`, but for a rotor's table where
/// `known` gives the rotor.
pub(super) fn vehicle_of(
    source: &Source,
    hash: &mut InputHash,
    known: Option<&mut KnownRotor>,
) -> Result<VehicleFile, ConfigError> {
    let json: VehicleJson = source.parse()?;
    hash.absorb("vehicle", &source.text);
    let mut rotor = match known {
        Some(known) => known.rotor(source, &json.rotor)?,
        None => build_rotor(source, &json.rotor, hash)?,
    };
    let motor = build_motor(source, &json.motor)?;
    let mut start = None;
    if let Some(start_json) = &json.rotor_start {
        start = Some(build_start(source, start_json, &rotor, &motor)?);
        rotor = turning_backwards(source, &json.rotor, rotor)?;
    }
    if let Some(factors) = &json.rotor_factors {
        rotor = rotor.scaled([factors.thrust_factor.get(), factors.torque_factor.get()]);
    }
    let options = VehicleOptions {
        reaction_torque: json.effects.reaction_torque,
        rotor_momentum: json.effects.rotor_momentum,
    };
    let mass = build_mass(source, &json)?;
    let mut mounts = build_mounts(source, &json.rotors)?;
    if let Some(coaxial) = &json.coaxial {
        set_interference(source, coaxial, &mut mounts)?;
    }
    let aero = build_aero(source, json.body_aero.as_ref())?;
    let vehicle = Vehicle::new(mass, mounts, aero, rotor, motor, options)
        .map_err(|e| source.refuse("rotors", e.to_string()))?;
    let vehicle = Vehicle { start, ..vehicle };
    check_static_thrust(source, &vehicle)?;
    check_longest_step(source, &vehicle)?;
    let (origins, estimated) = origins_and_estimates(source, json.origins.as_ref(), json.estimated.as_ref())?;
    let uncertain = json
        .uncertain
        .as_ref()
        .map(|uncertain| uncertain.uncertainty(source, UncertainQuantity::is_of_vehicle))
        .transpose()?;
    let rotor_radius_m = json.rotor.radius_m();
    Ok(VehicleFile { name: json.name.0, vehicle, rotor_radius_m, origins, estimated, uncertain })
}

/// Which reactions of the rotors on the body are modelled.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct EffectsJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// The torque that turns a rotor turns the body the other way.
    reaction_torque: bool,
    /// The rotors' angular momentum acts on the body, (19)-(22).
    rotor_momentum: bool,
}

fn build_mass(source: &Source, json: &VehicleJson) -> Result<MassProperties, ConfigError> {
    let [xx, yy, zz] = json.inertia_kg_m2.0.map(Positive::get);
    let [xy, xz, yz] = json.inertia_off_diagonal_kg_m2.map_or([0.0; 3], Exactly::get);
    let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    MassProperties::new(json.mass_kg.get(), inertia)
        .map_err(|e| source.refuse("inertia_kg_m2", e.to_string()))
}
