//! The model of PX4's control law beside PX4 itself, and as a user meets it. PX4's figures are those of v1.12.0, flown in lockstep
//! with `samara drop mission/x500_drop.json --autopilot px4=DIR --params FILE`.
#![cfg(feature = "cli")]
#![expect(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "a test that drives a program and reads its files"
)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const X500: &str = "mission/x500_drop.json";

fn samara(args: &[&str], out: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara")).args(args).arg("--out").arg(out).output().unwrap()
}

fn json(output: &Output) -> serde_json::Value {
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.stdout.is_empty(), "{error}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// PX4 as it comes, with its default gains; what the vehicle and the drop need is added.
const DEFAULTS: &str = "# For: px4\n1\t1\tMPC_XY_VEL_MAX\t20\t9\n";

/// J_TPF, peak speed [m/s], peak pitch [deg], altitude lost [m].
const JUDGED: [&str; 4] = ["j_tpf", "peak_speed_m_s", "peak_pitch_deg", "altitude_lost_m"];

#[test]
fn px4_flies_the_drop_as_predicted() {
    let folder = tempfile::tempdir().unwrap();
    let defaults = folder.path().join("defaults.params");
    fs::write(&defaults, DEFAULTS).unwrap();
    for (file, px4) in [
        (defaults.to_str().unwrap(), [0.4679, 9.36, 7.75, 15.0]),
        ("params/px4/x500_px4_tuned.params", [0.4678, 9.36, 6.99, 15.4]),
    ] {
        let out = folder.path().join("out");
        let flown =
            json(&samara(&["drop", X500, "--autopilot", "px4-model", "--params", file, "--json"], &out));
        for (name, px4) in JUDGED.into_iter().zip(px4) {
            let model = flown[name].as_f64().unwrap();
            assert!((model / px4 - 1.0).abs() < 0.1, "{file}: {name} {model}, PX4 {px4}");
        }
        assert_eq!(flown["limits_passed"], serde_json::json!([]));
        assert!(!out.join("hil.tlog").exists(), "there is no wire");
    }
}

#[test]
fn gains_for_px4_are_written_and_the_same_whatever_the_threads() {
    let folder = tempfile::tempdir().unwrap();
    let tune = |name: &str, threads: &str| {
        let args = ["tune", X500, "--for", "px4", "--iterations", "2", "--particles", "4", "--unseen", "4"];
        let out = folder.path().join(name);
        let output = samara(&[&args[..], &["--threads", threads, "--json"]].concat(), &out);
        (json(&output), fs::read_to_string(out.join("gains.params")).unwrap())
    };
    let (result, params) = tune("one", "1");
    assert_eq!((&result, &params), (&tune("two", "3").0, &tune("three", "2").1));
    assert_eq!(result["evaluations"], 10);
    assert!(params.contains("# For: px4\n") && params.contains("\tMC_PITCHRATE_P\t"), "{params}");
    let pitch_p = result["gains"]["MC_PITCH_P"].as_f64().unwrap();
    assert!((2.0..=12.0).contains(&pitch_p), "{result}");
    let checked = Command::new(env!("CARGO_BIN_EXE_samara"))
        .args(["params", "check", folder.path().join("one/gains.params").to_str().unwrap()])
        .output()
        .unwrap();
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stdout));
}

#[test]
fn what_has_no_meaning_for_px4_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for other in [
        &["--robust"][..],
        &["--method", "pso"],
        &["--method", "near-hover"],
        &["--objective", "rms"],
        &["--penalty", "7.5"],
        &["--swing", "1,2"],
        &["--stall", "5"],
        &["--start", "near_hover"],
    ] {
        let refused = samara(&[&["tune", X500, "--for", "px4"], other].concat(), folder.path());
        let error = String::from_utf8_lossy(&refused.stderr).into_owned();
        let named = error.contains(&format!("{} has no meaning with --for px4", other[0]));
        assert!(refused.status.code() == Some(2) && named, "{other:?}: {error}");
    }
}

