//! The shipped vehicles, and every way in which a vehicle file is refused, with the exact place.

use std::path::{Path, PathBuf};

use super::{ConfigError, VehicleFile, load_vehicle};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("params/vehicles").join(name)
}

/// A directory with the shipped vehicles, for spoiling.
fn copy() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    for name in ["titan.json", "titan_rotor.csv", "x500.json"] {
        std::fs::copy(shipped(name), dir.path().join(name)).unwrap();
    }
    dir
}

/// Line and column of the first occurrence of `needle`, and of the character `skip` further on.
fn place(text: &str, needle: &str, skip: usize) -> (usize, usize) {
    let at = text.find(needle).unwrap() + skip;
    let start = text[..at].rfind('\n').map_or(0, |i| i + 1);
    (text[..at].matches('\n').count() + 1, text[start..at].chars().count() + 1)
}

/// Replaces the first `from` by `to` in a copy of `file` and loads `vehicle`; the copy's text and what came of it.
fn spoil(vehicle: &str, file: &str, from: &str, to: &str) -> (String, Result<VehicleFile, ConfigError>) {
    let dir = copy();
    let path = dir.path().join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{from}");
    let text = text.replacen(from, to, 1);
    std::fs::write(&path, &text).unwrap();
    let loaded = load_vehicle(&dir.path().join(vehicle));
    (text, loaded)
}

#[track_caller]
fn assert_json(
    (text, loaded): (String, Result<VehicleFile, ConfigError>),
    (needle, skip): (&str, usize),
    path: &str,
    says: &str,
) {
    match loaded.unwrap_err() {
        ConfigError::Json { file, line, column, json_path, message } => {
            assert_eq!((line, column), place(&text, needle, skip), "{json_path}: {message}");
            assert_eq!(json_path, path, "{message}");
            assert!(message.contains(says), "{message}");
            let shown =
                ConfigError::Json { file: file.clone(), line, column, json_path, message }.to_string();
            assert!(shown.starts_with(&format!("{}:{line}:{column}: ", file.display())), "{shown}");
        }
        other => panic!("{other}"),
    }
}

#[track_caller]
fn assert_table(loaded: Result<VehicleFile, ConfigError>, at: (usize, usize), says: &str) {
    match loaded.unwrap_err() {
        ConfigError::Table { file, line, column, message } => {
            assert!(file.ends_with("titan_rotor.csv"));
            assert_eq!((line, column), at, "{message}");
            assert!(message.contains(says), "{message}");
        }
        other => panic!("{other}"),
    }
}

#[test]
fn reference_titan_loads_with_its_static_thrust() {
    let titan = load_vehicle(&shipped("titan.json")).unwrap();
    assert_eq!(titan.name, "titan");
    assert!((titan.vehicle.static_thrust_n(5.4) - 431.96945384024576).abs() < 1e-10);
    let hover = (790.0f64 * 1.35 / (4.0 * 431.96945384024576)).sqrt();
    assert!((hover - 0.785641).abs() < 1e-6);
    assert_eq!(titan.rotor_radius_m, Some(0.65));
    assert_eq!(titan.input_hash.len(), 64);
}

/// Values of the table between its nodes, as an independent implementation interpolates them.
#[test]
fn reference_titan_rotor_table_between_its_nodes() {
    use crate::model::rotor::Inflow;
    let titan = load_vehicle(&shipped("titan.json")).unwrap().vehicle;
    let rows = [
        (50.0, 3.67, 1.5708, 78.53854407160377, 3.888419439893991),
        (105.0, 5.6, 0.78, 352.54734313901497, 16.711451537660793),
        (88.3, 4.44, 1.1, 214.53952607540936, 11.801351242147218),
    ];
    for (omega, airspeed_m_s, angle_rad, thrust, torque) in rows {
        let load = titan.rotor.load(omega, Inflow { airspeed_m_s, angle_rad }, 5.4);
        assert!(
            (load.thrust_n - thrust).abs() < 1e-11 && (load.torque_nm - torque).abs() < 1e-11,
            "{load:?}"
        );
    }
}

#[test]
fn reference_x500_loads() {
    let x500 = load_vehicle(&shipped("x500.json")).unwrap().vehicle;
    assert!((x500.static_thrust_n(1.225) - 8.54858).abs() < 1e-14);
    assert!(x500.options.reaction_torque && x500.options.rotor_momentum);
}

