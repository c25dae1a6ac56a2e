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
