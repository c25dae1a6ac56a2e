//! The files inside the program: all that are shipped, as they are on disk, and the same missions.

use std::path::{Path, PathBuf};

use super::schema::schemas;
use super::shipped::{BUILT_IN, GAINS, MISSIONS, SHIPPED, is_built_in, names_in};
use super::spoil::{copy, shipped};
use super::*;

/// Whoever adds a file to one of these folders adds its line to the table in `crates/mission/src/shipped.rs`.
#[test]
fn every_shipped_file_is_inside_the_program() {
    for folder in ["mission", "params/gains", "params/px4", "params/vehicles", "params/schema"] {
        for entry in std::fs::read_dir(shipped(folder)).unwrap() {
            let path = format!("{folder}/{}", entry.unwrap().file_name().to_str().unwrap());
            // Nobody needs the schemas of results to write a file: samara-report holds them against the code.
            if path == "params/schema/results" {
                continue;
            }
            let on_disk = std::fs::read_to_string(shipped(&path)).unwrap();
            let inside = match path.strip_prefix("params/schema/") {
                Some(name) => schemas().into_iter().find(|(n, _)| *n == name).map(|(_, text)| text),
                None => SHIPPED.iter().find(|file| file.path == path).map(|file| file.text.to_owned()),
            };
            assert!(
                inside.as_ref() == Some(&on_disk),
                "{path} is not in crates/mission/src/shipped.rs, or is stale"
            );
        }
    }
    for file in SHIPPED {
        assert!(shipped(file.path).is_file(), "{} is gone", file.path);
    }
    assert!(SHIPPED.windows(2).all(|pair| pair[0].path < pair[1].path), "in the order of the paths");
}

/// A built-in mission is the file's: the same inputs, vehicle and parameter file.
#[test]
fn a_built_in_mission_is_the_one_on_disk() {
    for name in names_in(MISSIONS) {
        let built_in = Mission::shipped(name).unwrap();
        let on_disk = load_mission(&shipped(&format!("mission/{name}.json"))).unwrap();
        assert_eq!(built_in.inputs.hash, on_disk.inputs.hash, "{name}");
        assert_eq!(built_in.study_numbers(), on_disk.study_numbers(), "{name}");
        assert_eq!(built_in.file, PathBuf::from(format!("{BUILT_IN}mission/{name}.json")));
        assert!(is_built_in(&built_in.vehicle_file) && is_built_in(&built_in.inputs.gains_file));
        assert_eq!(built_in.gains_beside(), on_disk.gains_beside());
        // The parameter files that missions name.
        for path in built_in.px4.params.iter() {
            load_parameters(path).unwrap();
        }
    }
    let shown = Mission::shipped("none").unwrap_err().to_string();
    assert_eq!(shown, "cannot read mission file built-in:mission/none.json: no such file is built in");
}

/// A mission elsewhere may name built-in files, and takes the gains beside its own before built-in ones.
#[test]
fn built_in_gains_and_vehicles_serve_missions_on_disk() {
    let dir = copy();
    let mission = dir.path().join("mission/x500_drop.json");
    let text = std::fs::read_to_string(&mission).unwrap();
    let text = text.replace("\"../params/vehicles", "\"built-in:params/vehicles");
    std::fs::write(&mission, text).unwrap();
    std::fs::remove_file(dir.path().join("params/gains/near_hover.json")).unwrap();
    let mut m = load_mission(&mission).unwrap();
    assert!(is_built_in(&m.vehicle_file) && !is_built_in(&m.inputs.gains_file));
    m.use_gains("x500_hover").unwrap();
    assert!(!is_built_in(&m.inputs.gains_file));
    m.use_gains("near_hover").unwrap();
    assert!(is_built_in(&m.inputs.gains_file));
    assert!(!m.gains_beside().contains(&"near_hover".to_owned()));
}

#[test]
fn a_name_that_nothing_has_is_refused_with_those_that_there_are() {
    let shown = mission_path(Path::new("titan_dorp")).unwrap_err().to_string();
    let known: Vec<_> = names_in(MISSIONS).collect();
    let expected = "no mission file of the name `titan_dorp` (looked for mission/titan_dorp.json), did you mean \
                    `titan_drop`? expected one of ";
    assert!(shown.starts_with(expected) && shown.contains(&known.join(", ")), "{shown}");
    let shown = mission_path(Path::new("src")).unwrap_err().to_string();
    assert!(shown.ends_with("or a path: there is a ./src here"), "{shown}");
    let mut m = Mission::shipped("titan_drop").unwrap();
    let shown = m.use_gains("near-hover").unwrap_err().to_string();
    assert!(shown.contains("did you mean `near_hover`?"), "{shown}");
    assert!(names_in(GAINS).all(|name| shown.contains(name)), "{shown}");
    let shown = load_mission(Path::new("elsewhere/titan_drop.json")).unwrap_err().to_string();
    assert!(shown.contains("the built-in mission of that name is `titan_drop`"), "{shown}");
}
