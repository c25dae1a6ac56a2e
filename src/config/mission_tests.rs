//! The shipped missions and gains, and every way in which they are refused, with the exact place.

use crate::plan::InputReference;
use std::path::Path;

use nalgebra::Vector3;

use super::spoil::{Spoilt, copy, shipped, shipped_files, spoil};
use super::*;
use crate::control::{ControlLimits, Gains};
use crate::model::parachute::Hook;
use crate::sim::{ReleaseTrigger, SensorSettings, Start};
use crate::units::RAD_PER_DEG;

const TITAN: &str = "mission/titan_drop.json";

fn titan(from: &str, to: &str) -> Spoilt<Mission> {
    spoil(load_mission, TITAN, TITAN, from, to)
}

fn ours(from: &str, to: &str) -> Spoilt<Mission> {
    spoil(load_mission, TITAN, "params/gains/ours.json", from, to)
}

/// Every shipped file goes through its loader; a directory that gains a file of another kind fails here.
#[test]
fn every_shipped_file_loads() {
    for file in shipped_files() {
        let path = shipped(&file);
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let name = match file.split('/').nth(file.split('/').count() - 2).unwrap() {
            "mission" => load_mission(&path).unwrap().name,
            "gains" => load_gains(&path).unwrap().name,
            _ if file.ends_with(".csv") => continue,
            _ => load_vehicle(&path).unwrap().name,
        };
        assert_eq!(name, stem, "a file is named after what it holds");
    }
}

#[test]
fn paper_titan_mission_holds_tables_1_and_2_and_31() {
    let m = load_mission(&shipped(TITAN)).unwrap();
    assert_eq!((m.limits.speed_m_s, m.limits.vertical_acceleration_m_s2), (12.0, 3.0));
    assert_eq!((m.limits.pitch_rad, m.limits.pitch_rate_rad_s), (45.0 * RAD_PER_DEG, 90.0 * RAD_PER_DEG));
    assert_eq!((m.thrust_max_n, m.thrust_slew_n_s, m.horizon_s, m.nodes), (300.0, 60.0, 30.0, 38));
    assert_eq!(m.x_ss, Some([1.0, 0.0, -0.0026, 0.0, 4.0, 0.0, 4.0, 0.0, 0.0, 0.0]));
    assert_eq!(m.cost_state, [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 10.0, 10.0, 10.0]);
    assert_eq!((m.cost_input, m.cost_input_reference), (1e-5, InputReference::Zero));
    assert_eq!(m.target_v_ned, Vector3::new(4.0, 0.0, 4.0));
    assert_eq!(m.parachute.v0_m_s(m.environment.gravity_m_s2), 3.675);
    assert_eq!((m.start, m.hang_s, m.duration_s), (Start::Release, 10.0, 45.0));
    assert_eq!(m.release_trigger, ReleaseTrigger::Command);
    assert_eq!(m.control_limits, ControlLimits::default());
    assert_eq!((m.monte_carlo.trials, m.monte_carlo.length_m), (100, 0.34));
}

#[test]
fn paper_titan_tuning_cases_are_table_3() {
    let m = load_mission(&shipped(TITAN)).unwrap();
    let table_3 = [
        (0.0, 3.67, 0.0, 0.0),
        (0.32, 3.67, 0.0, 18.8),
        (0.26, 3.64, 5.5, 15.2),
        (0.10, 3.65, 8.9, 5.8),
        (-0.10, 3.69, 8.9, -5.8),
        (-0.26, 3.70, 5.5, -15.2),
        (-0.32, 3.67, 0.0, -18.8),
    ];
    assert_eq!(m.tuning_cases.len(), table_3.len());
    for (i, (case, (vn, vd, pitch, rate))) in m.tuning_cases.iter().zip(table_3).enumerate() {
        assert_eq!(case.name, format!("case_{i}"));
        assert_eq!(case.v_ned, Vector3::new(vn, 0.0, vd));
        assert_eq!((case.pitch_rad, case.pitch_rate_rad_s), (pitch * RAD_PER_DEG, rate * RAD_PER_DEG));
    }
}

