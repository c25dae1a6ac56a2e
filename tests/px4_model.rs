//! The model of PX4's control law beside PX4 itself, and as a user meets it. PX4's figures are those of
//! v1.12.0, flown in lockstep with `samara drop MISSION --autopilot px4=DIR` and the same options; the
//! quadrotor's with the files of version 0.1, whose rotors know no flow.
#![cfg(feature = "cli")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const X500: &str = "mission/x500_drop.json";
/// One release to be tuned for.
const QUICK: &str = "tests/data/one_release.json";

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

/// What is compared, and how near: altitude, speed and J_TPF are mostly the fall's, the rest is the law's.
/// PX4's own time to steady flight was 4.93 to 5.90 s in three drops with its defaults, its peak pitch 7.6 to
/// 8.4 deg.
const JUDGED: [(&str, f64); 5] = [
    ("j_tpf", 0.05),
    ("peak_speed_m_s", 0.02),
    ("peak_pitch_deg", 0.1),
    ("altitude_lost_m", 0.02),
    ("steady_after_s", 0.15),
];
const VELOCITY_RMS_WITHIN: f64 = 0.05;

/// RMS of the velocity's distance from its setpoint over the plan [m/s], from flight.csv.
fn velocity_rms_m_s(out: &Path, plan_end_s: f64) -> f64 {
    let text = fs::read_to_string(out.join("flight.csv")).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at = |name: &str| names.iter().position(|n| *n == name).unwrap();
    let t = at("t_powered_s");
    let pairs = [("vn_m_s", "vn_sp_m_s"), ("ve_m_s", "ve_sp_m_s"), ("vd_m_s", "vd_sp_m_s")];
    let pairs = pairs.map(|(v, v_sp)| (at(v), at(v_sp)));
    let (mut sum, mut count) = (0.0, 0u32);
    for line in lines {
        let row: Vec<Option<f64>> = line.split(',').map(|x| x.parse().ok()).collect();
        let off = pairs.map(|(v, v_sp)| Some(row[v]? - row[v_sp]?));
        if row[t].is_some_and(|t| (0.0..=plan_end_s).contains(&t))
            && let [Some(n), Some(e), Some(d)] = off
        {
            sum += n * n + e * e + d * d;
            count += 1;
        }
    }
    (sum / f64::from(count)).sqrt()
}

/// The files of version 0.1, as PX4 flew them.
const KEPT: &str = "tests/data/v0.1";

/// PX4's defaults and tuned gains on Earth; tuned gains on Titan, k = 2.695, from a case with a swing.
#[test]
fn px4_flies_the_drop_as_predicted() {
    let folder = tempfile::tempdir().unwrap();
    let defaults = folder.path().join("defaults.params");
    fs::write(&defaults, DEFAULTS).unwrap();
    let defaults = ["--params", defaults.to_str().unwrap()];
    let tuned = format!("{KEPT}/params/px4/x500_px4_tuned.params");
    let tuned = ["--params", &tuned];
    let x500 = format!("{KEPT}/{X500}");
    let titan = format!("{KEPT}/mission/titan_px4.json");
    for (mission, options, plan_end_s, px4, px4_rms_m_s) in [
        (&*x500, defaults, 5.0, [0.4680, 9.36, 8.39, 14.97, 5.70], 0.692),
        (&*x500, tuned, 5.0, [0.4680, 9.36, 6.78, 15.3, 1.82], 0.420),
        (&*titan, ["--case", "case_4"], 30.0, [0.5822, 6.686, 26.2, 147.1, 31.47], 0.282),
    ] {
        let out = folder.path().join("out");
        let common = ["drop", mission, "--autopilot", "px4-model", "--json"];
        let flown = json(&samara(&[&common[..], &options].concat(), &out));
        for ((name, within), px4) in JUDGED.into_iter().zip(px4) {
            let model = flown[name].as_f64().unwrap();
            assert!((model / px4 - 1.0).abs() < within, "{options:?}: {name} {model}, PX4 {px4}");
        }
        let rms_m_s = velocity_rms_m_s(&out, plan_end_s);
        let ratio = rms_m_s / px4_rms_m_s;
        assert!((ratio - 1.0).abs() < VELOCITY_RMS_WITHIN, "{options:?}: {rms_m_s}, PX4 {px4_rms_m_s}");
        assert_eq!(flown["limits_passed"], serde_json::json!([]));
        assert!(!out.join("hil.tlog").exists(), "there is no wire");
    }
}

