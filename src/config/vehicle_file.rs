//! The vehicle file: `params/vehicles/*.json`, with the rotor table in a CSV beside it.
//!
//! The structs whose names end in `Json` are the file as it is written; [`load_vehicle`] checks what serde
//! cannot (relations between numbers) and builds the model. Angles are in degrees in the file and in radians
//! inside.

use std::path::Path;

use nalgebra::{Matrix3, Vector3};
use schemars::JsonSchema;
use serde::Deserialize;

use super::error::ConfigError;
use super::number::{AngleDeg, Exactly, Name, NonNegative, Positive, TimeConstantS, UnitComponent, Within};
use super::rotor_table;
use super::source::{InputHash, Source};
use crate::model::rigid_body::MassProperties;
use crate::model::{
    BodyAero, EscDc, Interference, MAX_ROTORS, Motor, RotationSense, Rotor, RotorMount, Vehicle,
    VehicleOptions,
};
use crate::units::RAD_PER_DEG;

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
    /// The motor model, the same for all rotors.
    motor: MotorJson,
    /// Where the numbers come from.
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
}

/// Reads a vehicle file and its tables.
///
/// # Errors
/// [`ConfigError`] with the place in the file, when it cannot be read or is not a vehicle.
pub fn load_vehicle(path: &Path) -> Result<VehicleFile, ConfigError> {
    load_named_vehicle(path, None, &mut InputHash::default())
}

