//! `samara log` on the program's own flights, of which is known what was flown.
#![cfg(feature = "cli")]

use std::fs;
use std::process::{Command, Output};

use serde_json::Value;

fn samara(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara")).args(args).output().unwrap()
}

fn json(output: &Output) -> Value {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn named<'a>(object: &'a Value, list: &str, key: &str, name: &str) -> &'a Value {
    let rows = object[list].as_array().unwrap();
    rows.iter().find(|row| row[key] == name).unwrap_or_else(|| panic!("{list}: {name}"))
}

/// A drop's log: from its parachute it fell for the time that the mission has its rotors stopped, and flew;
/// every control step has the commands to the rotors, so that it may tell inertia; no flight tells the mass.
/// Broken in the middle, it is read past the break.
#[test]
fn a_drop_is_found_in_its_log_by_its_fall() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let flown = samara(&["drop", "x500_drop", "--autopilot", "reference", "--out", &place("flown")]);
    assert_eq!(flown.status.code(), Some(0));
    let log = place("flown/flight.ulg");
    let whole = json(&samara(&["log", &log, "--json"]));
    let phases = whole["phases"].as_array().unwrap();
    let [.., before, fall, after] = phases.as_slice() else { panic!("{phases:?}") };
    let doing = [before, fall, after].map(|phase| phase["doing"].as_str().unwrap());
    assert_eq!(doing, ["carried, rotors still", "falling", "manoeuvring"], "{phases:?}");
    let [from_s, to_s] = ["from_s", "to_s"].map(|key| fall[key].as_f64().unwrap());
    // Released at 15 s; the air of a fall of 0.5 s ends it a little earlier.
    assert!((from_s - 15.0).abs() < 0.11 && (0.3..=0.8).contains(&(to_s - from_s)), "{phases:?}");
    assert_eq!(whole["lost_bytes"], 0);
    let rate = named(&whole, "quantities", "name", "commands to the rotors")["rate_hz"].as_f64().unwrap();
    assert!((rate - 250.0).abs() < 1.0, "{rate}");
    assert_eq!(named(&whole, "tells", "quantity", "inertia of pitch over thrust")["can"], true);
    assert_eq!(named(&whole, "tells", "quantity", "mass")["can"], false);
    let mut bytes = fs::read(&log).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle..middle + 300].fill(0xA5);
    let broken = place("broken.ulg");
    fs::write(&broken, &bytes).unwrap();
    let read = json(&samara(&["log", &broken, "--json"]));
    let rows = |object: &Value| object["rows"].as_u64().unwrap();
    assert!(read["lost_bytes"].as_u64().unwrap() >= 300);
    assert!(rows(&read) < rows(&whole) && rows(&read) + 60 > rows(&whole));
    fs::write(&broken, "no log").unwrap();
    let refused = samara(&["log", &broken]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2));
    assert!(said.contains("broken.ulg") && said.contains("it begins with no log"), "{said}");
}