#[test]
fn paper_gains_are_table_4() {
    let load = |name: &str| load_gains(&shipped(&format!("params/gains/{name}.json"))).unwrap().gains;
    assert_eq!(load("near_hover"), Gains::near_hover());
    assert_eq!(load("paper_pso"), Gains::paper_pso());
}

#[test]
fn reference_x500_mission() {
    let m = load_mission(&shipped("mission/x500_drop.json")).unwrap();
    assert!((m.parachute.v0_m_s(m.environment.gravity_m_s2) - 9.903325).abs() < 1e-14);
    assert!((m.cost_input - 1e-5 * (300.0f64 / 8.54858).powi(2)).abs() < 1e-16);
    assert_eq!((m.x_ss, m.target_v_ned), (None, Vector3::new(2.0, 0.0, 1.0)));
    assert_eq!(m.vehicle_name, "x500");
    // Hangs still for 8 of 15 s; at the release the descent is complete: 1 - tanh(7 g/5) = 2e-12.
    assert_eq!(m.parachute.hook, Some(Hook { lets_go_before_s: 7.0 }));
    let (released, _) = m.parachute.hanging(0.0, &m.environment);
    assert!((released.v_ned.z - 5.0).abs() < 1e-10 && released.v_ned.z < 5.0);
    let (held, a_ned) = m.parachute.hanging(-7.5, &m.environment);
    assert_eq!((held.v_ned, a_ned), (Vector3::zeros(), Vector3::zeros()));
    // Three standard deviations of the receiver's velocity.
    assert!((m.steady_within_m_s / m.sensors.satellite.speed_noise_m_s - 3.0).abs() < 1e-9);
    let case_1 = &m.tuning_cases[1];
    let swing = 9.4 * RAD_PER_DEG * 3.1316;
    assert!((case_1.v_ned.x - swing).abs() < 5e-3 && (case_1.pitch_rate_rad_s - swing).abs() < 1e-3);
}

#[test]
fn gains_are_found_by_name_and_by_path_and_change_the_hash() {
    let mut m = load_mission(&shipped(TITAN)).unwrap();
    let (ours, hash) = (m.gains, m.input_hash.clone());
    m.use_gains("paper_pso").unwrap();
    assert_eq!((m.gains, m.gains_name.as_str()), (Gains::paper_pso(), "paper_pso"));
    assert_ne!(m.input_hash, hash);
    m.use_gains(shipped("params/gains/ours.json").to_str().unwrap()).unwrap();
    assert_eq!((m.gains, &m.input_hash), (ours, &hash));
    let shown = m.use_gains("no_such").unwrap_err().to_string();
    assert!(shown.contains("gains file") && shown.contains("no_such.json"), "{shown}");
    assert_eq!(m.gains, ours);
}

#[test]
fn the_hash_follows_every_file() {
    let hash = |m: Result<Mission, ConfigError>| m.unwrap().input_hash;
    let shipped_hash = hash(load_mission(&shipped(TITAN)));
    assert_eq!(
        hash(titan("\"about\"", "\"about\"").loaded),
        shipped_hash,
        "a copy elsewhere has the same hash"
    );
    let spoilt = [
        titan("\"seed\": 1,", "\"seed\": 2,").loaded,
        ours("\"k_pr_per_s\": 1.0", "\"k_pr_per_s\": 1.5").loaded,
        spoil(load_mission, TITAN, "params/vehicles/titan.json", "790.0", "791.0").loaded,
        spoil(load_mission, TITAN, "params/vehicles/titan_rotor.csv", "180.0,0.0,0.0", "180.0,0.0,0.5")
            .loaded,
    ];
    let mut hashes: Vec<String> = spoilt.into_iter().map(hash).chain([shipped_hash]).collect();
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), 5);
}

#[test]
fn the_hash_follows_what_is_chosen_beside_the_files() {
    let mut m = load_mission(&shipped(TITAN)).unwrap();
    let mut hashes = vec![m.input_hash.clone()];
    m.use_seed(1);
    assert_eq!((&m.input_hash, m.choices.len()), (&hashes[0], 0), "the mission's own seed is no choice");
    m.use_seed(2);
    hashes.push(m.input_hash.clone());
    m.note_choice("nodes", "51");
    hashes.push(m.input_hash.clone());
    m.use_gains("paper_pso").unwrap();
    hashes.push(m.input_hash.clone());
    m.use_gains("ours").unwrap();
    assert_eq!(m.input_hash, hashes[2], "gains put in later keep the choices");
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), 4);
}

