//! What was asked for is done or refused, and told apart; a flight that did not become steady is no success.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::{code, json, samara, spoilt_mission, stderr};

const X500: &str = "mission/x500_drop.json";
const MODEL: [&str; 2] = ["--autopilot", "px4-model"];

fn object(path: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// A mission whose vehicle is changed.
fn with_vehicle(folder: &Path, from: &str, to: &str) -> String {
    let shipped = format!("{}/params/vehicles/titan", fs::canonicalize(".").unwrap().display());
    let text = fs::read_to_string(format!("{shipped}.json")).unwrap();
    assert!(text.contains(from), "{from} is not in the vehicle");
    let text = text.replace(from, to).replace("\"titan_rotor", &format!("\"{shipped}_rotor"));
    fs::write(folder.join("vehicle.json"), text).unwrap();
    let mission = spoilt_mission(folder, "\"seed\": 1,", "\"seed\": 1,");
    let text = fs::read_to_string(&mission).unwrap().replace(&format!("{shipped}.json"), "vehicle.json");
    fs::write(&mission, text).unwrap();
    mission
}

fn refused(args: &[&str], words: &[&str]) {
    let output = samara(args);
    assert_eq!(code(&output), 2, "{args:?}: {}", stderr(&output));
    for word in words {
        assert!(stderr(&output).contains(word), "{args:?}: {word} not in {}", stderr(&output));
    }
}

/// Signing above all: who asks for it and does not get it must know.
#[test]
fn options_that_an_autopilot_has_not_got_are_refused() {
    // No build of PX4 is looked for before.
    let px4 = ["--autopilot", "px4=nowhere"];
    let reference = ["--autopilot", "reference"];
    let cases: [(&[&str], &[&str], &str); 11] = [
        (&px4, &["--sign-key", "nowhere", "--speed", "1"], "reference"),
        (&px4, &["--link", "tcpin:127.0.0.1:5999", "--speed", "1"], "reference"),
        (&px4, &["--estimator", "ekf"], "reference"),
        (&MODEL, &["--sign-key", "nowhere"], "reference"),
        (&MODEL, &["--link", "tcpin:127.0.0.1:5999"], "reference"),
        (&MODEL, &["--estimator", "ekf"], "reference"),
        (&MODEL, &["--speed", "1"], "reference or px4=DIR"),
        (&MODEL, &["--cpu", "0"], "px4=DIR"),
        (&reference, &["--cpu", "any"], "px4=DIR"),
        (&MODEL, &["--patience", "5"], "px4=DIR"),
        (&reference, &["--gains", "px4_default"], "px4=DIR or px4-model"),
    ];
    for (autopilot, options, expected) in cases {
        let words = [options[0], &format!("--autopilot {expected} is expected with it;")];
        refused(&[&["drop", X500], autopilot, options].concat(), &words);
    }
    let words = ["--gains px4_default", "--autopilot px4=DIR or px4-model is expected with it;"];
    refused(&["assess", X500, "--autopilot", "reference", "--gains", "px4_default"], &words);
    let words = ["--replan: --autopilot reference or px4=DIR is expected with it;"];
    refused(&["assess", X500, "--autopilot", "px4-model", "--replan"], &words);
    let words = ["--params: --gains is expected with --autopilot"];
    let params = ["--params", "params/px4/titan_px4.params"];
    refused(&[&["assess", X500, "--autopilot", "reference", "--replan"], &params[..]].concat(), &words);
    refused(&["assess", X500, "--estimator", "ekf"], &["--estimator: --autopilot is expected with it"]);
    refused(&["assess", X500, "--instance", "3"], &["--autopilot"]);
}

#[test]
fn the_hash_covers_who_flies_and_how() {
    let out = tempfile::tempdir().unwrap();
    let fly = |options: &[&str]| {
        let folder = ["drop", X500, "--json", "--out", out.path().to_str().unwrap()];
        let told = json(&samara(&[&folder, options].concat()));
        let manifest = object(&out.path().join("drop_manifest.json"));
        (told["input_hash"].as_str().unwrap().to_owned(), manifest["choices"].clone())
    };
    let flights = [
        fly(&[]),
        fly(&MODEL),
        fly(&[&MODEL[..], &["--feed-forward"]].concat()),
        fly(&[&MODEL[..], &["--gains", "px4_default"]].concat()),
        fly(&["--feed-forward"]),
    ];
    let mut hashes: Vec<&String> = flights.iter().map(|f| &f.0).collect();
    assert_eq!(flights[0].1, serde_json::json!({}), "what is the default is no choice");
    assert_eq!(flights[2].1, serde_json::json!({ "autopilot": "px4-model", "feed forward": "yes" }));
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), 5);
}

