//! A vehicle file from what a data sheet says.

use super::rounded;
use samara_core::math;
use samara_core::model::{ModelError, RotationSense};
use samara_core::units::RAD_PER_DEG;

/// Arrangement of the rotors, on a circle about the centre of mass, in PX4's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// Four rotors, two of them ahead.
    QuadX,
    /// Four rotors, one of them ahead.
    QuadPlus,
    /// Six rotors, two of them ahead.
    HexaX,
    /// Six rotors, one of them ahead.
    HexaPlus,
    /// Eight rotors, two of them ahead.
    OctoX,
    /// Eight rotors, one of them ahead.
    OctoPlus,
}

impl Frame {
    /// Every frame there is.
    pub const ALL: [Self; 6] =
        [Self::QuadX, Self::QuadPlus, Self::HexaX, Self::HexaPlus, Self::OctoX, Self::OctoPlus];

    /// Name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::QuadX => "quad-x",
            Self::QuadPlus => "quad-plus",
            Self::HexaX => "hexa-x",
            Self::HexaPlus => "hexa-plus",
            Self::OctoX => "octo-x",
            Self::OctoPlus => "octo-plus",
        }
    }

    /// Bearing of each arm, clockwise from the front [deg], and the rotor's sense of rotation seen from
    /// above, in PX4's order (its airframe reference, <https://docs.px4.io/main/en/airframes/>).
    pub fn arms(self) -> Vec<(f64, RotationSense)> {
        use RotationSense::{Ccw, Cw};
        match self {
            Self::QuadX => vec![(45.0, Ccw), (-135.0, Ccw), (-45.0, Cw), (135.0, Cw)],
            Self::QuadPlus => vec![(90.0, Ccw), (-90.0, Ccw), (0.0, Cw), (180.0, Cw)],
            Self::HexaX => {
                vec![(90.0, Cw), (-90.0, Ccw), (-30.0, Cw), (150.0, Ccw), (30.0, Ccw), (-150.0, Cw)]
            }
            Self::HexaPlus => {
                vec![(0.0, Cw), (180.0, Ccw), (-120.0, Cw), (60.0, Ccw), (-60.0, Ccw), (120.0, Cw)]
            }
            Self::OctoX => vec![
                (22.5, Cw),
                (-157.5, Cw),
                (67.5, Ccw),
                (157.5, Ccw),
                (-22.5, Ccw),
                (-112.5, Ccw),
                (-67.5, Cw),
                (112.5, Cw),
            ],
            Self::OctoPlus => vec![
                (0.0, Cw),
                (180.0, Cw),
                (45.0, Ccw),
                (135.0, Ccw),
                (-45.0, Ccw),
                (-135.0, Ccw),
                (-90.0, Cw),
                (90.0, Cw),
            ],
        }
    }
}

/// Thrust of a rotor, as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DraftThrust {
    /// Thrust at full throttle in still air [N]; the rotor speed is estimated.
    AtFullThrottle {
        /// The thrust [N].
        thrust_n: f64,
    },
    /// Thrust over the square of the rotor speed, and the speed at full throttle.
    Coefficient {
        /// k of thrust = k omega^2 [N/(rad/s)^2].
        thrust_n_per_rad2_s2: f64,
        /// Rotor speed at full throttle [rad/s].
        omega_max_rad_s: f64,
    },
}

/// What is known of a vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct VehicleDraft {
    /// Name: letters, digits, `_` and `-`.
    pub name: String,
    /// Mass, all included [kg].
    pub mass_kg: f64,
    /// Arrangement of the rotors.
    pub frame: Frame,
    /// From the centre of mass to a rotor's hub [m].
    pub arm_m: f64,
    /// Diameter of a propeller [m].
    pub propeller_m: f64,
    /// Thrust of a rotor.
    pub thrust: DraftThrust,
    /// Density of the air that the thrust holds for [kg/m^3].
    pub density_kg_m3: f64,
    /// Moments of inertia about x, y and z [kg m^2]; estimated when left out.
    pub inertia_kg_m2: Option<[f64; 3]>,
    /// Time constant of a motor speeding up [s]; estimated when left out.
    pub motor_tau_s: Option<f64>,
    /// Path of the schema beside the file, for editors.
    pub schema: Option<String>,
}