#[test]
fn the_plan_starts_from_the_paper_s_state_or_from_the_release_adrift_with_the_wind() {
    let m = load_mission(&shipped(TITAN)).unwrap();
    assert_eq!(m.plan_initial, PlanInitial::Paper);
    assert_eq!(m.plan_initial_state(), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.675, 0.0, 0.0, 0.0]);
    let windy = |from: &str| titan(from, "\"wind_ned_m_s\": [6, -2, 0]").loaded.unwrap();
    let state = windy("\"wind_ned_m_s\": [0, 0, 0]").plan_initial_state();
    assert_eq!(state, [1.0, 0.0, 0.0, 0.0, 6.0, -2.0, 3.675, 0.0, 0.0, 0.0]);
    // An independent implementation: 3.661 m/s on Titan after the fall through the air.
    let release = titan("\"initial\": \"paper\"", "\"initial\": \"release\"").loaded.unwrap();
    assert!((release.plan_initial_state()[6] - 3.661).abs() < 5e-4, "{:?}", release.plan_initial_state());
    let x500 = load_mission(&shipped("mission/x500_drop.json")).unwrap();
    assert_eq!(x500.plan_initial, PlanInitial::Release);
    let down = x500.plan_initial_state()[6];
    // Closed form, quadratic drag of the flat body: v_t tanh(artanh(5/v_t) + g t_d/v_t) with v_t = 18.2 m/s, instead of 9.9.
    assert!((down - 9.126639126).abs() < 1e-9, "{down}");
    let left_out = titan("\"initial\": \"paper\",", "").loaded.unwrap();
    assert_eq!(left_out.plan_initial, PlanInitial::Paper);
}

/// Without the object the sensors are ideal; each of them stands for itself; what it says is bounded and strict.
#[test]
fn sensors_are_read_and_refused() {
    let with = |mission: &str, sensors: &str| {
        spoil(
            load_mission,
            mission,
            mission,
            "\"seed\": 1,",
            &format!("\"seed\": 1, \"sensors\": {sensors},"),
        )
    };
    let x500 = |sensors: &str| with("mission/x500_ground.json", sensors);
    let ideal = SensorSettings::default();
    assert_eq!(load_mission(&shipped(TITAN)).unwrap().sensors, ideal);
    assert_eq!(x500("{}").loaded.unwrap().sensors, ideal);
    let gps = |rate: &str, delay: &str| {
        x500(&format!(
            "{{ \"gps\": {{ \"rate_hz\": {rate}, \"horizontal_noise_m\": 0.5, \"vertical_noise_m\": 0.8, \"velocity_noise_m_s\": 0.1, \"delay_s\": {delay} }} }}"
        ))
    };
    let sensors = gps("8", "0.11").loaded.unwrap().sensors;
    assert_eq!((sensors.satellite.period_us, sensors.satellite.delay_us), (125_000, 110_000));
    assert_eq!(SensorSettings { satellite: ideal.satellite, ..sensors }, ideal);
    gps("4", "0").refused_at(("4, \"hor", 0), "sensors.gps.rate_hz", "a whole number from 5 to 20");
    gps("5", "1.5").refused_at(("1.5 }", 0), "sensors.gps.delay_s", "a number from 0 to 1");
    x500("{ \"gyro\": {} }").refused_at(("\"gyro\"", 0), "sensors.gyro", "expected one of");
    let magnetometer = "{ \"magnetometer\": { \"field\": \"world_magnetic_model\", \"noise_gauss\": 0 } }";
    // PX4's default home on 2026-01-01, by the same model: about 3.4 deg of declination, 0.48 gauss.
    let field = x500(magnetometer).loaded.unwrap().sensors.magnetometer.field_ned_gauss.unwrap();
    assert!((field.norm() - 0.48).abs() < 0.01 && (field.y.atan2(field.x) - 0.06).abs() < 0.01, "{field:?}");
    with(TITAN, magnetometer).refused_at(
        ("\"world_magnetic_model\"", 0),
        "sensors.magnetometer.field",
        "Earth's",
    );
}