/// As [`load_vehicle`], for a vehicle that another file names; the bytes read go into `hash`.
pub(super) fn load_named_vehicle(
    path: &Path,
    named_in: Option<&Path>,
    hash: &mut InputHash,
) -> Result<VehicleFile, ConfigError> {
    let source = Source::read(path, "vehicle file", named_in)?;
    let json: VehicleJson = source.parse()?;
    hash.absorb("vehicle", &source.text);
    let rotor = build_rotor(&source, &json.rotor, hash)?;
    let motor = build_motor(&source, &json.motor)?;
    let options = VehicleOptions {
        reaction_torque: json.effects.reaction_torque,
        rotor_momentum: json.effects.rotor_momentum,
    };
    let mass = build_mass(&source, &json)?;
    let mut mounts = build_mounts(&source, &json.rotors)?;
    if let Some(coaxial) = &json.coaxial {
        set_interference(&source, coaxial, &mut mounts)?;
    }
    let aero = build_aero(&source, json.body_aero.as_ref())?;
    let vehicle = Vehicle::new(mass, mounts, aero, rotor, motor, options)
        .map_err(|e| source.refuse("rotors", e.to_string()))?;
    check_static_thrust(&source, &vehicle)?;
    check_longest_step(&source, &vehicle)?;
    let rotor_radius_m = match &json.rotor {
        RotorModelJson::Table(rotor) => rotor.radius_m,
        RotorModelJson::Quadratic(rotor) => rotor.radius_m,
    };
    Ok(VehicleFile { name: json.name.0, vehicle, rotor_radius_m: rotor_radius_m.map(Positive::get) })
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

/// Where a rotor sits, which way it pushes and turns.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RotorJson {
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

fn build_mounts(source: &Source, rotors: &[RotorJson]) -> Result<Vec<RotorMount>, ConfigError> {
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
struct CoaxialJson {
    /// Where the factors come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Thrust of a lower rotor over that of the same rotor alone, at the same speed.
    lower_thrust_factor: Positive<2>,
    /// Torque of the air on a lower rotor over that on the same rotor alone, at the same speed.
    lower_torque_factor: Positive<2>,
}

/// How far apart the axes of a coaxial pair may be [m], and how far from parallel [rad].
const SAME_AXIS: f64 = 1e-3;

fn set_interference(
    source: &Source,
    json: &CoaxialJson,
    mounts: &mut [RotorMount],
) -> Result<(), ConfigError> {
    let lower = |below: &RotorMount, above: &RotorMount| {
        let apart = above.position_body_m - below.position_body_m;
        let along = apart.dot(&below.axis_body);
        let parallel = (above.axis_body - below.axis_body).norm() <= SAME_AXIS;
        parallel && along > SAME_AXIS && (apart - below.axis_body * along).norm() <= SAME_AXIS
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

/// Either `drag_area_m2` alone, or coefficients over the angle of attack with their reference area and span;
/// a periodic cubic spline runs through the coefficients.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct BodyAeroJson {
    /// Where the coefficients come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Drag area, the same from all sides; without lift and moment. Stands instead of all other keys [m^2].
    drag_area_m2: Option<Positive<10_000>>,
    /// Reference area S [m^2].
    reference_area_m2: Option<Positive<10_000>>,
    /// Reference span b [m].
    reference_span_m: Option<Positive<1000>>,
    /// Angles of attack, increasing from -180 to 180 [deg]; five do: -180, -90, 0, 90, 180.
    #[schemars(length(min = 4, max = 721))]
    alpha_deg: Option<Vec<AngleDeg>>,
    /// Drag coefficient at each angle, (13).
    c_drag: Option<Vec<Within<1000>>>,
    /// Lift coefficient at each angle, (14).
    c_lift: Option<Vec<Within<1000>>>,
    /// Pitching moment coefficient at each angle, (15).
    c_pitch: Option<Vec<Within<1000>>>,
}

/// Entries of a coefficient table: the spline's equations are solved as a full matrix of this size.
const MOST_ANGLES: usize = 721;
/// What stands for a coefficient table.
const FIVE_POINTS: &str = "from -180 to 180 deg; five points do: -180, -90, 0, 90, 180 with a coefficient each, or `drag_area_m2` alone";

/// The body's aerodynamics; none at all where the file has none.
fn build_aero(source: &Source, json: Option<&BodyAeroJson>) -> Result<BodyAero, ConfigError> {
    let refuse = |path: &str, message: String| source.refuse(path, message);
    let of_area = |area_m2: f64, drag: f64| {
        let turn = [-180.0, -90.0, 0.0, 90.0, 180.0].map(|a: f64| a * RAD_PER_DEG);
        BodyAero::new(area_m2, 1.0, &turn, &[drag; 5], &[0.0; 5], &[0.0; 5])
            .map_err(|e| refuse("body_aero", e.to_string()))
    };
    let Some(json) = json else { return of_area(1.0, 0.0) };
    let others = [
        ("reference_area_m2", json.reference_area_m2.is_some()),
        ("reference_span_m", json.reference_span_m.is_some()),
        ("alpha_deg", json.alpha_deg.is_some()),
        ("c_drag", json.c_drag.is_some()),
        ("c_lift", json.c_lift.is_some()),
        ("c_pitch", json.c_pitch.is_some()),
    ];
    if let Some(area) = json.drag_area_m2 {
        return match others.iter().find(|(_, given)| *given) {
            None => of_area(area.get(), 1.0),
            Some((key, _)) => {
                let message =
                    format!("expected `drag_area_m2` alone, or none of it: `{key}` stands beside it");
                Err(refuse("body_aero.drag_area_m2", message))
            }
        };
    }
    let (Some(area), Some(span), Some(alpha), Some(c_drag), Some(c_lift), Some(c_pitch)) = (
        json.reference_area_m2,
        json.reference_span_m,
        &json.alpha_deg,
        &json.c_drag,
        &json.c_lift,
        &json.c_pitch,
    ) else {
        let missing = others.iter().find(|(_, given)| !given).map_or("", |(key, _)| key);
        return Err(refuse(
            "body_aero",
            format!(
                "missing field `{missing}`; expected `drag_area_m2` alone, or reference_area_m2, reference_span_m, alpha_deg, c_drag, c_lift and \
             c_pitch"
            ),
        ));
    };
    let alpha_deg: Vec<f64> = alpha.iter().map(|a| a.get()).collect();
    let n = alpha_deg.len();
    if n > MOST_ANGLES {
        let message = format!("expected at most {MOST_ANGLES} angles, one every half degree, found {n}");
        return Err(refuse("body_aero.alpha_deg", message));
    }
    if let Some(i) = alpha_deg.windows(2).position(|w| w[1] <= w[0]) {
        let message = format!("the angles must increase, but {} follows {}", alpha_deg[i + 1], alpha_deg[i]);
        return Err(refuse(&format!("body_aero.alpha_deg[{}]", i + 1), message));
    }
    if n < 4 {
        let message = format!("expected at least 4 angles {FIVE_POINTS}; found {n}");
        return Err(refuse("body_aero.alpha_deg", message));
    }
    let columns = [("c_drag", c_drag), ("c_lift", c_lift), ("c_pitch", c_pitch)];
    for (name, column) in columns {
        if column.len() != n {
            let message = format!("expected {n} entries, one per angle of alpha_deg, found {}", column.len());
            return Err(refuse(&format!("body_aero.{name}"), message));
        }
    }
    let alpha: Vec<f64> = alpha_deg.iter().map(|a| a * RAD_PER_DEG).collect();
    let [drag, lift, pitch] = columns.map(|(_, c)| c.iter().map(|x| x.get()).collect::<Vec<_>>());
    BodyAero::new(area.get(), span.get(), &alpha, &drag, &lift, &pitch)
        .map_err(|e| refuse("body_aero", e.to_string()))
}

/// The rotor model.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum RotorModelJson {
    /// Thrust and torque by table over rotor speed, airspeed and flow angle.
    Table(RotorTableJson),
    /// Thrust = k omega^2, torque = c thrust.
    Quadratic(QuadraticJson),
}

/// A table of thrust and torque, in a CSV file.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RotorTableJson {
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

/// Thrust = k omega^2, torque = c thrust.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct QuadraticJson {
    /// Where the coefficients come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Thrust coefficient k [N/(rad/s)^2].
    thrust_n_per_rad2_s2: Positive<1000>,
    /// Torque per thrust, c [m].
    torque_per_thrust_m: NonNegative<100>,
    /// Density that k holds for [kg/m^3].
    density_kg_m3: Positive<1000>,
    /// Radius [m].
    radius_m: Option<Positive<100>>,
}

/// The rotor model; the bytes of a table go into `hash`.
fn build_rotor(source: &Source, json: &RotorModelJson, hash: &mut InputHash) -> Result<Rotor, ConfigError> {
    match json {
        RotorModelJson::Table(t) => {
            let file = Source::read(&source.resolve(&t.file), "rotor table", Some(&source.file))?;
            let table = rotor_table::parse(&file, t.density_kg_m3.get())?;
            hash.absorb("rotor table", &file.text);
            Ok(Rotor::Table(table))
        }
        RotorModelJson::Quadratic(q) => Ok(Rotor::Quadratic {
            thrust_n_per_rad2_s2: q.thrust_n_per_rad2_s2.get(),
            torque_per_thrust_m: q.torque_per_thrust_m.get(),
            density_kg_m3: q.density_kg_m3.get(),
        }),
    }
}

/// The thrust at full throttle in still air scales the control channel: a rotor that gives none cannot be
/// commanded.
fn check_static_thrust(source: &Source, vehicle: &Vehicle) -> Result<(), ConfigError> {
    let density = match &vehicle.rotor {
        Rotor::Table(table) => table.density_kg_m3(),
        Rotor::Quadratic { density_kg_m3, .. } => *density_kg_m3,
    };
    let thrust_n = vehicle.static_thrust_n(density);
    if thrust_n.is_finite() && thrust_n > 0.0 {
        return Ok(());
    }
    let message = format!(
        "expected a rotor that lifts at full throttle ({} rad/s) in still air, found a thrust of {thrust_n} N",
        vehicle.motor.omega_max_rad_s()
    );
    Err(source.refuse("rotor", message))
}

/// The motor with its speed controller.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum MotorJson {
    /// Speed controller and DC motor with limits of voltage and current.
    EscDc(EscDcJson),
    /// First-order lag with separate time constants up and down.
    FirstOrder(FirstOrderJson),
}