/// Without voltage no rotor turns: it falls, slowly in Titan's air, past no limit. Nor is a plan flown of
/// which half a second fits in.
#[test]
fn a_drop_that_does_not_become_steady_is_no_success() {
    let out = tempfile::tempdir().unwrap();
    let short = spoilt_mission(out.path(), "\"duration_s\": 45", "\"duration_s\": 11");
    let kept = out.path().join("short.json");
    fs::rename(short, &kept).unwrap();
    let weak = with_vehicle(out.path(), "\"voltage_max_v\": 140.0", "\"voltage_max_v\": 1e-6");
    let cut = "the mission's duration_s ended before the plan";
    let cases = [
        (weak.as_str(), true, "never steady within 0.0566 m/s of the target", "NOT STEADY"),
        (kept.to_str().unwrap(), false, cut, "11 s, ended before the plan did"),
    ];
    for (mission, completed, reason, words) in cases {
        let folder = out.path().join("results");
        let args = ["drop", mission, "--out", folder.to_str().unwrap()];
        let output = samara(&args);
        assert_eq!(code(&output), 1, "{}", stderr(&output));
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(said.contains(words), "{said}");
        let told = object(&folder.join("drop.json"));
        assert_eq!((&told["completed"], &told["reason"]), (&completed.into(), &reason.into()));
        assert_eq!(told["limits_passed"], serde_json::json!([]));
    }
}

/// Over the wire the first row of `--replan` is the campaign of whole drops, trial by trial, and nothing but
/// results is left.
#[test]
fn reference_drops_over_the_wire_are_those_of_the_campaign() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let wire = ["assess", X500, "--autopilot", "reference", "--trials", "2", "--out", folder];
    samara(&wire);
    let renewed = samara(&[&wire[..], &["--replan=release", "--json"]].concat());
    assert_eq!(code(&renewed), 0, "{}", stderr(&renewed));
    let told: serde_json::Value = serde_json::from_slice(&renewed.stdout).unwrap();
    assert_eq!(told["autopilot"], "reference");
    let last = told["campaigns"].as_array().unwrap().last().unwrap();
    assert_eq!((&last["renewed"], &last["kept"]), (&2.into(), &0.into()));
    let j_tpf = |file: &str, row: &str| -> Vec<String> {
        let text = fs::read_to_string(out.path().join(file)).unwrap();
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let place = lines.next().unwrap().split(',').position(|name| name == "j_tpf").unwrap();
        let cells = lines.map(|line| line.split(',').collect::<Vec<_>>());
        cells.filter(|cells| row.is_empty() || cells[1] == row).map(|cells| cells[place].to_owned()).collect()
    };
    assert_eq!(j_tpf("replan.csv", "once"), j_tpf("drops_reference_x500.csv", ""));
    assert_ne!(j_tpf("replan.csv", "release"), j_tpf("replan.csv", "once"));
    let entries = fs::read_dir(out.path()).unwrap().map(Result::unwrap);
    let folders: Vec<_> =
        entries.filter(|e| e.file_type().unwrap().is_dir()).map(|e| e.file_name()).collect();
    assert_eq!(folders, ["drops_reference_x500"], "the drops of the first campaign");
}

