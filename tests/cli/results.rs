//! What a run leaves: every file says what made it, and none is of an earlier run.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::{code, json, samara, spoilt_mission, stderr};

fn sha256(path: &Path) -> String {
    Sha256::digest(fs::read(path).unwrap()).iter().map(|b| format!("{b:02x}")).collect()
}

fn object(path: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// Names and hashes of the files of a folder, without the manifest itself.
fn files(folder: &Path) -> BTreeMap<String, String> {
    fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file() && !path.to_str().unwrap().ends_with("_manifest.json"))
        .map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), sha256(&path)))
        .collect()
}

fn listed(manifest: &serde_json::Value) -> BTreeMap<String, String> {
    serde_json::from_value(manifest["files"].clone()).unwrap()
}

/// A drop of a plan, then one of a trajectory from a file into the same folder.
#[test]
fn results_say_what_was_flown_and_nothing_stale_remains() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let planned = json(&samara(&["drop", "--json", "--out", folder]));
    assert_eq!(planned["trajectory"]["source"], "planned");
    assert_eq!(planned["trajectory"]["sha256"], sha256(&out.path().join("trajectory.csv")).as_str());
    assert_eq!((&planned["completed"], &planned["reason"]), (&true.into(), &serde_json::Value::Null));
    assert!((planned["ended_at_s"].as_f64().unwrap() - 45.0).abs() < 1e-9);
    let manifest = object(&out.path().join("drop_manifest.json"));
    assert_eq!(listed(&manifest), files(out.path()), "all files of the run, and no others");
    for key in ["input_hash", "seed", "version", "mission", "gains"] {
        assert_eq!(manifest[key], planned[key], "{key}");
    }

    let mine = out.path().join("mine.csv");
    let text = fs::read_to_string(out.path().join("trajectory.csv")).unwrap();
    fs::write(&mine, text.replace("# seed 1", "# seed of mine")).unwrap();
    let flown = json(&samara(&["drop", "--trajectory", mine.to_str().unwrap(), "--json", "--out", folder]));
    assert_eq!(flown["trajectory"]["source"], "file");
    assert_eq!(flown["trajectory"]["sha256"], sha256(&mine).as_str());
    assert_eq!(sha256(&out.path().join("trajectory.csv")), sha256(&mine), "the trajectory that was flown");
    assert!(!out.path().join("plan.json").exists() && !out.path().join("plan.svg").exists());
    assert_ne!(flown["input_hash"], planned["input_hash"]);
    assert_eq!(flown["j_tpf"], planned["j_tpf"]);
    let manifest = object(&out.path().join("drop_manifest.json"));
    assert_eq!(manifest["choices"]["trajectory sha256"], flown["trajectory"]["sha256"]);

    // No plan is found any more: the flight's files are of another run and go.
    let mission = spoilt_mission(out.path(), "\"thrust_max_n\": 300.0", "\"thrust_max_n\": 200.0");
    assert_eq!(code(&samara(&["drop", &mission, "--out", folder])), 1);
    for name in [
        "drop.json",
        "flight.csv",
        "drop.svg",
        "drop.html",
        "hil.tlog",
        "vehicle.tlog",
        "companion.tlog",
        "flight.ulg",
    ] {
        assert!(!out.path().join(name).exists(), "{name}");
    }
}

/// The page of an earlier run would be taken for this one's.
#[test]
fn a_drop_without_a_page_leaves_none() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let args = ["drop", "mission/x500_drop.json", "--autopilot", "px4-model", "--out", folder];
    samara(&args);
    let first = fs::read(out.path().join("drop.html")).unwrap();
    samara(&args);
    assert!(fs::read(out.path().join("drop.html")).unwrap() == first, "the same drop, the same bytes");
    samara(&[&args[..], &["--no-html"]].concat());
    assert!(!out.path().join("drop.html").exists());
    assert_eq!(listed(&object(&out.path().join("drop_manifest.json"))), files(out.path()));
}

