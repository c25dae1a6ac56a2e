//! The rotors whose blades are known: the shipped tables against the theory, and that against what was
//! measured.
#![cfg(feature = "files")]

use std::path::PathBuf;
use std::sync::Arc;

use nalgebra::Vector3;
use samara::config::{BladeFile, ConfigError, Mission, VehicleFile, blade_file, load_vehicle};
use samara::model::rigid_body::BodyState;
use samara::model::wind::{RingFluctuation, Wind};
use samara::model::{DiskState, Rotor};
use samara::random::{Purpose, Stream};
use samara::sim::{DropSimulation, PlantKind};

fn shipped(name: &str) -> BladeFile {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("params/vehicles/{name}.json"));
    blade_file(&path).unwrap()
}

const SHIPPED: [&str; 2] = ["titan_bemt", "x500"];

/// Each shipped table is what `samara rotor` writes.
#[test]
fn regress_the_shipped_tables_are_fresh() {
    for name in SHIPPED {
        let file = shipped(name);
        let found = std::fs::read_to_string(&file.path).unwrap();
        assert!(found == file.table_text(), "{name}: stale; run `samara rotor params/vehicles/{name}.json`");
    }
}

/// Errors of a shipped table between its knots against the blades solved there, at random speeds up to the
/// top one and flows from anywhere: of thrust, torque and in-plane force, each over the thrust or torque, at
/// least over a tenth of hover's at that `(Omega R)^2 + V^2`; in ascending order.
fn errors_between_knots(name: &str, fastest: [f64; 2], density: f64, points: usize) -> [Vec<f64>; 3] {
    let file = shipped(name);
    let vehicle = load_vehicle(&file.path.with_file_name(format!("{name}.json"))).unwrap().vehicle;
    let Rotor::BladeElement(table) = &vehicle.rotor else { panic!() };
    let mut stream = Stream::new(7, Purpose::Dice, 0);
    let mut errors = [Vec::new(), Vec::new(), Vec::new()];
    for _ in 0..points {
        let [omega, v] = fastest.map(|fastest| fastest * stream.uniform());
        let climb = v * (2.0 * stream.uniform() - 1.0);
        let across = (v * v - climb * climb).max(0.0).sqrt();
        let (solved, flown) =
            (file.blades.load(omega, climb, across, density), table.load(omega, climb, across, density));
        let tip = table.radius_m() * omega;
        let hover = file.blades.load((tip * tip + v * v).sqrt() / table.radius_m(), 0.0, 0.0, density);
        let thrust = solved.thrust_n.abs().max(0.1 * hover.thrust_n);
        let torque = solved.torque_nm.abs().max(0.1 * hover.torque_nm);
        errors[0].push((flown.thrust_n - solved.thrust_n).abs() / thrust);
        errors[1].push((flown.torque_nm - solved.torque_nm).abs() / torque);
        errors[2].push((flown.in_plane_n - solved.in_plane_n).abs() / thrust);
    }
    errors.iter_mut().for_each(|e| e.sort_by(f64::total_cmp));
    errors
}

/// Vehicle, fastest rotor [rad/s] and air [m/s], density [kg/m^3], and what 95 % of the errors are below, as
/// `docs/rotors.md` has it to its digits.
const BETWEEN_KNOTS: [(&str, [f64; 2], f64, [f64; 3]); 3] = [
    ("titan_bemt", [133.0, 8.0], 5.4, [0.0022, 0.011, 0.0004]),
    ("titan_bemt", [60.0, 8.0], 5.4, [0.0031, 0.020, 0.0010]),
    ("x500", [714.0, 12.0], 1.225, [0.0020, 0.0023, 0.0004]),
];

/// Of 1500 points a twentieth, 75, is expected beyond the page's figures, with a deviation of 8.4: no more
/// than five deviations above that are.
#[test]
fn reference_the_shipped_tables_between_their_knots() {
    for (name, fastest, density, bars) in BETWEEN_KNOTS {
        let errors = errors_between_knots(name, fastest, density, 1500);
        for (errors, bar) in errors.iter().zip(bars) {
            let beyond = errors.iter().filter(|e| **e > bar).count();
            assert!(beyond <= 117, "{name}: {beyond} errors beyond {bar}");
        }
    }
}

