//! `samara identify` on the program's own flights: the vehicle that flew is known.
#![cfg(feature = "cli")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use samara::config::load_vehicle;
use samara::logged_flight::columns::flight;
use samara::logged_flight::{LoggedFlight, Series};
use samara::uncertain::UncertainQuantity;
use serde_json::Value;

fn samara(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara")).current_dir(folder).args(args).output().unwrap()
}

fn json(output: &Output) -> Value {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    serde_json::from_slice(&output.stdout).unwrap()
}

#[path = "../crates/core/tests/shared/test_flight.rs"]
mod test_flight;

/// The flight as a table, as `flight.csv` names its columns.
fn table(log: &LoggedFlight) -> String {
    let of = |series: &Option<Series<3>>| series.clone().unwrap();
    let (motors, force, rates) =
        (log.motors.clone().unwrap(), of(&log.force_body_m_s2), of(&log.rates_body_rad_s));
    let (attitude, velocity) = (log.attitude.clone().unwrap(), of(&log.velocity_ned_m_s));
    let mut text =
        "t_s,throttle_1,throttle_2,throttle_3,throttle_4,fx_m_s2,fy_m_s2,fz_m_s2,p_rad_s,q_rad_s,r_rad_s,\
                    q0,q1,q2,q3,vn_m_s,ve_m_s,vd_m_s\n"
            .to_owned();
    let at = |series: &Series<3>, t_s: f64| {
        let row = series.t_s.partition_point(|t| *t < t_s - 1e-6);
        let is_there = series.t_s.get(row).is_some_and(|t| (t - t_s).abs() < 1e-6);
        if is_there { series.values[row] } else { [f64::NAN; 3] }
    };
    for (row, t_s) in motors.t_s.iter().enumerate() {
        let numbers = [*t_s].into_iter().chain(motors.values[row][..4].iter().copied());
        let numbers = numbers.chain(at(&force, *t_s)).chain(at(&rates, *t_s));
        let numbers = numbers.chain(*attitude.at(*t_s).unwrap()).chain(at(&velocity, *t_s));
        let fields = numbers.map(|x| x.to_string());
        text += &(fields.collect::<Vec<String>>().join(",") + "\n");
    }
    text
}

