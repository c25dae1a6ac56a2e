//! The shipped vehicles, and every way in which a vehicle file is refused, with the exact place.

use std::path::Path;

use nalgebra::Vector3;

use super::spoil::{Spoilt, copy, shipped, spoil};
use super::{ConfigError, Mission, Origin, VehicleFile, derived, load_mission, load_vehicle};
use samara_core::frames::quaternion_from_euler;
use samara_core::model::rigid_body::BodyState;
use samara_core::model::{Interference, RotorLimits, trim};
use samara_core::params::{Purpose, export};
use samara_core::units::RAD_PER_DEG;

fn titan(from: &str, to: &str) -> Spoilt<VehicleFile> {
    spoil(load_vehicle, "params/vehicles/titan.json", "params/vehicles/titan.json", from, to)
}

fn x500(from: &str, to: &str) -> Spoilt<VehicleFile> {
    spoil(load_vehicle, "params/vehicles/x500.json", "params/vehicles/x500.json", from, to)
}

#[track_caller]
fn assert_table(loaded: Result<VehicleFile, ConfigError>, at: (usize, usize), says: &str) {
    match loaded.unwrap_err() {
        ConfigError::Content { file, line, column, message, .. } => {
            assert!(file.ends_with("titan_rotor.csv"));
            assert_eq!((line, column), at, "{message}");
            assert!(message.contains(says), "{message}");
        }
        other => panic!("{other}"),
    }
}

#[test]
fn reference_titan_loads_with_its_static_thrust() {
    let titan = load_vehicle(&shipped("params/vehicles/titan.json")).unwrap();
    assert_eq!(titan.name, "titan");
    assert!((titan.vehicle.static_thrust_n(5.4) - 431.96945384024576).abs() < 1e-10);
    let hover = (790.0f64 * 1.35 / (4.0 * 431.96945384024576)).sqrt();
    assert!((hover - 0.785641).abs() < 1e-6);
}

/// Values of the table between its nodes, as an independent implementation interpolates them.
#[test]
#[expect(clippy::approx_constant, reason = "1.5708 rad is the reference's input")]
fn reference_titan_rotor_table_between_its_nodes() {
    use samara_core::model::rotor::Inflow;
    let titan = load_vehicle(&shipped("params/vehicles/titan.json")).unwrap().vehicle;
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
fn reference_titan_trim_at_4_0_4() {
    let mission = load_mission(&shipped("mission/titan_paper.json")).unwrap();
    let trim = trim(&mission.vehicle, &mission.site.environment, mission.target_v_ned, 0.0).unwrap();
    assert!(
        (trim.pitch_rad / RAD_PER_DEG + 0.2979368855193513).abs() < 1e-9,
        "{}",
        trim.pitch_rad / RAD_PER_DEG
    );
    for (i, thrust_n) in
        [244.24582151172154, 260.9785700676843, 244.24582151172154, 260.9785700676843].iter().enumerate()
    {
        assert!((trim.thrust_n[i] - thrust_n).abs() < 1e-7, "{:?}", trim.thrust_n);
    }
}

/// Planar derivatives of (vn, vd, pitch, pitch rate) under thrusts per front and rear rotor.
#[test]
fn reference_titan_spot_dynamics() {
    let mission = load_mission(&shipped("mission/titan_paper.json")).unwrap();
    let rows = [
        (
            [0.0, 3.675, 0.0, 0.0],
            [100.0, 120.0],
            [-2.5529300265959957e-19, 0.7598038797468355, 0.0, -0.04269662921348315],
        ),
        (
            [4.0, 4.0, -0.0052, 0.0],
            [100.0, 120.0],
            [-0.0037548084546900917, 0.7220773055272409, 0.0, -0.006975031187733052],
        ),
        (
            [1.0, 5.0, -0.4, 0.2],
            [100.0, 120.0],
            [0.23695451924077174, 0.7779612221659727, 0.2, -0.015698980084020205],
        ),
        (
            [6.0, -2.0, 0.7, -0.5],
            [100.0, 120.0],
            [-0.4022329162634548, 0.8902655423529802, -0.5, -0.01204604498596631],
        ),
    ];
    for ([vn, vd, theta, q], [front, rear], expected) in rows {
        let state = BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: quaternion_from_euler(0.0, theta, 0.0),
            v_ned: Vector3::new(vn, 0.0, vd),
            omega_body: Vector3::new(0.0, q, 0.0),
        };
        // PX4's order: front right, rear left, front left, rear right.
        let rate =
            mission.vehicle.thrust_derivative(&mission.site.environment, &state, &[front, rear, front, rear]);
        let found = [rate.v_dot_ned.x, rate.v_dot_ned.z, q, rate.omega_dot_body.y];
        for (f, e) in found.iter().zip(expected) {
            assert!((f - e).abs() < 1e-12, "{found:?} {expected:?}");
        }
    }
}

