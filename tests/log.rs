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
    of_the_log_is_said_what_was_flown(&log, &place("flown/drop.json"), &place("lines.csv"));
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

/// The drop in a log comes to what the simulator says of it, as far as the autopilot's estimates do: within
/// 0.03 in J_TPF, 0.3 s in steady time, 0.5 m in altitude. Among a hundred drops whose J_TPF is lower it is
/// one in fifty (2 of 101, on either side); of their altitudes half are lower, half are higher.
fn of_the_log_is_said_what_was_flown(log: &str, truth: &str, lines: &str) {
    let truth: Value = serde_json::from_slice(&fs::read(truth).unwrap()).unwrap();
    let mut text = "# samara 0.0.1\n# seed 1\n# inputs sha256 00\n# drops of m by a pilot, gains g\n\
                    trial,j_tpf,peak_speed_m_s,altitude_lost_m,peak_tilt_deg,steady_after_s\n"
        .to_owned();
    (0..100).for_each(|trial| text += &format!("{trial},0.01,,{},,\n", if trial < 50 { 0.1 } else { 900.0 }));
    fs::write(lines, text).unwrap();
    let compared = json(&samara(&["compare", log, "x500_drop", "--campaign", lines, "--json"]));
    let logged = &compared["logged"];
    assert_eq!((&logged["safe"], &logged["falls"]), (&truth["safe"], &Value::from(1)), "{logged:#}");
    assert!((logged["released_s"].as_f64().unwrap() - 15.0).abs() < 0.02, "{logged:#}");
    for (name, within) in [("j_tpf", 0.03), ("steady_after_s", 0.3), ("altitude_lost_m", 0.5)] {
        let flight = named(logged, "quantities", "name", name)["flight"].as_f64().unwrap();
        let flown = truth[name].as_f64().unwrap();
        assert!((flight - flown).abs() < within, "{name}: {flight}, {flown} was flown");
    }
    // The controller is the one that flew, so that the prediction has the pull-out.
    let down = named(logged, "channels", "name", "velocity down [m/s]");
    assert!(down["correlation"].as_f64().unwrap() > 0.9, "{down}");
    let p_value = |name| named(logged, "places", "name", name)["p_value"].as_f64().unwrap();
    assert!(
        (p_value("j_tpf") - 2.0 / 101.0).abs() < 1e-12 && p_value("altitude_lost_m") == 1.0,
        "{logged:#}"
    );
    let refused = samara(&["compare", log, "titan_drop"]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(refused.status.code() == Some(2) && said.contains("Earth's gravity"), "{said}");
}