/// The page's figures: `cargo test --test integration rotors::figures -- --ignored --nocapture`.
#[test]
#[ignore = "20 000 points of each table"]
fn figures_of_the_tables_between_their_knots() {
    for (name, fastest, density, _) in BETWEEN_KNOTS {
        let errors = errors_between_knots(name, fastest, density, 20_000);
        println!("{name} {fastest:?}: {:?}", errors.map(|e| e[e.len() * 95 / 100]));
    }
}

/// Forces in the rotors' planes are against the motion of each hub and turn the body about its centre of
/// mass.
#[test]
fn closed_form_forces_in_the_rotors_planes() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("params/vehicles/titan_bemt.json");
    let mut vehicle = load_vehicle(&path).unwrap().vehicle;
    vehicle.rotors.iter_mut().for_each(|r| r.position_body_m.z = -0.5);
    let site = Mission::shipped("titan_paper").unwrap().site.environment;
    let body = BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: [1.0, 0.0, 0.0, 0.0],
        v_ned: Vector3::new(3.0, -4.0, 2.0),
        omega_body: Vector3::zeros(),
    };
    let balance = vehicle.powered_derivative(&site, &body, &[105.0; 8], &[0.7; 8], false).balance;
    let Rotor::BladeElement(table) = &vehicle.rotor else { panic!() };
    let one = table.load(105.0, -2.0, 5.0, site.density_kg_m3);
    assert!(one.in_plane_n > 1.0 && one.thrust_n > 200.0, "{one:?}");
    let force = Vector3::new(-0.6 * one.in_plane_n, 0.8 * one.in_plane_n, -one.thrust_n) * 4.0;
    assert!((balance.rotor_force_body - force).norm() < 1e-9, "{:?}", balance.rotor_force_body);
    // Symmetric rotors: only the forces in the plane, half a metre above, turn the body.
    let moment = Vector3::new(0.0, 0.0, -0.5).cross(&force);
    assert!((balance.rotor_moment_body - moment).norm() < 1e-9, "{:?}", balance.rotor_moment_body);
}

/// A rotor that another's wake works on gives that share of thrust and in-plane force.
#[test]
fn closed_form_interference_acts_on_known_blades_too() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("params/vehicles/titan_bemt.json");
    let alone = load_vehicle(&path).unwrap().vehicle;
    let mut paired = alone.clone();
    for mount in &mut paired.rotors {
        (mount.interference.thrust, mount.interference.torque) = (0.5, 0.7);
    }
    let site = Mission::shipped("titan_paper").unwrap().site.environment;
    let body = BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: [1.0, 0.0, 0.0, 0.0],
        v_ned: Vector3::new(4.0, 0.0, 4.0),
        omega_body: Vector3::zeros(),
    };
    let [a, p] = [&alone, &paired]
        .map(|vehicle| vehicle.powered_derivative(&site, &body, &[90.0; 8], &[0.7; 8], false).balance);
    assert!((p.rotor_force_body - a.rotor_force_body * 0.5).norm() < 1e-9);
    assert!((p.torque_nm[0] - 0.7 * a.torque_nm[0]).abs() < 1e-12);
}

