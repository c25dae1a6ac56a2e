//! `--set`: keys with other values.

use std::path::Path;

use super::spoil::shipped;
use crate::{
    ConfigError, Mission, Override, SettableKey, changed_mission_files, is_of_vehicle, load_mission,
    load_mission_with, settable_keys,
};
use nalgebra::Vector3;
use samara_core::units::RAD_PER_DEG;

const FILE: &str = "mission/x500_drop.json";

fn with(texts: &[&str]) -> Result<Mission, ConfigError> {
    let overrides: Vec<Override> = texts.iter().map(|text| text.parse().unwrap()).collect();
    load_mission_with(&shipped(FILE), &overrides)
}

/// What is set is what the mission has, in the key's unit; the inputs are others, and say which. All else is
/// the file's.
#[test]
fn closed_form_what_is_set_is_what_the_mission_has() {
    let own = load_mission(&shipped(FILE)).unwrap();
    let given = [
        "limits.pitch_deg=40",
        "mass_kg=2200g",
        "target_v_ned_m_s=3,0,3.6km/h",
        "uncertain.mass.uniform=-0.1,0.1",
    ];
    let mission = with(&given).unwrap();
    assert!((mission.limits.safety.pitch_rad - 40.0 * RAD_PER_DEG).abs() < 1e-15);
    assert!((mission.vehicle.mass.mass_kg - 2.2).abs() < 1e-15);
    assert!((mission.target_v_ned - Vector3::new(3.0, 0.0, 1.0)).amax() < 1e-15);
    assert!(mission.uncertain.is_some() && own.uncertain.is_none());
    assert_eq!(mission.vehicle.mass.inertia_kg_m2, own.vehicle.mass.inertia_kg_m2);
    let choices: Vec<String> =
        mission.inputs.choices.iter().map(|(name, value)| format!("{name}={value}")).collect();
    assert_eq!(choices, given.map(|given| format!("set {given}")));
    assert_ne!(mission.inputs.hash, own.inputs.hash);
    assert_ne!(mission.inputs.hash, with(&["limits.pitch_deg=40"]).unwrap().inputs.hash);
    assert_eq!(mission.inputs.mission_text().matches("\"pitch_deg\": 40").count(), 1);
    let texts = mission.input_texts("x500").unwrap();
    assert!(texts[1].1.contains("\"mass_kg\": 2.2,"), "{}", texts[1].1);
    // The last word counts, and a key that both files have is the mission's.
    assert_eq!(with(&["seed=3", "seed=7"]).unwrap().seed, 7);
    assert_eq!(with(&["name=other"]).unwrap().name, "other");
    assert_eq!(with(&["vehicle.name=other"]).unwrap().vehicle_name, "other");
    assert_eq!(with(&["vehicle.name=other", "mission.name=third"]).unwrap().name, "third");
}

/// What cannot be is refused by its key, or where it stands in the file.
#[test]
fn what_cannot_be_set_is_refused_where_it_stands() {
    for (text, expected) in [
        (
            "pitch_deg=3",
            "--set pitch_deg=3: neither the mission's file nor the vehicle's has such a key, did you mean `limits.pitch_deg`?",
        ),
        ("limits.pitch_deg=7in", "--set limits.pitch_deg=7in: `in` is no unit here; expected rad, deg"),
        ("wind.gusts[3].start_s=1", "--set wind.gusts[3].start_s=1: there is no `wind.gusts[3]` in "),
        ("name.first=a", "--set name.first=a: `name` is no object in "),
        (
            "limits.pitch_deg=soon",
            ": limits.pitch_deg: invalid type: string \"soon\", expected a number greater than 0 and at most 180 (--set limits.pitch_deg=soon)",
        ),
        ("limits.pich_deg=3", ": limits.pich_deg: did you mean `pitch_deg`?"),
        ("mass_kg=-1", "x500.json:"),
    ] {
        let said = with(&[text]).unwrap_err().to_string();
        assert!(said.contains(expected), "{text}: {said}");
    }
    for text in ["", "a", "=3", "a=", "a b=3", "limits.pitch_deg"] {
        assert!(text.parse::<Override>().is_err(), "{text}");
    }
}

/// Whatever the shell completes is a key: another one is refused as unknown, and the files' own are among
/// them.
#[test]
fn every_settable_key_is_one_of_the_files() {
    let keys: Vec<&str> = settable_keys().map(|key| key.path.as_str()).collect();
    for key in [
        "limits.pitch_deg",
        "wind.turbulence.sigma_m_s",
        "mass_kg",
        "motor.first_order.tau_up_s",
        "tuning.cases[0].name",
        "gains.k_pq_per_s",
    ] {
        assert!(keys.contains(&key), "{key}");
    }
    for key in keys {
        let given: Override = format!("{key}=null").parse().unwrap();
        assert!(is_of_vehicle(&given).is_ok(), "{key}");
    }
}

