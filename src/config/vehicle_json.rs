//! The vehicle file as it is written: `params/vehicles/*.json`. What serde cannot check, and the model objects, are
//! [`super::vehicle_file`]'s. Angles are in degrees.

use schemars::JsonSchema;
use serde::Deserialize;

use super::number::{AngleDeg, Exactly, Name, NonNegative, Positive, TimeConstantS, UnitComponent, Within};

/// A multirotor: mass, rotors, body aerodynamics, rotor and motor models. Body axes: x forward, y right, z down.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct VehicleJson {
    /// What this vehicle is.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// Name of the vehicle.
    pub(super) name: Name,
    /// Mass [kg].
    pub(super) mass_kg: Positive<100_000>,
    /// Moments of inertia about the centre of mass, Jxx, Jyy, Jzz [kg m^2]. Each is at most the sum of the others.
    pub(super) inertia_kg_m2: Exactly<Positive<10_000_000>, 3>,
    /// Off-diagonal entries Jxy, Jxz, Jyz of the inertia matrix [kg m^2], with the sign that they have in the matrix;
    /// 0 when left out.
    pub(super) inertia_off_diagonal_kg_m2: Option<Exactly<Within<10_000_000>, 3>>,
    /// The rotors, 1 to 8, in PX4's order (quad-X: front right, rear left, front left, rear right).
    #[schemars(length(min = 1, max = 8))]
    pub(super) rotors: Vec<RotorJson>,
    /// Which reactions of the rotors on the body are modelled.
    pub(super) effects: EffectsJson,
    /// Body aerodynamics, (13)-(18).
    pub(super) body_aero: BodyAeroJson,
    /// The rotor model, the same for all rotors.
    pub(super) rotor: RotorModelJson,
    /// The motor model, the same for all rotors.
    pub(super) motor: MotorJson,
    /// Where the numbers come from.
    #[serde(rename = "provenance")]
    pub(super) _provenance: Option<Vec<String>>,
}

/// Where a rotor sits, which way it pushes and turns.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RotorJson {
    /// Hub, from the centre of mass, body axes [m].
    pub(super) position_body_m: Exactly<Within<100>, 3>,
    /// Unit vector of the thrust, body axes; [0, 0, -1] pushes up.
    pub(super) axis_body: Exactly<UnitComponent, 3>,
    /// Sense of rotation, seen from above.
    pub(super) spin_from_above: SpinJson,
}

/// Sense of rotation.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum SpinJson {
    /// Clockwise.
    Cw,
    /// Counter-clockwise.
    Ccw,
}

/// Which reactions of the rotors on the body are modelled.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EffectsJson {
    /// Why.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// The torque that turns a rotor turns the body the other way.
    pub(super) reaction_torque: bool,
    /// The rotors' angular momentum acts on the body, (19)-(22).
    pub(super) rotor_momentum: bool,
}

/// Coefficients over the angle of attack; a periodic cubic spline runs through them.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BodyAeroJson {
    /// Where the coefficients come from.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// Reference area S [m^2].
    pub(super) reference_area_m2: Positive<10_000>,
    /// Reference span b [m].
    pub(super) reference_span_m: Positive<1000>,
    /// Angles of attack, increasing from -180 to 180 [deg].
    #[schemars(length(max = 721))]
    pub(super) alpha_deg: Vec<AngleDeg>,
    /// Drag coefficient at each angle, (13).
    pub(super) c_drag: Vec<Within<1000>>,
    /// Lift coefficient at each angle, (14).
    pub(super) c_lift: Vec<Within<1000>>,
    /// Pitching moment coefficient at each angle, (15).
    pub(super) c_pitch: Vec<Within<1000>>,
}

/// The rotor model.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum RotorModelJson {
    /// Thrust and torque by table over rotor speed, airspeed and flow angle.
    Table(RotorTableJson),
    /// Thrust = k omega^2, torque = c thrust.
    Quadratic(QuadraticJson),
}

/// A table of thrust and torque, in a CSV file.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RotorTableJson {
    /// How the table was made.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// CSV file, relative to this file; columns omega_rad_s, airspeed_m_s, angle_deg, thrust_n, torque_nm, a full grid with
    /// the angle running fastest, then the airspeed.
    pub(super) file: String,
    /// Density that the table holds for; thrust and torque scale with density [kg/m^3].
    pub(super) density_kg_m3: Positive<1000>,
    /// Radius [m].
    pub(super) radius_m: Option<Positive<100>>,
}

/// Thrust = k omega^2, torque = c thrust.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct QuadraticJson {
    /// Where the coefficients come from.
    #[serde(rename = "about")]
    pub(super) _about: Option<String>,
    /// k [N/(rad/s)^2].
    pub(super) thrust_n_per_rad2_s2: Positive<1000>,
    /// c [m].
    pub(super) torque_per_thrust_m: NonNegative<100>,
    /// Density that k holds for [kg/m^3].
    pub(super) density_kg_m3: Positive<1000>,
    /// Radius [m].
    pub(super) radius_m: Option<Positive<100>>,
}

/// The motor with its speed controller.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum MotorJson {
    /// Speed controller and DC motor with limits of voltage and current.
    EscDc(EscDcJson),
    /// First-order lag with separate time constants up and down.
    FirstOrder(FirstOrderJson),
}

/// Speed controller and DC motor.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EscDcJson {
    /// Rotor speed at full throttle [rad/s].
    pub(super) omega_max_rad_s: Positive<100_000>,
    /// Torque per current [N m/A].
    pub(super) torque_constant_nm_a: Positive<1000>,
    /// Voltage per speed [V s/rad].
    pub(super) back_emf_constant_v_s_rad: Positive<1000>,
    /// Resistance of the winding [ohm].
    pub(super) resistance_ohm: Positive<1000>,
    /// Largest voltage [V].
    pub(super) voltage_max_v: Positive<100_000>,
    /// Largest current [A].
    pub(super) current_max_a: Positive<100_000>,
    /// Smallest current [A]; 0: no active braking, negative: braking.
    pub(super) current_min_a: Within<100_000>,
    /// Voltage per speed error [V s/rad].
    pub(super) esc_gain_v_s_rad: NonNegative<1000>,
    /// Moment of inertia of rotor and motor about the shaft [kg m^2].
    pub(super) rotor_inertia_kg_m2: Positive<10_000>,
}

/// First-order lag of the rotor speed.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FirstOrderJson {
    /// Rotor speed at full throttle [rad/s].
    pub(super) omega_max_rad_s: Positive<100_000>,
    /// Time constant speeding up [s].
    pub(super) tau_up_s: TimeConstantS,
    /// Time constant slowing down [s].
    pub(super) tau_down_s: TimeConstantS,
    /// Moment of inertia of rotor and motor about the shaft [kg m^2], for the gyroscopic moment.
    pub(super) rotor_inertia_kg_m2: NonNegative<10_000>,
}