/// A mission in another place, its files found where they are.
fn elsewhere(folder: &Path, change: impl FnOnce(&mut serde_json::Value)) -> String {
    let mut mission: serde_json::Value = serde_json::from_str(&fs::read_to_string(X500).unwrap()).unwrap();
    for key in ["vehicle", "gains"] {
        let path = fs::canonicalize(format!("mission/{}", mission[key].as_str().unwrap())).unwrap();
        mission[key] = path.to_str().unwrap().into();
    }
    change(&mut mission);
    let path = folder.join("elsewhere.json");
    fs::write(&path, mission.to_string()).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Under 9.78 m/s^2 PX4 flies as it is: a file that is exported for it there is the one that it takes.
#[test]
fn a_site_with_nearly_px4s_gravity_has_files_that_are_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let mission = elsewhere(folder.path(), |mission| mission["site"]["gravity_m_s2"] = 9.78.into());
    let file = folder.path().join("here.params");
    let file = file.to_str().unwrap();
    let exported = Command::new(env!("CARGO_BIN_EXE_samara"))
        .args(["params", "export", &mission, "--for", "px4", "--drop", "--out", file])
        .output()
        .unwrap();
    assert!(exported.status.success(), "{}", String::from_utf8_lossy(&exported.stderr));
    let fly = |more: &[&str]| {
        let args = ["drop", &mission, "--autopilot", "px4-model", "--json"];
        json(&samara(&[&args[..], more].concat(), &folder.path().join("out")))
    };
    let (by_file, by_gains) = (fly(&["--params", file]), fly(&[]));
    assert_eq!(by_file["completed"], true, "{by_file}");
    let ratio = by_file["j_tpf"].as_f64().unwrap() / by_gains["j_tpf"].as_f64().unwrap();
    assert!((ratio - 1.0).abs() < 1e-3, "{by_file} {by_gains}");
}

/// The model flies what PX4 flies: the same missions are refused, and in the same words.
#[test]
fn a_mission_that_px4_cannot_fly_is_not_predicted() {
    let folder = tempfile::tempdir().unwrap();
    let silent = elsewhere(folder.path(), |mission| mission["sensors"]["barometer"] = serde_json::json!({}));
    for (mission, words) in [("mission/titan_drop.json", "\"px4_clock\": \"froude\""), (&silent, "barometer")]
    {
        let refused = samara(&["drop", mission, "--autopilot", "px4-model"], folder.path());
        let error = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(2) && error.contains(words), "{error}");
    }
}

#[test]
fn a_parameter_file_is_checked_before_it_is_flown() {
    let folder = tempfile::tempdir().unwrap();
    let fly = |rows: &str| {
        let file = folder.path().join("rows.params");
        fs::write(&file, rows).unwrap();
        let args = ["drop", X500, "--autopilot", "px4-model", "--params", file.to_str().unwrap()];
        let output = samara(&args, folder.path());
        (output.status.code().unwrap(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    for (rows, code, words) in [
        ("1\t1\tMPC_XY_VEL_P_ACC\t500\t9\n", None, "MPC_XY_VEL_P_ACC = 500 1/s is outside PX4's range"),
        ("1\t1\tMC_PITCH_P\t4\t6\n", Some(2), "wrong type"),
        ("1\t1\tMC_PICH_P\t4\t9\n", Some(2), "none of PX4's parameters"),
        ("", Some(2), "none of PX4's parameters"),
        (
            "1\t1\tMC_PITCH_P\t6\t9\n1\t1\tEKF2_GPS_CHECK\t245\t6\n",
            Some(0),
            "EKF2_GPS_CHECK = 245 is not sent",
        ),
    ] {
        let (found, said) = fly(rows);
        assert!(said.contains(words), "{words}: {said}");
        assert!(code.is_none_or(|code| code == found), "{rows}: {found}");
    }
}
