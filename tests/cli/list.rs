//! `samara list`: what it names is what other verbs take, and runs are what lies in the folders.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::{code, json, samara_in, stderr};

fn listed(folder: &Path, args: &[&str]) -> Value {
    let output = samara_in(folder, &[&["list", "--json"], args].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    json(&output)
}

fn of<'a>(list: &'a Value, kind: &str, name: &str) -> &'a Value {
    let all = list[kind].as_array().unwrap();
    all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name} in {list}"))
}

/// A folder with files of one's own: a mission that stands before a built-in one, one that is refused, one
/// whose name is a path, a vehicle and gains.
fn own_files() -> tempfile::TempDir {
    let here = tempfile::tempdir().unwrap();
    for folder in ["mission", "params/vehicles", "params/gains"] {
        fs::create_dir_all(here.path().join(folder)).unwrap();
    }
    let write = |name: &str, text: &str| fs::write(here.path().join(name), text).unwrap();
    let mission = fs::read_to_string("mission/x500_drop.json").unwrap();
    let mission = mission.replace("../params", "built-in:params");
    write("mission/x500_drop.json", &mission.replace("\"about\": \"A ", "\"about\": \"Mine. A "));
    write("mission/spoilt.json", "{}");
    write("mission/two.json.json", &mission);
    let vehicle = fs::read_to_string("params/vehicles/titan.json").unwrap();
    let table = fs::read_to_string("params/vehicles/titan_rotor.csv").unwrap();
    write("params/vehicles/heavy.json", &vehicle.replace("\"mass_kg\": 790", "\"mass_kg\": 800"));
    write("params/vehicles/titan_rotor.csv", &table);
    let gains = fs::read_to_string("params/gains/ours.json").unwrap();
    write("params/gains/ours.json", &gains);
    write("params/gains/safety.json", &gains);
    here
}

#[test]
fn every_name_is_one_that_other_verbs_take() {
    let here = own_files();
    let list = listed(here.path(), &[]);
    for mission in list["missions"].as_array().unwrap() {
        let name = mission["name"].as_str().unwrap();
        // `params export` reads mission, vehicle and gains, and flies nothing.
        let read = samara_in(here.path(), &["params", "export", name, "--out", "p.params"]);
        assert_eq!(code(&read) == 2, name == "spoilt", "{name}: {}", stderr(&read));
        assert_eq!(mission["refused"].is_null(), name != "spoilt", "{mission}");
    }
    for gains in list["gains"].as_array().unwrap() {
        let args = ["params", "export", "titan_drop", "--out", "p.params", "--gains"];
        let read = samara_in(here.path(), &[&args[..], &[gains["name"].as_str().unwrap()]].concat());
        assert_eq!(code(&read), 0, "{gains}: {}", stderr(&read));
    }
}

#[test]
fn own_files_stand_before_those_built_in() {
    let here = own_files();
    let list = listed(here.path(), &[]);
    let own = of(&list, "missions", "x500_drop");
    assert_eq!((&own["path"], &own["built_in"]), (&json!("mission/x500_drop.json"), &json!(false)));
    assert_eq!((&own["vehicle"], &own["planet"]), (&json!("x500"), &json!("earth")));
    let titan = of(&list, "missions", "titan_drop");
    assert_eq!((&titan["planet"], &titan["built_in"]), (&json!("titan"), &json!(true)));
    let heavy = of(&list, "vehicles", "heavy");
    assert_eq!((&heavy["mass_kg"], &heavy["rotors"]), (&json!(800.0), &json!(4)));
    assert_eq!(of(&list, "gains", "x500")["vehicles"], json!(["x500"]));
    // The same text is the built-in one; another text has a path.
    let names: Vec<_> = list["gains"].as_array().unwrap().iter().map(|gains| &gains["name"]).collect();
    assert!(names.contains(&&json!("params/gains/safety.json")) && names.contains(&&json!("safety")));
    assert!(!names.contains(&&json!("params/gains/ours.json")), "{names:?}");
    let said = samara_in(here.path(), &["list", "missions"]);
    let text = String::from_utf8(said.stdout).unwrap();
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    let line = |name: &str| text.lines().find(|line| line.starts_with(name)).unwrap();
    assert!(line("spoilt").contains("NOT read: "), "{text}");
    assert!(line("x500_drop").contains("earth   ./mission  Mine"), "{text}");
    assert!(!text.contains("vehicle  mass"), "missions alone: {text}");
}

/// By hand: manifests and results as verbs write them.
#[test]
fn runs_are_what_lies_below_the_folder() {
    let here = tempfile::tempdir().unwrap();
    let text = samara_in(here.path(), &["list", "runs"]);
    assert_eq!((code(&text), String::from_utf8(text.stdout).unwrap()), (0, "no runs below out\n".to_owned()));
    let run = |folder: &str, verb: &str, result: Option<(&str, &str)>| {
        let folder = here.path().join(folder);
        fs::create_dir_all(&folder).unwrap();
        let files = result.map(|(name, text)| {
            fs::write(folder.join(name), text).unwrap();
            json!({ name: "0" })
        });
        let manifest = json!({
            "verb": verb, "version": "0.1.9", "mission": "m", "vehicle": "v", "gains": "g", "seed": 1,
            "input_hash": "0", "choices": {}, "circumstances": {}, "files": files.unwrap_or(json!({})),
        });
        fs::write(folder.join(format!("{verb}_manifest.json")), manifest.to_string()).unwrap();
    };
    run("out/m", "drop", Some(("drop.json", r#"{ "safe": false }"#)));
    run("out/m/earlier/free_fall-0", "free_fall", Some(("free_fall.json", r#"{ "holds": true }"#)));
    run("out/plan", "plan", Some(("plan.json", "{}")));
    fs::write(here.path().join("out/plan/torn_manifest.json"), "{").unwrap();
    let list = listed(here.path(), &["runs"]);
    assert!(list.get("missions").is_none());
    let runs = list["runs"].as_array().unwrap();
    let verdict = |verb: &str| {
        let run = runs.iter().find(|run| run["verb"] == verb).unwrap();
        (run["verdict"].clone(), run["version"].clone())
    };
    assert_eq!(runs.len(), 4);
    assert_eq!(verdict("drop"), (json!("NOT safe"), json!("0.1.9")));
    assert_eq!(verdict("free_fall"), (json!("holds"), json!("0.1.9")));
    assert_eq!(verdict("plan"), (Value::Null, json!("0.1.9")));
    assert_eq!(verdict("torn"), (Value::Null, json!("-")));
    assert!(runs[0]["written"].as_str().unwrap().ends_with(" UTC"));
    assert_eq!(listed(here.path(), &["runs", "--out", "out/m"])["runs"].as_array().unwrap().len(), 2);
    let file = samara_in(here.path(), &["list", "--out", "out/m/drop.json"]);
    assert_eq!(code(&file), 2);
    assert!(stderr(&file).contains("a folder of results is expected"), "{}", stderr(&file));
}