/// A vehicle that is known badly comes out of a table as the one that flew; what is uncertain of it is drawn.
#[test]
fn closed_form_a_table_tells_the_vehicle_that_flew() {
    let folder = tempfile::tempdir().unwrap();
    let truth = test_flight::vehicle();
    let flown = test_flight::Flown { length_s: 38.0, ..test_flight::Flown::manoeuvre(4) };
    let log = test_flight::thinned(test_flight::fly(&truth, &flown), [1, 2, 2]);
    fs::write(folder.path().join("flight.csv"), table(&log)).unwrap();
    let base = serde_json::json!({
        "name": "known_badly", "mass_kg": 2.064, "inertia_kg_m2": [0.03, 0.02, 0.04],
        "rotors": truth.rotors.iter().enumerate().map(|(i, rotor)| serde_json::json!({
            "position_body_m": rotor.position_body_m.as_slice(), "axis_body": [0, 0, -1],
            "spin_from_above": if i < 2 { "ccw" } else { "cw" },
        })).collect::<Vec<_>>(),
        "effects": { "reaction_torque": true, "rotor_momentum": true },
        "body_aero": { "drag_area_m2": 0.06, "side_drag_area_m2": 0.06 },
        "rotor": { "quadratic": { "thrust_n_per_rad2_s2": 2.1e-5, "torque_per_thrust_m": 0.013, "density_kg_m3": 1.225 } },
        "motor": { "first_order": {
            "omega_max_rad_s": 714, "tau_up_s": 0.02, "tau_down_s": 0.06, "rotor_inertia_kg_m2": 2.6e-5,
        } },
        "uncertain": { "mass": { "normal": { "sigma": 0.02 } }, "inertia": { "uniform": [-0.3, 0.3] } },
        "origins": [{ "keys": ["inertia_kg_m2", "mass_kg"], "kind": "guessed" }],
    });
    fs::write(folder.path().join("base.json"), base.to_string()).unwrap();
    let args = ["identify", "flight.csv", "--vehicle", "base.json", "--out", "found", "--json"];
    let told = json(&samara(folder.path(), &args));
    let truths = [9.686, 0.155, 0.0236, 0.0236, 0.0439, 1.0, 1.0, 30.0, 45.0, 4.0, 0.0, 0.0];
    let rooms = [0.03, 0.003, 2e-4, 2e-4, 9e-4, 0.1, 0.1, 0.6, 0.9, 0.5, 1.0, 1.0];
    let numbers = told["numbers"].as_array().unwrap();
    for ((number, truth), room) in numbers.iter().zip(truths).zip(rooms) {
        let found = number["found"].as_f64().unwrap_or_else(|| panic!("{number}"));
        assert!((found - truth).abs() < room, "{truth} {number}");
    }
    let written = load_vehicle(&folder.path().join("found.json")).unwrap();
    assert!((written.vehicle.mass.inertia_kg_m2.m11 - 0.0236).abs() < 2e-4);
    assert!((written.vehicle.static_thrust_n(1.225) - 9.686).abs() < 0.03);
    let uncertain = written.uncertain.unwrap();
    // Thrust and inertia are seen over the mass: they are as uncertain, and move with it.
    let (thrust, mass) = (UncertainQuantity::Thrust, UncertainQuantity::Mass);
    let joint = uncertain.joint_of(thrust).unwrap();
    assert!(joint.correlation(thrust, mass).unwrap() > 0.95);
    assert!(joint.correlation(UncertainQuantity::Inertia, mass).unwrap() > 0.9);
    assert_eq!(joint.correlation(UncertainQuantity::MotorLag, mass), Some(0.0));
    assert_eq!(written.estimated, Some(vec!["mass_kg".to_owned()]));
    let page = fs::read_to_string(folder.path().join("found.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("inertia of roll"));
    what_was_found_is_drawn(folder.path());
}

/// A campaign draws what was found as it hangs together - thrust over mass is known to 0.3 %, the mass to 2 -
/// and its card says which log that is from.
fn what_was_found_is_drawn(folder: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read(root.join("tests/calm_x500.json")).unwrap();
    let mut mission: Value = serde_json::from_slice(&text).unwrap();
    mission["vehicle"] = "found.json".into();
    mission["gains"] = root.join("params/gains/x500.json").to_str().unwrap().into();
    mission["duration_s"] = 24.into();
    mission.as_object_mut().unwrap().retain(|key, _| !["$schema", "px4_params"].contains(&&**key));
    fs::write(folder.join("mission.json"), mission.to_string()).unwrap();
    let flown =
        ["assess", "mission.json", "--autopilot", "reference", "--trials", "4", "--out", "out", "--json"];
    let flown = samara(folder, &flown);
    assert!(flown.status.code() < Some(2), "{}", String::from_utf8_lossy(&flown.stderr));
    let drawn = fs::read_to_string(folder.join("out/drops_reference_x500_uncertain.csv")).unwrap();
    let mut lines = drawn.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = |name: &str| names.iter().position(|one| *one == name).unwrap();
    let (mass, thrust) = (place("mass"), place("thrust"));
    let rows = lines.map(|line| line.split(',').map(|x| x.parse().unwrap()).collect::<Vec<f64>>());
    let rows: Vec<Vec<f64>> = rows.collect();
    assert!(rows.iter().any(|row| row[mass].abs() > 0.008), "{drawn}");
    assert!(rows.iter().all(|row| (row[thrust] - row[mass]).abs() < 0.006), "{drawn}");
    let card = ["card", "mission.json", "--accept-estimates", "--evidence", "out", "--out", "card", "--json"];
    let card: Value = serde_json::from_slice(&samara(folder, &card).stdout).unwrap();
    let assumed = card["assumed"].to_string();
    assert!(assumed.contains("; measured in flight.csv: inertia_kg_m2, "), "{assumed}");
}

/// A drop's log, of a vehicle that is as its file says, is too short for a fit: all is refused with the
/// reason, and there is a page, but no vehicle.
#[test]
fn a_drop_is_too_short_to_tell_a_vehicle() {
    let folder = tempfile::tempdir().unwrap();
    let flown = samara(folder.path(), &["drop", "x500_drop", "--autopilot", "reference", "--out", "flown"]);
    assert_eq!(flown.status.code(), Some(0));
    for log in ["flown/flight.ulg", "flown/flight.csv"] {
        let args = ["identify", log, "--vehicle", "x500", "--out", "same", "--json"];
        let output = samara(folder.path(), &args);
        assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
        let told: Value = serde_json::from_slice(&output.stdout).unwrap();
        let numbers = told["numbers"].as_array().unwrap();
        assert!(numbers.iter().all(|number| number["refused"].as_str().unwrap().contains("20 are needed")));
        assert!(!folder.path().join("same.json").exists(), "the base is no vehicle that was found");
        assert!(folder.path().join("same.html").exists());
    }
}

/// What cannot be is refused, with the file and what was expected.
#[test]
fn what_is_no_log_of_the_vehicle_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |text: &str, more: &[&str], words: &str| {
        fs::write(folder.path().join("log.csv"), text).unwrap();
        let args = [&["identify", "log.csv", "--vehicle", "x500"][..], more].concat();
        let output = samara(folder.path(), &args);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && said.contains(words), "{words}: {said}");
    };
    refused("", &[], "log.csv:1");
    refused("time,q0\n1,2\n", &[], "expected a header with the column `t_s`");
    refused("t_s,q0\n1\n", &[], "log.csv:2");
    refused("t_s,q0\n1,2\n", &[], "the log has no commands to the rotors");
    refused("t_s,q0\n1,2\n", &["--mass", "-1"], "--mass: expected a number above 0");
    refused("t_s,q0\n1,2\n", &["--gravity", "nan"], "--gravity: expected a number above 0");
    refused("t_s,q0\n1,2\n", &["--density", "0"], "--density: expected a number above 0");
    let rotors: String = (0..300)
        .map(|i| format!("{}.{:03},0.{i:03},0.5,0.{i:03},0,0,0,0,0,0\n", i / 250, 4 * (i % 250)))
        .collect();
    let header = "t_s,throttle_1,throttle_2,throttle_3,fx_m_s2,fy_m_s2,fz_m_s2,p_rad_s,q_rad_s,r_rad_s\n";
    refused(&format!("{header}{rotors}"), &[], "2 rotors were commanded in the log, and the vehicle has 4");
    fs::write(folder.path().join("no.ulg"), "ULog").unwrap();
    let output = samara(folder.path(), &["identify", "no.ulg", "--vehicle", "x500"]);
    assert_eq!(output.status.code(), Some(2));
}

