//! `samara fidelity` by the program: a campaign held against its own first trials is equal to them, and what
//! is no campaign of the mission, or the same one twice, is refused.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn samara(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara")).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The source of truth is the campaign itself: with its first trials as the most faithful way its mean is
/// that of all of them, with a correlation of 1 and a margin of 0.
#[test]
fn closed_form_a_campaign_against_its_first_trials() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let mission = Path::new("mission/x500_drop.json").to_str().unwrap();
    let drops = ["assess", mission, "--autopilot", "px4-model", "--trials", "40", "--out", out];
    assert!(samara(&drops).status.success());
    let lines = folder.path().join("drops_px4-model_x500_px4_tuned.csv");
    let all = fs::read_to_string(&lines).unwrap();
    let first = folder.path().join("first.csv");
    // Comments, the names of the columns and 32 trials.
    let comments = all.lines().take_while(|line| line.starts_with('#')).count();
    let some: Vec<&str> = all.lines().take(comments + 1 + 32).collect();
    fs::write(&first, some.join("\n") + "\n").unwrap();
    let [by, of] = [&first, &lines].map(|path| path.to_str().unwrap());
    let found =
        samara(&["fidelity", mission, "--by", by, "--by", of, "--calibrate", "20", "--out", out, "--json"]);
    assert!(found.status.success(), "{}", text(&found.stderr));
    let json: serde_json::Value = serde_json::from_slice(&found.stdout).unwrap();
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(all.as_bytes());
    let place = reader.headers().unwrap().iter().position(|name| name == "j_tpf").unwrap();
    let j_tpf: Vec<f64> = reader.records().map(|row| row.unwrap()[place].parse().unwrap()).collect();
    let mean = j_tpf.iter().sum::<f64>() / 40.0;
    let helped = json["quantities"][0]["mean"]["with_the_others"]["mean"].as_f64().unwrap();
    assert!(j_tpf.len() == 40 && (helped - mean).abs() < 1e-9 * mean, "{helped} {mean}");
    for quantity in json["quantities"].as_array().unwrap() {
        let agreement = &quantity["mean"]["agreements"][0];
        assert!((agreement["correlation"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{quantity}");
        assert_eq!((&agreement["shared"], &agreement["value_in_one"]), (&32.into(), &0.into()));
        let bound = &quantity["bound"];
        assert_eq!(
            (&bound["margin"], &bound["fresh"], &bound["held"]),
            (&0.0.into(), &12.into(), &12.into())
        );
    }
    for name in ["fidelity.txt", "fidelity.json", "fidelity.svg", "fidelity_manifest.json"] {
        assert!(folder.path().join(name).is_file(), "{name}");
    }
    let refused = |arguments: &[&str], words: &str| {
        let refused = samara(&[&["fidelity", mission], arguments].concat());
        let said = text(&refused.stderr);
        assert!(refused.status.code() == Some(2) && said.contains(words), "{said}");
    };
    refused(&["--by", by, "--by", of, "--seed", "2"], "another seed: 1, expected 2");
    refused(&["--by", by], "at least two campaigns");
    refused(&["--by", by, "--by", of, "--by", by], "another campaign than that of");
    refused(&["--by", by, "--by", of, "--calibrate", "33"], "at most the 32 trials that both");
}