/// The lander in vertical flight whose thrusts fluctuate in the vortex ring by 0.2: for the given flights,
/// after 1.2 s at the throttle of hover, the first rotor's thrust over its mean less 1, and the share of the
/// fluctuation that it should have.
fn fluctuating(v_ned: Vector3<f64>, flights: std::ops::Range<u64>) -> Vec<[f64; 2]> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("params/vehicles/titan_bemt.json");
    let vehicle = Arc::new(load_vehicle(&path).unwrap().vehicle);
    let site = Mission::shipped("titan_paper").unwrap().site.environment;
    let ring = RingFluctuation {
        rms_share: 0.2,
        frequency_hz: 0.3,
        seed: 1,
        follows_mission: true,
        mirrored: false,
    };
    let wind = Wind { ring: Some(ring), ..Wind::default() };
    let body = BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: [1.0, 0.0, 0.0, 0.0],
        v_ned,
        omega_body: Vector3::zeros(),
    };
    let throttle = [0.785; 8];
    flights
        .map(|number| {
            let course = wind.course(&site, number);
            let mut sim = DropSimulation::at_t0(vehicle.clone(), site.clone(), body, PlantKind::Actuator)
                .in_wind(course);
            for _ in 0..59 {
                sim.step(&throttle, 0.02);
            }
            let mean = |sim: &DropSimulation| {
                let s = sim.state();
                vehicle.powered_derivative(&site, &s.body, &s.rotor_speed, &throttle, false).balance.thrust_n
                    [0]
            };
            let before = mean(&sim);
            let disk =
                DiskState::of_each(&vehicle, &site.ambient(), &sim.state().body.motion(), &[before; 8])
                    .unwrap()[0];
            sim.step(&throttle, 0.02);
            [sim.balance(&throttle).thrust_n[0] / mean(&sim) - 1.0, disk.ring_share()]
        })
        .collect()
}

/// In the ring a thrust's standard deviation over its mean is the mission's, over 200 flights and within five
/// standard deviations of the estimate; in a climb and in fast edgewise flow the thrust is its mean to the
/// bit.
#[test]
fn closed_form_thrust_fluctuates_in_the_ring_and_nowhere_else() {
    let inside = fluctuating(Vector3::new(0.0, 0.0, 3.5), 0..200);
    assert!(inside.iter().all(|[_, share]| *share == 1.0), "{inside:?}");
    let of = |power: i32| inside.iter().map(|[off, _]| (off / 0.2).powi(power)).sum::<f64>() / 200.0;
    assert!(of(1).abs() < 5.0 / 200f64.sqrt() && (of(2) - 1.0).abs() < 0.5, "{} {}", of(1), of(2));
    for outside in [Vector3::new(0.0, 0.0, -4.0), Vector3::new(12.0, 0.0, 3.0)] {
        for [off, share] in fluctuating(outside, 0..3) {
            assert!(share == 0.0 && off == 0.0, "{outside}: {share} {off}");
        }
    }
}

