//! Every way in which a mission is refused, with the exact place; and what the parts that may be left out are
//! read as.

use std::path::Path;

use super::spoil::{OURS, TITAN, shipped, spoil, titan, titan_with};
use super::*;
use samara_core::math;
use samara_core::sim::{ReleaseTrigger, SensorSettings};

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
    titan_with(OURS, "\"k_pr_per_s\"", "\"k_pr\"").refused_at(
        ("\"k_pr\"", 0),
        "k_pr",
        "unknown field `k_pr`",
    );
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
    titan("\"seed\": 1", "\"seed\": -1").refused_at(("-1,\n", 0), "seed", "expected a whole number from 0");
    titan("\"name\": \"titan_paper\"", "\"name\": \"../x\"").refused_at(
        ("\"../x\"", 0),
        "name",
        "letters, digits",
    );
    let zero = "\"cost_input_reference\": \"zero\",";
    titan(zero, &format!("{zero} \"terminal_tolerance_m_s\": 1e-9,")).refused_at(
        ("1e-9", 0),
        "plan.terminal_tolerance_m_s",
        "expected at least 1e-7 m/s",
    );
    titan("\"pitch_rate_deg_s\": 18.8", "\"pitch_rate_deg_s\": \"18.8\"").refused_at(
        ("\"18.8\"", 0),
        "tuning.cases[1].pitch_rate_deg_s",
        "expected a number from -100000 to 100000",
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
    let vehicle = |from: &str, to: &str| titan_with("params/vehicles/titan.json", from, to);
    vehicle("790.0", "1e300").refused_at(("1e300", 0), "mass_kg", "greater than 0 and at most 100000");
    titan_with(OURS, "\"k_pr_per_s\": 1.0", "\"k_pr_per_s\": 1e300").refused_at(
        ("1e300", 0),
        "k_pr_per_s",
        "from 0 to 1000000",
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
    titan("\"name\": \"case_4\"", "\"name\": \"case_2\"").refused_at(
        ("\"case_2\", \"v_ned_m_s\": [-0.10", 0),
        "tuning.cases[4].name",
        "expected a name of its own, `case_2` is that of tuning.cases[2]",
    );
    titan("\"trials\": 100", "\"trials\": 1").refused_at(
        ("\"trials\": 1,", 10),
        "monte_carlo.trials",
        "expected a whole number from 2",
    );
    let trigger = |altitude: &str| {
        titan(
            "\"trigger\": \"command\"",
            &format!("\"trigger\": {{ \"altitude\": {{ \"altitude_m\": {altitude} }} }}"),
        )
    };
    let path = "release.trigger.altitude.altitude_m";
    trigger("1030").refused_at(("1030", 0), path, "expected less than 1030 m");
    assert_eq!(trigger("990.5").loaded.unwrap().release.trigger, ReleaseTrigger::Altitude(990.5));
    titan("\"command\"", "\"comand\"").refused_at(
        ("\"comand\"", 0),
        "release.trigger",
        "expected one of `command`, `time`, `altitude`, `armed_offboard`",
    );
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

/// From a hook a canopy takes over before the release: by hand, 3 v/g of Titan's 3 m/s are 6.6 s.
#[test]
fn a_hook_that_leaves_no_time_to_a_canopy_is_refused() {
    let file = "mission/titan_drop.json";
    let hooked = |hook: &str| spoil(load_mission, file, file, "\"hang_s\": 10,", hook);
    assert!(hooked("\"hang_s\": 10, \"hook_s\": 3,").loaded.is_ok());
    hooked("\"hang_s\": 10, \"hook_s\": 5,").refused_at(
        ("\"hook_s\"", 10),
        "release.hook_s",
        "of the 5 s that are left",
    );
}

/// The ground lies below the release and a battery has a charge; without either key there is none.
#[test]
fn ground_and_battery_are_read_and_refused() {
    let m = load_mission(&shipped(TITAN)).unwrap();
    assert_eq!((m.site.ground, m.battery, m.release.standing), (None, None, false));
    let ground = |altitude: &str| {
        let to = format!("\"altitude_m\": 1000, \"ground_altitude_m\": {altitude}");
        titan("\"altitude_m\": 1000", &to)
    };
    let m = ground("700").loaded.unwrap();
    assert_eq!(
        (m.site.ground.map(|g| g.down_m), m.release.standing, m.limits.touch.speed_m_s),
        (Some(300.0), false, 2.1)
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
    assert!(standing.release.standing && standing.simulation().on_ground());
}

/// A battery with a voltage is no store of energy beside it, its charge is its energy over the mean voltage,
/// and rotors without inertia, which would take no current to speed up, are refused.
#[test]
fn an_electric_battery_is_read_and_refused() {
    let m = load_mission(&shipped("mission/balloon_drop.json")).unwrap();
    let battery = m.electric.as_ref().unwrap();
    assert!(m.battery.is_none() && m.simulation().battery() == Some(battery));
    // 185 W h over 23.1255 V, by trapezoids over the mission's table.
    assert!((battery.capacity_c() / (185.0 * 3600.0 / 23.1255) - 1.0).abs() < 1e-12);
    assert_eq!((battery.charge(), battery.at_rest().bus_v), (1.0, 25.2));
    assert_eq!(battery.pack().limits().current_max_a, 120.0);
    let massless = spoil(
        load_mission,
        "mission/balloon_drop.json",
        "params/vehicles/hexa_4kg5.json",
        "\"rotor_inertia_kg_m2\": 0.00019",
        "\"rotor_inertia_kg_m2\": 0",
    );
    let said = massless.loaded.unwrap_err().to_string();
    assert!(said.contains("battery.electric: expected rotors with inertia"), "{said}");
}

/// Without the object the sensors are ideal; each of them stands for itself; what it says is bounded and
/// strict.
#[test]
fn sensors_are_read_and_refused() {
    let ground = "mission/x500_ground.json";
    let text = std::fs::read_to_string(shipped(ground)).unwrap();
    let (_, behind) = text.split_once("\"sensors\": {").unwrap();
    let own = format!("\"sensors\": {{{}\n  }}", behind.split_once("\n  }").unwrap().0);
    let with = |mission: &str, from: &str, sensors: &str| {
        spoil(load_mission, mission, mission, from, &format!("\"sensors\": {sensors}"))
    };
    let x500 = |sensors: &str| with(ground, &own, sensors);
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
    assert!(
        (field.norm() - 0.48).abs() < 0.01 && (math::atan2(field.y, field.x) - 0.06).abs() < 0.01,
        "{field:?}"
    );
    with(TITAN, "\"seed\": 1", &format!("{magnetometer}, \"seed\": 1")).refused_at(
        ("\"world_magnetic_model\"", 0),
        "sensors.magnetometer.field",
        "Earth's",
    );
}

#[test]
fn a_fault_in_a_named_file_is_reported_there() {
    let in_vehicle = |from: &str, to: &str| titan_with("params/vehicles/titan.json", from, to);
    in_vehicle("790.0", "-790.0").refused_at(("-790.0", 0), "mass_kg", "greater than 0");
    let shown = titan("vehicles/titan.json", "vehicles/none.json").loaded.unwrap_err().to_string();
    assert!(
        shown.contains("none.json") && shown.contains("named in") && shown.contains("titan_paper.json"),
        "{shown}"
    );
    let shown = load_mission(Path::new("none.json")).unwrap_err().to_string();
    assert!(shown.starts_with("cannot read mission file none.json: "), "{shown}");
    assert!(shown.contains("relative to the current directory"), "{shown}");
    let shown = load_mission(&shipped("mission")).unwrap_err().to_string();
    assert!(shown.contains("directory"), "{shown}");
}

/// A file of a byte more than 64 MiB is not read, be it a mission with spaces behind it.
#[test]
fn a_file_beyond_the_bound_is_refused_unread() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("large.json");
    std::fs::copy(shipped(TITAN), &path).unwrap();
    let file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    file.set_len((64 << 20) + 1).unwrap();
    let refused = load_mission(&path).unwrap_err().to_string();
    assert!(refused.ends_with("it is larger than 64 MiB"), "{refused}");
    file.set_len(64 << 20).unwrap();
    assert!(!load_mission(&path).unwrap_err().to_string().contains("larger"), "at the bound it is read");
}
