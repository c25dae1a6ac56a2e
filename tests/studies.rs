//! Studies that are killed go on: what `--resume` ends in is, to the byte, what was never killed.
#![cfg(feature = "cli")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn study(kind: &[&str], mission: &str, out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_samara"));
    command.arg("study").args(kind).args([mission, "--out"]).arg(out);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let files = entries.filter(|path| path.is_file());
    files
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()))
        .collect()
}

/// Kills a study once so many of its rows are kept; whether it was still at it.
fn kill_after(rows: usize, mut command: Command, kept: &Path) -> bool {
    let mut child = command.spawn().unwrap();
    let began = Instant::now();
    while fs::read_to_string(kept).is_ok_and(|text| text.lines().count() <= rows)
        || !kept.exists() && began.elapsed() < Duration::from_secs(120)
    {
        if child.try_wait().unwrap().is_some() {
            return false;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    true
}

/// A search of many rounds, one whose rows are lists, and one of several campaigns: killed twice each.
#[test]
fn prop_a_study_that_is_killed_goes_on_and_ends_in_the_same_bytes() {
    let calm = "tests/calm_x500.json";
    for (name, mission, kind, most) in [
        ("rare", calm, &["rare", "--least", "1e-3"][..], 200),
        ("envelope", calm, &["envelope", "--pairs", "wind:delay", "--rays", "4"], 1),
        ("effects", "x500_drop", &["effects", "--trials", "24"], 60),
    ] {
        let out = tempfile::tempdir().unwrap();
        let [whole, killed] = ["whole", "killed"].map(|name| out.path().join(name));
        let code = study(kind, mission, &whole).status().unwrap().code();
        let kept = killed.join(format!("{name}_rows.csv"));
        assert!(kill_after(most, study(kind, mission, &killed), &kept), "{name} was over too soon");
        let going_on = [kind, &["--resume"]].concat();
        let before = fs::read_to_string(&kept).unwrap().lines().count();
        kill_after(before + 1, study(&going_on, mission, &killed), &kept);
        if kept.exists() {
            assert_eq!(study(&going_on, mission, &killed).status().unwrap().code(), code, "{name}");
        }
        assert!(files(&whole) == files(&killed), "{name}: {:?}", files(&killed).keys());
        // Rows are no result: no manifest lists them.
        assert!(
            files(&whole).values().all(|file| !String::from_utf8_lossy(file).contains("_rows.csv")),
            "{name}"
        );
        // Nothing is left to go on with, and other inputs never were.
        assert_eq!(study(&going_on, mission, &killed).status().unwrap().code(), Some(2));
    }
}

/// Rows of another seed, or of none of this, are refused and stay.
#[test]
fn rows_of_other_inputs_are_refused() {
    let out = tempfile::tempdir().unwrap();
    let kept = out.path().join("sobol_rows.csv");
    fs::write(&kept, "# {\"study\":\"sobol\"}\n1.0,2.0\n").unwrap();
    let output = study(&["sobol", "--points", "64", "--resume"], "tests/calm_x500.json", out.path())
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("sobol_rows.csv:1: these rows are of other inputs; expected `# {"), "{said}");
    assert!(fs::read_to_string(&kept).unwrap().ends_with("1.0,2.0\n"));
}

/// An old spelling is the new one, and says so in a line.
#[test]
fn old_spellings_fly_the_same_and_say_the_new_one() {
    let out = tempfile::tempdir().unwrap();
    let [old, new] = ["old", "new"].map(|name| out.path().join(name));
    let mission = "tests/calm_x500.json";
    let flown = Command::new(env!("CARGO_BIN_EXE_samara"))
        .args(["assess", mission, "--sobol=64", "--out"])
        .arg(&old)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&flown.stderr);
    assert_eq!(flown.status.code(), Some(0), "{said}");
    assert!(said.contains("samara: assess --sobol is now: samara study sobol --points\n"), "{said}");
    assert!(study(&["sobol", "--points", "64"], mission, &new).status().unwrap().success());
    assert!(files(&old) == files(&new));
}