/// Share of the mass that sits at the rotors, and radius of the body over the arm: fitted to three quadrotors
/// of 1.4 to 2.1 kg.
const ROTORS_SHARE: f64 = 0.3;
const BODY_RADIUS: f64 = 0.35;
/// Static thrust and power coefficients of a small propeller, of rho n^2 D^4 and rho n^3 D^5: APC 10x4.7 Slow
/// Flyer at 4900 rpm, UIUC Propeller Data Site, volume 1,
/// <https://m-selig.ae.illinois.edu/props/propDB.html>.
const C_THRUST: f64 = 0.122;
const C_POWER: f64 = 0.0494;
/// That propeller's diameter [m] and its moment of inertia with a motor's rotor [kg m^2].
const REFERENCE_M: f64 = 0.254;
const REFERENCE_INERTIA_KG_M2: f64 = 5.2e-5;
/// Time constant of a motor with that propeller [s].
const REFERENCE_TAU_S: f64 = 0.025;

/// Moments of inertia [kg m^2]: a solid sphere and point masses at the hubs (R. W. Beard, Quadrotor Dynamics
/// and Control, Brigham Young University 2008, section 2.3).
fn estimated_inertia(draft: &VehicleDraft, hubs: &[[f64; 2]]) -> [f64; 3] {
    let radius = BODY_RADIUS * draft.arm_m;
    let body = 0.4 * (1.0 - ROTORS_SHARE) * draft.mass_kg * radius * radius;
    let at_hub = ROTORS_SHARE * draft.mass_kg / hubs.len() as f64;
    let sum = |f: &dyn Fn(&[f64; 2]) -> f64| hubs.iter().map(f).sum::<f64>();
    let (xx, yy) = (at_hub * sum(&|[_, y]| y * y), at_hub * sum(&|[x, _]| x * x));
    [body + xx, body + yy, body + xx + yy].map(rounded)
}

