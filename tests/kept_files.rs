//! Missions, vehicles, the rotor table and gains as version 0.1 shipped them load for ever, and mean what
//! they meant: the plan's objective, J_TPF and the time to steady flight are those recorded with them, to
//! the bit.
//!
//! The files in `tests/data/v0.1` never change. A change of the planner's arithmetic that is made on purpose
//! may record new numbers, in a commit of its own, within 1e-9 relative of the old ones and the time to
//! steady flight within one control step: `SAMARA_RECORD=1 cargo test --test integration kept_files`.
#![cfg(feature = "cli")]

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

const FOLDER: &str = "tests/data/v0.1";

/// A verb's answer for a mission of the folder.
fn samara(verb: &str, mission: &str, more: &[&str]) -> Value {
    let out = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_samara"))
        .args([verb, &format!("{FOLDER}/mission/{mission}.json"), "--json", "--out"])
        .arg(out.path())
        .args(more)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{verb} {mission} {more:?}: {said}"))
}

/// Numbers of the plan, and of the drop with each of `gains`.
fn numbers(mission: &str, gains: &[&str]) -> Value {
    let plan = samara("plan", mission, &[]);
    let drops: Vec<Value> = gains
        .iter()
        .map(|gains| {
            let drop = samara("drop", mission, &["--gains", gains]);
            json!({ "gains": gains, "j_tpf": drop["j_tpf"], "steady_after_s": drop["steady_after_s"] })
        })
        .collect();
    json!({ "mission": mission, "objective": plan["objective"], "drops": drops })
}

/// JSON keeps every bit of a number here: the shortest decimal that reads back as that number.
#[test]
fn regress_files_of_version_0_1_mean_what_they_meant() {
    let titan = ["ours", "safety", "near_hover", "paper_pso", "ideal_rms"];
    let found = json!([
        numbers("titan_drop", &titan),
        numbers("titan_px4", &["ours"]),
        numbers("x500_drop", &["x500", "x500_hover"]),
        // It starts on its legs: there is no drop.
        numbers("x500_ground", &[]),
    ]);
    let record = Path::new(FOLDER).join("numbers.json");
    if std::env::var_os("SAMARA_RECORD").is_some() {
        fs::write(&record, format!("{found:#}\n")).unwrap();
    }
    let recorded: Value = serde_json::from_slice(&fs::read(&record).unwrap()).unwrap();
    assert_eq!(found, recorded);
}