#[test]
fn reference_x500_loads() {
    let x500 = load_vehicle(&shipped("params/vehicles/x500.json")).unwrap().vehicle;
    // PX4's Gazebo model: 8.54858e-6 N s^2 (1000 rad/s)^2. The coefficients of the table have seven decimals.
    assert!((x500.static_thrust_n(1.225) - 8.54858).abs() < 1e-5 * 8.54858);
    let old = load_vehicle(&shipped("tests/data/v0.1/params/vehicles/x500.json")).unwrap().vehicle;
    assert!((old.static_thrust_n(1.225) - 8.54858).abs() < 1e-14);
    assert!(x500.options.reaction_torque && x500.options.rotor_momentum);
}

#[test]
fn an_unknown_key_is_refused_where_it_stands() {
    let spoilt = x500("\"mass_kg\"", "\"mas_kg\": 1, \"mass_kg\"");
    spoilt.refused_at(("\"mas_kg\"", 0), "mas_kg", "unknown field `mas_kg`, expected one of");
    let spoilt = x500("\"tau_up_s\"", "\"tau_s\": 1, \"tau_up_s\"");
    spoilt.refused_at(("\"tau_s\"", 0), "motor.first_order.tau_s", "unknown field `tau_s`");
}

#[test]
fn a_repeated_key_is_refused_where_it_comes_again() {
    let spoilt = x500("\"rotors\"", "\"mass_kg\" : 3, \"rotors\"");
    spoilt.refused_at(("\"mass_kg\" :", 0), "mass_kg", "duplicate field `mass_kg`");
}

#[test]
fn a_missing_key_refused_at_the_object_that_lacks_it() {
    let spoilt = x500("  \"mass_kg\": 2.064,\n", "");
    spoilt.refused_at(("{", 0), "", "missing field `mass_kg`");
    let spoilt = x500("\"tau_up_s\": 0.0125,", "");
    spoilt.refused_at(("\"first_order\": {", 15), "motor.first_order", "missing field `tau_up_s`");
}

#[test]
fn a_wrong_type_is_refused_with_what_was_expected() {
    let spoilt = x500("2.064", "\"heavy\"");
    spoilt.refused_at(("\"heavy\"", 0), "mass_kg", "expected a number greater than 0");
    let spoilt = x500("2.064", "null");
    spoilt.refused_at(("null", 0), "mass_kg", "expected a number greater than 0");
    let spoilt = x500("[0.174, 0.174, 0]", "[0.174, 0.174, 0, 0]");
    spoilt.refused_at(("[0.174, 0.174, 0, 0]", 0), "rotors[0].position_body_m", "exactly 3");
    let spoilt = x500("[0.174, 0.174, 0]", "[0.174, 0.174]");
    spoilt.refused_at(("[0.174, 0.174]", 0), "rotors[0].position_body_m", "exactly 3");
    let spoilt = x500("\"first_order\"", "\"second_order\"");
    spoilt.refused_at(("\"motor\": {", 9), "motor", "unknown variant `second_order`, expected `esc_dc` or");
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let spoilt = x500("2.064", "NaN");
    spoilt.refused_at(("NaN", 0), "mass_kg", "expected a finite number");
    let spoilt = x500("2.064", "-Infinity");
    spoilt.refused_at(("-Infinity", 1), "mass_kg", "expected a finite number");
    let spoilt = x500("2.064", "1e999");
    spoilt.refused_at(("1e999", 4), "mass_kg", "number out of range; expected a finite number");
}