/// What cannot be wanted of a manoeuvre is refused, with what was expected.
#[test]
fn what_cannot_be_wanted_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |args: &[&str], words: &str| {
        let output = samara(folder.path(), &[&["identify"], args].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && said.contains(words), "{words}: {said}");
    };
    for (wanted, words) in [
        ("thrust", "expected QUANTITY=PERCENT, above 0 and up to 100"),
        ("mass=2", "one of thrust, torque, inertia_xx"),
        ("inert=2", "found inert"),
        ("thrust=0", "found 0"),
        ("thrust=nan", "found NaN"),
        ("thrust=x", "found x"),
    ] {
        refused(&["--manoeuvre", "x500_drop", "--wanted", wanted], words);
    }
    refused(&["--manoeuvre", "nowhere.json"], "nowhere.json");
    refused(&["log.ulg", "--manoeuvre", "x500_drop"], "cannot be used with");
    refused(&["log.ulg", "--vehicle", "x500", "--wanted", "thrust=1"], "cannot be used with");
    refused(&["log.ulg"], "--vehicle");
}

/// The Crazyflie's own log of shared flights: a text of its columns, then for each row two bytes, the time in
/// microseconds and a number for each column.
fn crazyflie(bytes: &[u8]) -> String {
    let columns = 10;
    let begins = bytes.windows(5).position(|five| five == b"(I)\0\xff").unwrap() + 4;
    let row = 2 + 8 + 4 * columns;
    let mut text =
        "t_s,fx_m_s2,fy_m_s2,fz_m_s2,p_rad_s,q_rad_s,r_rad_s,throttle_1,throttle_2,throttle_3,throttle_4\n"
            .to_owned();
    for row in bytes[begins..].chunks_exact(row) {
        let four = |i: usize| <[u8; 4]>::try_from(&row[10 + 4 * i..14 + 4 * i]).unwrap();
        let real = |i: usize| f64::from(f32::from_le_bytes(four(i)));
        let throttle = |i: usize| f64::from(u32::from_le_bytes(four(6 + i))) / 65535.0;
        let t_s = u64::from_le_bytes(row[2..10].try_into().unwrap()) as f64 * 1e-6;
        // Forward, left, up in g and deg/s; motors front right, rear right, rear left, front left.
        let [x, y, z] = [real(0), -real(1), -real(2)].map(|g| 9.80665 * g);
        let [p, q, r] = [real(3), -real(4), -real(5)].map(f64::to_radians);
        let [one, two, three, four] = [throttle(0), throttle(2), throttle(3), throttle(1)];
        text += &format!("{t_s},{x},{y},{z},{p},{q},{r},{one},{two},{three},{four}\n");
    }
    text
}

