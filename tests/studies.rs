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
        ("effects", "x500_drop", &["effects", "--trials", "12"], 40),
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
    assert!(
        said.contains("sobol_rows.csv:1: these rows are of another study: version was nothing, is "),
        "{said}"
    );
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

/// Studies of one round and of several, in three shards, one of which is killed and one damaged: what `merge`
/// writes is, to the byte, what one process writes.
#[cfg(feature = "shards")]
#[test]
fn prop_a_study_in_shards_ends_in_the_same_bytes() {
    let samara = |words: &[&str], out: &Path| {
        Command::new(env!("CARGO_BIN_EXE_samara")).args(words).arg(out).output().unwrap()
    };
    for (mission, kind) in [
        ("tests/calm_x500.json", &["envelope", "--pairs", "wind:delay", "--rays", "4"][..]),
        ("tests/calm_x500.json", &["sobol", "--points", "64"]),
        ("x500_drop", &["effects", "--trials", "8", "--set", "limits.pitch_deg=44"]),
        (
            "tests/calm_x500.json",
            &[
                "replan",
                "--when",
                "release",
                "--trials",
                "2",
                "--autopilot",
                "reference",
                "--estimator",
                "ekf",
            ],
        ),
    ] {
        let out = tempfile::tempdir().unwrap();
        let [whole, apart] = ["whole", "apart"].map(|name| out.path().join(name));
        let code = study(kind, mission, &whole).status().unwrap().code();
        let shards = apart.join("shards");
        let mut rounds = 0;
        let merged = loop {
            for cut in ["2/3", "0/3", "1/3"] {
                let of_part = [kind, &["--shard", cut]].concat();
                if cut == "0/3" {
                    let mut killed = study(&of_part, mission, &apart).spawn().unwrap();
                    std::thread::sleep(Duration::from_millis(40));
                    killed.kill().unwrap();
                    killed.wait().unwrap();
                }
                assert_eq!(study(&of_part, mission, &apart).status().unwrap().code(), Some(0));
                if cut == "2/3" && rounds == 0 {
                    let name = shards.join("000000000-00002-of-00003.rows");
                    let text = fs::read(&name).unwrap();
                    fs::write(&name, &text[..text.len() - 2]).unwrap();
                    let missing = samara(&["merge", "--missing"], &apart);
                    assert_eq!(String::from_utf8_lossy(&missing.stdout), "0-2\n");
                    assert_eq!(study(&of_part, mission, &apart).status().unwrap().code(), Some(0));
                    assert!(fs::read(&name).unwrap() == text);
                }
            }
            rounds += 1;
            let merged = samara(&["merge"], &apart);
            if merged.status.code() == code {
                break merged;
            }
            let said = String::from_utf8_lossy(&merged.stderr);
            assert!(
                merged.status.code() == Some(2) && said.contains("shards 0-2 of 3 are missing"),
                "{said}"
            );
            assert!(rounds < 9, "{said}");
        };
        assert!(String::from_utf8_lossy(&merged.stdout).contains("results in "));
        assert!(files(&whole) == files(&apart), "{kind:?}: {:?}", files(&apart).keys());
        // Another seed is another study.
        let other = [kind, &["--shard", "0/3", "--seed", "77"]].concat();
        let refused = study(&other, mission, &apart).stderr(Stdio::piped()).output().unwrap();
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(
            refused.status.code() == Some(2) && said.contains("another study is flown in this folder"),
            "{said}"
        );
    }
}