#[test]
fn numbers_out_of_range_are_refused() {
    let spoilt = x500("2.064", "-2.064");
    spoilt.refused_at(("-2.064", 0), "mass_kg", "`-2.064`, expected a number greater than 0");
    let spoilt = x500("2.064", "0");
    spoilt.refused_at(("0,\n  \"inertia", 0), "mass_kg", "expected a number greater than 0");
    let spoilt = x500("[0, 0, -1]", "[0, 0, -0.5]");
    spoilt.refused_at(("[0, 0, -0.5]", 0), "rotors[0].axis_body", "found length 0.5");
    let spoilt = titan("\"current_min_a\": 0.0", "\"current_min_a\": 31.0");
    spoilt.refused_at(("31.0", 0), "motor.esc_dc.current_min_a", "expected at most current_max_a, 30");
}

#[test]
fn an_inertia_that_no_body_has_is_refused() {
    let spoilt = titan("1160.0]", "1600.0]");
    spoilt.refused_at(("[620.0", 0), "inertia_kg_m2", "triangle inequality");
}

#[test]
fn rotors_must_be_one_to_eight() {
    let rotor =
        "{ \"position_body_m\": [0.174, 0.174, 0], \"axis_body\": [0, 0, -1], \"spin_from_above\": \"ccw\" }";
    let spoilt = x500(rotor, &[rotor; 6].join(","));
    spoilt.refused_at(("\"rotors\": [", 10), "rotors", "expected 1 to 8 rotors, found 9");
}

#[test]
fn coefficient_tables_that_do_not_fit_are_refused() {
    let spoilt = x500("-150.0,", "-160.0,");
    spoilt.refused_at(("-160.0, -160.0", 8), "body_aero.alpha_deg[3]", "-160 follows -160");
    let spoilt = x500("-150.0,", "-15.0.0,");
    assert!(spoilt.loaded.is_err());
    let spoilt = x500("-150.0, ", "");
    spoilt.refused_at(("\"c_drag\": [", 10), "body_aero.c_drag", "expected 36 entries");
    let spoilt = x500("-180.0,", "-179.0,");
    spoilt.refused_at(("\"body_aero\": {", 13), "body_aero", "from -180 to 180 deg");
}

#[test]
fn a_coefficient_table_that_would_fill_the_memory_is_refused() {
    let many: Vec<String> = (0..722).map(|i| format!("{}", -180.0 + f64::from(i) * 0.01)).collect();
    let spoilt = x500("-180.0,", &format!("{},", many.join(", ")));
    spoilt.refused_at(("\"alpha_deg\": [", 13), "body_aero.alpha_deg", "at most 721 angles");
}

#[test]
fn text_after_the_document_is_refused() {
    let spoilt = x500("notional\" }\n  ]\n}\n", "\" }\n  ]\n}\n {}");
    spoilt.refused_at(("\n {}", 2), "", "text after the end of the document");
}

#[test]
fn a_file_that_is_cut_off_is_refused() {
    let dir = copy();
    let path = dir.path().join("params/vehicles/x500.json");
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
    std::fs::remove_file(dir.path().join("params/vehicles/titan_rotor.csv")).unwrap();
    let shown = load_vehicle(&dir.path().join("params/vehicles/titan.json")).unwrap_err().to_string();
    assert!(shown.contains("titan_rotor.csv") && shown.contains("named in"), "{shown}");
}

