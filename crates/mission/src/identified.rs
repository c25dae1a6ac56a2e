//! The vehicle file that an identification makes: the one that was known, with the numbers that were found,
//! where they are from, and how far they may be off.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use super::error::ConfigError;
use super::source::Source;
use samara_core::identify::{Found, Identified, Parameter};
use samara_core::model::{ModelError, Motor, Vehicle};
use samara_core::units::DEG_PER_RAD;

/// A vehicle file with the table that it names.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifiedFile {
    /// Text of the vehicle file.
    pub text: String,
    /// Name and text of the table of its rotor beside it, where it has one.
    pub table: Option<(String, String)>,
}

/// Why no vehicle file can be made.
#[derive(Debug, thiserror::Error)]
pub enum IdentifiedError {
    /// A file cannot be read.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// There is no such vehicle.
    #[error("what was found is no vehicle")]
    Model(#[from] ModelError),
}

/// Standard deviations up to which a share is normal; what is less sure is cut at three of them, or at what
/// leaves something.
const NORMAL_TO: f64 = 0.1;
const CUT_AT: f64 = 3.0;
const LEAST: f64 = -0.9;

/// Parameters behind the shares that a file's `uncertain` has, each the mean of those that were found.
const SHARES: [(&str, &[Parameter]); 4] = [
    ("thrust", &[Parameter::Thrust]),
    ("inertia", &[Parameter::InertiaX, Parameter::InertiaY]),
    ("drag", &[Parameter::DragAlong]),
    ("motor_lag", &[Parameter::LagUp, Parameter::LagDown]),
];

/// The file of the vehicle at `known` with what was found of it in `logs`: named `name`, of `mass_kg`.
///
/// # Errors
/// [`IdentifiedError`] when the file or its table cannot be read, or there is no such vehicle.
pub fn identified_file(
    known: &Path,
    (name, logs, mass_kg): (&str, &str, f64),
    vehicle: &Vehicle,
    found: &Identified,
) -> Result<IdentifiedFile, IdentifiedError> {
    let source = Source::read(known, "vehicle file", None)?;
    let mut file: Map<String, Value> = source.parse()?;
    let after = found.vehicle(vehicle)?;
    file.remove("$schema");
    file.insert("name".into(), name.into());
    if mass_kg != file.get("mass_kg").and_then(Value::as_f64).unwrap_or(f64::NAN) {
        file.insert("mass_kg".into(), mass_kg.into());
    }
    let mut keys: Vec<(&str, String)> = Vec::new();
    let said = |parameters: &[Parameter]| said(found, parameters);
    let any = |parameters: &[Parameter]| parameters.iter().any(|parameter| found.of(*parameter).is_some());
    if any(&[Parameter::InertiaX, Parameter::InertiaY, Parameter::InertiaZ]) {
        let inertia = &after.mass.inertia_kg_m2;
        file.insert("inertia_kg_m2".into(), json!([inertia.m11, inertia.m22, inertia.m33]));
        if file.contains_key("inertia_off_diagonal_kg_m2") {
            file.insert("inertia_off_diagonal_kg_m2".into(), json!([inertia.m12, inertia.m13, inertia.m23]));
        }
        keys.push(("inertia_kg_m2", said(&[Parameter::InertiaX, Parameter::InertiaY, Parameter::InertiaZ])));
    }
    // Rotors that are mirror images stay so, unless it is told that they are none.
    let is_off = |parameter: Parameter| {
        found.of(parameter).is_some_and(|one| one.deviation.abs() > one.reach * one.error)
    };
    if is_off(Parameter::CentreX) || is_off(Parameter::CentreY) {
        for (i, rotor) in after.rotors.iter().enumerate() {
            let place = rotor.position_body_m;
            if let Some(Value::Object(json)) = file.get_mut("rotors").and_then(|rotors| rotors.get_mut(i)) {
                json.insert("position_body_m".into(), json!([place.x, place.y, place.z]));
            }
        }
        keys.push(("rotors", said(&[Parameter::CentreX, Parameter::CentreY])));
    }
    if any(&[Parameter::Thrust, Parameter::Torque]) {
        let before = |key: &str| file.get("rotor_factors").and_then(|f| f.get(key)?.as_f64()).unwrap_or(1.0);
        let factor = |parameter: Parameter| found.of(parameter).map_or(1.0, Found::value);
        let factors = json!({
            "thrust_factor": before("thrust_factor") * factor(Parameter::Thrust),
            "torque_factor": before("torque_factor") * factor(Parameter::Torque),
        });
        file.insert("rotor_factors".into(), factors);
        keys.push(("rotor_factors", said(&[Parameter::Thrust, Parameter::Torque])));
    }
    if any(&[Parameter::DragAlong, Parameter::DragAcross]) {
        put_drag(&mut file, &after);
        keys.push(("body_aero", said(&[Parameter::DragAlong, Parameter::DragAcross])));
    }
    for (parameter, key, first_order) in [
        (Parameter::LagUp, "tau_up_s", "motor.first_order.tau_up_s"),
        (Parameter::LagDown, "tau_down_s", "motor.first_order.tau_down_s"),
    ] {
        if found.of(parameter).is_none() {
            continue;
        }
        match (&after.motor, file.get_mut("motor")) {
            (Motor::FirstOrder { tau_up_s, tau_down_s, .. }, Some(motor)) => {
                motor["first_order"][key] =
                    json!(if parameter == Parameter::LagUp { tau_up_s } else { tau_down_s });
                keys.push((first_order, said(&[parameter])));
            }
            (Motor::EscDc(dc), Some(motor)) => {
                motor["esc_dc"]["rotor_inertia_kg_m2"] = json!(dc.rotor_inertia_kg_m2);
                keys.push(("motor.esc_dc.rotor_inertia_kg_m2", said(&[parameter])));
            }
            _ => (),
        }
    }
    put_origins(&mut file, &keys, logs);
    put_uncertain(&mut file, found);
    let table = table(&source, &mut file, name)?;
    let text = serde_json::to_string_pretty(&Value::Object(file)).unwrap_or_default() + "\n";
    Ok(IdentifiedFile { text, table })
}

/// The table beside the file, under a name of its own.
fn table(
    source: &Source,
    file: &mut Map<String, Value>,
    name: &str,
) -> Result<Option<(String, String)>, ConfigError> {
    for model in ["blade_element", "table"] {
        let Some(Value::String(named)) =
            file.get_mut("rotor").and_then(|rotor| rotor.get_mut(model)?.get_mut("file"))
        else {
            continue;
        };
        let path: PathBuf = source.resolve(named);
        let table = Source::read(&path, "rotor table", Some(&source.file))?;
        *named = format!("{name}_rotor.csv");
        return Ok(Some((named.clone(), table.text)));
    }
    Ok(None)
}

/// "thrust: standard error 0.3 %, ..": how numbers were measured.
fn said(found: &Identified, parameters: &[Parameter]) -> String {
    let one = |found: &Found| {
        format!("{}: standard error {}", found.parameter.words(), found.parameter.error_words(found.error))
    };
    let all: Vec<String> = parameters.iter().filter_map(|parameter| found.of(*parameter)).map(one).collect();
    format!("output error over the flight; {}", all.join(", "))
}

/// The coefficients of the body, over the angles that the model has.
fn put_drag(file: &mut Map<String, Value>, after: &Vehicle) {
    let [drag, lift, pitch] = after.aero.coefficients();
    let degrees: Vec<f64> = drag.knots().iter().map(|alpha| alpha * DEG_PER_RAD).map(clean).collect();
    let mut json = json!({
        "reference_area_m2": after.aero.area_m2(),
        "reference_span_m": after.aero.span_m(),
        "alpha_deg": degrees,
        "c_drag": drag.values(),
        "c_lift": lift.values(),
        "c_pitch": pitch.values(),
    });
    if let Some(area) = after.aero.side_area_m2() {
        json["side_drag_area_m2"] = json!(area);
    }
    file.insert("body_aero".into(), json);
}

/// A number of degrees without what a turn into radians and back has left.
fn clean(x: f64) -> f64 {
    let near = (1e9 * x).round() * 1e-9;
    if (near - near.round()).abs() < 1e-8 { near.round() } else { near }
}

/// Says where numbers are from; of the same keys nothing else is said any more.
fn put_origins(file: &mut Map<String, Value>, keys: &[(&str, String)], logs: &str) {
    let is_found = |key: &Value| keys.iter().any(|(found, _)| key == found);
    let mut origins = match file.remove("origins") {
        Some(Value::Array(origins)) => origins,
        _ => Vec::new(),
    };
    for origin in &mut origins {
        if let Some(Value::Array(old)) = origin.get_mut("keys") {
            old.retain(|key| !is_found(key));
        }
    }
    origins.retain(|origin| origin["keys"].as_array().is_some_and(|keys| !keys.is_empty()));
    if let Some(Value::Array(estimated)) = file.get_mut("estimated") {
        estimated.retain(|key| !is_found(key));
    }
    let new = |(key, formula): &(&str, String)| json!({ "keys": [key], "kind": "measured", "file": logs, "formula": formula });
    origins.extend(keys.iter().map(new));
    if !origins.is_empty() {
        file.insert("origins".into(), Value::Array(origins));
    }
}

/// Says how far numbers may be off: what was found together, with the mass where its own is known to be off.
fn put_uncertain(file: &mut Map<String, Value>, found: &Identified) {
    let shares: Vec<(&str, Vec<usize>)> = SHARES
        .iter()
        .map(|(key, parameters)| {
            let places =
                found.found.iter().enumerate().filter(|(_, one)| parameters.contains(&one.parameter));
            (*key, places.map(|(i, _)| i).collect::<Vec<usize>>())
        })
        .filter(|(_, places)| !places.is_empty())
        .collect();
    if shares.is_empty() {
        return;
    }
    let mut uncertain = match file.remove("uncertain") {
        Some(Value::Object(uncertain)) => uncertain,
        _ => Map::new(),
    };
    for (key, _) in &shares {
        uncertain.remove(*key);
    }
    if let Some(Value::Array(together)) = uncertain.get_mut("together") {
        together.iter_mut().for_each(|joint| forget(joint, &shares));
        together.retain(|joint| joint["quantities"].as_array().is_some_and(|all| all.len() > 1));
        if together.is_empty() {
            uncertain.remove("together");
        }
    }
    // Thrust, inertia and drag are seen over the mass.
    let mass = uncertain.get("mass").and_then(|mass| mass.get("normal")?.get("sigma")?.as_f64());
    let mass_variance = mass.map_or(0.0, |sigma| sigma * sigma);
    let over_mass = |key: &str| f64::from(key != "motor_lag");
    let covariance = |a: usize, b: usize| {
        let ((key_a, of_a), (key_b, of_b)) = (&shares[a], &shares[b]);
        let mut sum = 0.0;
        for i in of_a {
            for j in of_b {
                sum += found.covariance[(*i, *j)];
            }
        }
        sum / (of_a.len() * of_b.len()) as f64 + over_mass(key_a) * over_mass(key_b) * mass_variance
    };
    let sigma = |a: usize| covariance(a, a).sqrt();
    let joint: Vec<usize> = (0..shares.len()).filter(|a| sigma(*a) <= NORMAL_TO).collect();
    for a in (0..shares.len()).filter(|a| !joint.contains(a)) {
        let reach = CUT_AT * sigma(a);
        let cut = json!({ "sigma": sigma(a), "range": [(-reach).max(LEAST), reach] });
        uncertain.insert(shares[a].0.into(), json!({ "truncated_normal": cut }));
    }
    let with_mass = mass_variance > 0.0;
    if joint.len() + usize::from(with_mass) > 1 && !joint.is_empty() {
        let mut quantities: Vec<&str> = joint.iter().map(|a| shares[*a].0).collect();
        let mut rows: Vec<Vec<f64>> =
            joint.iter().map(|a| joint.iter().map(|b| covariance(*a, *b)).collect()).collect();
        if with_mass {
            let with: Vec<f64> = joint.iter().map(|a| over_mass(shares[*a].0) * mass_variance).collect();
            rows.iter_mut().zip(&with).for_each(|(row, with)| row.push(*with));
            rows.push(with.into_iter().chain([mass_variance]).collect());
            quantities.push("mass");
            uncertain.remove("mass");
        }
        let together = json!({ "quantities": quantities, "covariance": rows });
        match uncertain.get_mut("together") {
            Some(Value::Array(all)) => all.push(together),
            _ => _ = uncertain.insert("together".into(), json!([together])),
        }
    } else if let Some(a) = joint.first() {
        uncertain.insert(shares[*a].0.into(), json!({ "normal": { "sigma": sigma(*a) } }));
    }
    file.insert("uncertain".into(), Value::Object(uncertain));
}

/// Takes quantities that were found out of those that are normal together.
fn forget(joint: &mut Value, shares: &[(&str, Vec<usize>)]) {
    let Some(names) = joint["quantities"].as_array().cloned() else { return };
    for i in (0..names.len()).rev().filter(|i| shares.iter().any(|(key, _)| names[*i] == *key)) {
        for list in ["quantities", "mean", "covariance"] {
            if let Some(Value::Array(list)) = joint.get_mut(list).filter(|list| list.get(i).is_some()) {
                list.remove(i);
            }
        }
        if let Some(Value::Array(rows)) = joint.get_mut("covariance") {
            for row in rows.iter_mut().filter_map(Value::as_array_mut).filter(|row| i < row.len()) {
                row.remove(i);
            }
        }
    }
}
