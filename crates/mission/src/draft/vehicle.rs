//! A vehicle file from what a data sheet says.

use super::rounded;
use crate::estimated::OriginKind;
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
    /// Three arms, one of them behind, with a coaxial pair each.
    Y6,
    /// Four arms, two of them ahead, with a coaxial pair each.
    X8,
}

/// Where the rotor of a frame sits on its arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnArm {
    /// Alone.
    Alone,
    /// Above the other one of a coaxial pair.
    Upper,
    /// Below the other one of a coaxial pair.
    Lower,
}

/// A rotor of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRotor {
    /// Bearing of the arm, clockwise from the front [deg].
    pub bearing_deg: f64,
    /// Place on the arm.
    pub on_arm: OnArm,
    /// Sense of rotation, seen from above.
    pub spin: RotationSense,
}

impl Frame {
    /// Every frame there is.
    pub const ALL: [Self; 8] = [
        Self::QuadX,
        Self::QuadPlus,
        Self::HexaX,
        Self::HexaPlus,
        Self::OctoX,
        Self::OctoPlus,
        Self::Y6,
        Self::X8,
    ];

    /// Name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::QuadX => "quad-x",
            Self::QuadPlus => "quad-plus",
            Self::HexaX => "hexa-x",
            Self::HexaPlus => "hexa-plus",
            Self::OctoX => "octo-x",
            Self::OctoPlus => "octo-plus",
            Self::Y6 => "y6",
            Self::X8 => "x8",
        }
    }

    /// Whether each arm has a coaxial pair.
    pub fn is_coaxial(self) -> bool {
        matches!(self, Self::Y6 | Self::X8)
    }

    /// The rotors in PX4's order (its airframe reference, <https://docs.px4.io/main/en/airframes/>; coaxial
    /// ones: airframes 11001 and 12001).
    pub fn rotors(self) -> Vec<FrameRotor> {
        use OnArm::{Alone, Lower, Upper};
        use RotationSense::{Ccw, Cw};
        let places: &[(f64, OnArm, RotationSense)] = match self {
            Self::QuadX => {
                &[(45.0, Alone, Ccw), (-135.0, Alone, Ccw), (-45.0, Alone, Cw), (135.0, Alone, Cw)]
            }
            Self::QuadPlus => {
                &[(90.0, Alone, Ccw), (-90.0, Alone, Ccw), (0.0, Alone, Cw), (180.0, Alone, Cw)]
            }
            Self::HexaX => &[
                (90.0, Alone, Cw),
                (-90.0, Alone, Ccw),
                (-30.0, Alone, Cw),
                (150.0, Alone, Ccw),
                (30.0, Alone, Ccw),
                (-150.0, Alone, Cw),
            ],
            Self::HexaPlus => &[
                (0.0, Alone, Cw),
                (180.0, Alone, Ccw),
                (-120.0, Alone, Cw),
                (60.0, Alone, Ccw),
                (-60.0, Alone, Ccw),
                (120.0, Alone, Cw),
            ],
            Self::OctoX => &[
                (22.5, Alone, Cw),
                (-157.5, Alone, Cw),
                (67.5, Alone, Ccw),
                (157.5, Alone, Ccw),
                (-22.5, Alone, Ccw),
                (-112.5, Alone, Ccw),
                (-67.5, Alone, Cw),
                (112.5, Alone, Cw),
            ],
            Self::OctoPlus => &[
                (0.0, Alone, Cw),
                (180.0, Alone, Cw),
                (45.0, Alone, Ccw),
                (135.0, Alone, Ccw),
                (-45.0, Alone, Ccw),
                (-135.0, Alone, Ccw),
                (-90.0, Alone, Cw),
                (90.0, Alone, Cw),
            ],
            Self::Y6 => &[
                (60.0, Upper, Cw),
                (60.0, Lower, Ccw),
                (180.0, Upper, Cw),
                (180.0, Lower, Ccw),
                (-60.0, Upper, Cw),
                (-60.0, Lower, Ccw),
            ],
            Self::X8 => &[
                (45.0, Upper, Ccw),
                (-45.0, Upper, Cw),
                (-135.0, Upper, Ccw),
                (135.0, Upper, Cw),
                (-45.0, Lower, Ccw),
                (45.0, Lower, Cw),
                (135.0, Lower, Ccw),
                (-135.0, Lower, Cw),
            ],
        };
        places.iter().map(|&(bearing_deg, on_arm, spin)| FrameRotor { bearing_deg, on_arm, spin }).collect()
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
    /// Angle by which each rotor is turned about its arm, so that its thrust pushes the way that its torque
    /// turns the body [deg]; 0: straight up. Only of frames without coaxial pairs.
    pub cant_deg: f64,
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

/// Share of those moments of inertia that a draft has: commanded moments are in proportion to the file's, and
/// a vehicle that is easier to turn than its file has loops that are faster than the file's.
const INERTIA_SAFE: f64 = 0.8;
/// Force in a rotor's plane, over rho omega V D^3. Blade elements have 0.0028 for that propeller
/// ([`samara_core::model::blade_element`]), PX4's Gazebo model x500 0.0040 if its own have 10 inch (8.06e-5
/// N/((rad/s)(m/s))). So much slows a vehicle in hover by some 0.25 1/s; a quadrotor was slowed by 0.24 to
/// 0.54 1/s, body and all (M. Faessler et al., Differential Flatness of Quadrotor Dynamics Subject to Rotor
/// Drag, RA-L 2018).
const C_DRAG: f64 = 0.011;
/// Drag area over the circle through the hubs. Of an x500, of 0.19 m2, some 0.035 m2 face a wind along the
/// rotors' planes, where more is worse, and some 0.1 m2 the fall, where less is worse: 0.18 and 0.53.
const DRAG_AREA: f64 = 0.3;
/// From rotor to rotor of a coaxial pair, over the diameter: best of 0.16 to 0.38
/// (doi 10.1177/1756829318804763).
const PAIR_SPACING: f64 = 0.19;
/// Thrust and torque of a lower rotor over those of a lone one at the same speed: that propeller at an
/// advance ratio of 0.28, which is that of the upper one's induced velocity, sqrt(2 C_T/pi). So a pair lifts
/// 0.835 of two lone rotors; designers count on 0.78 to 0.88.
const LOWER_THRUST: f64 = 0.67;
const LOWER_TORQUE: f64 = 0.87;
/// Greatest angle of canted rotors [deg].
const MOST_CANT_DEG: f64 = 45.0;

/// Moments of inertia [kg m^2]: a solid sphere and point masses at the hubs (R. W. Beard, Quadrotor Dynamics
/// and Control, Brigham Young University 2008, section 2.3), on the safe side.
fn estimated_inertia(draft: &VehicleDraft, hubs: &[[f64; 3]]) -> [f64; 3] {
    let radius = BODY_RADIUS * draft.arm_m;
    let body = 0.4 * (1.0 - ROTORS_SHARE) * draft.mass_kg * radius * radius;
    let at_hub = ROTORS_SHARE * draft.mass_kg / hubs.len() as f64;
    let [x2, y2, z2] = [0, 1, 2].map(|k| hubs.iter().map(|hub| hub[k] * hub[k]).sum::<f64>());
    [y2 + z2, x2 + z2, x2 + y2].map(|squares| rounded(INERTIA_SAFE * (body + at_hub * squares)))
}

/// Unit vector of the thrust of a rotor on an arm of this bearing, body axes. Turned about the arm, a rotor
/// that turns counter-clockwise pushes its arm clockwise, as the torque of the air on it does.
fn canted_axis(rotor: &FrameRotor, cant_deg: f64) -> [f64; 3] {
    let (sin_bearing, cos_bearing) = math::sin_cos(rotor.bearing_deg * RAD_PER_DEG);
    let (sin_cant, cos_cant) = math::sin_cos(cant_deg * RAD_PER_DEG);
    let across = rotor.spin.sign() * sin_cant;
    let to_1e_9 = |x: f64| (x * 1e9).round() / 1e9 + 0.0;
    [-across * sin_bearing, across * cos_bearing, -cos_cant].map(to_1e_9)
}

/// The text of a vehicle file, as [`load_vehicle`](crate::load_vehicle) reads it.
///
/// # Errors
/// [`ModelError`] when a number of the draft is not positive.
pub fn vehicle_draft_json(draft: &VehicleDraft) -> Result<String, ModelError> {
    let VehicleDraft { mass_kg, cant_deg, arm_m, propeller_m, density_kg_m3, .. } = *draft;
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
    let in_range = (0.0..=MOST_CANT_DEG).contains(&cant_deg);
    samara_core::model::check(in_range, "cant", "from 0 to 45 deg", cant_deg)?;
    let is_coaxial = draft.frame.is_coaxial();
    let not_both = !(is_coaxial && cant_deg > 0.0);
    samara_core::model::check(
        not_both,
        "cant of a coaxial frame",
        "0 deg: a pair shares its axis",
        cant_deg,
    )?;
    let to_1e_5 = |x: f64| (x * 1e5).round() / 1e5 + 0.0;
    let of_frame = draft.frame.rotors();
    let hubs: Vec<[f64; 3]> = of_frame
        .iter()
        .map(|FrameRotor { bearing_deg, on_arm, .. }| {
            let (sin, cos) = math::sin_cos(bearing_deg * RAD_PER_DEG);
            let down = match on_arm {
                OnArm::Alone => 0.0,
                OnArm::Upper => -0.5 * PAIR_SPACING * propeller_m,
                OnArm::Lower => 0.5 * PAIR_SPACING * propeller_m,
            };
            [arm_m * cos, arm_m * sin, down].map(to_1e_5)
        })
        .collect();
    let mut origins = Vec::new();
    let mut given = vec!["mass_kg", "rotors"];
    if is_coaxial {
        origins.push(Told::estimated(
            &["coaxial"],
            format!(
                "rotors of a pair {PAIR_SPACING} diameters apart; the lower one has {LOWER_THRUST} of the thrust and {LOWER_TORQUE} of \
                 the torque of a lone one at the same speed: APC 10x4.7 SF in the wake of another (UIUC Propeller Data Site), a \
                 pair lifts 0.835 of two lone rotors, and designers count on 0.78 to 0.88"
            ),
        ));
    }
    let inertia = draft.inertia_kg_m2.inspect(|_| given.push("inertia_kg_m2")).unwrap_or_else(|| {
        origins.push(Told::estimated(
            &["inertia_kg_m2"],
            format!(
                "on the small side: {INERTIA_SAFE} of that of a solid sphere of {:.0} % of the mass and {BODY_RADIUS} arm lengths \
                 radius with the rest as points at the hubs (Beard, Quadrotor Dynamics and Control, 2008), since a vehicle that \
                 is easier to turn than its file says has faster loops and keeps less to instability",
                100.0 * (1.0 - ROTORS_SHARE)
            ),
        ));
        estimated_inertia(draft, &hubs)
    });
    let of_thrust = ["rotor.quadratic.thrust_n_per_rad2_s2", "motor.first_order.omega_max_rad_s"];
    let (k, omega_max) = match draft.thrust {
        DraftThrust::Coefficient { thrust_n_per_rad2_s2, omega_max_rad_s } => {
            given.extend(of_thrust);
            (thrust_n_per_rad2_s2, omega_max_rad_s)
        }
        DraftThrust::AtFullThrottle { thrust_n } => {
            let formula = format!(
                "the speed at full throttle from the thrust of {thrust_n} N: thrust = {C_THRUST} rho n^2 D^4"
            );
            origins.push(Told::estimated(&of_thrust, formula));
            let diameter_4 = propeller_m.powi(4);
            let turns_per_s = (thrust_n / (C_THRUST * density_kg_m3 * diameter_4)).sqrt();
            let omega = rounded(std::f64::consts::TAU * turns_per_s);
            (thrust_n / (omega * omega), omega)
        }
    };
    let torque_per_thrust_m = rounded(C_POWER * propeller_m / (std::f64::consts::TAU * C_THRUST));
    origins.push(Told::estimated(
        &["rotor.quadratic.torque_per_thrust_m"],
        format!(
            "a static power coefficient of {C_POWER} beside a thrust coefficient of {C_THRUST} (APC 10x4.7 SF, UIUC Propeller Data Site)"
        ),
    ));
    origins.push(Told::estimated(
        &["rotor.quadratic.drag_n_s2_per_rad_m"],
        format!(
            "on the side that is worse: {C_DRAG} rho D^3, four times what blade elements give and as quadrotors are slowed in \
             flight (Faessler et al., RA-L 2018)"
        ),
    ));
    origins.push(Told::estimated(
        &["body_aero"],
        format!(
            "on the side that is worse: {DRAG_AREA} of the circle through the hubs, more than frames show to a wind and less \
             than they show to the fall"
        ),
    ));
    let size = propeller_m / REFERENCE_M;
    let up = "motor.first_order.tau_up_s";
    let tau_up_s = draft.motor_tau_s.inspect(|_| given.push(up)).unwrap_or_else(|| {
        let formula =
            format!("{REFERENCE_TAU_S} s for a propeller of 10 inch, in proportion to the diameter");
        origins.push(Told::estimated(&[up], formula));
        rounded((REFERENCE_TAU_S * size).clamp(0.005, 1.0))
    });
    origins
        .push(Told::estimated(&["motor.first_order.tau_down_s"], "1.5 times the one speeding up".to_owned()));
    origins.push(Told::estimated(
        &["motor.first_order.rotor_inertia_kg_m2"],
        "5.2e-5 kg m2 at 10 inch, with the fourth power of the diameter".to_owned(),
    ));
    let told = "told to samara new vehicle".to_owned();
    origins.insert(0, Told { keys: given, kind: OriginKind::Given, formula: told });
    let rotor_inertia = rounded(REFERENCE_INERTIA_KG_M2 * size.powi(4));
    let drag_n_s2_per_rad_m = rounded(C_DRAG * density_kg_m3 * propeller_m.powi(3));
    let drag_area_m2 = rounded(DRAG_AREA * std::f64::consts::PI * arm_m * arm_m);
    let canted = if cant_deg > 0.0 {
        format!(
            " Each rotor is turned about its arm by {cant_deg} deg, so that its thrust adds to its own torque about the \
             vertical axis."
        )
    } else {
        String::new()
    };
    let about = format!(
        "A draft by samara new vehicle: {} of {mass_kg} kg, arms of {arm_m} m, propellers of {:.0} mm.{canted} Replace what is \
         estimated by what is measured: origins say what, and how.",
        draft.frame.name(),
        1e3 * propeller_m,
    );
    let rotors: Vec<String> = hubs
        .iter()
        .zip(&of_frame)
        .map(|([x, y, z], rotor)| {
            let [a, b, c] = canted_axis(rotor, cant_deg);
            let sense = if rotor.spin == RotationSense::Cw { "cw" } else { "ccw" };
            format!(
                "    {{ \"position_body_m\": [{x}, {y}, {z}], \"axis_body\": [{a}, {b}, {c}], \"spin_from_above\": \"{sense}\" }}"
            )
        })
        .collect();
    let coaxial = if is_coaxial {
        format!(
            "  \"coaxial\": {{ \"lower_thrust_factor\": {LOWER_THRUST}, \"lower_torque_factor\": {LOWER_TORQUE} }},\n"
        )
    } else {
        String::new()
    };
    let schema =
        draft.schema.as_ref().map_or_else(String::new, |path| format!("  \"$schema\": {},\n", text(path)));
    let [xx, yy, zz] = inertia;
    Ok(format!(
        "{{\n{schema}  \"about\": {},\n  \"origins\": [\n{}\n  ],\n  \"name\": {},\n  \"mass_kg\": {mass_kg:?},\n  \"inertia_kg_m2\": [{xx:?}, {yy:?}, {zz:?}],\n  \
         \"rotors\": [\n{}\n  ],\n{coaxial}  \"effects\": {{ \"reaction_torque\": true, \"rotor_momentum\": true }},\n  \"body_aero\": {{ \"drag_area_m2\": {drag_area_m2:?}, \
         \"side_drag_area_m2\": {drag_area_m2:?} }},\n  \"rotor\": {{\n    \"quadratic\": {{\n      \"thrust_n_per_rad2_s2\": {k:?},\n      \
         \"torque_per_thrust_m\": {torque_per_thrust_m:?},\n      \"drag_n_s2_per_rad_m\": {drag_n_s2_per_rad_m:?},\n      \"density_kg_m3\": {density_kg_m3:?},\n      \"radius_m\": {:?}\n    \
         }}\n  }},\n  \"motor\": {{\n    \"first_order\": {{\n      \"omega_max_rad_s\": {omega_max:?},\n      \"tau_up_s\": \
         {tau_up_s:?},\n      \"tau_down_s\": {:?},\n      \"rotor_inertia_kg_m2\": {rotor_inertia:?}\n    }}\n  }}\n}}\n",
        text(&about),
        origins.iter().map(Told::line).collect::<Vec<_>>().join(",\n"),
        text(&draft.name),
        rotors.join(",\n"),
        rounded(0.5 * propeller_m),
        rounded(1.5 * tau_up_s),
    ))
}

/// Where numbers of a draft are from.
struct Told {
    keys: Vec<&'static str>,
    kind: OriginKind,
    formula: String,
}

impl Told {
    fn estimated(keys: &[&'static str], formula: String) -> Self {
        Self { keys: keys.to_vec(), kind: OriginKind::Estimated, formula }
    }

    /// The line of the file.
    fn line(&self) -> String {
        let keys = serde_json::Value::from(self.keys.clone()).to_string().replace("\",", "\", ");
        let (kind, formula) = (self.kind.word(), text(&self.formula));
        format!("    {{ \"keys\": {keys}, \"kind\": \"{kind}\", \"formula\": {formula} }}")
    }
}

fn text(s: &str) -> String {
    serde_json::Value::from(s).to_string()
}
