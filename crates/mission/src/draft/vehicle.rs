//! A vehicle file from what a data sheet or files of other programs say.

use nalgebra::Vector3;

use super::frame::{Frame, FrameRotor, OnArm};
use super::ledger::Ledger;
use super::{rounded, text};
use crate::foreign::{Key, Known, KnownRotors, KnownVehicle};
use samara_core::math;
use samara_core::model::{Interference, ModelError, RotationSense, RotorMount, SAME_AXIS};
use samara_core::units::{RAD_PER_DEG, STANDARD_GRAVITY_M_S2};

/// Thrust of a rotor, as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DraftThrust {
    /// Thrust at full throttle in still air [N]; the rotor speed is what files say, else estimated.
    AtFullThrottle {
        /// The thrust [N].
        thrust_n: f64,
    },
    /// Share of the full thrust that carries the weight, as PX4's MPC_THR_HOVER has it; the rotor speed as
    /// before.
    Hover {
        /// The share, from 0 to 1.
        share: f64,
    },
    /// Thrust over the square of the rotor speed, and the speed at full throttle.
    Coefficient {
        /// k of thrust = k omega^2 [N/(rad/s)^2].
        thrust_n_per_rad2_s2: f64,
        /// Rotor speed at full throttle [rad/s].
        omega_max_rad_s: f64,
    },
}

/// Where the rotors are.
#[derive(Clone, Debug, PartialEq)]
pub enum DraftRotors {
    /// On a circle about the centre of mass.
    Frame {
        /// Arrangement of the rotors.
        frame: Frame,
        /// Angle by which each rotor is turned about its arm, so that its thrust pushes the way that its
        /// torque turns the body [deg]; 0: straight up. Only of frames without coaxial pairs.
        cant_deg: f64,
        /// From the centre of mass to a rotor's hub [m].
        arm_m: f64,
    },
    /// Where files have them, in metres.
    Known(KnownRotors),
}

/// What is known of a vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct VehicleDraft {
    /// Name: letters, digits, `_` and `-`.
    pub name: String,
    /// Mass, all included [kg].
    pub mass_kg: f64,
    /// How the mass was estimated, where it was.
    pub mass_by: Option<String>,
    /// The rotors.
    pub rotors: DraftRotors,
    /// Diameter of a propeller [m]; may be left out where nothing is estimated by it.
    pub propeller_m: Option<f64>,
    /// Thrust of a rotor.
    pub thrust: DraftThrust,
    /// Density of the air that the thrust holds for [kg/m^3].
    pub density_kg_m3: f64,
    /// Moments of inertia about x, y and z [kg m^2]; as files have them, or estimated, when left out.
    pub inertia_kg_m2: Option<[f64; 3]>,
    /// Time constant of a motor speeding up [s]; as files have it, or estimated, when left out.
    pub motor_tau_s: Option<f64>,
    /// What files say, but for what was told otherwise: it names the file of each number.
    pub known: KnownVehicle,
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

/// A vehicle is lighter than a ball of iron that has its arms for a radius: density [kg/m^3].
const IRON_KG_M3: f64 = 7870.0;

/// Moments of inertia [kg m^2]: a solid sphere and point masses at the hubs (R. W. Beard, Quadrotor Dynamics
/// and Control, Brigham Young University 2008, section 2.3), on the safe side.
fn estimated_inertia(mass_kg: f64, arm_m: f64, rotors: &[RotorMount]) -> [f64; 3] {
    let radius = BODY_RADIUS * arm_m;
    let body = 0.4 * (1.0 - ROTORS_SHARE) * mass_kg * radius * radius;
    let at_hub = ROTORS_SHARE * mass_kg / rotors.len() as f64;
    let squares = |k: usize| rotors.iter().map(|r| r.position_body_m[k] * r.position_body_m[k]).sum::<f64>();
    let [x2, y2, z2] = [0, 1, 2].map(squares);
    [y2 + z2, x2 + z2, x2 + y2].map(|squares| rounded(INERTIA_SAFE * (body + at_hub * squares)))
}

