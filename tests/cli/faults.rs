//! Faults as a user meets them: listed, flown, named in results, refused where they cannot act.

use std::fs;
use std::path::Path;

use super::{code, json, samara, spoilt_mission, stderr};

fn with_faults(folder: &Path, faults: &str) -> String {
    spoilt_mission(folder, "\"seed\": 1,", &format!("\"seed\": 1, \"faults\": {faults},"))
}

fn drop(folder: &Path, faults: &str, more: &[&str]) -> std::process::Output {
    let mission = with_faults(folder, faults);
    let out = folder.join("out");
    let mut args = vec!["drop", &mission, "--json", "--no-html", "--out", out.to_str().unwrap()];
    args.extend(more);
    samara(&args)
}

/// Every fault of the list stands in docs/faults.md, and in the mission's schema.
#[test]
fn the_list_the_page_and_the_schema_name_the_same_faults() {
    let listed = json(&samara(&["faults", "--json"]));
    let table = String::from_utf8(samara(&["faults"]).stdout).unwrap();
    let page = fs::read_to_string("docs/faults.md").unwrap();
    let schema: serde_json::Value =
        serde_json::from_str(&fs::read_to_string("params/schema/mission.schema.json").unwrap()).unwrap();
    let kinds = schema["$defs"]["KindJson"]["oneOf"].as_array().unwrap();
    let name = |kind: &serde_json::Value| match kind["const"].as_str() {
        Some(name) => name.to_owned(),
        None => kind["required"][0].as_str().unwrap().to_owned(),
    };
    let mut in_schema: Vec<String> = kinds.iter().map(name).collect();
    let faults = listed["faults"].as_array().unwrap();
    let mut names: Vec<&str> = faults.iter().map(|fault| fault["name"].as_str().unwrap()).collect();
    for name in &names {
        assert!(page.contains(&format!("`{name}`")), "{name} is not in docs/faults.md");
        assert!(table.lines().any(|line| line.split_whitespace().next() == Some(name)), "{name}");
    }
    for fault in faults {
        for key in fault["keys"].as_array().unwrap() {
            assert!(page.contains(&format!("`{}`", key.as_str().unwrap())), "{key}");
        }
    }
    names.sort_unstable();
    in_schema.sort_unstable();
    assert_eq!(names, in_schema);
    assert!(table.lines().all(|line| line.len() <= 100), "{table}");
}

#[test]
fn a_rotor_that_fails_is_told_in_events_and_results() {
    let place = tempfile::tempdir().unwrap();
    let output =
        drop(place.path(), r#"{ "list": [{ "fault": { "motor_off": { "rotor": 2 } }, "at_s": 3 }] }"#, &[]);
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    let flown = json(&output);
    let fault = &flown["faults"][0];
    assert_eq!((&fault["name"], &fault["by"]), (&"motor_off".into(), &"mission".into()));
    assert_eq!((&fault["text"], &fault["from_s"]), (&"rotor 2 off".into(), &13.5.into()));
    assert!(fault["until_s"].is_null());
    let events = flown["events"].as_array().unwrap();
    assert!(events.iter().any(|e| e["text"] == "fault: rotor 2 off" && e["t_s"] == 13.5), "{events:?}");
    let kept = fs::read_to_string(place.path().join("out/drop.json")).unwrap();
    let last = kept.lines().rfind(|line| line.starts_with("  \"")).unwrap();
    assert_eq!(last, "  \"faults\": [", "at the end");
}

#[test]
fn a_parachute_that_holds_is_no_success_by_any_autopilot() {
    let holds = r#"{ "list": [{ "fault": "parachute_holds", "at_s": -10.5 }] }"#;
    let place = tempfile::tempdir().unwrap();
    let output = drop(place.path(), holds, &[]);
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    let flown = json(&output);
    assert_eq!(flown["reason"], "the vehicle was never released");
    assert_eq!(flown["faults"][0]["name"], "parachute_holds");
}

#[test]
fn a_model_without_a_wire_flies_what_it_can_and_refuses_the_rest() {
    let x500 = |folder: &Path, fault: &str| {
        let root = fs::canonicalize(".").unwrap();
        let text = fs::read_to_string("mission/x500_drop.json").unwrap();
        let faults = format!(r#""seed": 1, "faults": {{ "list": [{{ "fault": {fault}, "at_s": -15 }}] }},"#);
        let text = text.replace("\"../params", &format!("\"{}/params", root.display()));
        let path = folder.join("x500.json");
        fs::write(&path, text.replace("\"seed\": 1,", &faults)).unwrap();
        let (path, out) = (path.to_str().unwrap().to_owned(), folder.join("out"));
        let model = ["--autopilot", "px4-model", "--no-html", "--json", "--out", out.to_str().unwrap()];
        samara(&[&["drop", &path], &model[..]].concat())
    };
    let place = tempfile::tempdir().unwrap();
    let refused = x500(place.path(), "\"gps_off\"");
    assert_eq!(code(&refused), 2);
    for words in ["faults.list[0].fault: gps_off", "--autopilot reference --estimator ekf"] {
        assert!(stderr(&refused).contains(words), "{}", stderr(&refused));
    }
    let late = json(&x500(place.path(), r#"{ "late_release": { "delay_s": 0.25 } }"#));
    assert_eq!(late["faults"][0]["text"], "release 0.25 s late");
    assert_eq!(late["events"][0]["text"], "fault: release 0.25 s late");
}

#[test]
fn flights_from_t_0_have_motor_faults_alone() {
    let place = tempfile::tempdir().unwrap();
    let out = place.path().join("out");
    let assess = |faults: &str| {
        let mission = with_faults(place.path(), faults);
        let args =
            ["assess", &mission, "--trials", "2", "--json", "--no-html", "--out", out.to_str().unwrap()];
        samara(&args)
    };
    let refused = assess(r#"{ "list": [{ "fault": "setpoint_loss", "at_s": 1 }] }"#);
    assert_eq!(code(&refused), 2);
    for words in ["faults.list[0].fault: setpoint_loss", "samara assess --autopilot reference"] {
        assert!(stderr(&refused).contains(words), "{}", stderr(&refused));
    }
    let unsafe_all = assess(r#"{ "list": [{ "fault": { "motor_off": { "rotor": 1 } }, "at_s": 0 }] }"#);
    assert_eq!(code(&unsafe_all), 1, "{}", stderr(&unsafe_all));
}

/// Sensors do not touch an autopilot that flies by the truth, and that is said.
#[test]
fn a_fault_that_the_autopilot_does_not_feel_is_remarked_on() {
    let off = r#"{ "list": [{ "fault": "gyro_off", "at_s": 3 }] }"#;
    let place = tempfile::tempdir().unwrap();
    let output = drop(place.path(), off, &[]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stderr(&output).contains("gyro_off: the autopilot flies by the simulator's truth"));
    let output = drop(place.path(), off, &["--estimator", "ekf"]);
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    assert!(!stderr(&output).contains("simulator's truth"));
}