/// A spoilt copy of the lander is refused with file, line and path.
#[test]
fn faults_in_blades_and_tables_are_told_with_their_place() {
    const VEHICLE: &str = "titan_bemt.json";
    const TABLE: &str = "titan_bemt_rotor.csv";
    let cases: [(&str, &str, &str, &str); 13] = [
        (VEHICLE, "\"blades\": 4", "\"blades\": 0", "rotor.blade_element.blades: "),
        (VEHICLE, "\"blades\": 4", "\"blade\": 4", "did you mean `blades`?"),
        (VEHICLE, "\"radius_share\": [0.1, 1.0]", "\"radius_share\": [0.1, 1.1]", "radius_share[1]: "),
        (VEHICLE, "\"radius_share\": [0.1, 1.0]", "\"radius_share\": [0.5, 0.5]", "the shares must increase"),
        (
            VEHICLE,
            "\"radius_share\": [0.1, 1.0]",
            "\"radius_share\": [0.5]",
            "expected 2 to 100 stations, found 1",
        ),
        (
            VEHICLE,
            "\"pitch_deg\": [10.3537, 10.3537]",
            "\"pitch_deg\": [10]",
            "expected 2 entries, one per radius_share",
        ),
        (
            VEHICLE,
            "\"stall_lift\": [-1.2, 1.2]",
            "\"stall_lift\": [0.2, 1.2]",
            "expected a negative and a positive number",
        ),
        (VEHICLE, "\"drag_min\": 0.01287", "\"drag_min\": 0", "profile.drag_min: "),
        (
            VEHICLE,
            "\"pitch_deg\": [10.3537, 10.3537]",
            "\"pitch_deg\": [10.3537, 10.3538]",
            "expected a table of the blades in",
        ),
        (TABLE, "# blades: ", "# of: ", "one that does not say its blades"),
        (TABLE, "speed_share,", "speed,", "3:1: expected the header `speed_share,"),
        (TABLE, "\n0,-0.95,", "\n0,-0.96,", "6:1: expected the point 0,-0.95 of the grid"),
        (TABLE, "\n1,1,", "\n#", "expected 5 numbers separated by commas"),
    ];
    let folder = tempfile::tempdir().unwrap();
    let shipped = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("params/vehicles");
    for (file, from, to, wanted) in cases {
        for name in [VEHICLE, TABLE] {
            let text = std::fs::read_to_string(shipped.join(name)).unwrap();
            let text = if name == file {
                assert!(text.contains(from), "{file} has no {from}");
                text.replacen(from, to, 1)
            } else {
                text
            };
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let error = load_vehicle(&folder.path().join(VEHICLE)).unwrap_err().to_string();
        assert!(error.contains(wanted) && error.contains(file), "{to}: {error}");
    }
    let other = blade_file(&shipped.join("titan.json")).unwrap_err().to_string();
    assert!(other.contains("expected `blade_element`"), "{other}");
}

/// A copy of a shipped vehicle with known blades, with one text replaced by another after it was given a
/// start of its rotors.
fn with_start(
    folder: &std::path::Path,
    name: &str,
    start: &str,
    [from, to]: [&str; 2],
) -> Result<VehicleFile, ConfigError> {
    let shipped = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("params/vehicles");
    let text = std::fs::read_to_string(shipped.join(format!("{name}.json"))).unwrap();
    let text = text.replacen("  \"motor\": {", &format!("  \"rotor_start\": {start},\n  \"motor\": {{"), 1);
    assert!(text.contains(from), "{name} has no {from}");
    let path = folder.join(format!("{name}.json"));
    std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
    let table = format!("{name}_rotor.csv");
    std::fs::copy(shipped.join(&table), folder.join(table)).unwrap();
    load_vehicle(&path)
}

const START: &str = r#"{
    "before": "free", "friction_nm": 0.0001,
    "esc": {
      "start_torque_nm": 0.02, "brake_torque_nm": 0.03, "catch_speed_rad_s": 30,
      "try_s": 0.0225, "tries": 100, "wait_s": 0
    }
  }"#;
const UNCHANGED: [&str; 2] = ["", ""];

/// Free rotors of the shipped vehicles: both windmill backwards from rest; the lander's would go on forwards
/// from speed, the x500's would not: its blades, cambered and early to stall, have no autorotation.
#[test]
fn closed_form_the_speed_of_free_rotors() {
    let folder = tempfile::tempdir().unwrap();
    for (name, descent_m_s, density, backwards, forwards) in
        [("titan_bemt", 3.675, 5.4, -5.8, Some(5.25)), ("x500", 5.0, 1.225, -4.0, None)]
    {
        let vehicle = with_start(folder.path(), name, START, UNCHANGED).unwrap().vehicle;
        let mut site = Mission::shipped("titan_paper").unwrap().site.environment;
        site.density_kg_m3 = density;
        let body = BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: [1.0, 0.0, 0.0, 0.0],
            v_ned: Vector3::new(0.0, 0.0, descent_m_s),
            omega_body: Vector3::zeros(),
        };
        let Rotor::BladeElement(table) = &vehicle.rotor else { panic!() };
        let tip_share = |omega: f64| omega * table.radius_m() / descent_m_s;
        let settled = |from: f64| vehicle.settled_speed_rad_s(&site.ambient(), &body, 0, from);
        let fast = 7.0 * descent_m_s / table.radius_m();
        let (from_rest, from_speed) = (settled(0.0), settled(fast));
        println!("{name}: {from_rest} rad/s from rest, {from_speed} rad/s from {fast}");
        assert!((tip_share(from_rest) - backwards).abs() < 0.25, "{name}: {}", tip_share(from_rest));
        match forwards {
            Some(share) => assert!((tip_share(from_speed) - share).abs() < 0.25, "{}", tip_share(from_speed)),
            None => assert!((from_speed - from_rest).abs() < 1.0, "{from_speed} {from_rest}"),
        }
        // No torque but that of the friction, which is against the turning.
        let left_nm = vehicle.air_torque_nm(&site.ambient(), &body, 0, from_rest) - 0.0001;
        assert!(left_nm.abs() < 1e-9, "{name}: {left_nm}");
    }
}

