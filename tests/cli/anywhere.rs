//! Missions and gains by name, in any folder: those of the folder first, else those inside the program.

use std::fs;
use std::path::Path;
use std::process::Output;

use super::{code, samara, samara_in, stderr};

fn first_line(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stdout);
    format!("{} ({})", text.lines().next().unwrap_or_default(), stderr(output))
}

/// Every file that a drop writes elsewhere is, byte by byte, the one that it writes in the project.
#[test]
fn a_built_in_mission_flies_as_the_file_does() {
    let (elsewhere, out) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let by_name = samara_in(elsewhere.path(), &["drop", "x500_drop", "--gains", "x500_hover"]);
    assert_eq!(code(&by_name), 0, "{}", stderr(&by_name));
    assert_eq!(first_line(&by_name), "mission x500_drop: built in ()");
    let folder = out.path().to_str().unwrap();
    let by_file = samara(&["drop", "mission/x500_drop.json", "--gains", "x500_hover", "--out", folder]);
    assert!(first_line(&by_file).starts_with("samara drop: x500_drop"), "a path says nothing of itself");
    let mut count = 0;
    for entry in fs::read_dir(out.path()).unwrap() {
        let file = entry.unwrap().file_name();
        let there = fs::read(elsewhere.path().join("out/x500_drop").join(&file)).unwrap();
        assert!(fs::read(out.path().join(&file)).unwrap() == there, "{}", file.display());
        count += 1;
    }
    assert!(count > 8, "{count} files");
}

/// A mission of one's own under a shipped one's name comes first; gains that are not beside it are built in,
/// and that is said.
#[test]
fn the_folder_s_own_files_come_first_and_the_first_line_says_which() {
    let here = tempfile::tempdir().unwrap();
    let plan = |args: &[&str]| samara_in(here.path(), &[&["plan"], args].concat());
    assert_eq!(first_line(&plan(&[])), "mission titan_drop: built in ()");
    fs::create_dir_all(here.path().join("mission")).unwrap();
    let text = fs::read_to_string("mission/titan_drop.json").unwrap();
    let text = text.replace("../params", "built-in:params").replace("\"nodes\": 75", "\"nodes\": 41");
    fs::write(here.path().join("mission/titan_drop.json"), text).unwrap();
    let own = plan(&["titan_drop", "--out", "own"]);
    assert_eq!(first_line(&own), "mission ./mission/titan_drop.json ()");
    assert_eq!(first_line(&samara_in(here.path(), &["plan", "x500_drop"])), "mission x500_drop: built in ()");
    let json = plan(&["--json"]);
    assert_eq!(serde_json::from_slice::<serde_json::Value>(&json.stdout).unwrap()["nodes"], 41);
    let misspelt = plan(&["titan_dorp"]);
    assert_eq!(code(&misspelt), 2);
    assert!(stderr(&misspelt).contains("did you mean `titan_drop`?"), "{}", stderr(&misspelt));
    let path = plan(&["mission/x500_drop.json"]);
    assert!(stderr(&path).contains("the built-in mission of that name is `x500_drop`"), "{}", stderr(&path));
}

/// What `init` writes is what is inside, and it overwrites nothing.
#[test]
fn init_writes_an_editable_copy_once() {
    let here = tempfile::tempdir().unwrap();
    let written = samara_in(here.path(), &["init", "mine"]);
    assert_eq!(code(&written), 0, "{}", stderr(&written));
    let text = String::from_utf8(written.stdout).unwrap();
    assert!(text.contains("mine/mission/x500_drop.json\n") && text.contains("next:\n  cd mine\n"), "{text}");
    let mine = here.path().join("mine");
    for file in
        ["mission/titan_px4.json", "params/vehicles/titan_rotor.csv", "params/schema/gains.schema.json"]
    {
        assert!(fs::read(mine.join(file)).unwrap() == fs::read(file).unwrap(), "{file}");
    }
    // What the examples of the help name is there.
    for help in fs::read_dir("src/cli/help").unwrap() {
        let text = fs::read_to_string(help.unwrap().path()).unwrap();
        let is_ours = |word: &&str| word.starts_with("mission/") || word.starts_with("params/");
        for file in text.split_whitespace().filter(is_ours).filter(|word| Path::new(word).is_file()) {
            assert!(mine.join(file).is_file(), "{file}");
        }
    }
    assert!(mine.join("drop.py").is_file());
    assert!(first_line(&samara_in(&mine, &["plan"])).starts_with("mission ./mission/titan_drop.json"));
    fs::remove_file(mine.join("README.md")).unwrap();
    fs::write(mine.join("mission/x500_drop.json"), "mine").unwrap();
    let again = samara_in(here.path(), &["init", "mine"]);
    assert_eq!(code(&again), 2);
    assert!(stderr(&again).contains("is there already"), "{}", stderr(&again));
    assert!(!mine.join("README.md").exists());
    assert_eq!(fs::read_to_string(mine.join("mission/x500_drop.json")).unwrap(), "mine");
    let schema = samara_in(here.path(), &["schema"]);
    assert!(code(&schema) == 2 && stderr(&schema).contains("--out DIR is expected"), "{}", stderr(&schema));
}

/// The checks fly the project's own vehicles, wherever they are made.
#[test]
fn verify_needs_no_folder() {
    let output = samara_in(tempfile::tempdir().unwrap().path(), &["verify", "--json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
}
