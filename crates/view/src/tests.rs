//! What is looked at, against what flies elsewhere and what files say.

use std::cell::Cell;
use std::path::Path;

use serde_json::Value;

use crate::campaign::{BATCH_FIRST, fly_drops};
use crate::controls::mission_shown;
use crate::flown::{Planned, answer};
use crate::viewed::{Changes, Refused, Viewed, changes_of};
use crate::written::{Unwritten, write};
use samara_core::sim::ABREAST;
use samara_host::Threads;
use samara_mission::shipped::{MISSIONS, built_in, names_in};
use samara_mission::{changed_mission_files, load_mission};
use samara_study::designing::own_loops;
use samara_study::effects::EffectFlights;

const CALM: &str = "../../tests/calm_x500.json";

fn viewed(path: &Path) -> Viewed {
    Viewed { path: path.to_owned(), typed: path.display().to_string(), set: Vec::new() }
}

fn changes(texts: &[&str]) -> Changes {
    texts.iter().map(|text| text.parse().unwrap()).collect()
}

/// Every control of every mission that has a drop takes its own value, or what it is absent for is said; and
/// each is in some mission.
#[test]
fn every_control_is_a_key_that_can_be_set() {
    let mut seen = std::collections::BTreeSet::new();
    for name in names_in(MISSIONS).filter(|name| *name != "x500_ground") {
        let viewed = viewed(&built_in(MISSIONS, name));
        let own = viewed.with(&[]).unwrap();
        let shown: Value = serde_json::from_str(&mission_shown(&viewed, &own).unwrap()).unwrap();
        let controls = shown["controls"].as_array().unwrap();
        assert!((20..=30).contains(&controls.len()), "{name}: {}", controls.len());
        let mut all = Vec::new();
        for control in controls {
            let key = control["key"].as_str().unwrap();
            let number = |of: &str| control[of].as_f64().unwrap();
            assert!(number("minimum") < number("maximum") && number("step") > 0.0, "{name}: {control}");
            seen.insert(key.to_owned());
            match control["value"].as_f64() {
                Some(own) => {
                    assert!((number("minimum")..=number("maximum")).contains(&own), "{name}: {control}");
                    all.push(format!("{key}={own}"));
                }
                None => assert!(control["absent"].as_str().is_some_and(|text| !text.is_empty()), "{control}"),
            }
        }
        let given = changes(&all.iter().map(String::as_str).collect::<Vec<_>>());
        let set = viewed.with(&given).unwrap();
        assert_eq!((set.vehicle, set.control.gains), (own.vehicle, own.control.gains), "{name}");
        assert_eq!((set.limits, set.target_v_ned), (own.limits, own.target_v_ned), "{name}");
        assert!(shown["keys"].as_array().is_some_and(|keys| keys.len() > 400), "{name}");
    }
    assert_eq!(seen.len(), 27, "{seen:?}");
    let ground = viewed(&built_in(MISSIONS, "x500_ground")).with(&[]).unwrap_err();
    assert_eq!(ground.to_string(), "the vehicle starts on the ground, there is no drop");
}

/// Where nothing random is left, the page's drop is any drop of the mission's campaign, to the bit.
#[test]
fn reference_the_drop_is_that_of_a_campaign_without_chance() {
    let still = ["monte_carlo.amplitude_sigma_deg=0", "monte_carlo.wind_sigma_m_s=0", "limits.pitch_deg=40"];
    let (calm, given) = (viewed(Path::new(CALM)), changes(&still));
    let (planned, threads) =
        (Planned::new(&calm, &given, &|| false).unwrap(), Threads::new(Some(2)).unwrap());
    let flown = planned.fly(&threads, &|| false).unwrap();
    let Planned { mission, plan } = &planned;
    let campaign = EffectFlights::new(mission, &mission.effects(), &plan.trajectory).unwrap();
    let outcome = campaign.fly(3).outcome;
    let object = answer(&flown, &calm.command(&given), 9, 1.26);
    let object: Value = serde_json::from_str(&object).unwrap();
    assert_eq!(object["cost"], outcome.j_tpf);
    assert_eq!(object["steady_s"], outcome.steady_after_s.unwrap());
    assert_eq!((&object["number"], &object["took_ms"]), (&9.into(), &1.3.into()));
    assert_eq!(object["drop"]["limits"]["pitch_deg"], 40.0);
    assert_eq!(object["cause"], Value::Null);
    let (loops, least) = own_loops(mission, Some(&plan.trajectory));
    assert_eq!(flown.loops, loops.iter().map(|of| (*of, of.keeps(&least))).collect::<Vec<_>>());
}

/// What is overtaken ends at once, wherever it is: in the plan, in the flight, between groups of drops.
#[test]
fn what_is_overtaken_ends() {
    let calm = viewed(Path::new(CALM));
    let overtaken = |refused: Refused| matches!(refused, Refused::Overtaken);
    assert!(overtaken(Planned::new(&calm, &[], &|| true).unwrap_err()));
    let planned = Planned::new(&calm, &[], &|| false).unwrap();
    let threads = Threads::new(Some(1)).unwrap();
    assert!(overtaken(planned.fly(&threads, &|| true).unwrap_err()));
    assert!(overtaken(fly_drops(&planned, 64, &threads, &|| true, &mut |_| true).unwrap_err()));
    let lines = Cell::new(0);
    let gone = fly_drops(&planned, 8, &threads, &|| false, &mut |_| {
        lines.set(lines.get() + 1);
        false
    });
    assert!(overtaken(gone.unwrap_err()) && lines.get() == 1);
}

