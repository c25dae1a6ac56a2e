//! `samara replay` as a user meets it: what is true is the flight that was recorded.

use std::fs;
use std::path::Path;

use super::{code, json, samara, stderr};

const X500: &str = "mission/x500_drop.json";

fn replayed(folder: &Path, more: &[&str]) -> std::process::Output {
    let recording = folder.to_str().unwrap();
    samara(&[&["replay", recording], more].concat())
}

/// A drop, a trial that a campaign kept, and a drop under PX4's clock are flown again to the last digit.
#[test]
fn recorded_drops_are_flown_again() {
    let out = tempfile::tempdir().unwrap();
    let place = out.path().to_str().unwrap();
    let flown = samara(&["drop", X500, "--no-html", "--out", place]);
    assert_eq!(code(&flown), 0, "{}", stderr(&flown));
    let again = replayed(out.path(), &[X500, "--json"]);
    assert_eq!(code(&again), 0, "{}", stderr(&again));
    let told = json(&again);
    assert_eq!((&told["difference"], &told["truth"]["equal"]), (&serde_json::Value::Null, &true.into()));
    assert!(told["equal_messages"].as_u64().unwrap() > 15_000, "{told}");
    assert!(out.path().join("replay/drop.html").exists(), "the flight is written");
    let [a, b] = ["drop.json", "replay/drop.json"].map(|name| {
        let text = fs::read_to_string(out.path().join(name)).unwrap();
        serde_json::from_str::<serde_json::Value>(&text).unwrap()
    });
    for key in ["j_tpf", "steady_after_s", "safe", "altitude_lost_m"] {
        assert_eq!(a[key], b[key], "{key}");
    }

    let trial = out.path().join("campaign");
    let campaign = trial.to_str().unwrap();
    samara(&["assess", X500, "--autopilot", "reference", "--only", "7", "--out", campaign]);
    let again = replayed(&trial.join("trial_7"), &[X500, "--trial", "7"]);
    assert_eq!(code(&again), 0, "{}", stderr(&again));
    let other = replayed(&trial.join("trial_7"), &[X500, "--trial", "8"]);
    assert_eq!(code(&other), 1, "{}", stderr(&other));
    assert!(String::from_utf8_lossy(&other.stdout).contains("was recorded (record "), "{other:?}");

    let titan = out.path().join("titan");
    samara(&["drop", "mission/titan_px4.json", "--out", titan.to_str().unwrap()]);
    let again = replayed(&titan, &["mission/titan_px4.json"]);
    assert_eq!(code(&again), 0, "{}", stderr(&again));
}

/// A truth that was changed is named by line and column; a recording that is cut, is none, or is not there,
/// by its place.
#[test]
fn what_is_not_the_recorded_flight_is_named() {
    let out = tempfile::tempdir().unwrap();
    samara(&["drop", X500, "--out", out.path().to_str().unwrap()]);
    let truth = out.path().join("flight.csv");
    let text = fs::read_to_string(&truth).unwrap();
    let line = text.lines().nth(5000).unwrap();
    let (t_s, rest) = line.split_once(',').unwrap();
    fs::write(&truth, text.replace(line, &format!("{t_s},9{rest}"))).unwrap();
    let differs = replayed(out.path(), &[X500]);
    assert_eq!(code(&differs), 1, "{}", stderr(&differs));
    let told = String::from_utf8_lossy(&differs.stdout).into_owned();
    assert!(told.contains(&format!("first in line 5001, at {t_s} s: ")), "{told}");

    let recording = out.path().join("hil.tlog");
    let bytes = fs::read(&recording).unwrap();
    let cases: [(&[u8], &str); 3] = [
        (&bytes[..bytes.len() - 5], "the file ends inside it"),
        (b"not a recording at all", "record 1, at byte 0: expected a MAVLink frame"),
        (b"", "no message of a simulator in the recording"),
    ];
    for (bytes, words) in cases {
        fs::write(&recording, bytes).unwrap();
        let refused = replayed(out.path(), &[X500]);
        assert_eq!(code(&refused), 2, "{words}");
        assert!(
            stderr(&refused).contains("hil.tlog") && stderr(&refused).contains(words),
            "{}",
            stderr(&refused)
        );
    }
    fs::remove_file(&recording).unwrap();
    let refused = replayed(out.path(), &[X500]);
    assert_eq!(code(&refused), 2);
    assert!(stderr(&refused).contains("hil.tlog: no such file"), "{}", stderr(&refused));
}