/// What would make arithmetic overflow, or memory or time explode, is refused where it stands.
#[test]
fn absurd_numbers_are_refused() {
    let cases = [
        ("\"duration_s\": 45", "\"duration_s\": ", "1e12", "duration_s", "at most 900 s"),
        ("\"horizon_s\": 30.0", "\"horizon_s\": ", "901", "plan.horizon_s", "at most 900 s"),
        ("\"density_kg_m3\": 5.4", "\"density_kg_m3\": ", "1e300", "site.density_kg_m3", "at most 1000"),
        ("\"gravity_m_s2\": 1.35", "\"gravity_m_s2\": ", "1e9", "site.gravity_m_s2", "at most 100"),
        ("\"thrust_max_n\": 300.0", "\"thrust_max_n\": ", "1e300", "plan.thrust_max_n", "at most 1000000"),
        ("\"descent_m_s\": 3.0", "\"descent_m_s\": ", "300", "parachute.descent_m_s", "from 0 to 200"),
        ("\"delay_s\": 0.5", "\"delay_s\": ", "1e5", "parachute.delay_s", "a time from 0 to 900 s"),
        ("\"nodes\": 38", "\"nodes\": ", "10001", "plan.nodes", "from 3 to 10000"),
    ];
    for (from, key, value, path, says) in cases {
        titan(from, &format!("{key}{value}")).refused_at((&format!("{key}{value}"), key.len()), path, says);
    }
    titan("[4, 0, 4],\n  \"site", "[1e160, 0, 4],\n  \"site").refused_at(
        ("1e160", 0),
        "target_v_ned_m_s[0]",
        "expected a number from -1000 to 1000",
    );
    let vehicle = |from: &str, to: &str| spoil(load_mission, TITAN, "params/vehicles/titan.json", from, to);
    vehicle("790.0", "1e300").refused_at(("1e300", 0), "mass_kg", "greater than 0 and at most 100000");
    ours("\"k_pr_per_s\": 1.0", "\"k_pr_per_s\": 1e300").refused_at(
        ("1e300", 0),
        "k_pr_per_s",
        "from 0 to 1000000",
    );
}

#[test]
fn written_gains_read_back_to_the_last_bit() {
    let dir = copy();
    let path = dir.path().join("mine.json");
    let gains =
        Gains::longitudinal([1.0 / 3.0, 1e-20, 0.1 + 0.2, 5.0, 0.0, 1e6 - 1e-10, 2.2250738585072014e-308]);
    std::fs::write(&path, gains_json("mine", "a \"quoted\" \n about", &gains)).unwrap();
    assert_eq!(load_gains(&path).unwrap(), GainsFile { name: "mine".into(), gains });
}

/// The hook is a part of the time to the release.
#[test]
fn a_hook_that_outlasts_the_hang_is_refused() {
    titan("\"hang_s\": 10,", "\"hang_s\": 10, \"hook_s\": 10,").refused_at(
        ("\"hook_s\"", 10),
        "release.hook_s",
        "expected less than 10 s, the time to the release (release.hang_s), of which it is a part, found 10 s",
    );
}

#[test]
fn unknown_missing_and_repeated_keys_are_refused() {
    titan("\"hang_s\"", "\"hang\"").refused_at(
        ("\"hang\"", 0),
        "release.hang",
        "expected one of `start`, `hang_s`",
    );
    titan("\"hang_s\": 10,", "").refused_at(("\"release\": {", 11), "release", "missing field `hang_s`");
    titan("\"hang_s\"", "\"hang_s\": 1, \"hang_s\"").refused_at(
        ("\"hang_s\": 10", 0),
        "release.hang_s",
        "duplicate field",
    );
    ours("\"k_pr_per_s\"", "\"k_pr\"").refused_at(("\"k_pr\"", 0), "k_pr", "unknown field `k_pr`");
}