#[test]
fn gains_for_px4_are_written_and_the_same_whatever_the_threads() {
    let folder = tempfile::tempdir().unwrap();
    let tune = |name: &str, threads: &str| {
        let args = ["tune", QUICK, "--for", "px4", "--px4-version", "v1.12"];
        let args = [&args[..], &["--iterations", "2", "--particles", "4", "--unseen", "4"]].concat();
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

/// A mission in another place, its files found where they are. It names no file for PX4.
fn elsewhere(folder: &Path, change: impl FnOnce(&mut serde_json::Value)) -> String {
    let mut mission: serde_json::Value = serde_json::from_str(&fs::read_to_string(X500).unwrap()).unwrap();
    for key in ["vehicle", "gains"] {
        let path = fs::canonicalize(format!("mission/{}", mission[key].as_str().unwrap())).unwrap();
        mission[key] = path.to_str().unwrap().into();
    }
    mission.as_object_mut().unwrap().remove("px4_params");
    change(&mut mission);
    let path = folder.join("elsewhere.json");
    fs::write(&path, mission.to_string()).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Properties of a version that is asked for: it is named in the results, its flight is its own, the number
/// may be written in full, and v1.12 is what flies where nothing is asked for.
#[test]
fn the_law_of_a_version_flies_where_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let fly = |autopilot: &str| {
        let mut found =
            json(&samara(&["drop", X500, "--autopilot", autopilot, "--json"], &folder.path().join("out")));
        for timed in ["plan_solve_ms", "real_time_factor"] {
            found.as_object_mut().unwrap().remove(timed);
        }
        found
    };
    let [unasked, v1_12, v1_14, v1_16, in_full] =
        ["px4-model", "px4-model=1.12", "px4-model=v1.14", "px4-model=v1.16", "px4-model=1.16.0"].map(fly);
    assert_eq!(unasked, v1_12);
    assert_eq!(v1_16, in_full);
    assert_eq!(
        (&unasked["autopilot_version"], &v1_14["autopilot_version"]),
        (&serde_json::Value::Null, &"v1.14".into())
    );
    assert_eq!((&v1_16["autopilot"], &v1_16["autopilot_version"]), (&"px4-model".into(), &"v1.16".into()));
    for (older, newer) in [(&v1_12, &v1_14), (&v1_14, &v1_16)] {
        assert_ne!(older["peak_pitch_rate_deg_s"], newer["peak_pitch_rate_deg_s"]);
        assert!(newer["limits_passed"].as_array().unwrap().is_empty() && newer["steady_after_s"].is_number());
    }
}

/// A mission that names a file for PX4 flies it where nothing is chosen, as if it had been; chosen gains come
/// before it. All that
/// `params export --drop` writes is of that file then.
#[test]
fn the_file_that_a_mission_names_for_px4_is_flown() {
    let folder = tempfile::tempdir().unwrap();
    let fly = |more: &[&str]| {
        let args = ["drop", X500, "--autopilot", "px4-model", "--json"];
        json(&samara(&[&args[..], more].concat(), &folder.path().join("out")))
    };
    let named = "params/px4/x500_px4_tuned.params";
    let (unchosen, chosen, gains) = (fly(&[]), fly(&["--params", named]), fly(&["--gains", "x500"]));
    for key in ["gains", "input_hash", "j_tpf", "peak_tilt_deg", "steady_after_s"] {
        assert_eq!(unchosen[key], chosen[key], "{key}");
    }
    assert_eq!((&unchosen["gains"], &gains["gains"]), (&"x500_px4_tuned.params".into(), &"x500".into()));
    assert_ne!(unchosen["steady_after_s"], gains["steady_after_s"]);

    let exported = folder.path().join("drop.params");
    let args = ["params", "export", X500, "--for", "px4", "--drop", "--out", exported.to_str().unwrap()];
    let output = Command::new(env!("CARGO_BIN_EXE_samara")).args(args).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (file, exported) = (fs::read_to_string(named).unwrap(), fs::read_to_string(exported).unwrap());
    for name in ["MPC_XY_VEL_P_ACC", "MPC_TILTMAX_LND", "MC_PITCHRATE_P"] {
        let line = file.lines().find(|line| line.contains(&format!("\t{name}\t"))).unwrap();
        assert!(exported.lines().any(|l| l == line), "{line}\n{exported}");
    }
    assert!(exported.contains("\tCOM_DISARM_PRFLT\t"), "{exported}");

    let lost = elsewhere(folder.path(), |mission| mission["px4_params"] = "nowhere.params".into());
    let refused = samara(&["drop", &lost, "--autopilot", "px4-model"], folder.path());
    let error = String::from_utf8_lossy(&refused.stderr).into_owned();
    let words = "elsewhere.json: px4_params: cannot read parameter file";
    assert!(refused.status.code() == Some(2) && error.contains(words), "{error}");
    // Whom it is not for does not miss it.
    let reference = samara(&["drop", &lost], &folder.path().join("out"));
    assert_eq!(reference.status.code(), Some(0), "{}", String::from_utf8_lossy(&reference.stderr));
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

/// A mission whose cascade scales by its battery and says what its tilt comes from asks PX4 for the same: by
/// its gains and by their exported file alike. Where PX4 has no counterpart it is refused by its name.
#[test]
fn battery_and_tilt_are_those_of_the_mission() {
    let folder = tempfile::tempdir().unwrap();
    let with_battery = |tilt_from: &str, scales: bool| {
        elsewhere(folder.path(), |mission| {
            let airy = fs::read_to_string("mission/x500_drop.json").unwrap();
            mission["battery"] = serde_json::from_str::<serde_json::Value>(&airy).unwrap()["battery"].take();
            mission["control"]["battery_scaling"] = scales.into();
            mission["control"]["tilt_from"] = tilt_from.into();
        })
    };
    let log = |name: &str| {
        let text = fs::read_to_string(folder.path().join(name).join("flight.csv")).unwrap();
        let rows: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
        rows.join("\n")
    };
    let fly = |mission: &str, name: &str, more: &[&str]| {
        let args = ["drop", mission, "--autopilot", "px4-model=v1.14"];
        let output = samara(&[&args[..], more].concat(), &folder.path().join(name));
        assert!(folder.path().join(name).is_dir(), "{}", String::from_utf8_lossy(&output.stderr));
        log(name)
    };
    let export = |mission: &str, more: &[&str]| {
        let args = ["params", "export", mission, "--for", "px4"];
        samara(&[&args[..], more].concat(), Path::new("-"))
    };
    let mission = with_battery("gravity", true);
    let text = String::from_utf8(export(&mission, &["--px4-version", "v1.14"]).stdout).unwrap();
    for row in ["MC_BAT_SCALE_EN\t1\t6", "BAT1_N_CELLS\t4\t6"] {
        assert!(text.contains(&format!("\t{row}\n")), "{row} in {text}");
    }
    // v1.14 has no such parameter, and sets the tilt against gravity.
    assert!(!text.contains("MPC_ACC_DECOUPLE"), "{text}");
    let newest = String::from_utf8(export(&mission, &[]).stdout).unwrap();
    assert!(newest.contains("\tMPC_ACC_DECOUPLE\t1\t6\n"), "{newest}");
    let file = folder.path().join("exported.params");
    fs::write(&file, &text).unwrap();
    let scaled = fly(&mission, "scaled", &[]);
    assert!(scaled == fly(&mission, "by_file", &["--params", file.to_str().unwrap()]));
    let unscaled = fly(&with_battery("gravity", false), "unscaled", &[]);
    assert!(scaled != unscaled, "the battery's voltage counts");

    let mission = with_battery("thrust", false);
    let whole = ["--drop"];
    for options in [&["--px4-version", "v1.14"][..], &whole, &["--drop", "--px4-version", "v1.14"]] {
        let refused = export(&mission, options);
        let error = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{options:?}: {error}");
        let named = error.contains("control.tilt_from: thrust has no counterpart in PX4 before v1.15");
        assert!(named, "{options:?}: {error}");
    }
    let text = String::from_utf8(export(&mission, &["--px4-version", "v1.16"]).stdout).unwrap();
    assert!(text.contains("\tMPC_ACC_DECOUPLE\t0\t6\n"), "{text}");
}