/// The text of a vehicle file, as [`load_vehicle`](crate::load_vehicle) reads it.
///
/// # Errors
/// [`ModelError`] when a number of the draft is not positive.
pub fn vehicle_draft_json(draft: &VehicleDraft) -> Result<String, ModelError> {
    let VehicleDraft { mass_kg, arm_m, propeller_m, density_kg_m3, .. } = *draft;
    let (given, speed) = match draft.thrust {
        DraftThrust::AtFullThrottle { thrust_n } => (thrust_n, 1.0),
        DraftThrust::Coefficient { thrust_n_per_rad2_s2, omega_max_rad_s } => {
            (thrust_n_per_rad2_s2, omega_max_rad_s)
        }
    };
    let inertia = draft.inertia_kg_m2.unwrap_or([1.0; 3]);
    for (what, value) in [
        ("mass", mass_kg),
        ("arm", arm_m),
        ("propeller", propeller_m),
        ("thrust", given),
        ("rotor speed", speed),
        ("density", density_kg_m3),
        ("inertia", inertia[0].min(inertia[1]).min(inertia[2])),
        ("motor time constant", draft.motor_tau_s.unwrap_or(1.0)),
    ] {
        samara_core::model::check_positive(what, value)?;
    }
    let to_1e_5 = |x: f64| (x * 1e5).round() / 1e5 + 0.0;
    let arms = draft.frame.arms();
    let hubs: Vec<[f64; 2]> = arms
        .iter()
        .map(|(bearing_deg, _)| {
            let (sin, cos) = math::sin_cos(bearing_deg * RAD_PER_DEG);
            [to_1e_5(arm_m * cos), to_1e_5(arm_m * sin)]
        })
        .collect();
    let mut told = Vec::new();
    let mut estimated = vec!["body_aero", "rotor.quadratic.torque_per_thrust_m"];
    let inertia = draft.inertia_kg_m2.unwrap_or_else(|| {
        estimated.push("inertia_kg_m2");
        told.push(format!(
            "The inertia is estimated: a solid sphere of {:.0} % of the mass and {BODY_RADIUS} arm lengths radius, the rest as \
             points at the hubs (Beard, Quadrotor Dynamics and Control, 2008)",
            100.0 * (1.0 - ROTORS_SHARE)
        ));
        estimated_inertia(draft, &hubs)
    });
    let (k, omega_max) = match draft.thrust {
        DraftThrust::Coefficient { thrust_n_per_rad2_s2, omega_max_rad_s } => {
            (thrust_n_per_rad2_s2, omega_max_rad_s)
        }
        DraftThrust::AtFullThrottle { thrust_n } => {
            estimated.extend(["rotor.quadratic.thrust_n_per_rad2_s2", "motor.first_order.omega_max_rad_s"]);
            told.push(format!(
                "The rotor speed at full throttle is estimated from the thrust of {thrust_n} N: thrust = {C_THRUST} rho n^2 D^4"
            ));
            let diameter_4 = propeller_m.powi(4);
            let turns_per_s = (thrust_n / (C_THRUST * density_kg_m3 * diameter_4)).sqrt();
            let omega = rounded(std::f64::consts::TAU * turns_per_s);
            (thrust_n / (omega * omega), omega)
        }
    };
    let torque_per_thrust_m = rounded(C_POWER * propeller_m / (std::f64::consts::TAU * C_THRUST));
    told.push(format!(
        "The rotors' torque is that of a static power coefficient of {C_POWER} beside a thrust coefficient of {C_THRUST} (APC \
         10x4.7 SF, UIUC Propeller Data Site)"
    ));
    let size = propeller_m / REFERENCE_M;
    let tau_up_s = draft.motor_tau_s.unwrap_or_else(|| {
        estimated.push("motor.first_order.tau_up_s");
        told.push(format!(
            "The motors' time constant is estimated: {REFERENCE_TAU_S} s for a propeller of 10 inch, in proportion to the diameter"
        ));
        rounded((REFERENCE_TAU_S * size).clamp(0.005, 1.0))
    });
    estimated.extend(["motor.first_order.tau_down_s", "motor.first_order.rotor_inertia_kg_m2"]);
    estimated.sort_unstable();
    let rotor_inertia = rounded(REFERENCE_INERTIA_KG_M2 * size.powi(4));
    let drag_area_m2 = rounded(0.3 * std::f64::consts::PI * arm_m * arm_m);
    let about = format!(
        "A draft by samara new vehicle: {} of {mass_kg} kg, arms of {arm_m} m, propellers of {:.0} mm. Replace what is estimated by \
         what is measured. {}. Rotor inertia: 5.2e-5 kg m2 at 10 inch, with the fourth power of the diameter. Drag areas: 0.3 of the \
         circle through the hubs.",
        draft.frame.name(),
        1e3 * propeller_m,
        told.join(". "),
    );
    let rotors: Vec<String> = hubs
        .iter()
        .zip(&arms)
        .map(|([x, y], (_, sense))| {
            let sense = if *sense == RotationSense::Cw { "cw" } else { "ccw" };
            format!(
                "    {{ \"position_body_m\": [{x}, {y}, 0], \"axis_body\": [0, 0, -1], \"spin_from_above\": \"{sense}\" }}"
            )
        })
        .collect();
    let schema =
        draft.schema.as_ref().map_or_else(String::new, |path| format!("  \"$schema\": {},\n", text(path)));
    let [xx, yy, zz] = inertia;
    Ok(format!(
        "{{\n{schema}  \"about\": {},\n  \"estimated\": {},\n  \"name\": {},\n  \"mass_kg\": {mass_kg:?},\n  \"inertia_kg_m2\": [{xx:?}, {yy:?}, {zz:?}],\n  \
         \"rotors\": [\n{}\n  ],\n  \"effects\": {{ \"reaction_torque\": true, \"rotor_momentum\": true }},\n  \"body_aero\": {{ \
         \"drag_area_m2\": {drag_area_m2:?}, \"side_drag_area_m2\": {drag_area_m2:?} }},\n  \"rotor\": {{\n    \"quadratic\": {{\n      \"thrust_n_per_rad2_s2\": {k:?},\n      \
         \"torque_per_thrust_m\": {torque_per_thrust_m:?},\n      \"density_kg_m3\": {density_kg_m3:?},\n      \"radius_m\": {:?}\n    \
         }}\n  }},\n  \"motor\": {{\n    \"first_order\": {{\n      \"omega_max_rad_s\": {omega_max:?},\n      \"tau_up_s\": \
         {tau_up_s:?},\n      \"tau_down_s\": {:?},\n      \"rotor_inertia_kg_m2\": {rotor_inertia:?}\n    }}\n  }}\n}}\n",
        text(&about),
        list(&estimated),
        text(&draft.name),
        rotors.join(",\n"),
        rounded(0.5 * propeller_m),
        rounded(1.5 * tau_up_s),
    ))
}

/// A list of keys, one a line.
fn list(keys: &[&str]) -> String {
    let lines: Vec<String> = keys.iter().map(|key| format!("    {}", text(key))).collect();
    format!("[\n{}\n  ]", lines.join(",\n"))
}

fn text(s: &str) -> String {
    serde_json::Value::from(s).to_string()
}