#[test]
fn numbers_out_of_range_are_refused() {
    let nodes = "a whole number from 3 to 10000";
    titan("\"nodes\": 38", "\"nodes\": 2").refused_at(("\"nodes\": 2", 9), "plan.nodes", nodes);
    titan("\"nodes\": 38", "\"nodes\": 38.5").refused_at(("38.5", 0), "plan.nodes", nodes);
    titan("\"nodes\": 38", "\"nodes\": -38").refused_at(("-38", 0), "plan.nodes", nodes);
    titan("\"latitude_deg\": 7.0", "\"latitude_deg\": 90").refused_at(
        ("90,\n    \"lon", 0),
        "site.latitude_deg",
        "a latitude between -90 and 90 deg",
    );
    titan("37.5", "90").refused_at(("90,\n    \"rate", 0), "control.tilt_limit_deg", "between 0 and 90 deg");
    titan("[0, 0, 0],\n    \"lat", "[0, 0, 1e400],\n    \"lat").refused_at(
        ("1e400", 4),
        "site.wind_ned_m_s[2]",
        "number out of range; expected a finite number",
    );
    titan("\"seed\": 1", "\"seed\": -1").refused_at(("-1,\n", 0), "seed", "expected u64");
    titan("\"name\": \"titan_drop\"", "\"name\": \"../x\"").refused_at(
        ("\"../x\"", 0),
        "name",
        "letters, digits",
    );
    titan("\"pitch_rate_deg_s\": 18.8", "\"pitch_rate_deg_s\": \"18.8\"").refused_at(
        ("\"18.8\"", 0),
        "tuning.cases[1].pitch_rate_deg_s",
        "expected a number from -100000 to 100000",
    );
}

#[test]
fn numbers_that_do_not_fit_each_other_are_refused() {
    titan("\"duration_s\": 45", "\"duration_s\": 10.5").refused_at(
        ("10.5", 0),
        "duration_s",
        "expected more than 10.5 s",
    );
    titan("[1, 0, -0.0026, 0]", "[1, 0, -0.26, 0]").refused_at(
        ("[1, 0, -0.26, 0]", 0),
        "plan.x_ss.q_ned_from_body",
        "length 1",
    );
    let trigger = |altitude: &str| {
        titan(
            "\"trigger\": \"command\"",
            &format!("\"trigger\": {{ \"altitude\": {{ \"altitude_m\": {altitude} }} }}"),
        )
    };
    let path = "release.trigger.altitude.altitude_m";
    trigger("1030").refused_at(("1030", 0), path, "expected less than 1030 m");
    assert_eq!(trigger("990.5").loaded.unwrap().release_trigger, ReleaseTrigger::Altitude(990.5));
    titan("\"command\"", "\"comand\"").refused_at(
        ("\"comand\"", 0),
        "release.trigger",
        "expected one of `command`, `time`, `altitude`, `armed_offboard`",
    );
}

/// The ground lies below the release and a battery has a charge; without either key there is none.
#[test]
fn ground_and_battery_are_read_and_refused() {
    let m = load_mission(&shipped(TITAN)).unwrap();
    assert_eq!((m.ground, m.battery, m.starts_on_ground()), (None, None, false));
    let ground = |altitude: &str| {
        let to = format!("\"altitude_m\": 1000, \"ground_altitude_m\": {altitude}");
        titan("\"altitude_m\": 1000", &to)
    };
    let m = ground("700").loaded.unwrap();
    assert_eq!(
        m.ground.map(|g| (g.ground.down_m, g.standing, g.impact_limit_m_s)),
        Some((300.0, false, 2.1))
    );
    assert!(!m.simulation().on_ground());
    ground("1000").refused_at(
        ("1000, \"ground_altitude_m\": 1000", 27),
        "site.ground_altitude_m",
        "expected less than 1000 m",
    );
    titan("\"start\": \"release\"", "\"start\": \"ground\"").refused_at(
        ("\"ground\"", 0),
        "release.start",
        "site.ground_altitude_m",
    );
    let battery = |charge: &str| {
        let to = format!("\"seed\": 1, \"battery\": {{ \"capacity_wh\": 2, \"charge_percent\": {charge} }},");
        titan("\"seed\": 1,", &to)
    };
    let full = battery("50").loaded.unwrap().battery.unwrap();
    assert_eq!((full.charge(), full.consumed_j()), (0.5, 3600.0));
    assert!(battery("0").loaded.is_err() && battery("101").loaded.is_err());
    let standing = load_mission(&shipped("mission/x500_ground.json")).unwrap();
    assert!(standing.starts_on_ground() && standing.simulation().on_ground());
}