/// A drop on the wire, then one without a wire into the same folder: no recording of the first is left.
#[test]
fn a_drop_without_a_wire_leaves_no_recording_of_an_earlier_one() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    for (autopilot, count) in [("reference", 11), ("px4-model", 8)] {
        let args = ["drop", "mission/x500_drop.json", "--autopilot", autopilot, "--json", "--out", folder];
        assert_eq!(json(&samara(&args))["autopilot"], autopilot);
        let manifest = object(&out.path().join("drop_manifest.json"));
        assert_eq!(listed(&manifest), files(out.path()), "{autopilot}");
        assert_eq!(listed(&manifest).len(), count, "{autopilot}");
    }
}

#[test]
fn the_hash_covers_the_options() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let hash = |verb: &str, options: &[&str]| {
        let output = samara(&[&[verb, "--json", "--out", folder], options].concat());
        json(&output)["input_hash"].as_str().unwrap().to_owned()
    };
    let plain = hash("plan", &[]);
    assert_eq!(hash("plan", &["--nodes", "75", "--input-cost", "zero", "--tolerance", "1e-8"]), plain);
    let mut hashes = vec![
        hash("plan", &["--nodes", "51"]),
        hash("plan", &["--input-cost", "trim"]),
        hash("plan", &["--terminal-tolerance", "0.03"]),
        hash("plan", &["--tolerance", "1e-6"]),
        hash("plan", &["--max-iterations", "4"]),
        plain.clone(),
    ];
    // The drops below leave nothing of another plan.
    let manifest = object(&out.path().join("plan_manifest.json"));
    hashes.extend([hash("drop", &["--seed", "2"]), hash("drop", &["--gains", "near_hover"])]);
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), 8);
    assert_eq!(manifest["choices"], serde_json::json!({ "max iterations": "4" }));
    // Another vehicle number makes other .tlog files of the same flight.
    assert_eq!(hash("drop", &["--instance", "3"]), plain);
    let drop = object(&out.path().join("drop_manifest.json"));
    assert_eq!(drop["circumstances"], serde_json::json!({ "instance": "3" }));
    let names: Vec<String> = listed(&manifest).into_keys().collect();
    assert_eq!(names, ["plan.json"], "a solve that ran out of iterations is no plan");
}

/// A run with other inputs says whose results it replaces and leaves none of them; what was edited, and hours
/// of work of another verb, stay.
#[test]
fn what_replaces_another_run_says_so_and_leaves_nothing_of_it() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let run = |args: &[&str]| {
        let output = samara(&[args, &["--out", folder]].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        stderr(&output)
    };
    let drop = ["drop", "mission/x500_drop.json"];
    assert_eq!(run(&drop), "");
    assert_eq!(run(&["plan", "mission/x500_drop.json"]), "", "of the same inputs: the same files");
    assert!(out.path().join("drop_manifest.json").exists());
    let said = run(&[&drop[..], &["--gains", "x500_hover", "--seed", "2"]].concat());
    let expected = format!(
        "samara: replaces the results of `samara drop` of x500_drop with gains x500 in {folder}; --out keeps both\n\
         samara: replaces the results of `samara plan` of x500_drop with gains x500 in {folder}; --out keeps both\n"
    );
    assert_eq!(said, expected);
    fs::write(out.path().join("flight.csv"), "mine").unwrap();
    fs::write(out.path().join("assess.html"), "page").unwrap();
    let written = ["assess.html", "plan.json"].map(|name| (name, sha256(&out.path().join(name))));
    let long = serde_json::json!({
        "verb": "assess", "mission": "x500_drop", "gains": "x500", "input_hash": "other", "choices": {},
        "files": BTreeMap::from(written),
    });
    fs::write(out.path().join("assess_manifest.json"), long.to_string()).unwrap();
    let said = run(&["plan", "mission/x500_drop.json", "--nodes", "41"]);
    assert!(
        said.contains("`samara drop` of x500_drop with gains x500_hover, seed 2 are set aside"),
        "{said}"
    );
    assert!(said.contains("`samara assess` of x500_drop") && said.contains("stays where it is"), "{said}");
    let left: Vec<String> = files(out.path()).into_keys().collect();
    assert_eq!(left, ["assess.html", "flight.csv", "plan.json", "plan.svg", "trajectory.csv"]);
    assert!(
        !out.path().join("drop_manifest.json").exists() && out.path().join("assess_manifest.json").exists()
    );
    for run in fs::read_dir(out.path().join("earlier")).unwrap().map(|entry| entry.unwrap().path()) {
        let manifest = fs::read_dir(&run).unwrap().map(|entry| entry.unwrap().path());
        let manifest = manifest.into_iter().find(|path| path.ends_with("drop_manifest.json"));
        let name = if manifest.is_some() { "drop_manifest.json" } else { "assess_manifest.json" };
        let mut listed = listed(&object(&run.join(name)));
        // The flight that was edited is no longer the run's.
        listed.remove("flight.csv");
        assert_eq!(listed, files(&run), "{name}: as it was written");
    }
}