/// A log of two rows in the Crazyflie's form becomes a table that is read.
#[test]
fn closed_form_a_crazyflie_s_log_is_a_table() {
    let mut bytes = b"\xbc\x02\0\x01\0\xff\xfffixedFrequency\0\n\0acc.x(f)\0motor.m4(I)\0".to_vec();
    for (t_us, motor) in [(1_000_000_u64, 0_u32), (1_001_000, 65_535)] {
        bytes.extend([0xff, 0xff]);
        bytes.extend(t_us.to_le_bytes());
        for x in [0.5_f32, 0.25, 1.0, 90.0, 0.0, -180.0] {
            bytes.extend(x.to_le_bytes());
        }
        (0..4).for_each(|_| bytes.extend(motor.to_le_bytes()));
    }
    let text = crazyflie(&bytes);
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    let names: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let columns: Vec<Vec<f64>> = (0..names.len()).map(|i| rows.iter().map(|row| row[i]).collect()).collect();
    let read = flight(|name| Some(columns[names.iter().position(|one| *one == name)?].as_slice())).unwrap();
    assert_eq!(read.motors.unwrap().values[1][..4], [1.0; 4]);
    assert_eq!(read.force_body_m_s2.unwrap().values[0][2], -9.80665);
    let rates = read.rates_body_rad_s.unwrap();
    assert!((rates.values[0][0] - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert!((rates.values[0][2] - std::f64::consts::PI).abs() < 1e-12 && (rates.t_s[1] - 0.001).abs() < 1e-9);
}

/// Real flights in the folder SAMARA_FLIGHTS. The Crazyflie's at 1 kHz tells nothing by a second's flight: of
/// what pitch did within 0.05 s, commands explain a half, whatever the lag, and the rest is the air of the
/// room; over a second nothing is left. PX4's at its usual rates tell the thrust of hovers at most.
#[test]
fn reference_real_flights_tell_what_they_can() {
    let Some(flights) = std::env::var_os("SAMARA_FLIGHTS") else {
        eprintln!("skipped: SAMARA_FLIGHTS is not set");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let flights = Path::new(&flights);
    let bytes = fs::read(flights.join("arpl_cf_log10.bin")).unwrap();
    fs::write(folder.path().join("crazyflie.csv"), crazyflie(&bytes)).unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/crazyflie.json");
    let vehicle = data.to_str().unwrap();
    let told = samara(folder.path(), &["identify", "crazyflie.csv", "--vehicle", vehicle, "--json"]);
    assert_eq!(told.status.code(), Some(1), "{}", String::from_utf8_lossy(&told.stderr));
    let told: Value = serde_json::from_slice(&told.stdout).unwrap();
    println!("{told:#}");
    for number in told["numbers"].as_array().unwrap() {
        assert!(number["name"] == "mass" || number["refused"].as_str().unwrap().len() > 20, "{number}");
    }
    for log in ["aut_esc_status.ulg", "aut_quadrotor_local.ulg"] {
        let path = flights.join(log);
        let told =
            samara(folder.path(), &["identify", path.to_str().unwrap(), "--vehicle", "x500", "--json"]);
        println!("{log}: {}{}", String::from_utf8_lossy(&told.stdout), String::from_utf8_lossy(&told.stderr));
        if told.status.code() == Some(0) {
            let found =
                json(&told)["numbers"].as_array().unwrap().iter().filter(|n| n["found"].is_number()).count();
            assert_eq!(found, 1);
        }
    }
}