/// A gain is set in whichever gains fly: the mission's own, and others that are chosen; what is kept of the
/// inputs has it.
#[test]
fn gains_that_are_set_stay_set_in_other_gains() {
    let mut mission = with(&["gains.k_pq_per_s=18"]).unwrap();
    let own = load_mission(&shipped(FILE)).unwrap();
    assert_eq!((mission.control.gains.k_pq, own.control.gains.k_pq), (18.0, 21.0));
    assert_eq!(mission.control.gains.k_pvz, own.control.gains.k_pvz);
    assert_ne!(mission.inputs.hash, own.inputs.hash);
    let texts = mission.input_texts("x500").unwrap();
    assert!(texts[2].1.contains("\"k_pq_per_s\": 18,"), "{}", texts[2].1);
    let mut others = own.clone();
    mission.use_gains("x500_hover").unwrap();
    others.use_gains("x500_hover").unwrap();
    assert_eq!(mission.control.gains.k_pq, 18.0);
    assert_eq!(mission.control.gains.k_pvx, others.control.gains.k_pvx);
    let said = with(&["gains.k_pq_per_s=-1"]).unwrap_err().to_string();
    assert!(said.contains("x500.json:") && said.ends_with("(--set gains.k_pq_per_s=-1)"), "{said}");
    assert_ne!(with(&["gains=\"../params/gains/x500_hover.json\""]).unwrap().control.gains_name, "x500");
}

/// What schemas say of keys: by hand, of each kind.
#[test]
fn closed_form_what_is_known_of_keys() {
    let key = |path: &str| settable_keys().find(|key| key.path == path).unwrap().clone();
    let of = |path: &str| {
        let SettableKey { unit, kind, minimum, maximum, choices, .. } = key(path);
        (unit.unwrap_or_default(), kind, minimum, maximum, choices.join(" "))
    };
    let none = String::new;
    assert_eq!(of("limits.pitch_deg"), ("deg".to_owned(), "number", Some(0.0), Some(180.0), none()));
    assert_eq!(of("control.latency_s"), ("s".to_owned(), "number", Some(0.0), Some(1.0), none()));
    assert_eq!(of("target_v_ned_m_s"), ("m/s".to_owned(), "array", Some(-1000.0), Some(1000.0), none()));
    assert_eq!(of("gains.k_iq_per_s2"), ("1/s^2".to_owned(), "number", Some(0.0), Some(1e6), none()));
    assert_eq!(of("seed"), (none(), "integer", Some(0.0), None, none()));
    assert_eq!(of("control.feed_forward"), (none(), "boolean", None, None, none()));
    assert_eq!(of("release.start"), (none(), "string", None, None, "release t0 ground".to_owned()));
    assert_eq!(of("control.tilt_from"), (none(), "string", None, None, "gravity thrust".to_owned()));
    assert_eq!(of("wind.turbulence").1, "object");
    assert_eq!(key("mass_kg").description, "Mass [kg].");
}

/// A changed mission in files of its own is the changed mission, wherever it was read: all that flies, but
/// for names.
#[test]
fn a_changed_mission_is_read_back_from_its_files() {
    let set: Vec<Override> = ["limits.pitch_deg=40", "mass_kg=2.2", "gains.k_pq_per_s=18"]
        .map(|text| text.parse().unwrap())
        .to_vec();
    let folder = tempfile::tempdir().unwrap();
    for path in [shipped(FILE), Path::new("built-in:mission/x500_drop.json").to_owned()] {
        let mission = load_mission_with(&path, &set).unwrap();
        let files = changed_mission_files(&mission, &set, "mine", folder.path()).unwrap();
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["mine.json", "mine_vehicle.json", "mine_gains.json"]);
        for (name, text) in &files {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let read = load_mission(&folder.path().join("mine.json")).unwrap();
        assert_eq!(
            [&*read.name, &*read.vehicle_name, &*read.control.gains_name],
            ["mine", "mine_vehicle", "mine_gains"]
        );
        assert_eq!(read.vehicle, mission.vehicle);
        assert_eq!(read.control.gains, mission.control.gains);
        assert_eq!(read.limits, mission.limits);
        assert!(read.px4.params.is_some() && read.px4.params == mission.px4.params || path == shipped(FILE));
    }
    // Of a mission on disk, in its own folder: what was not set stands as it was written.
    let own = std::fs::read_to_string(shipped(FILE)).unwrap();
    let mission = load_mission_with(&shipped(FILE), &set[..1]).unwrap();
    let files = changed_mission_files(&mission, &set[..1], "mine", shipped("mission").as_path()).unwrap();
    let expected =
        own.replace("\"x500_drop\",", "\"mine\",").replace("\"pitch_deg\": 45.0,", "\"pitch_deg\": 40,");
    assert_eq!(files, [("mine.json".to_owned(), expected)]);
    assert!(changed_mission_files(&mission, &set, "no name", folder.path()).is_err());
}