/// Speed controller and DC motor.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct EscDcJson {
    /// Rotor speed at full throttle [rad/s].
    omega_max_rad_s: Positive<100_000>,
    /// Torque per current [N m/A].
    torque_constant_nm_a: Positive<1000>,
    /// Voltage per speed [V s/rad].
    back_emf_constant_v_s_rad: Positive<1000>,
    /// Resistance of the winding [ohm].
    resistance_ohm: Positive<1000>,
    /// Largest voltage [V].
    voltage_max_v: Positive<100_000>,
    /// Largest current [A].
    current_max_a: Positive<100_000>,
    /// Smallest current [A]; 0: no active braking, negative: braking.
    current_min_a: Within<100_000>,
    /// Voltage per speed error [V s/rad].
    esc_gain_v_s_rad: NonNegative<1000>,
    /// Moment of inertia of rotor and motor about the shaft [kg m^2].
    rotor_inertia_kg_m2: Positive<10_000>,
}

/// First-order lag of the rotor speed.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct FirstOrderJson {
    /// Rotor speed at full throttle [rad/s].
    omega_max_rad_s: Positive<100_000>,
    /// Time constant speeding up [s].
    tau_up_s: TimeConstantS,
    /// Time constant slowing down [s].
    tau_down_s: TimeConstantS,
    /// Moment of inertia of rotor and motor about the shaft [kg m^2], for the gyroscopic moment.
    rotor_inertia_kg_m2: NonNegative<10_000>,
}

