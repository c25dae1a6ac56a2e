//! `--set`: keys with other values.

use super::spoil::shipped;
use crate::{ConfigError, Mission, Override, is_of_vehicle, load_mission, load_mission_with, settable_keys};
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
fn every_settable_key_is_one_of_the_two_files() {
    let keys: Vec<&str> = settable_keys().collect();
    for key in [
        "limits.pitch_deg",
        "wind.turbulence.sigma_m_s",
        "mass_kg",
        "motor.first_order.tau_up_s",
        "tuning.cases[0].name",
    ] {
        assert!(keys.contains(&key), "{key}");
    }
    for key in keys {
        let given: Override = format!("{key}=null").parse().unwrap();
        assert!(is_of_vehicle(&given).is_ok(), "{key}");
    }
}