/// Unit vector of the thrust of a rotor on an arm of this bearing, body axes. Turned about the arm, a rotor
/// that turns counter-clockwise pushes its arm clockwise, as the torque of the air on it does.
fn canted_axis(rotor: &FrameRotor, cant_deg: f64) -> Vector3<f64> {
    let (sin_bearing, cos_bearing) = math::sin_cos(rotor.bearing_deg * RAD_PER_DEG);
    let (sin_cant, cos_cant) = math::sin_cos(cant_deg * RAD_PER_DEG);
    let across = rotor.spin.sign() * sin_cant;
    Vector3::new(-across * sin_bearing, across * cos_bearing, -cos_cant).map(to_1e_9)
}

fn to_1e_9(x: f64) -> f64 {
    (x * 1e9).round() / 1e9 + 0.0
}

/// The rotors of a frame.
fn frame_rotors(frame: Frame, cant_deg: f64, arm_m: f64, propeller_m: f64) -> Vec<RotorMount> {
    let to_1e_5 = |x: f64| (x * 1e5).round() / 1e5 + 0.0;
    let mount = |rotor: FrameRotor| {
        let (sin, cos) = math::sin_cos(rotor.bearing_deg * RAD_PER_DEG);
        let down = match rotor.on_arm {
            OnArm::Alone => 0.0,
            OnArm::Upper => -0.5 * PAIR_SPACING * propeller_m,
            OnArm::Lower => 0.5 * PAIR_SPACING * propeller_m,
        };
        RotorMount {
            position_body_m: Vector3::new(arm_m * cos, arm_m * sin, down).map(to_1e_5),
            axis_body: canted_axis(&rotor, cant_deg),
            spin: rotor.spin,
            interference: Interference::NONE,
        }
    };
    frame.rotors().into_iter().map(mount).collect()
}

/// How many thrusts of a lone rotor the rotors lift together.
fn lift(rotors: &[RotorMount]) -> f64 {
    let each = |rotor: &RotorMount| {
        let of_wake = if is_lower(rotor, rotors) { LOWER_THRUST } else { 1.0 };
        -of_wake * rotor.axis_body.z
    };
    rotors.iter().map(each).sum()
}

/// Whether a rotor is in the wake of another one on its axis.
fn is_lower(rotor: &RotorMount, rotors: &[RotorMount]) -> bool {
    let beside_m = |above: &RotorMount| rotor.beside_the_axis_above_m(above);
    rotors.iter().any(|above| beside_m(above).is_some_and(|m| m <= SAME_AXIS))
}

impl VehicleDraft {
    /// From the centre of mass to the farthest hub [m].
    pub fn arm_m(&self) -> f64 {
        match &self.rotors {
            DraftRotors::Frame { arm_m, .. } => *arm_m,
            DraftRotors::Known(known) => known.arm(),
        }
    }

    /// Refuses a mass that no vehicle with such arms has, as of grams taken for kilograms.
    ///
    /// # Errors
    /// [`ModelError::OutOfRange`].
    pub fn check_mass(&self) -> Result<(), ModelError> {
        samara_core::model::check_positive("mass", self.mass_kg)?;
        let iron_kg = IRON_KG_M3 * 4.0 / 3.0 * std::f64::consts::PI * self.arm_m().powi(3);
        let expected = "less than a ball of iron weighs that has the arms for a radius";
        samara_core::model::check(self.mass_kg < iron_kg, "mass [kg]", expected, self.mass_kg)
    }

