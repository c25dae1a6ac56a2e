//! Which mission is the paper's study: the shipped one, and none with another number. The shipped files are
//! what says which numbers there are.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use serde_json::Value;

use super::source::sha256;
use super::spoil::{TITAN, copy, shipped};
use super::*;
use samara_core::control::{ThrustCurve, TiltFrom};
use samara_core::model::RotationSense;
use samara_core::plan::InputReference;

const VEHICLE: &str = "params/vehicles/titan.json";
const TABLE: &str = "params/vehicles/titan_rotor.csv";

/// Numbers of mission and vehicle that the study's flights do not depend on.
const NOT_OF_THE_STUDY: [&str; 17] = [
    "/seed",
    "/epoch_unix_us",
    "/duration_s",
    "/site/latitude_deg",
    "/site/longitude_deg",
    "/site/altitude_m",
    "/parachute/pendulum/amplitude_deg",
    "/parachute/pendulum/phase_deg",
    "/parachute/pendulum/omega_rad_s",
    "/parachute/pendulum/length_m",
    "/release/hang_s",
    "/monte_carlo/trials",
    "/tuning/gains/0",
    "/tuning/gains/1",
    // The last point of a coefficient is the first, a turn later.
    "/body_aero/c_drag/36",
    "/body_aero/c_lift/36",
    "/body_aero/c_pitch/36",
];

/// What the paper prints stands beside the shipped study alone, whatever it is called and whoever flies it.
#[test]
fn the_papers_study_is_known_by_its_numbers() {
    let m = load_mission(&shipped(TITAN)).unwrap();
    assert!(m.is_the_papers_study(), "vehicle or mission have changed: {}", sha256(&m.study_numbers()));
    let mut same = m.clone();
    (same.name, same.seed, same.study.monte_carlo.trials) = ("other".into(), 7, 1000);
    same.use_gains("near_hover").unwrap();
    assert!(same.is_the_papers_study());
    let before = same.study_numbers();
    same.control.limits.tilt_from = TiltFrom::Gravity;
    let tilted = same.study_numbers();
    same.control.limits.thrust_curve = ThrustCurve::Linear;
    assert!(same.is_the_papers_study(), "another reading of the law is the paper's too");
    assert!(before != tilted && tilted != same.study_numbers());
    let changes: [fn(&mut Mission); 8] = [
        |m| m.plan.initial = PlanInitial::Release,
        |m| m.plan.cost_input_reference = InputReference::Trim,
        |m| m.plan.x_ss = None,
        |m| Arc::make_mut(&mut m.vehicle).rotors[2].spin = RotationSense::Ccw,
        |m| Arc::make_mut(&mut m.vehicle).options.reaction_torque = true,
        |m| Arc::make_mut(&mut m.vehicle).options.rotor_momentum = true,
        |m| m.study.cases.truncate(6),
        |m| m.study.cases[3].pitch_rad = m.study.cases[3].pitch_rad.next_up(),
    ];
    for (i, change) in changes.iter().enumerate() {
        let mut other = m.clone();
        change(&mut other);
        assert!(!other.is_the_papers_study(), "change {i}");
    }
}

/// The names and values of a mission; a name stands once.
fn numbers(mission: &Path) -> BTreeMap<String, String> {
    let text = load_mission(mission).unwrap().study_numbers();
    let lines: Vec<(&str, &str)> = text.lines().map(|line| line.split_once('=').unwrap()).collect();
    let numbers: BTreeMap<_, _> = lines.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
    assert_eq!(numbers.len(), lines.len(), "a name stands twice");
    numbers
}

/// The JSON pointers of a document's numbers.
fn pointers(value: &Value, at: &str) -> Vec<String> {
    match value {
        Value::Number(_) => vec![at.to_owned()],
        Value::Array(list) => {
            list.iter().enumerate().flat_map(|(i, v)| pointers(v, &format!("{at}/{i}"))).collect()
        }
        Value::Object(map) => map.iter().flat_map(|(key, v)| pointers(v, &format!("{at}/{key}"))).collect(),
        _ => Vec::new(),
    }
}

/// The nearest other number, towards zero; of an angle in degrees, whose radians may round to the same, the
/// third.
fn nudged(x: f64, in_degrees: bool) -> f64 {
    if x == 0.0 { 1e-300 } else { f64::from_bits(x.to_bits() - if in_degrees { 3 } else { 1 }) }
}