#[test]
fn rotor_tables_that_are_no_grid_are_refused() {
    let csv = |from: &str, to: &str| {
        spoil(load_vehicle, "params/vehicles/titan.json", "params/vehicles/titan_rotor.csv", from, to).loaded
    };
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

/// R J/(K_t (K_e + K_esc)) of Titan is 6.9 ms; with a rotor of 0.001 kg m^2 it is 0.077 ms.
#[test]
fn rotors_that_are_too_fast_to_integrate_are_refused() {
    titan("\"rotor_inertia_kg_m2\": 0.09", "\"rotor_inertia_kg_m2\": 0.001").refused_at(
        ("0.001", 0),
        "motor.esc_dc.rotor_inertia_kg_m2",
        "R J/(K_t (K_e + K_esc)) = 7.66e-5 s",
    );
    assert!(titan("\"rotor_inertia_kg_m2\": 0.09", "\"rotor_inertia_kg_m2\": 0.02").loaded.is_ok());
    x500("\"tau_up_s\": 0.0125", "\"tau_up_s\": 0.0004").refused_at(
        ("0.0004", 0),
        "motor.first_order.tau_up_s",
        "expected a time from 0.0005 to 100 s",
    );
}

/// The pairs are found by their places; what is no pair is refused.
#[test]
fn coaxial_pairs_are_found_and_their_lower_rotors_weakened() {
    let dragonfly = load_vehicle(&shipped("params/vehicles/dragonfly_notional.json")).unwrap().vehicle;
    let factors: Vec<f64> = dragonfly.rotors.iter().map(|r| r.interference.thrust).collect();
    assert_eq!(factors, [1.0, 1.0, 1.0, 1.0, 0.5534, 0.5534, 0.5534, 0.5534]);
    // The reaction torque of a lower rotor per newton: the factors' ratio.
    let [upper, lower] = [0, 4].map(|i| dragonfly.torque_per_thrust_of_m(i, 5.1));
    assert!((lower / upper - 0.7601 / 0.5534).abs() < 1e-12);
    // The lower rotors' speed under load is a little below that without.
    let share = RotorLimits::of(&dragonfly, 5.4).thrust_n / (0.5534 * dragonfly.static_thrust_n(5.4));
    assert!((0.95..1.0).contains(&share), "{share}");
    let flat = x500(
        "\"effects\"",
        "\"coaxial\": { \"lower_thrust_factor\": 0.8, \"lower_torque_factor\": 0.9 }, \"effects\"",
    );
    let message = flat.loaded.unwrap_err().to_string();
    assert!(message.contains("coaxial: expected a rotor on another one's axis, below it"), "{message}");
}

/// By hand: a rotor of the dragonfly makes 332 N at its greatest speed in Titan's air of 5.11 kg/m3, of which
/// an upper one holds 324, and a lower one 180.6; all together 2020 over a weight of 1184 N. At one throttle
/// for all, a share of the greatest speed, the thrusts go with its square: W = d^2 (4 + 4 f) T.
#[test]
fn closed_form_coaxial_rotors_lift_together() {
    let mission = Mission::shipped("dragonfly_drop").unwrap();
    let derived = derived(&mission);
    let value = |key: &str| {
        let rows = derived.groups.iter().flat_map(|group| &group.rows);
        rows.clone().find(|row| row.key == key).unwrap().values.clone()
    };
    let near = |key: &str, by_hand: &[f64], share: f64| {
        let found = value(key);
        let same = found.len() == by_hand.len()
            && found.iter().zip(by_hand).all(|(a, b)| (a / b - 1.0).abs() < share);
        assert!(same, "{key}: {found:?}, by hand {by_hand:?}");
    };
    let weight_n = value("weight_n")[0];
    near("weight_n", &[1184.0], 2e-3);
    near("thrust_max_n", &[180.6], 2e-3);
    near("thrust_to_weight", &[(4.0 * 324.4 + 4.0 * 180.6) / 1184.0], 5e-3);
    let alone_n = mission.vehicle.static_thrust_n(mission.site.environment.density_kg_m3);
    let throttle = (weight_n / (4.0 * (1.0 + 0.5534) * alone_n)).sqrt();
    near("hover_throttle", &[throttle], 1e-12);
    near("hover_throttle", &[(1184.0f64 / (4.0 * 1.5534 * 332.5)).sqrt()], 1e-2);
    let upper_n = weight_n / (4.0 * (1.0 + 0.5534));
    near("hover_thrust_n", &[upper_n, 0.5534 * upper_n], 1e-12);
    assert!(derived.odd.is_empty(), "{:?}", derived.odd);
}

/// PX4's thrust in hover is a share of the greatest thrust, the throttle in hover of the greatest speed:
/// without coaxial pairs one is the other's square.
#[test]
fn closed_form_hover_throttle_is_the_root_of_px4s() {
    for name in ["x500_drop", "titan_drop", "hexa_drop", "octo_drop"] {
        let mission = Mission::shipped(name).unwrap();
        let site = &mission.site.environment;
        let throttle = mission.vehicle.hover_throttle(site.gravity_m_s2, site.density_kg_m3);
        let exported = export(&mission.parameter_subject(), Purpose::Samara).unwrap();
        let px4s = exported.parameters["MPC_THR_HOVER"].as_f64();
        assert!((throttle * throttle / px4s - 1.0).abs() < 1e-6, "{name}: {throttle} {px4s}");
    }
}

/// A coaxial vehicle without its factors is said to be one; with them, and rotors side by side, nothing is.
#[test]
fn regress_rotors_above_one_another_want_factors() {
    let of = |name: &str| Mission::shipped(name).unwrap();
    let said = |mission: &Mission| {
        mission
            .contradictions()
            .into_iter()
            .filter(|odd| odd.text.contains("in the wake of"))
            .collect::<Vec<_>>()
    };
    let mut dragonfly = of("dragonfly_drop");
    assert!(said(&dragonfly).is_empty() && said(&of("x500_drop")).is_empty());
    let mut bare = (*dragonfly.vehicle).clone();
    bare.rotors.iter_mut().for_each(|rotor| rotor.interference = Interference::NONE);
    dragonfly.vehicle = bare.into();
    let odd = said(&dragonfly);
    assert!(
        odd.len() == 1 && odd[0].text.starts_with("vehicle: rotor 5 stands in the wake of rotor 2"),
        "{odd:?}"
    );
}

/// The x500 with other words on where its numbers are from.
fn x500_from(words: &str) -> Spoilt<VehicleFile> {
    let text = std::fs::read_to_string(shipped("params/vehicles/x500.json")).unwrap();
    let at = text.find(",\n  \"origins\": [").unwrap();
    x500(&text[at..], &format!("{words}\n}}\n"))
}

/// Where numbers are from is of keys of the file, each once; what is estimated or guessed counts as
/// estimated.
#[test]
fn origins_are_of_keys_of_the_file() {
    let with = |inside: &str| x500_from(&format!(", \"origins\": [{inside}], \"estimated\": [\"motor\"]"));
    let mass = "{ \"keys\": [\"mass_kg\"], \"kind\": \"measured\", \"file\": \"scales.csv\" }";
    let inertia = "{ \"keys\": [\"inertia_kg_m2\"], \"kind\": \"estimated\", \"formula\": \"a sphere\" }";
    let found = with(&format!("{mass}, {inertia}")).loaded.unwrap();
    let words: Vec<String> = found.origins.iter().map(Origin::words).collect();
    assert_eq!(words, ["measured (scales.csv)", "estimated: a sphere"]);
    let estimated = found.estimated.unwrap();
    assert_eq!(estimated, ["inertia_kg_m2", "motor"]);
    let twice = with(&format!("{mass}, {mass}"));
    let Err(ConfigError::Content { json_path, message, .. }) = twice.loaded else { panic!("accepted") };
    assert_eq!(
        (json_path.as_str(), message.contains("each key once")),
        ("origins[1].keys[0]", true),
        "{message}"
    );
    let none = with(&mass.replace("mass_kg", "weight_kg"));
    let Err(ConfigError::Content { json_path, .. }) = none.loaded else { panic!("accepted") };
    assert_eq!(json_path, "origins[0].keys[0]");
}

/// What a file calls estimated are keys of it; a file that says nothing is another than one that says nothing
/// is.
#[test]
fn what_is_estimated_are_keys_of_the_file() {
    let estimated = |key: &str| x500_from(&format!(", \"estimated\": [\"rotor\", \"body_aero\", {key}]"));
    let known = estimated("\"mass_kg\"").loaded.unwrap().estimated.unwrap();
    assert_eq!(known, ["rotor", "body_aero", "mass_kg"]);
    estimated("\"motor.second_order\"").refused_at(
        ("\"motor.second_order\"", 0),
        "estimated[2]",
        "expected a key of this file, such as `limits.speed_m_s`, found `motor.second_order`, which is none",
    );
    let silent = x500_from("");
    assert_eq!(silent.loaded.unwrap().estimated, None);
    let none = super::spoil::titan("\"estimated\": []", "\"estimated\": [\"plan.nodes\"]").loaded.unwrap();
    assert_eq!(none.estimated.mission.unwrap(), ["plan.nodes"]);
    for file in super::spoil::shipped_files().into_iter().filter(|file| file.starts_with("mission/")) {
        let mission = load_mission(&shipped(&file)).unwrap();
        assert!(mission.estimated.vehicle.is_some() && mission.estimated.mission.is_some(), "{file}");
    }
}

/// Drag alone, tables, or nothing: each on its own, and what a table has to be is told.
#[test]
fn body_aerodynamics_are_a_drag_area_or_tables() {
    let area = "\"reference_area_m2\": 0.1,";
    x500(area, &format!("\"drag_area_m2\": 0.2, {area}")).refused_at(
        ("\"drag_area_m2\": 0.2", 16),
        "body_aero.drag_area_m2",
        "alone, or none of it: `reference_area_m2` stands beside it",
    );
    x500(area, "").refused_at(("\"body_aero\": {", 13), "body_aero", "missing field `reference_area_m2`");
    titan("\"c_lift\": [", "\"c_lift\": [1], \"c_lyft\": [").loaded.unwrap_err();
    let dir = copy();
    let path = dir.path().join("params/vehicles/x500.json");
    let text = std::fs::read_to_string(&path).unwrap();
    let text = text.split_once(",\n  \"origins\": [").unwrap().0.to_owned() + "\n}\n";
    let (before, rest) = text.split_once("  \"body_aero\": {").unwrap();
    let (_, after) = rest.split_once("\n  },\n").unwrap();
    let with = |aero: &str| {
        std::fs::write(&path, format!("{before}{aero}{after}")).unwrap();
        load_vehicle(&path)
    };
    let none = with("").unwrap().vehicle.aero;
    assert!(none.coefficients().iter().all(|c| c.pieces().iter().all(|[value, ..]| *value == 0.0)));
    let drag = with("\"body_aero\": { \"drag_area_m2\": 0.07 },").unwrap().vehicle.aero;
    let [c_drag, c_lift, _] = drag.coefficients();
    assert_eq!(drag.area_m2(), 0.07);
    assert!(c_drag.pieces().iter().all(|piece| piece[..] == [1.0, 0.0, 0.0, 0.0]), "{:?}", c_drag.pieces());
    assert!(c_lift.pieces().iter().all(|[value, ..]| *value == 0.0));
    assert_eq!(drag.side_area_m2(), None);
    let both = with("\"body_aero\": { \"drag_area_m2\": 0.07, \"side_drag_area_m2\": 0.05 },").unwrap();
    assert_eq!(both.vehicle.aero.side_area_m2(), Some(0.05));
    let three = "{ \"reference_area_m2\": 0.1, \"reference_span_m\": 1, \"alpha_deg\": [0, 90, 180], \"c_drag\": [1, 1, 1], \
                 \"c_lift\": [0, 0, 0], \"c_pitch\": [0, 0, 0] }";
    let shown = with(&format!("\"body_aero\": {three},")).unwrap_err().to_string();
    assert!(
        shown.contains("body_aero.alpha_deg: expected at least 4 angles from -180 to 180 deg; five"),
        "{shown}"
    );
}