#[test]
fn a_fault_in_a_named_file_is_reported_there() {
    let in_vehicle =
        |from: &str, to: &str| spoil(load_mission, TITAN, "params/vehicles/titan.json", from, to);
    in_vehicle("790.0", "-790.0").refused_at(("-790.0", 0), "mass_kg", "greater than 0");
    let shown = titan("vehicles/titan.json", "vehicles/none.json").loaded.unwrap_err().to_string();
    assert!(
        shown.contains("none.json") && shown.contains("named in") && shown.contains("titan_drop.json"),
        "{shown}"
    );
    let shown = load_mission(Path::new("none.json")).unwrap_err().to_string();
    assert!(shown.starts_with("cannot read mission file none.json: "), "{shown}");
    assert!(shown.contains("relative to the current directory"), "{shown}");
    let shown = load_mission(&shipped("mission")).unwrap_err().to_string();
    assert!(shown.contains("directory"), "{shown}");
}

#[test]
fn regress_schemas_are_current_and_show_the_ranges() {
    for (name, text) in schema::schemas() {
        let path = shipped("params/schema").join(name);
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(committed == text, "{name} is stale: run `samara schema`");
        assert!(
            !text.contains("\"additionalProperties\": true")
                && text.contains("\"additionalProperties\": false")
        );
    }
    let [_, (_, vehicle), _] = schema::schemas();
    let vehicle: serde_json::Value = serde_json::from_str(&vehicle).unwrap();
    assert_eq!(vehicle["properties"]["mass_kg"]["exclusiveMinimum"], 0);
    assert_eq!(vehicle["properties"]["mass_kg"]["maximum"], 100_000);
    assert_eq!(vehicle["properties"]["inertia_kg_m2"]["maxItems"], 3);
}

/// Every number's key ends in its unit, or the number has none.
#[test]
fn every_number_in_a_schema_names_its_unit() {
    const UNITS: [&str; 39] = [
        "_kg",
        "_m",
        "_m2",
        "_kg_m2",
        "_deg",
        "_deg_s",
        "_rad_s",
        "_s",
        "_m_s",
        "_m_s2",
        "_n",
        "_n_s",
        "_per_n2",
        "_kg_m3",
        "_per_s",
        "_per_s2",
        "_n_per_rad2_s2",
        "_nm_a",
        "_v_s_rad",
        "_ohm",
        "_v",
        "_a",
        "_us",
        "_rad_s2",
        // Without a unit.
        "nodes",
        "trials",
        "seed",
        "cost_state",
        "axis_body",
        "q_ned_from_body",
        "_wh",
        "_percent",
        "c_drag",
        "c_lift",
        "c_pitch",
        "thrust_m",
        "_hz",
        "_gauss",
        "_hpa",
    ];
    fn is_number(schema: &serde_json::Value) -> bool {
        let is = |kind: &serde_json::Value| kind == "number" || kind == "integer";
        let kind = &schema["type"];
        is(kind)
            || kind.as_array().is_some_and(|k| k.iter().any(is))
            || schema.get("items").is_some_and(is_number)
    }
    fn walk(schema: &serde_json::Value, seen: &mut usize) {
        if let Some(properties) = schema["properties"].as_object() {
            for (key, value) in properties {
                if is_number(value) {
                    *seen += 1;
                    assert!(UNITS.iter().any(|unit| key.ends_with(unit)), "{key}");
                }
            }
        }
        for child in schema
            .as_object()
            .into_iter()
            .flat_map(|o| o.values())
            .chain(schema.as_array().into_iter().flatten())
        {
            walk(child, seen);
        }
    }
    let mut seen = 0;
    for (_, text) in schema::schemas() {
        walk(&serde_json::from_str(&text).unwrap(), &mut seen);
    }
    assert!(seen > 60, "{seen}");
}