    /// What is to be told where a file's hover is another one than that of the motors of a file, which stand.
    pub fn hovers_otherwise(&self) -> Option<String> {
        let (hover, DraftRotors::Known(KnownRotors { rotors, .. })) =
            (self.known.numbers.get(&Key::Hover)?, &self.rotors)
        else {
            return None;
        };
        let DraftThrust::Coefficient { thrust_n_per_rad2_s2, omega_max_rad_s } = self.thrust else {
            return None;
        };
        let lift_n = lift(rotors) * thrust_n_per_rad2_s2 * omega_max_rad_s * omega_max_rad_s;
        let (by_motors, by_hover) = (lift_n / (self.mass_kg * STANDARD_GRAVITY_M_S2), 1.0 / hover.value);
        ((by_hover / by_motors - 1.0).abs() > SAME_HOVER).then(|| {
            format!(
                "thrust to weight: {by_motors:.2} of the motors stands, not {by_hover:.2} of {} ({})",
                hover.file, hover.words
            )
        })
    }

    /// What is to be told where a file's force in the rotors' planes slows a hover as it slows no multirotor.
    pub fn drags_oddly(&self) -> Option<String> {
        let (drag, DraftThrust::Coefficient { thrust_n_per_rad2_s2, .. }) =
            (self.known.numbers.get(&Key::Drag)?, self.thrust)
        else {
            return None;
        };
        let rotors = &self.known.rotors.as_ref()?.value.rotors;
        let weight_n = self.mass_kg * STANDARD_GRAVITY_M_S2;
        let hover_rad_s = (weight_n / (lift(rotors) * thrust_n_per_rad2_s2)).sqrt();
        let slowed_per_s = rotors.len() as f64 * drag.value * hover_rad_s / self.mass_kg;
        (slowed_per_s > MOST_SLOWED_PER_S).then(|| {
            format!(
                "{} ({}): in a hover it slows the vehicle by {slowed_per_s:.2} of its speed a second, and multirotors by 0.24 to 0.54, \
                 body and all: is it right?",
                drag.words, drag.file
            )
        })
    }
}

/// More than a multirotor is slowed by its rotors in a hover, twice over [1/s].
const MOST_SLOWED_PER_S: f64 = 1.0;

/// The mass [kg] that a file's rotors carry at a file's hover, if each has so much thrust at full throttle
/// [N], with the formula; `None` where no file has both.
pub fn mass_by_hover(known: &KnownVehicle, thrust_n: f64) -> Option<(f64, String)> {
    let (hover, rotors) = (known.numbers.get(&Key::Hover)?, known.rotors.as_ref()?);
    let mass_kg = rounded(hover.value * lift(&rotors.value.rotors) * thrust_n / STANDARD_GRAVITY_M_S2);
    let Known { file, words, value, .. } = hover;
    Some((
        mass_kg,
        format!("what {value} of {thrust_n:.4} N of each rotor carries ({file}: {words}): weigh it"),
    ))
}

/// Share of a thrust to weight by which what a file says of the hover may be off what the motors say.
const SAME_HOVER: f64 = 0.2;

/// Whether a draft needs the propeller's diameter, for what neither files nor options say: the speed at full
/// throttle, where the thrust is no coefficient, the lag, where it was not told, and what files may say.
pub fn needs_propeller(known: &KnownVehicle, by_coefficient: bool, pairs: bool, lag_told: bool) -> bool {
    let unknown = |key: Key| !known.numbers.contains_key(&key);
    let speed = !by_coefficient && unknown(Key::OmegaMax);
    let lag = !lag_told && unknown(Key::TauUp);
    let others = [Key::Torque, Key::Drag, Key::RotorInertia].into_iter().any(unknown);
    unknown(Key::Radius) && (speed || pairs || lag || others)
}

