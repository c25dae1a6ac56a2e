//! `samara fidelity` by the program: a campaign held against itself is equal to itself, and what is no
//! campaign of the mission is refused.

use std::path::Path;
use std::process::{Command, Output};

fn samara(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara")).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The source of truth is the campaign itself: its mean, a correlation of 1, a margin of 0.
#[test]
fn closed_form_a_campaign_against_itself() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let mission = Path::new("mission/x500_drop.json").to_str().unwrap();
    let drops = ["assess", mission, "--autopilot", "px4-model", "--trials", "40", "--out", out];
    assert!(samara(&drops).status.success());
    let lines = folder.path().join("drops_px4-model_x500_px4_tuned.csv");
    let by = lines.to_str().unwrap();
    let found = samara(&["fidelity", mission, "--by", by, "--by", by, "--out", out, "--json"]);
    assert!(found.status.success(), "{}", text(&found.stderr));
    let json: serde_json::Value = serde_json::from_slice(&found.stdout).unwrap();
    for quantity in json["quantities"].as_array().unwrap() {
        let mean = &quantity["mean"];
        let [alone, helped] = ["alone", "with_the_others"].map(|way| mean[way]["mean"].as_f64().unwrap());
        assert!((alone - helped).abs() < 1e-9 * alone.abs(), "{quantity}");
        assert!((mean["agreements"][0]["correlation"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{quantity}");
        let bound = &quantity["bound"];
        assert_eq!(
            (&bound["margin"], &bound["fresh"], &bound["held"]),
            (&0.0.into(), &20.into(), &20.into())
        );
    }
    for name in ["fidelity.txt", "fidelity.json", "fidelity.svg", "fidelity_manifest.json"] {
        assert!(folder.path().join(name).is_file(), "{name}");
    }
    let refused = samara(&["fidelity", mission, "--by", by, "--by", by, "--seed", "2"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("another seed: 1, expected 2"), "{}", text(&refused.stderr));
    let alone = samara(&["fidelity", mission, "--by", by]);
    assert!(alone.status.code() == Some(2) && text(&alone.stderr).contains("at least two campaigns"));
}