/// A struct or variant made of the JSON struct whose fields have the same names.
macro_rules! fields {
    ($($type:ident)::+, $json:ident: $($field:ident)*) => {
        $($type)::+ { $($field: $json.$field.get()),* }
    };
}

fn build_motor(source: &Source, json: &MotorJson) -> Result<Motor, ConfigError> {
    match json {
        MotorJson::EscDc(m) => {
            let (least_a, most_a) = (m.current_min_a.get(), m.current_max_a.get());
            if least_a > most_a {
                let message = format!("expected at most current_max_a, {most_a}, found {least_a}");
                return Err(source.refuse("motor.esc_dc.current_min_a", message));
            }
            Ok(Motor::EscDc(fields!(EscDc, m: omega_max_rad_s torque_constant_nm_a
                back_emf_constant_v_s_rad resistance_ohm voltage_max_v current_max_a current_min_a
                esc_gain_v_s_rad rotor_inertia_kg_m2)))
        }
        MotorJson::FirstOrder(m) => {
            Ok(fields!(Motor::FirstOrder, m: omega_max_rad_s tau_up_s tau_down_s rotor_inertia_kg_m2))
        }
    }
}

/// Least step of integration that rotors may need [s]: 1.6 time constants of 0.5 ms.
const SHORTEST_STEP_S: f64 = 0.0008;

/// Rotors that follow too fast take too many steps of integration; the time constants of the first-order
/// motor have bounds of their own.
fn check_longest_step(source: &Source, vehicle: &Vehicle) -> Result<(), ConfigError> {
    let Motor::EscDc(EscDc { rotor_inertia_kg_m2, .. }) = vehicle.motor else { return Ok(()) };
    let longest_s = vehicle.longest_step_s();
    if longest_s >= SHORTEST_STEP_S {
        return Ok(());
    }
    let message = format!(
        "expected at least {:.2e} kg m^2, found {rotor_inertia_kg_m2:?}: with these constants, R J/(K_t (K_e + K_esc)) = {:.2e} s, the speed \
         follows in less than 0.5 ms, which takes too many steps of integration",
        rotor_inertia_kg_m2 * SHORTEST_STEP_S / longest_s,
        1.0 / vehicle.motor.fastest_rate_per_s(),
    );
    Err(source.refuse("motor.esc_dc.rotor_inertia_kg_m2", message))
}