#[test]
fn an_unknown_key_is_refused_where_it_stands() {
    let spoilt = spoil("x500.json", "x500.json", "\"mass_kg\"", "\"mas_kg\": 1, \"mass_kg\"");
    assert_json(spoilt, ("\"mas_kg\"", 0), "mas_kg", "unknown field `mas_kg`, expected one of");
    let spoilt = spoil("x500.json", "x500.json", "\"tau_up_s\"", "\"tau_s\": 1, \"tau_up_s\"");
    assert_json(spoilt, ("\"tau_s\"", 0), "motor.first_order.tau_s", "unknown field `tau_s`");
}

#[test]
fn a_repeated_key_is_refused_where_it_comes_again() {
    let spoilt = spoil("x500.json", "x500.json", "\"rotors\"", "\"mass_kg\" : 3, \"rotors\"");
    assert_json(spoilt, ("\"mass_kg\" :", 0), "mass_kg", "duplicate field `mass_kg`");
}

#[test]
fn a_missing_key_is_refused_at_the_object_that_lacks_it() {
    let spoilt = spoil("x500.json", "x500.json", "  \"mass_kg\": 2.064,\n", "");
    assert_json(spoilt, ("{", 0), "", "missing field `mass_kg`");
    let spoilt = spoil("x500.json", "x500.json", "\"tau_up_s\": 0.0125,", "");
    assert_json(spoilt, ("\"first_order\": {", 15), "motor.first_order", "missing field `tau_up_s`");
}

#[test]
fn a_wrong_type_is_refused_with_what_was_expected() {
    let spoilt = spoil("x500.json", "x500.json", "2.064", "\"heavy\"");
    assert_json(spoilt, ("\"heavy\"", 0), "mass_kg", "expected a number greater than 0");
    let spoilt = spoil("x500.json", "x500.json", "2.064", "null");
    assert_json(spoilt, ("null", 0), "mass_kg", "expected a number greater than 0");
    let spoilt = spoil("x500.json", "x500.json", "[0.174, 0.174, 0]", "[0.174, 0.174, 0, 0]");
    assert_json(spoilt, ("[0.174, 0.174, 0, 0]", 0), "rotors[0].position_body_m", "exactly 3");
    let spoilt = spoil("x500.json", "x500.json", "[0.174, 0.174, 0]", "[0.174, 0.174]");
    assert_json(spoilt, ("[0.174, 0.174]", 0), "rotors[0].position_body_m", "exactly 3");
    let spoilt = spoil("x500.json", "x500.json", "\"first_order\"", "\"second_order\"");
    assert_json(spoilt, ("\"motor\": {", 9), "motor", "unknown variant `second_order`, expected `esc_dc` or");
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let spoilt = spoil("x500.json", "x500.json", "2.064", "NaN");
    assert_json(spoilt, ("NaN", 0), "mass_kg", "expected a finite number");
    let spoilt = spoil("x500.json", "x500.json", "2.064", "-Infinity");
    assert_json(spoilt, ("-Infinity", 1), "mass_kg", "expected a finite number");
    let spoilt = spoil("x500.json", "x500.json", "2.064", "1e999");
    assert_json(spoilt, ("1e999", 4), "mass_kg", "number out of range; expected a finite number");
}

#[test]
fn numbers_out_of_range_are_refused() {
    let spoilt = spoil("x500.json", "x500.json", "2.064", "-2.064");
    assert_json(spoilt, ("-2.064", 0), "mass_kg", "`-2.064`, expected a number greater than 0");
    let spoilt = spoil("x500.json", "x500.json", "2.064", "0");
    assert_json(spoilt, ("0,\n  \"inertia", 0), "mass_kg", "expected a number greater than 0");
    let spoilt = spoil("x500.json", "x500.json", "[0, 0, -1]", "[0, 0, -0.5]");
    assert_json(spoilt, ("[0, 0, -0.5]", 0), "rotors[0].axis_body", "found length 0.5");
    let spoilt = spoil("titan.json", "titan.json", "\"current_min_a\": 0.0", "\"current_min_a\": 31.0");
    assert_json(spoilt, ("31.0", 0), "motor.esc_dc.current_min_a", "expected at most current_max_a, 30");
}

#[test]
fn an_inertia_that_no_body_has_is_refused() {
    let spoilt = spoil("titan.json", "titan.json", "1160.0]", "1600.0]");
    assert_json(spoilt, ("[620.0", 0), "inertia_kg_m2", "triangle inequality");
}