/// The lines of a campaign are its drops in their order, the same on any number of threads.
#[test]
fn reference_a_campaign_is_what_the_studies_fly() {
    let calm = viewed(Path::new(CALM));
    let planned =
        Planned::new(&calm, &changes(&["limits.speed_m_s=9.3", "duration_s=22"]), &|| false).unwrap();
    let drops = BATCH_FIRST + ABREAST as u64;
    let lines = |threads| {
        let mut lines: Vec<Value> = Vec::new();
        let threads = Threads::new(Some(threads)).unwrap();
        let take = &mut |line: String| {
            lines.push(serde_json::from_str(&line).unwrap());
            true
        };
        fly_drops(&planned, drops, &threads, &|| false, take).unwrap();
        lines
    };
    let found = lines(2);
    let Planned { mission, plan } = &planned;
    let flights = EffectFlights::new(mission, &mission.effects(), &plan.trajectory).unwrap();
    let expected = flights.fly_all(0..drops);
    let all = |key: &str| -> Vec<Value> {
        found.iter().filter_map(|line| line[key].as_array()).flatten().cloned().collect()
    };
    assert_eq!(all("cost"), expected.iter().map(|drop| drop.outcome.j_tpf.into()).collect::<Vec<Value>>());
    assert_eq!(all("passed"), expected.iter().map(|drop| drop.safe.into()).collect::<Vec<Value>>());
    let failed = expected.iter().filter(|drop| !drop.safe).count() as u64;
    assert!(failed > 0 && failed < drops, "{failed}");
    assert_eq!(all("cause").iter().filter(|cause| **cause == "speed").count() as u64, failed);
    let counts: Vec<usize> = found.iter().filter_map(|line| line["cost"].as_array().map(Vec::len)).collect();
    assert_eq!(counts, [BATCH_FIRST as usize, ABREAST]);
    let last = found.last().unwrap();
    assert_eq!((&last["flown"], &last["failed"]), (&drops.into(), &failed.into()));
    let share = failed as f64 / drops as f64;
    assert!(last["interval95"][0].as_f64() < Some(share) && last["interval95"][1].as_f64() > Some(share));
}

/// A mission is written beside the one that is open, under its own name, and never over another file.
#[test]
fn a_changed_mission_is_written_once() {
    let folder = tempfile::tempdir().unwrap();
    let own = load_mission(&built_in(MISSIONS, "x500_drop")).unwrap();
    let files = changed_mission_files(&own, &[], "open", folder.path()).unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let open = viewed(&folder.path().join("open.json"));
    let given = changes(&["mass_kg=2.2", "gains.k_pq_per_s=18"]);
    let written = write(&open, &given, "mine.json").unwrap();
    let expected = ["mine.json", "mine_vehicle.json", "mine_gains.json"].map(|name| folder.path().join(name));
    assert_eq!(written, expected);
    let mine = load_mission(&folder.path().join("mine.json")).unwrap();
    assert_eq!((mine.vehicle.mass.mass_kg, mine.control.gains.k_pq), (2.2, 18.0));
    let before = std::fs::read(&written[0]).unwrap();
    assert!(matches!(write(&open, &[], "mine.json"), Err(Unwritten::Exists(file)) if file == written[0]));
    // One that is in the way of the second file leaves nothing of the first.
    assert!(matches!(write(&open, &given, "open.json"), Err(Unwritten::Exists(_))));
    std::fs::write(folder.path().join("other_vehicle.json"), "").unwrap();
    assert!(matches!(write(&open, &given, "other.json"), Err(Unwritten::Exists(_))));
    assert!(!folder.path().join("other.json").exists());
    assert_eq!(std::fs::read(&written[0]).unwrap(), before);
    for name in
        ["", ".json", "mine", "../mine.json", "a/b.json", "/tmp/a.json", "a b.json", "a.JSON", "a\0.json"]
    {
        assert!(matches!(write(&open, &[], name), Err(Unwritten::Name)), "{name}");
    }
    assert!(matches!(write(&open, &[], &format!("{}.json", "a".repeat(57))), Err(Unwritten::Name)));
}

/// Changes come as texts, in their order; of a key that was set at the opening the page's value counts.
#[test]
fn closed_form_changes_and_the_command_of_them() {
    let object: Value = serde_json::from_str("{\"limits.pitch_deg\":\"40\",\"mass_kg\":\"2.2kg\"}").unwrap();
    let given = changes_of(object.as_object().unwrap()).unwrap();
    let viewed = Viewed { set: changes(&["seed=3", "mass_kg=9"]), ..viewed(Path::new("x500_drop")) };
    let command = "samara drop x500_drop --set seed=3 --set limits.pitch_deg=40 --set mass_kg=2.2kg";
    assert_eq!(viewed.command(&given), command);
    for (text, key) in
        [("{\"a b\":\"1\"}", "a b"), ("{\"mass_kg\":2}", "mass_kg"), ("{\"mass_kg\":\"\"}", "mass_kg")]
    {
        let object: Value = serde_json::from_str(text).unwrap();
        assert_eq!(changes_of(object.as_object().unwrap()).unwrap_err().0, key);
    }
}
