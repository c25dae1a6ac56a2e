//! The rotors of a vehicle file: where they sit, what a coaxial pair loses, and their model.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Deserialize;

use super::blade_element::{BladeElementJson, build_coefficients};
use crate::error::ConfigError;
use crate::number::{Exactly, NonNegative, Positive, UnitComponent, Within};
use crate::rotor_table;
use crate::source::{InputHash, Source};
use samara_core::model::{Interference, MAX_ROTORS, RotationSense, Rotor, RotorMount, SAME_AXIS, Vehicle};

/// Where a rotor sits, which way it pushes and turns.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RotorJson {
    /// Hub, from the centre of mass, body axes [m].
    position_body_m: Exactly<Within<100>, 3>,
    /// Unit vector of the thrust, body axes; [0, 0, -1] pushes up.
    axis_body: Exactly<UnitComponent, 3>,
    /// Sense of rotation, seen from above.
    spin_from_above: SpinJson,
}

/// Sense of rotation.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum SpinJson {
    /// Clockwise.
    Cw,
    /// Counter-clockwise.
    Ccw,
}

pub(super) fn build_mounts(source: &Source, rotors: &[RotorJson]) -> Result<Vec<RotorMount>, ConfigError> {
    if !(1..=MAX_ROTORS).contains(&rotors.len()) {
        let message = format!("expected 1 to {MAX_ROTORS} rotors, found {}", rotors.len());
        return Err(source.refuse("rotors", message));
    }
    let mount = |(i, r): (usize, &RotorJson)| {
        let axis = Vector3::from(r.axis_body.0.map(UnitComponent::get));
        if (axis.norm() - 1.0).abs() >= 1e-6 {
            let message = format!("expected a vector of length 1, found length {}", axis.norm());
            return Err(source.refuse(&format!("rotors[{i}].axis_body"), message));
        }
        let spin = match r.spin_from_above {
            SpinJson::Cw => RotationSense::Cw,
            SpinJson::Ccw => RotationSense::Ccw,
        };
        let position_body_m = r.position_body_m.get().into();
        Ok(RotorMount { position_body_m, axis_body: axis, spin, interference: Interference::NONE })
    };
    rotors.iter().enumerate().map(mount).collect()
}

/// Interference of coaxial rotors, steady. A rotor is a lower one when another sits on its axis, ahead of it
/// in the direction of its thrust; it works in that one's wake, whatever the speed of that one. The upper
/// rotor works as if alone.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CoaxialJson {
    /// Where the factors come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Thrust of a lower rotor over that of the same rotor alone, at the same speed.
    lower_thrust_factor: Positive<2>,
    /// Torque of the air on a lower rotor over that on the same rotor alone, at the same speed.
    lower_torque_factor: Positive<2>,
}

/// Factors on what the rotor model has.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RotorFactorsJson {
    /// Where the factors come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Factor on the thrust, and on the force in the rotor's plane.
    pub(super) thrust_factor: Positive<10>,
    /// Factor on the torque of the air.
    pub(super) torque_factor: Positive<10>,
}

pub(super) fn set_interference(
    source: &Source,
    json: &CoaxialJson,
    mounts: &mut [RotorMount],
) -> Result<(), ConfigError> {
    let lower = |below: &RotorMount, above: &RotorMount| {
        below.beside_the_axis_above_m(above).is_some_and(|beside_m| beside_m <= SAME_AXIS)
    };
    let is_lower: Vec<bool> =
        mounts.iter().map(|below| mounts.iter().any(|above| lower(below, above))).collect();
    if !is_lower.contains(&true) {
        let message = "expected a rotor on another one's axis, below it, found none among the rotors";
        return Err(source.refuse("coaxial", message.to_owned()));
    }
    for (mount, _) in mounts.iter_mut().zip(is_lower).filter(|(_, is_lower)| *is_lower) {
        let (thrust, torque) = (json.lower_thrust_factor.get(), json.lower_torque_factor.get());
        mount.interference = Interference { thrust, torque };
    }
    Ok(())
}

/// The rotor model.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum RotorModelJson {
    /// Thrust, in-plane force and torque of known blades in any flow, from rest on.
    BladeElement(BladeElementJson),
    /// Thrust and torque by table over rotor speed, airspeed and flow angle.
    Table(RotorTableJson),
    /// Thrust = k omega^2, torque = c thrust, in-plane force = h omega V.
    Quadratic(QuadraticJson),
}