/// A start that the vehicle contradicts is refused with its place.
#[test]
fn faults_in_the_rotors_start_are_told_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&str, [&str; 2], &str); 7] = [
        (
            "titan_bemt",
            ["\"start_torque_nm\": 0.02", "\"start_torque_nm\": 27.1"],
            "rotor_start.esc.start_torque_nm: expected at most",
        ),
        (
            "titan_bemt",
            ["\"brake_torque_nm\": 0.03", "\"brake_torque_nm\": 28"],
            "rotor_start.esc.brake_torque_nm: expected at most",
        ),
        (
            "titan_bemt",
            ["\"catch_speed_rad_s\": 30", "\"catch_speed_rad_s\": 133"],
            "rotor_start.esc.catch_speed_rad_s: expected less",
        ),
        ("titan_bemt", ["\"wait_s\": 0", "\"waits_s\": 0"], "did you mean `wait_s`?"),
        ("titan_bemt", [", \"wait_s\": 0", ""], "missing field `wait_s`"),
        (
            "x500",
            ["2.649858234714004e-05", "0"],
            "motor.first_order.rotor_inertia_kg_m2: expected a number greater than 0",
        ),
        ("x500", ["2.649858234714004e-05", "1e-9"], "motor.first_order.rotor_inertia_kg_m2: expected more"),
    ];
    for (name, change, wanted) in cases {
        let error = with_start(folder.path(), name, START, change).unwrap_err().to_string();
        assert!(error.contains(wanted) && error.contains(name), "{change:?}: {error}");
    }
}

/// The x500's propeller in the wind tunnel of the University of Illinois (UIUC Propeller Database, volume 1,
/// APC SlowFlyer 10x4.7: static at 6528 rpm, 6512 rpm up to J 0.42, then 6020 rpm). The profile is fitted to
/// these points, so this holds the fit: within 2 % of the static values from static thrust to windmilling in
/// a climb.
#[test]
fn reference_the_x500s_propeller_in_the_wind_tunnel() {
    const MEASURED: [(f64, f64, f64); 10] = [
        (0.0, 0.1299, 0.0531),
        (0.089, 0.1201, 0.0523),
        (0.199, 0.1019, 0.0493),
        (0.308, 0.0833, 0.0454),
        (0.420, 0.0616, 0.0398),
        (0.507, 0.0405, 0.0331),
        (0.601, 0.0160, 0.0254),
        (0.652, 0.0017, 0.0207),
        (0.700, -0.0123, 0.0160),
        (0.774, -0.0347, 0.0085),
    ];
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("params/vehicles/x500.json");
    let rotor = load_vehicle(&path).unwrap().vehicle.rotor;
    let Rotor::BladeElement(table) = &rotor else { panic!() };
    let (n, d, density) = (108.0f64, 0.254f64, 1.225);
    for (advance, c_t, c_p) in MEASURED {
        let load = table.load(std::f64::consts::TAU * n, advance * n * d, 0.0, density);
        let thrust = load.thrust_n / (density * n.powi(2) * d.powi(4));
        let power = std::f64::consts::TAU * load.torque_nm / (density * n.powi(2) * d.powi(5));
        assert!((thrust - c_t).abs() < 0.02 * 0.1299, "J {advance}: {thrust} {c_t}");
        assert!((power - c_p).abs() < 0.02 * 0.0531, "J {advance}: {power} {c_p}");
    }
}

/// What the x500 kept with a real propeller of the vehicle of version 0.1, whose rotors knew no flow: the
/// thrust at full throttle, and with it the throttle in hover.
#[test]
fn reference_the_x500_hovers_at_the_same_throttle() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let [old, new] = ["tests/data/v0.1/params/vehicles/x500.json", "params/vehicles/x500.json"]
        .map(|name| load_vehicle(&folder.join(name)).unwrap().vehicle);
    let share = new.static_thrust_n(1.225) / old.static_thrust_n(1.225);
    assert!((share - 1.0).abs() < 1e-5, "{share}");
}
