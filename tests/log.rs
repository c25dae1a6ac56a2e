//! `samara log` on the program's own flights, of which is known what was flown.
#![cfg(feature = "cli")]

use std::fs;
use std::path::Path;
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
    of_a_table_is_said_what_it_has(&place("flown/flight.csv"));
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

/// A table of the same flight has its quantities at its own rate, and no topics; what it lacks is said.
fn of_a_table_is_said_what_it_has(table: &str) {
    let rows = fs::read_to_string(table).unwrap().lines().filter(|line| !line.starts_with('#')).count() - 1;
    let said = json(&samara(&["log", table, "--json"]));
    assert_eq!(said["rows"], rows);
    assert_eq!((&said["topics"], &said["says"]), (&serde_json::json!([]), &serde_json::json!([])));
    let rates = named(&said, "quantities", "name", "angular rates");
    assert_eq!((&rates["from"], &rates["values"]), (&Value::from("p_rad_s"), &Value::from(rows)));
    assert_eq!(named(&said, "quantities", "name", "battery")["from"], Value::Null);
    assert_eq!(named(&said, "tells", "quantity", "inertia of pitch over thrust")["can"], true);
    let text = String::from_utf8(samara(&["log", table, "--topics"]).stdout).unwrap();
    assert!(
        text.contains(&format!("{rows} rows")) && text.contains("all of it is taken for a flight"),
        "{text}"
    );
}

/// By hand: in still air the commands of a log make of the vehicle that flew what the log has, to what its
/// sensors are off; of one with constant coefficients in place of blade elements they do not, and it is said.
/// What a log has not is said, too.
#[test]
fn closed_form_a_second_is_predicted_by_the_vehicle_that_flew_and_by_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let calm = root.join("tests/calm_x500.json");
    let calm = calm.to_str().unwrap();
    let flown = samara(&["drop", calm, "--autopilot", "reference", "--no-html", "--out", &place("flown")]);
    assert_eq!(flown.status.code(), Some(0));
    let read = |path: &Path| serde_json::from_slice::<Value>(&fs::read(path).unwrap()).unwrap();
    let mut vehicle = read(&root.join("params/vehicles/x500.json"));
    let full: f64 = 714.3286;
    vehicle["rotor"] = serde_json::json!({ "quadratic": {
        "thrust_n_per_rad2_s2": 8.54858 / (full * full), "torque_per_thrust_m": 0.016, "density_kg_m3": 1.225,
    } });
    vehicle.as_object_mut().unwrap().retain(|key, _| !["$schema", "origins", "estimated"].contains(&&**key));
    fs::write(folder.path().join("constant.json"), vehicle.to_string()).unwrap();
    let mut other = read(Path::new(calm));
    other["vehicle"] = "constant.json".into();
    other["gains"] = root.join("params/gains/x500.json").to_str().unwrap().into();
    other.as_object_mut().unwrap().retain(|key, _| !["$schema", "px4_params"].contains(&&**key));
    fs::write(folder.path().join("other.json"), other.to_string()).unwrap();
    let log = place("flown/flight.ulg");
    let [own, other] = [calm.to_owned(), place("other.json")]
        .map(|mission| json(&samara(&["compare", &log, &mission, "--json"]))["logged"].clone());
    let rms = |logged: &Value, by: &str, name: &str| {
        let channel = named(&logged[by], "channels", "name", name);
        channel["rms_error"].as_f64().unwrap()
    };
    // By setpoints the controller takes back some of what the model is off by.
    let names = [("velocity down [m/s]", 0.02), ("specific force z [m/s^2]", 0.1)];
    for (name, most) in names {
        for (by, times) in [("by_commands", 4.0), ("by_setpoints", 2.0)] {
            assert!(rms(&own, by, name) < most, "{name} {by}: {own:#}");
            assert!(rms(&other, by, name) > times * rms(&own, by, name), "{name} {by}: {other:#}");
        }
    }
    assert_eq!(own["by_commands"]["off"], serde_json::json!([]));
    assert_eq!(own["by_commands"]["count"], 15);
    let off = other["by_commands"]["off"].as_array().unwrap();
    assert!(off.contains(&"velocity down [m/s]".into()), "{off:?}");
    the_flight_is_a_ghost(&log, calm, &folder.path().join("out"));
}

/// The text of a block of a page, as an object.
fn block(page: &str, begin: &str) -> Value {
    let (_, behind) = page.split_once(begin).unwrap();
    let (_, behind) = behind.split_once('>').unwrap();
    serde_json::from_str(behind.split_once("</script>").unwrap().0).unwrap()
}

/// The page of the prediction has the flight's motion and nothing of its rotors, whose thrusts nobody
/// measured; flown again by its commands alone the drop stays near its log for seconds.
fn the_flight_is_a_ghost(log: &str, mission: &str, out: &Path) {
    let to = out.to_str().unwrap();
    json(&samara(&["compare", log, mission, "--out", to, "--json"]));
    let page = fs::read_to_string(out.join("drop.html")).unwrap();
    let [own, ghost] = ["<script id=\"drop\"", "<script id=\"beside\""].map(|begin| block(&page, begin));
    let channels = |of: &Value| {
        let all = of["flight"]["channels"].as_array().unwrap();
        all.iter().map(|channel| channel["name"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert!(channels(&own).contains(&"thrust_1_n".to_owned()) && own["plan"].is_object());
    assert!(
        channels(&ghost).contains(&"q3".to_owned()) && !channels(&ghost).contains(&"thrust_1_n".to_owned())
    );
    assert!(ghost["flight"]["count"].as_u64().unwrap() > 3000 && page.contains("data-name=\"flight.ulg\""));
    let [a, b] = [&ghost, &own].map(|of| of["times"]["free_s"].as_f64().unwrap());
    assert!((a - b).abs() < 1e-9, "{a} {b}");
    let replayed = json(&samara(&["replay", log, mission, "--out", to, "--no-html", "--json"]));
    let near_s = replayed["near_s"].as_f64().unwrap();
    assert!(near_s > 5.0 && near_s <= replayed["powered_s"].as_f64().unwrap(), "{replayed}");
    assert!(replayed["lacks"][0].as_str().unwrap().starts_with("wind"), "{replayed}");
    assert!(out.join("flight.csv").exists());
    let refused = samara(&["replay", log, mission, "--out", to, "--trial", "3"]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(refused.status.code() == Some(2) && said.contains("without --trial"), "{said}");
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