/// The text of a vehicle file, as [`load_vehicle`](crate::load_vehicle) reads it.
///
/// # Errors
/// [`ModelError`] when a number of the draft is not positive.
pub fn vehicle_draft_json(draft: &VehicleDraft) -> Result<String, ModelError> {
    let VehicleDraft { mass_kg, density_kg_m3, ref known, .. } = *draft;
    let arm_m = draft.arm_m();
    // The radius that is known stands for a propeller; where nothing is estimated by it, none is needed.
    let propeller = draft.propeller_m.or_else(|| known.number(Key::Radius).map(|radius| 2.0 * radius));
    let by_coefficient = matches!(draft.thrust, DraftThrust::Coefficient { .. });
    let pairs = matches!(draft.rotors, DraftRotors::Frame { frame, .. } if frame.is_coaxial());
    let needed = needs_propeller(known, by_coefficient, pairs, draft.motor_tau_s.is_some());
    let propeller_m = propeller.unwrap_or(if needed { f64::NAN } else { 1.0 });
    let (given, speed) = match draft.thrust {
        DraftThrust::AtFullThrottle { thrust_n } => (thrust_n, 1.0),
        DraftThrust::Hover { share } => (share, 1.0),
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
    draft.check_mass()?;
    let rotors = match &draft.rotors {
        DraftRotors::Known(known) => known.rotors.clone(),
        DraftRotors::Frame { frame, cant_deg, arm_m } => {
            let cant_deg = *cant_deg;
            let in_range = (0.0..=MOST_CANT_DEG).contains(&cant_deg);
            samara_core::model::check(in_range, "cant", "from 0 to 45 deg", cant_deg)?;
            let not_both = !(frame.is_coaxial() && cant_deg > 0.0);
            samara_core::model::check(
                not_both,
                "cant of a coaxial frame",
                "0 deg: a pair shares its axis",
                cant_deg,
            )?;
            frame_rotors(*frame, cant_deg, *arm_m, propeller_m)
        }
    };
    let is_coaxial = rotors.iter().any(|rotor| is_lower(rotor, &rotors));
    let mut ledger = Ledger::new(known);
    match &draft.mass_by {
        Some(formula) => ledger.estimate(&["mass_kg"], formula.clone()),
        None => ledger.known(Key::Mass),
    }
    match &known.rotors {
        Some(from) => ledger.of_file("rotors", from),
        None => ledger.told.push("rotors"),
    }
    if is_coaxial {
        let apart = match draft.rotors {
            DraftRotors::Frame { .. } => format!("rotors of a pair {PAIR_SPACING} diameters apart; "),
            DraftRotors::Known(_) => String::new(),
        };
        ledger.estimate(
            &["coaxial"],
            format!(
                "{apart}the lower one has {LOWER_THRUST} of the thrust and {LOWER_TORQUE} of \
                 the torque of a lone one at the same speed: APC 10x4.7 SF in the wake of another (UIUC Propeller Data Site), a \
                 pair lifts 0.835 of two lone rotors, and designers count on 0.78 to 0.88"
            ),
        );
    }
    let [xx, yy, zz, xy, xz, yz] = match (draft.inertia_kg_m2, &known.inertia_kg_m2) {
        (Some([xx, yy, zz]), _) => {
            ledger.told.push("inertia_kg_m2");
            [xx, yy, zz, 0.0, 0.0, 0.0]
        }
        (None, Some(inertia)) => {
            ledger.of_file("inertia_kg_m2", inertia);
            inertia.value
        }
        (None, None) => {
            ledger.estimate(
                &["inertia_kg_m2"],
                format!(
                    "on the small side: {INERTIA_SAFE} of that of a solid sphere of {:.0} % of the mass and {BODY_RADIUS} arm lengths \
                     radius with the rest as points at the hubs (Beard, Quadrotor Dynamics and Control, 2008), since a vehicle that \
                     is easier to turn than its file says has faster loops and keeps less to instability",
                    100.0 * (1.0 - ROTORS_SHARE)
                ),
            );
            let [xx, yy, zz] = estimated_inertia(mass_kg, arm_m, &rotors);
            [xx, yy, zz, 0.0, 0.0, 0.0]
        }
    };
    let off_diagonal = [xy, xz, yz];
    let off_diagonal = if off_diagonal == [0.0; 3] {
        String::new()
    } else {
        if let Some(inertia) = &known.inertia_kg_m2 {
            ledger.of_file("inertia_off_diagonal_kg_m2", inertia);
        }
        format!("  \"inertia_off_diagonal_kg_m2\": [{xy:?}, {xz:?}, {yz:?}],\n")
    };
    let of_thrust = [Key::Thrust, Key::OmegaMax];
    let (k, omega_max) = match draft.thrust {
        DraftThrust::Coefficient { thrust_n_per_rad2_s2, omega_max_rad_s } => {
            of_thrust.into_iter().for_each(|key| ledger.known(key));
            (thrust_n_per_rad2_s2, omega_max_rad_s)
        }
        DraftThrust::AtFullThrottle { thrust_n } => thrust_and_speed(
            &mut ledger,
            thrust_n,
            format!("the thrust of {thrust_n} N"),
            propeller_m,
            density_kg_m3,
        ),
        DraftThrust::Hover { share } => {
            let thrust_n = rounded(mass_kg * STANDARD_GRAVITY_M_S2 / (share * lift(&rotors)));
            let by = known.numbers.get(&Key::Hover);
            let by = by.map_or_else(String::new, |by| format!(" ({}: {})", by.file, by.words));
            let thrust = format!(
                "a thrust of {thrust_n} N, of which {share} carries the weight, as PX4's thrust has it where THR_MDL_FAC fits the \
                 motors{by}"
            );
            thrust_and_speed(&mut ledger, thrust_n, thrust, propeller_m, density_kg_m3)
        }
    };
    let torque_per_thrust_m = ledger.number(Key::Torque, None, || {
        (
            rounded(C_POWER * propeller_m / (std::f64::consts::TAU * C_THRUST)),
            format!(
                "a static power coefficient of {C_POWER} beside a thrust coefficient of {C_THRUST} (APC 10x4.7 SF, UIUC Propeller Data Site)"
            ),
        )
    });
    let drag_n_s2_per_rad_m = ledger.number(Key::Drag, None, || {
        (
            rounded(C_DRAG * density_kg_m3 * propeller_m.powi(3)),
            format!(
                "on the side that is worse: {C_DRAG} rho D^3, four times what blade elements give and as quadrotors are slowed in \
                 flight (Faessler et al., RA-L 2018)"
            ),
        )
    });
    ledger.estimate(
        &["body_aero"],
        format!(
            "on the side that is worse: {DRAG_AREA} of the circle through the hubs, more than frames show to a wind and less \
             than they show to the fall"
        ),
    );
    let size = propeller_m / REFERENCE_M;
    let tau_up_s = ledger.number(Key::TauUp, draft.motor_tau_s, || {
        (
            rounded((REFERENCE_TAU_S * size).clamp(0.005, 1.0)),
            format!("{REFERENCE_TAU_S} s for a propeller of 10 inch, in proportion to the diameter"),
        )
    });
    let tau_down_s = ledger
        .number(Key::TauDown, None, || (rounded(1.5 * tau_up_s), "1.5 times the one speeding up".to_owned()));
    let rotor_inertia = ledger.number(Key::RotorInertia, None, || {
        (
            rounded(REFERENCE_INERTIA_KG_M2 * size.powi(4)),
            "5.2e-5 kg m2 at 10 inch, with the fourth power of the diameter".to_owned(),
        )
    });
    let radius = if known.numbers.contains_key(&Key::Radius) && draft.propeller_m.is_none() {
        ledger.known(Key::Radius);
        known.number(Key::Radius)
    } else {
        draft.propeller_m.map(|diameter_m| rounded(0.5 * diameter_m))
    };
    let radius = radius.map_or_else(String::new, |radius| format!(",\n      \"radius_m\": {radius:?}"));
    let drag_area_m2 = rounded(DRAG_AREA * std::f64::consts::PI * arm_m * arm_m);
    let arranged = match &draft.rotors {
        DraftRotors::Frame { frame, .. } => frame.name().to_owned(),
        DraftRotors::Known(known) => format!("{} rotors", known.rotors.len()),
    };
    let propellers =
        propeller.map_or_else(String::new, |diameter| format!(", propellers of {:.0} mm", 1e3 * diameter));
    let canted = match draft.rotors {
        DraftRotors::Frame { cant_deg, .. } if cant_deg > 0.0 => format!(
            " Each rotor is turned about its arm by {cant_deg} deg, so that its thrust adds to its own torque about the \
             vertical axis."
        ),
        _ => String::new(),
    };
    let about = format!(
        "A draft by samara new vehicle: {arranged} of {mass_kg} kg, arms of {} m{propellers}.{canted} Replace what is \
         estimated by what is measured: origins say what, and how.",
        rounded(arm_m),
    );
    let mounts: Vec<String> = rotors
        .iter()
        .map(|rotor| {
            let [x, y, z]: [f64; 3] = rotor.position_body_m.map(to_1e_9).into();
            let [a, b, c]: [f64; 3] = rotor.axis_body.map(to_1e_9).into();
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
    Ok(format!(
        "{{\n{schema}  \"about\": {},\n  \"origins\": [\n{}\n  ],\n  \"name\": {},\n  \"mass_kg\": {mass_kg:?},\n  \"inertia_kg_m2\": [{xx:?}, {yy:?}, {zz:?}],\n{off_diagonal}  \
         \"rotors\": [\n{}\n  ],\n{coaxial}  \"effects\": {{ \"reaction_torque\": true, \"rotor_momentum\": true }},\n  \"body_aero\": {{ \"drag_area_m2\": {drag_area_m2:?}, \
         \"side_drag_area_m2\": {drag_area_m2:?} }},\n  \"rotor\": {{\n    \"quadratic\": {{\n      \"thrust_n_per_rad2_s2\": {k:?},\n      \
         \"torque_per_thrust_m\": {torque_per_thrust_m:?},\n      \"drag_n_s2_per_rad_m\": {drag_n_s2_per_rad_m:?},\n      \"density_kg_m3\": {density_kg_m3:?}{radius}\n    \
         }}\n  }},\n  \"motor\": {{\n    \"first_order\": {{\n      \"omega_max_rad_s\": {omega_max:?},\n      \"tau_up_s\": \
         {tau_up_s:?},\n      \"tau_down_s\": {tau_down_s:?},\n      \"rotor_inertia_kg_m2\": {rotor_inertia:?}\n    }}\n  }}\n}}\n",
        text(&about),
        ledger.lines().join(",\n"),
        text(&draft.name),
        mounts.join(",\n"),
    ))
}

/// Thrust over the square of the rotor speed, and that speed, of a thrust at full throttle that is from
/// `by`.
fn thrust_and_speed(
    ledger: &mut Ledger,
    thrust_n: f64,
    by: String,
    propeller_m: f64,
    density_kg_m3: f64,
) -> (f64, f64) {
    if let Some(known) = ledger.files.numbers.get(&Key::OmegaMax) {
        ledger.of_file(Key::OmegaMax.path(), known);
        ledger.estimate(&[Key::Thrust.path()], format!("{by}, at the speed at full throttle"));
        return (thrust_n / (known.value * known.value), known.value);
    }
    let formula = format!("the speed at full throttle from {by}: thrust = {C_THRUST} rho n^2 D^4");
    ledger.estimate(&[Key::Thrust.path(), Key::OmegaMax.path()], formula);
    let turns_per_s = (thrust_n / (C_THRUST * density_kg_m3 * propeller_m.powi(4))).sqrt();
    let omega = rounded(std::f64::consts::TAU * turns_per_s);
    (thrust_n / (omega * omega), omega)
}