/// A copy of the shipped study with a rotor table of two airspeeds and two angles, to be read often.
fn small_study() -> tempfile::TempDir {
    let dir = copy();
    let table = std::fs::read_to_string(shipped(TABLE)).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let (first, last) = (&rows[0], &rows[rows.len() - 1]);
    let at_an_end = |row: &&Vec<&str>| (1..3).all(|c| row[c] == first[c] || row[c] == last[c]);
    let kept: Vec<String> = rows.iter().filter(at_an_end).map(|row| row.join(",")).collect();
    let header = table.lines().next().unwrap();
    std::fs::write(dir.path().join(TABLE), format!("{header}\n{}\n", kept.join("\n"))).unwrap();
    let vehicle = std::fs::read_to_string(shipped(VEHICLE)).unwrap();
    let with_all = vehicle.replacen("\"rotors\"", "\"inertia_off_diagonal_kg_m2\": [0, 0, 0], \"rotors\"", 1);
    std::fs::write(dir.path().join(VEHICLE), with_all).unwrap();
    dir
}

/// Each number of the three files by the smallest step: the text of the study follows, but for numbers that
/// are not of it; and each number of the text follows one of the files'.
#[test]
fn prop_every_number_of_the_study_counts() {
    let dir = small_study();
    let mission = dir.path().join(TITAN);
    let shipped_numbers = numbers(&mission);
    let mut reached = BTreeSet::new();
    let mut spoil = |file: &str, text: &str, what: &str| {
        let path = dir.path().join(file);
        let before = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text).unwrap();
        let spoilt = numbers(&mission);
        std::fs::write(&path, before).unwrap();
        let changed = spoilt.into_iter().filter(|(name, value)| shipped_numbers.get(name) != Some(value));
        let changed: Vec<String> = changed.map(|(name, _)| name).collect();
        let counts = !NOT_OF_THE_STUDY.contains(&what) && !what.ends_with("radius_m");
        assert_eq!(!changed.is_empty(), counts, "{file} {what}: {changed:?}");
        reached.extend(changed);
    };
    for file in [TITAN, VEHICLE] {
        let text = std::fs::read_to_string(dir.path().join(file)).unwrap();
        let document: Value = serde_json::from_str(&text).unwrap();
        for pointer in pointers(&document, "") {
            let mut other = document.clone();
            let mut set = |pointer: &str, value: Value| *other.pointer_mut(pointer).unwrap() = value;
            let old = document.pointer(&pointer).unwrap().as_f64().unwrap();
            let whole = ["/seed", "/epoch_unix_us", "/nodes", "/trials"].iter().any(|k| pointer.ends_with(k));
            let in_degrees = pointer.contains("_deg");
            let new = if whole { Value::from(old as u64 + 1) } else { Value::from(nudged(old, in_degrees)) };
            set(&pointer, new.clone());
            // The target and the steady state's velocity are the same numbers.
            if let Some(axis) = pointer.strip_prefix("/target_v_ned_m_s/") {
                set(&format!("/plan/x_ss/v_ned_m_s/{axis}"), new);
            } else if let Some(axis) = pointer.strip_prefix("/plan/x_ss/v_ned_m_s/") {
                set(&format!("/target_v_ned_m_s/{axis}"), new);
            }
            spoil(file, &other.to_string(), &pointer);
        }
    }
    let table = std::fs::read_to_string(dir.path().join(TABLE)).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let joined = |rows: &[Vec<&str>]| rows.iter().map(|row| row.join(",") + "\n").collect::<String>();
    for (column, name) in rows[0].iter().enumerate() {
        for i in 1..rows.len() {
            let old = rows[i][column];
            let new = format!("{:?}", nudged(old.parse().unwrap(), *name == "angle_deg"));
            let mut other = rows.clone();
            // A knot of an axis stands in many rows.
            let axis = column < 3;
            if axis && rows[1..i].iter().any(|row| row[column] == old) {
                continue;
            }
            other
                .iter_mut()
                .skip(1)
                .enumerate()
                .filter(|(at, row)| at + 1 == i || axis && row[column] == old)
                .for_each(|(_, row)| row[column] = &new);
            spoil(TABLE, &joined(&other), &format!("{name} {i}"));
        }
    }
    let unreached = shipped_numbers
        .iter()
        .filter(|(name, value)| value.parse::<f64>().is_ok() && !reached.contains(*name));
    assert_eq!(unreached.count(), 0);
}