/// A swing and a side wind: it is the roll that comes nearest to a limit, and all that is told of the drop
/// says so.
#[test]
fn a_trial_alone_leaves_all_files_and_says_what_decides() {
    for (autopilot, files) in
        [("reference", &["companion.tlog", "flight.ulg", "hil.tlog", "vehicle.tlog"][..]), ("px4-model", &[])]
    {
        let out = tempfile::tempdir().unwrap();
        let folder = out.path().to_str().unwrap();
        let output = samara(&["assess", X500, "--autopilot", autopilot, "--only", "0", "--out", folder]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let trial = out.path().join("trial_0");
        let mut found: Vec<String> = fs::read_dir(&trial)
            .unwrap()
            .map(|e| e.unwrap().file_name().to_str().unwrap().to_owned())
            .collect();
        found.sort();
        let mut expected = [
            files,
            &["drop.html", "drop.json", "drop.svg", "drop_manifest.json", "flight.csv"],
            &["trajectory.csv"],
        ]
        .concat();
        expected.sort_unstable();
        assert_eq!(found, expected, "{autopilot}");
        let manifest = object(&trial.join("drop_manifest.json"));
        assert_eq!(manifest["circumstances"]["trial"], "0");
        assert_eq!(manifest["files"].as_object().unwrap().len(), found.len() - 1);
        if autopilot == "reference" {
            assert_eq!(object(&trial.join("drop.json"))["decided_by"], "speed");
            let figure = fs::read_to_string(trial.join("drop.svg")).unwrap();
            for words in ["pitch and roll [deg]", "pitch and roll rate [deg/s]", "east", "or roll rate."] {
                assert!(figure.contains(words), "{words}");
            }
            assert!(String::from_utf8_lossy(&output.stdout).contains("ok, decided by speed\n"));
        }
    }
}

/// MAVLink 2: a record is a stamp of 8 bytes and a frame, which tells its length, number and sender. A link's
/// numbers have no gaps.
#[test]
fn numbers_in_a_recording_have_no_gaps() {
    let out = tempfile::tempdir().unwrap();
    samara(&["drop", X500, "--out", out.path().to_str().unwrap()]);
    for (name, senders) in [("hil", 2), ("vehicle", 1), ("companion", 3)] {
        let bytes = fs::read(out.path().join(format!("{name}.tlog"))).unwrap();
        let (mut rest, mut last) = (&bytes[..], BTreeMap::new());
        while let Some(frame) = rest.get(8..) {
            assert_eq!((frame[0], frame[2]), (0xFD, 0), "{name}: an unsigned frame");
            let (number, sender) = (frame[4], (frame[5], frame[6]));
            if let Some(before) = last.insert(sender, number) {
                assert_eq!(number, u8::wrapping_add(before, 1), "{name}: of {sender:?}");
            }
            rest = &frame[usize::from(frame[1]) + 12..];
        }
        assert_eq!(last.len(), senders, "{name}");
    }
}

/// What the simulator reports of the drop is not repeated when the parachute's STATUSTEXT of it arrives, a
/// period of the control loop later with an older stamp.
#[test]
fn regress_a_limit_that_is_passed_has_one_line_in_the_order_of_time() {
    let out = tempfile::tempdir().unwrap();
    let root = fs::canonicalize(".").unwrap();
    let text = fs::read_to_string(X500).unwrap();
    let text = text.replace("\"../params", &format!("\"{}/params", root.display()));
    let mission = out.path().join("mission.json");
    assert!(text.contains("\"speed_m_s\": 20.0"));
    fs::write(&mission, text.replace("\"speed_m_s\": 20.0", "\"speed_m_s\": 8.0")).unwrap();
    let output =
        samara(&["drop", mission.to_str().unwrap(), "--out", out.path().join("results").to_str().unwrap()]);
    let said = String::from_utf8(output.stdout).unwrap();
    let stamps: Vec<f64> =
        said.lines().filter_map(|line| line.split_once(" s  ")?.0.trim().parse().ok()).collect();
    assert!(stamps.len() >= 6 && stamps.is_sorted(), "{said}");
    assert_eq!(said.to_lowercase().matches("limit passed: speed").count(), 1, "{said}");
}

/// Stamped lines are in order of time; when it was steady is known at the end and has no stamp.
#[test]
fn the_timeline_runs_forward() {
    let out = tempfile::tempdir().unwrap();
    let output = samara(&["drop", X500, "--out", out.path().to_str().unwrap()]);
    let said = String::from_utf8(output.stdout).unwrap();
    let stamps: Vec<f64> =
        said.lines().filter_map(|line| line.split_once(" s  ")?.0.trim().parse().ok()).collect();
    assert!(stamps.len() >= 6 && stamps.is_sorted(), "{said}");
    assert!(
        said.contains(
            "\nsteady after 2.34 s, from 17.840 s to the end: within 0.3 m/s of [2 0 1] m/s in the mean"
        ),
        "{said}"
    );
}

#[test]
fn cases_are_kept_in_one_table() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let output = samara(&["drop", "--cases", "--json", "--out", folder]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let kept = object(&out.path().join("cases.json"));
    let told = json(&output);
    assert_eq!(kept["cases"].as_array().unwrap().len(), 7);
    assert!(kept["cases"][0]["drop"].get("real_time_factor").is_none(), "no durations in files");
    let csv = fs::read_to_string(out.path().join("cases.csv")).unwrap();
    let rows: Vec<&str> = csv.lines().filter(|line| !line.starts_with('#')).collect();
    assert!(rows[0].starts_with("case,autopilot,j_tpf,") && rows.len() == 8, "{csv}");
    for (row, case) in rows[1..].iter().zip(told["cases"].as_array().unwrap()) {
        let expected = format!(
            "{},reference,{:?},",
            case["case"].as_str().unwrap(),
            case["drop"]["j_tpf"].as_f64().unwrap()
        );
        assert!(row.starts_with(&expected), "{row}: {expected}");
    }
    assert!(object(&out.path().join("cases_manifest.json"))["files"]["cases.csv"].is_string());
}

/// An option says itself what it expects, also of a number with a minus, which is no other option.
#[test]
fn numbers_that_do_not_suit_are_refused_with_what_is_expected() {
    let whole = "a whole number from ";
    for (args, words) in [
        (["assess", "--trials", "-5"], whole),
        (["assess", "--trials", "1.5"], whole),
        (["assess", "--only", "x"], whole),
        (["drop", "--seed", "-1"], whole),
        (["plan", "--nodes", "abc"], whole),
        (["tune", "--particles", "1.5"], whole),
        (["tune", "--rms-bound", "-1"], "a positive number is expected"),
        (["plan", "--terminal-tolerance", "-1"], " is expected"),
        (["drop", "--speed", "-1"], "a factor from 0.001 to 10000"),
    ] {
        refused(&args, &[args[1], args[2], words]);
    }
}

#[test]
fn files_that_do_not_suit_are_refused_with_what_is_expected() {
    let out = tempfile::tempdir().unwrap();
    let file = |text: &str| {
        let path = out.path().join("file.json");
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    refused(&["plan", &file("[]")], &["file.json:1:1: invalid type: a list, expected an object"]);
    refused(&["plan", &file(" \n")], &["file.json:1:1: the file is empty; a JSON object is expected"]);
    let spoilt = |from: &str, to: &str| spoilt_mission(out.path(), from, to);
    refused(
        &["plan", &spoilt("\"seed\": 1,", "\"seed\": -1,")],
        &["seed: ", "`-1`", "a whole number from 0 to"],
    );
    refused(
        &["drop", "--gains", "nosuch"],
        &[
            "nosuch.json",
            "expected one of dragonfly, hexa, hexa_drop, ideal_rms, near_hover, octo_drop, ours,",
        ],
    );
    // A byte order mark is no fault.
    let mission = spoilt("\"seed\": 1,", "\"seed\": 1,");
    fs::write(&mission, format!("\u{feff}{}", fs::read_to_string(&mission).unwrap())).unwrap();
    let output = samara(&["plan", &mission, "--out", out.path().join("marked").to_str().unwrap()]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    // What cannot be balanced names the vehicle's file.
    let mission = with_vehicle(out.path(), "\"mass_kg\": 790.0", "\"mass_kg\": 0.001");
    refused(
        &["plan", &mission, "--out", out.path().join("light").to_str().unwrap()],
        &["vehicle.json to target_v_ned_m_s [4 0 4]: the target velocity cannot be reached"],
    );
}

/// A value that is set is flown, and so said by manifest and command; the card is of the mission with it.
#[test]
fn what_is_set_is_flown_and_said() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let set = ["--set", "mass_kg=2.2kg", "--set", "limits.speed_m_s=30kt"];
    let drop = samara(
        &[&["drop", "tests/calm_x500.json", "--no-html", "--json", "--out", folder], &set[..]].concat(),
    );
    assert_eq!(code(&drop), 0, "{}", stderr(&drop));
    let plain =
        samara(&["drop", "tests/calm_x500.json", "--no-html", "--json", "--out", &format!("{folder}/plain")]);
    assert!(json(&drop)["input_hash"] != json(&plain)["input_hash"]);
    let faster =
        json(&drop)["peak_speed_m_s"].as_f64().unwrap() - json(&plain)["peak_speed_m_s"].as_f64().unwrap();
    assert!(faster > 0.001, "a heavier vehicle falls faster: {faster}");
    let choices = &object(&out.path().join("drop_manifest.json"))["choices"];
    assert_eq!(
        (&choices["set mass_kg"], &choices["set limits.speed_m_s"]),
        (&"2.2kg".into(), &"30kt".into())
    );
    let card = |set: &[&str]| {
        let card = samara(&[&["card", "tests/calm_x500.json", "--json", "--evidence", folder], set].concat());
        let evidence = json(&card)["evidence"][0].clone();
        (evidence["refused"].as_str().unwrap_or_default().to_owned(), json(&card)["reasons"].to_string())
    };
    let (refused, missing) = card(&set);
    assert_eq!(refused, "");
    assert!(missing.contains("--set mass_kg=2.2kg --set limits.speed_m_s=30kt"), "{missing}");
    assert!(card(&[]).0.contains("limits.speed_m_s=30kt, mass_kg=2.2kg set (--set)"), "{}", card(&[]).0);
    let checked = samara(&["check", "x500_drop", "--set", "limits.pich_deg=3"]);
    assert!(
        code(&checked) == 2 && stderr(&checked).contains("did you mean `pitch_deg`"),
        "{}",
        stderr(&checked)
    );
    let designed = samara(&["design", "x500_drop", "--set", "mass_kg=2.2"]);
    assert!(code(&designed) == 2 && stderr(&designed).contains("a key of the mission is expected"));
    let assessed = samara(&[
        "assess",
        "tests/calm_x500.json",
        "--set",
        "mass_kg=2.2",
        "--trials",
        "8",
        "--json",
        "--out",
        folder,
    ]);
    assert!(json(&assessed)["command"].as_str().unwrap().contains("--set mass_kg=2.2"));
    let bash = samara(&["completions", "bash"]);
    assert!(String::from_utf8_lossy(&bash.stdout).contains("limits.pitch_deg="));
}