#[test]
fn rotors_must_be_one_to_eight() {
    let dir = copy();
    let path = dir.path().join("x500.json");
    let text = std::fs::read_to_string(&path).unwrap();
    let (start, end) = (text.find("\"rotors\": [").unwrap() + 11, text.find("  ],\n  \"effects\"").unwrap());
    let text = format!("{}{}", &text[..start], &text[end..]);
    std::fs::write(&path, &text).unwrap();
    assert_json(
        (text, load_vehicle(&path)),
        ("\"rotors\": [", 10),
        "rotors",
        "expected 1 to 8 rotors, found 0",
    );
}

#[test]
fn coefficient_tables_that_do_not_fit_are_refused() {
    let spoilt = spoil("x500.json", "x500.json", "-150.0,", "-160.0,");
    assert_json(spoilt, ("-160.0, -160.0", 8), "body_aero.alpha_deg[3]", "-160 follows -160");
    let spoilt = spoil("x500.json", "x500.json", "-150.0,", "-15.0.0,");
    assert!(spoilt.1.is_err());
    let spoilt = spoil("x500.json", "x500.json", "-150.0, ", "");
    assert_json(spoilt, ("\"c_drag\": [", 10), "body_aero.c_drag", "expected 36 entries");
    let spoilt = spoil("x500.json", "x500.json", "-180.0,", "-179.0,");
    assert_json(spoilt, ("\"body_aero\": {", 13), "body_aero", "from -180 to 180 deg");
}

#[test]
fn text_after_the_document_is_refused() {
    let spoilt = spoil("x500.json", "x500.json", "aerodynamics: notional\"\n  ]\n}\n", "\"\n  ]\n}\n {}");
    assert_json(spoilt, ("\n {}", 2), "", "text after the end of the document");
}

#[test]
fn a_file_that_is_cut_off_is_refused() {
    let dir = copy();
    let path = dir.path().join("x500.json");
    std::fs::write(&path, "{\n \"name\": \"x\",\n").unwrap();
    let shown = load_vehicle(&path).unwrap_err().to_string();
    assert!(shown.contains("x500.json:2:") || shown.contains("x500.json:3:"), "{shown}");
    assert!(shown.contains("EOF"), "{shown}");
    std::fs::write(&path, "[".repeat(1_000_000)).unwrap();
    assert!(load_vehicle(&path).is_err());
    std::fs::write(&path, [0x7b, 0xff]).unwrap();
    assert!(load_vehicle(&path).unwrap_err().to_string().contains("byte 2 is not UTF-8"));
}

#[test]
fn missing_files_are_named_with_the_place_that_names_them() {
    let shown = load_vehicle(Path::new("no/such.json")).unwrap_err().to_string();
    assert!(shown.contains("vehicle file no/such.json") && shown.contains("current directory"), "{shown}");
    let dir = copy();
    std::fs::remove_file(dir.path().join("titan_rotor.csv")).unwrap();
    let shown = load_vehicle(&dir.path().join("titan.json")).unwrap_err().to_string();
    assert!(shown.contains("titan_rotor.csv") && shown.contains("named in"), "{shown}");
}

#[test]
fn rotor_tables_that_are_no_grid_are_refused() {
    let csv = |from: &str, to: &str| spoil("titan.json", "titan_rotor.csv", from, to).1;
    assert_table(csv("thrust_n,", "thrust,"), (1, 1), "expected the header `omega_rad_s,");
    assert_table(csv("0.0,0.0,-165.0,0.0,0.0", "0.0,0.0,-165.0,0.0"), (3, 1), "expected 5 numbers");
    assert_table(
        csv("0.0,0.0,-165.0,0.0,0.0", "0.0,0.0,-165.0,NaN,0.0"),
        (3, 16),
        "thrust_n: expected a finite",
    );
    assert_table(
        csv("0.0,0.0,-165.0,0.0,0.0", "0.0,0.0,-165.0,0.0,1e999"),
        (3, 20),
        "torque_nm: expected a finite",
    );
    assert_table(csv("0.0,0.0,-165.0,0.0,0.0", "0.0,0.0,-190.0,0.0,0.0"), (3, 1), "angle_deg must increase");
    assert_table(csv("0.0,1.0,-180.0", "0.0,-1.0,-180.0"), (27, 1), "airspeed_m_s");
    assert_table(csv("0.0,1.0,-165.0,0.0,0.0\n", ""), (28, 1), "expected -165, found -150");
    assert_table(
        csv("0.0,1.0,-165.0,0.0,0.0\n", "\n"),
        (28, 1),
        "expected 5 numbers separated by commas, found 1",
    );
}