/// Files that are the user's own are set aside and named; the next run has nothing to say about its own.
#[test]
fn a_file_that_no_manifest_lists_is_set_aside() {
    let out = tempfile::tempdir().unwrap();
    let at = |name: &str| out.path().join(name);
    for name in ["plan.json", "drop.html"] {
        fs::write(at(name), "mine").unwrap();
    }
    let drop =
        || samara(&["drop", "mission/x500_drop.json", "--no-html", "--out", out.path().to_str().unwrap()]);
    let first = drop();
    assert_eq!(code(&first), 0, "{}", stderr(&first));
    let said = stderr(&first);
    assert!(said.starts_with("samara: drop.html, plan.json: no manifest in "), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(!at("drop.html").exists());
    let mine: Vec<_> = fs::read_dir(at("earlier")).unwrap().map(|entry| entry.unwrap().path()).collect();
    let text = |name: &str| mine.iter().find_map(|place| fs::read_to_string(place.join(name)).ok());
    assert_eq!([text("plan.json"), text("drop.html")], [Some("mine".to_owned()), Some("mine".to_owned())]);
    assert_eq!(stderr(&drop()), "");
}

/// A link that leads out of the folder, a pipe and a device are no files to write results to: refused by
/// name, at once, and what the link leads to is as it was.
#[cfg(unix)]
#[test]
fn what_is_no_file_is_refused_in_a_folder_of_results() {
    let place = tempfile::tempdir().unwrap();
    let precious = place.path().join("precious");
    fs::write(&precious, "precious").unwrap();
    let fly = |name: &str, make: &dyn Fn(&Path)| {
        let out = place.path().join(format!("out of {name}"));
        fs::create_dir(&out).unwrap();
        make(&out.join(name));
        let output = samara(&["drop", "mission/x500_drop.json", "--out", out.to_str().unwrap()]);
        assert_eq!(code(&output), 2, "{}", stderr(&output));
        assert!(stderr(&output).contains(&format!("{name}: a file is expected")), "{}", stderr(&output));
        let manifest = fs::symlink_metadata(out.join("drop_manifest.json"));
        assert!(!manifest.is_ok_and(|there| there.is_file()), "nothing vouches for it");
        stderr(&output)
    };
    for name in ["plan.json", "hil.tlog", "flight.csv", "drop_manifest.json"] {
        let said = fly(name, &|path| std::os::unix::fs::symlink(&precious, path).unwrap());
        assert!(said.contains(&format!("a link to {}", precious.display())), "{said}");
        assert_eq!(fs::read_to_string(&precious).unwrap(), "precious");
    }
    let pipe = |path: &Path| {
        assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
    };
    assert!(fly("drop.json", &pipe).contains("a pipe"));
}

/// Two runs into one folder: the second is refused and names the first, whose lock goes with it, however it
/// ends. The first one waits, the folder its own, for a trajectory from a pipe.
#[cfg(target_os = "linux")]
#[test]
fn a_second_run_into_a_folder_is_refused_and_names_the_first() {
    let place = tempfile::tempdir().unwrap();
    let (pipe, out) = (place.path().join("pipe"), place.path().join("out"));
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let folder = out.to_str().unwrap();
    let mut first = std::process::Command::new(env!("CARGO_BIN_EXE_samara"))
        .args(["drop", "mission/x500_drop.json", "--trajectory", pipe.to_str().unwrap(), "--out", folder])
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let lock = out.join(".autopilot.lock");
    let begun = || fs::read_to_string(&lock).is_ok_and(|text| text.contains("drop"));
    while !begun() {
        assert!(first.try_wait().unwrap().is_none(), "it waits");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    for verb in ["assess", "plan"] {
        let output = samara(&[verb, "mission/x500_drop.json", "--out", folder]);
        assert_eq!(code(&output), 2);
        let named = format!("process {}, `samara drop`, begun ", first.id());
        assert!(stderr(&output).contains(&named) && output.stdout.is_empty(), "{}", stderr(&output));
        assert_eq!(files(&out).into_keys().collect::<Vec<_>>(), [".autopilot.lock", ".simulator.lock"]);
    }
    first.kill().unwrap();
    first.wait().unwrap();
    let output = samara(&["plan", "mission/x500_drop.json", "--out", folder]);
    assert_eq!((code(&output), stderr(&output).as_str()), (0, ""));
    assert_eq!(files(&out).into_keys().collect::<Vec<_>>(), ["plan.json", "plan.svg", "trajectory.csv"]);
}

/// On the estimator the errors of the sensors are flown, the same on every run; the manifest says so, and the
/// truth is the default.
#[test]
fn a_drop_on_the_estimator_says_so_and_is_repeatable() {
    let fly = |options: &[&str]| {
        let out = tempfile::tempdir().unwrap();
        let folder = ["mission/x500_drop.json", "--json", "--out", out.path().to_str().unwrap()];
        let output = samara(&[&["drop"], &folder[..], options].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let manifest = object(&out.path().join("drop_manifest.json"));
        (json(&output), manifest["choices"].clone(), files(out.path()))
    };
    let (own, choices, first) = fly(&["--estimator", "ekf"]);
    assert_eq!(choices, serde_json::json!({ "estimator": "ekf" }));
    assert_eq!(fly(&["--estimator", "ekf"]).2, first, "the same bytes");
    let (truth, choices, second) = fly(&["--estimator", "truth"]);
    assert_eq!(choices, serde_json::json!({}));
    assert_ne!(own["input_hash"], truth["input_hash"]);
    assert_ne!(first["flight.csv"], second["flight.csv"]);
    let off = own["j_tpf"].as_f64().unwrap() - truth["j_tpf"].as_f64().unwrap();
    assert!(off.abs() < 0.001, "{off}");
    let refused = samara(&["drop", "--estimator", "lpe"]);
    assert_eq!(code(&refused), 2);
    assert!(stderr(&refused).contains("truth, ekf"), "{}", stderr(&refused));
}

/// The rows of a flight log: its header's names and the values.
fn flight(folder: &Path) -> Vec<BTreeMap<String, String>> {
    let text = fs::read_to_string(folder.join("flight.csv")).unwrap();
    let mut lines = text.lines().skip_while(|l| l.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|l| header.iter().map(|h| (*h).to_owned()).zip(l.split(',').map(str::to_owned)).collect())
        .collect()
}

/// Each trigger of the mission file, flown; and the time of the release that it makes.
#[test]
fn every_release_trigger_is_flown() {
    let cases = [
        ("\"time\"", 10.0),
        // 1000 m is reached at the end of the hang, at 3 m/s.
        ("{ \"altitude\": { \"altitude_m\": 1015 } }", 5.0),
    ];
    for (trigger, released_s) in cases {
        let out = tempfile::tempdir().unwrap();
        let mission =
            spoilt_mission(out.path(), "\"trigger\": \"command\"", &format!("\"trigger\": {trigger}"));
        let output = samara(&["drop", &mission, "--json", "--out", out.path().to_str().unwrap()]);
        assert_eq!(code(&output), 0, "{trigger}: {}", stderr(&output));
        assert!((json(&output)["j_tpf"].as_f64().unwrap() / 0.5551 - 1.0).abs() < 0.02, "{}", json(&output));
        let rows = flight(out.path());
        let falling = rows.iter().find(|row| row["phase"] == "falling").unwrap();
        let t_s: f64 = falling["t_s"].parse().unwrap();
        assert!((t_s - released_s).abs() < 0.01, "{trigger}: released at {t_s} s");
    }
}

/// In wind the vehicle hangs adrift, and the plan starts from there.
#[test]
fn closed_form_a_drop_in_wind_starts_adrift() {
    let out = tempfile::tempdir().unwrap();
    let mission =
        spoilt_mission(out.path(), "\"wind_ned_m_s\": [0, 0, 0]", "\"wind_ned_m_s\": [2.5, -1.5, 0]");
    let output = samara(&["drop", &mission, "--json", "--out", out.path().to_str().unwrap()]);
    assert!([0, 1].contains(&code(&output)), "{}", stderr(&output));
    let first = &flight(out.path())[0];
    let velocity = ["vn_m_s", "ve_m_s", "vd_m_s"].map(|name| first[name].parse::<f64>().unwrap());
    assert_eq!(velocity, [2.5, -1.5, 3.0]);
    let plan = fs::read_to_string(out.path().join("trajectory.csv")).unwrap();
    let node: Vec<f64> = plan.lines().nth(4).unwrap().split(',').map(|x| x.parse().unwrap()).collect();
    assert_eq!(node[5..8], [2.5, -1.5, 3.675]);
    assert!(json(&output)["peak_roll_deg"].as_f64().unwrap() > 0.1, "it rolls to stop the drift");
}

/// A canopy and a riser in place of the prescribed hang: the vehicle sinks as fast as the two bodies do, at
/// `sqrt(2 (M + m) g/(rho (CdS + S C_d)))` (44.62 m^2: the lander's own drag is 0.36 of 2 m^2, rotors
/// locked), the riser carries it less its own drag; cut loose it falls away from the canopy, which the
/// verdict judges.
#[test]
fn closed_form_a_drop_from_a_canopy() {
    let out = tempfile::tempdir().unwrap();
    let canopy = r#""delay_s": 0.5,
    "canopy": { "mass_kg": 20, "drag_area_m2": 43.9, "apparent_mass_factor": 1 },
    "riser": {
      "length_m": 10, "stiffness_n_m": 10000, "damping_n_s_m": 300, "attachment_body_m": [0, 0, -2.6]
    },"#;
    let mission = spoilt_mission(out.path(), "\"delay_s\": 0.5,", canopy);
    let text = fs::read_to_string(&mission).unwrap();
    fs::write(&mission, text.replacen("\"speed_m_s\"", "\"separation_m\": 13, \"speed_m_s\"", 1)).unwrap();
    let output = samara(&["drop", &mission, "--json", "--out", out.path().to_str().unwrap()]);
    assert_eq!(code(&output), 1, "too close: {}", stderr(&output));
    let verdict = json(&output);
    assert_eq!((&verdict["recontact"], &verdict["limits_passed"][0]), (&true.into(), &"separation".into()));
    let rows = flight(out.path());
    let of = |row: usize, name: &str| rows[row][name].parse::<f64>().unwrap();
    let sinks_m_s = (2.0 * 810.0 * 1.35 / (5.4 * 44.62f64)).sqrt();
    let pull_n = 790.0 * 1.35 - 0.5 * 5.4 * 0.72 * sinks_m_s * sinks_m_s;
    for row in [0, 1_000] {
        assert!((of(row, "vd_m_s") - sinks_m_s).abs() < 1e-3, "{}", of(row, "vd_m_s"));
        assert!((of(row, "canopy_vd_m_s") - sinks_m_s).abs() < 1e-3);
        assert!((of(row, "riser_tension_n") - pull_n).abs() < 0.5, "{}", of(row, "riser_tension_n"));
        assert!((of(row, "canopy_fd_n") + pull_n).abs() < 0.5);
    }
    let distance_m = |row: usize| {
        let axes = ["north_m", "east_m", "down_m"];
        axes.map(|axis| of(row, &format!("canopy_{axis}")) - of(row, axis))
            .map(|x| x * x)
            .iter()
            .sum::<f64>()
            .sqrt()
    };
    let falling = rows.iter().position(|row| row["phase"] == "falling").unwrap();
    let least_m = verdict["canopy_distance_m"].as_f64().unwrap();
    // Riser, its stretch and the bridle.
    assert!((least_m - (12.6 + pull_n / 1e4)).abs() < 0.02, "{least_m}");
    assert!((distance_m(falling) - least_m).abs() < 1e-3);
    assert_eq!(of(falling, "riser_tension_n"), 0.0);
    assert!((distance_m(falling + 125) - least_m - 0.51).abs() < 0.03, "{}", distance_m(falling + 125));
}

/// A drop whose rotors windmill until their speed controllers catch them: what is logged, said and judged;
/// with too little torque they are not caught, and `check` has said so.
#[test]
fn a_drop_with_rotors_that_are_started() {
    let out = tempfile::tempdir().unwrap();
    let fly = |torque_nm: f64| {
        let folder = out.path().join(format!("{torque_nm}"));
        fs::create_dir_all(&folder).unwrap();
        let vehicle = fs::read_to_string("params/vehicles/titan_bemt.json").unwrap();
        let start = format!(
            r#"  "rotor_start": {{
    "before": "free", "friction_nm": 0.1,
    "esc": {{
      "start_torque_nm": {torque_nm}, "brake_torque_nm": {torque_nm}, "catch_speed_rad_s": 8,
      "try_s": 0.5, "tries": 5, "wait_s": 0.1
    }}
  }},
  "motor": {{"#
        );
        let path = folder.join("titan_bemt.json");
        fs::write(&path, vehicle.replacen("  \"motor\": {", &start, 1)).unwrap();
        fs::copy("params/vehicles/titan_bemt_rotor.csv", folder.join("titan_bemt_rotor.csv")).unwrap();
        let root = fs::canonicalize(".").unwrap();
        let named = format!("\"{}/params/vehicles/titan.json", root.display());
        let mission = spoilt_mission(&folder, "\"seed\": 1,", "\"seed\": 1,");
        let text = fs::read_to_string(&mission).unwrap();
        assert!(text.contains(&named));
        fs::write(&mission, text.replace(&named, &format!("\"{}", path.display()))).unwrap();
        let check = samara(&["check", &mission]);
        let output = samara(&["drop", &mission, "--json", "--out", folder.to_str().unwrap()]);
        (check, output, flight(&folder))
    };

    let (check, output, rows) = fly(9.0);
    let said = String::from_utf8_lossy(&check.stdout).into_owned();
    assert!(said.contains("start of the rotors") && said.contains("free rotors, in the descent"), "{said}");
    let verdict = json(&output);
    let starts = verdict["rotor_starts"].as_array().unwrap();
    assert_eq!(starts.len(), 4, "{}", stderr(&output));
    assert!(starts.iter().all(|s| s["running"] == true && s["from_rad_s"].as_f64().unwrap() < -20.0));
    let caught_s = starts[0]["caught_at_s"].as_f64().unwrap();
    assert!((10.6..11.5).contains(&caught_s), "{caught_s}");
    let events = verdict["events"].as_array().unwrap();
    assert!(events.iter().any(|e| e["text"].as_str().unwrap().starts_with("rotor 4 caught")), "{events:?}");
    let of = |row: usize, name: &str| rows[row][name].parse::<f64>().unwrap();
    assert_eq!((of(0, "esc_1"), of(rows.len() - 1, "esc_1")), (1.0, 4.0));
    assert!(of(0, "rotor_speed_1_rad_s") < -20.0 && (of(0, "torque_1_nm") - 0.1).abs() < 1e-6, "friction");

    let (check, output, rows) = fly(0.2);
    assert_eq!((code(&check), code(&output)), (1, 1));
    assert!(String::from_utf8_lossy(&check.stdout).contains("a rotor does not catch in the flow at t = 0"));
    let last = rows.last().unwrap();
    assert_eq!(last["esc_3"], "5.0");
    let verdict = json(&output);
    assert!(verdict["rotor_starts"][2]["caught_at_s"].is_null());
    let said = verdict["events"].to_string();
    assert!(said.contains("rotor 3 did not catch: 5 tries"), "{said}");
}

/// A battery with a voltage: row by row `V = E(charge) - R I`, the pack's current is that of its speed
/// controllers, none of which passes its limit, and the charge falls by the current over 37.04 A h (5000 W h
/// by 135 V). What the verdict says is what the rows say; flights from t = 0 say that they have none of it.
#[test]
fn closed_form_a_drop_on_a_battery() {
    let out = tempfile::tempdir().unwrap();
    let battery = r#""seed": 1, "battery": { "capacity_wh": 5000, "charge_percent": 90, "electric": {
      "open_circuit": [{ "charge_percent": 0, "voltage_v": 120 }, { "charge_percent": 100, "voltage_v": 150 }],
      "internal_resistance_ohm": 0.1, "esc_current_max_a": 15, "esc_efficiency": 0.95 } },"#;
    let mission = spoilt_mission(out.path(), "\"seed\": 1,", battery);
    let output = samara(&["drop", &mission, "--out", out.path().to_str().unwrap()]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for line in ["least bus voltage", "most pack current", "most current of a motor", "charge left"] {
        assert!(text.contains(line), "{line}: {text}{}", stderr(&output));
    }
    let rows = flight(out.path());
    let of = |row: &BTreeMap<String, String>, name: &str| row[name].parse::<f64>().unwrap();
    let (mut taken_as, mut least_v, mut held_s): (f64, f64, f64) = (0.0, f64::INFINITY, 0.0);
    for pair in rows.windows(2) {
        let [row, next] = [&pair[0], &pair[1]];
        let (bus_v, pack_a, charge) =
            (of(row, "bus_v"), of(row, "pack_current_a"), of(row, "charge_percent"));
        assert!((bus_v - (120.0 + 0.3 * charge - 0.1 * pack_a)).abs() < 1e-9, "{row:?}");
        let escs_a = [1, 2, 3, 4].map(|i| of(row, &format!("rotor{i}_current_a")));
        assert!((escs_a.iter().sum::<f64>() - pack_a).abs() < 1e-9);
        assert!(escs_a.iter().all(|a| (0.0..15.0 + 1e-6).contains(a)), "{escs_a:?}");
        let dt_s = of(next, "t_s") - of(row, "t_s");
        taken_as += 0.5 * (pack_a + of(next, "pack_current_a")) * dt_s;
        least_v = least_v.min(bus_v);
        if escs_a.iter().any(|a| *a > 15.0 - 1e-6) {
            held_s += dt_s;
        }
    }
    let power = &object(&out.path().join("drop.json"))["power"];
    let number = |key: &str| power[key].as_f64().unwrap();
    // The rows' trapezoids miss what a command that jumps between them takes: half a percent of it.
    let (taken, rows_taken) =
        (0.9 - 0.01 * number("charge_left_percent"), taken_as / (5000.0 / 135.0 * 3600.0));
    assert!((taken / rows_taken - 1.0).abs() < 0.01, "{power} {rows_taken}");
    assert!((number("bus_least_v") - least_v).abs() < 1e-9 && number("current_margin") < 1.0 + 1e-9);
    assert!(held_s > 0.5 && (number("held_by_esc_current_s") - held_s).abs() < 0.02, "{power} {held_s}");
    assert_eq!(
        (&power["pack_current_limit_a"], &power["empty_at_s"]),
        (&serde_json::Value::Null, &serde_json::Value::Null)
    );
    let assessed =
        samara(&["assess", &mission, "--trials", "2", "--out", out.path().join("a").to_str().unwrap()]);
    let said = String::from_utf8_lossy(&assessed.stdout).into_owned() + &stderr(&assessed);
    assert!(said.contains("flights from t = 0 have the battery as it is"), "{said}");
}