/// A table of thrust and torque, in a CSV file.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RotorTableJson {
    /// How the table was made.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// CSV file, relative to this file; columns omega_rad_s, airspeed_m_s, angle_deg, thrust_n, torque_nm, a
    /// full grid with the angle running fastest, then the airspeed.
    file: String,
    /// Density that the table holds for; thrust and torque scale with density [kg/m^3].
    density_kg_m3: Positive<1000>,
    /// Radius [m].
    radius_m: Option<Positive<100>>,
}

/// Thrust = k omega^2, torque = c thrust, in-plane force = h omega V.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct QuadraticJson {
    /// Where the coefficients come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Thrust coefficient k [N/(rad/s)^2].
    thrust_n_per_rad2_s2: Positive<1000>,
    /// Torque per thrust, c [m].
    torque_per_thrust_m: NonNegative<100>,
    /// Force in the rotor's plane, against its motion, over rotor speed and speed across the axis
    /// [N/((rad/s)(m/s))], as rotorDragCoefficient of Gazebo's motor model; none when left out.
    drag_n_s2_per_rad_m: Option<NonNegative<1000>>,
    /// Density that thrust and drag hold for [kg/m^3].
    density_kg_m3: Positive<1000>,
    /// Radius [m].
    radius_m: Option<Positive<100>>,
}

impl RotorModelJson {
    /// Radius of a rotor [m], where the file gives one.
    pub(super) fn radius_m(&self) -> Option<f64> {
        let radius_m = match self {
            Self::BladeElement(rotor) => return Some(rotor.radius_m()),
            Self::Table(rotor) => rotor.radius_m,
            Self::Quadratic(rotor) => rotor.radius_m,
        };
        radius_m.map(Positive::get)
    }
}

/// The rotor model; the bytes of a table go into `hash`.
pub(super) fn build_rotor(
    source: &Source,
    json: &RotorModelJson,
    hash: &mut InputHash,
) -> Result<Rotor, ConfigError> {
    match json {
        RotorModelJson::BladeElement(b) => Ok(Rotor::BladeElement(build_coefficients(source, b, hash)?)),
        RotorModelJson::Table(t) => {
            let file = Source::read(&source.resolve(&t.file), "rotor table", Some(&source.file))?;
            let table = rotor_table::parse(&file, t.density_kg_m3.get())?;
            hash.absorb_named("rotor table", &file);
            Ok(Rotor::Table(table))
        }
        RotorModelJson::Quadratic(q) => Ok(Rotor::Quadratic {
            thrust_n_per_rad2_s2: q.thrust_n_per_rad2_s2.get(),
            torque_per_thrust_m: q.torque_per_thrust_m.get(),
            drag_n_s2_per_rad_m: q.drag_n_s2_per_rad_m.map_or(0.0, NonNegative::get),
            density_kg_m3: q.density_kg_m3.get(),
        }),
    }
}

/// A rotor of known blades with its coefficients when it turns backwards; another one as it is.
pub(super) fn turning_backwards(
    source: &Source,
    json: &RotorModelJson,
    rotor: Rotor,
) -> Result<Rotor, ConfigError> {
    match (json, rotor) {
        (RotorModelJson::BladeElement(b), Rotor::BladeElement(table)) => {
            Ok(Rotor::BladeElement(table.with_backwards(&b.blades(source)?)))
        }
        (_, rotor) => Ok(rotor),
    }
}

/// The thrust at full throttle in still air scales the control channel: a rotor that gives none cannot be
/// commanded.
pub(super) fn check_static_thrust(source: &Source, vehicle: &Vehicle) -> Result<(), ConfigError> {
    let thrust_n = vehicle.static_thrust_n(vehicle.rotor.reference_density_kg_m3());
    if thrust_n.is_finite() && thrust_n > 0.0 {
        return Ok(());
    }
    let message = format!(
        "expected a rotor that lifts at full throttle ({} rad/s) in still air, found a thrust of {thrust_n} N",
        vehicle.motor.omega_max_rad_s()
    );
    Err(source.refuse("rotor", message))
}
