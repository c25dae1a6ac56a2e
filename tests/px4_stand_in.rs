//! Drops whose PX4 is a shell script that does what a broken PX4 does: nothing, or less. What is true here is
//! what a user must get to know: on stderr, in drop.json, by the exit code.
#![cfg(all(target_os = "linux", feature = "cli"))]

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Mutex, MutexGuard, PoisonError};

const MISSION: &str = "mission/x500_drop.json";
/// The vehicle's number, and where PX4 would connect.
const INSTANCE: &str = "3";
const PORT: &str = "TCP 4563";

static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// A build folder with a script for PX4.
struct StandIn {
    place: tempfile::TempDir,
    _turn: MutexGuard<'static, ()>,
}

impl StandIn {
    fn new(script: &str) -> Self {
        let turn = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        let place = tempfile::tempdir().unwrap();
        for file in [
            "bin/px4",
            "etc/init.d-posix/rcS",
            "etc/init.d-posix/airframes/10016_iris",
            "etc/mixers/quad_x.main.mix",
        ] {
            let path = place.path().join("build").join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        }
        Self { place, _turn: turn }
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.place.path().join(name)
    }

    fn samara(&self, verb: &str, mission: &str, out: &Path, more: &[&str]) -> Output {
        let autopilot = format!("px4={}", self.path("build").display());
        let args = [verb, mission, "--autopilot", &autopilot, "--instance", INSTANCE];
        let mut command = Command::new(env!("CARGO_BIN_EXE_samara"));
        command.args(args).arg("--out").arg(out).args(more).output().unwrap()
    }
}

const MUTE: &str = "echo INFO starting\necho ERROR no simulator in this build\nexec sleep 600";

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn json(text: &[u8]) -> serde_json::Value {
    serde_json::from_slice(text).unwrap()
}

/// The mission with other values, its files found where they are.
fn changed(folder: &Path, change: impl FnOnce(&mut serde_json::Value)) -> String {
    let mut mission = json(&fs::read(MISSION).unwrap());
    for key in ["vehicle", "gains", "px4_params"] {
        let path = fs::canonicalize(format!("mission/{}", mission[key].as_str().unwrap())).unwrap();
        mission[key] = path.to_str().unwrap().into();
    }
    change(&mut mission);
    let path = folder.join("changed.json");
    fs::write(&path, mission.to_string()).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_px4_that_never_connects_ends_with_what_is_missing_and_its_last_words() {
    let px4 = StandIn::new(MUTE);
    let out = px4.path("out");
    let output = px4.samara("drop", MISSION, &out, &["--patience", "3", "--json"]);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("for HEARTBEAT from the autopilot of system 4"), "a wait is not mute: {said}");
    for flown in [json(&output.stdout), json(&fs::read(out.join("drop.json")).unwrap())] {
        let reason = flown["reason"].as_str().unwrap();
        for words in ["stopped before the release", PORT, "within 3 s", "no simulator in this build"] {
            assert!(reason.contains(words), "{words} in {reason}");
        }
        assert_eq!((&flown["completed"], &flown["autopilot"]), (&false.into(), &"px4".into()));
    }
    assert!(said.contains(PORT), "{said}");
}

#[test]
fn a_px4_that_ends_is_reported_by_its_exit_code_and_its_last_lines() {
    let px4 = StandIn::new("echo ERROR no such airframe\nexit 7");
    let out = px4.path("out");
    let output = px4.samara("drop", MISSION, &out, &["--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let flown = json(&output.stdout);
    let reason = flown["reason"].as_str().unwrap();
    assert!(reason.contains("exit code 7") && reason.contains("no such airframe"), "{reason}");
}

#[test]
fn a_trial_of_a_campaign_whose_px4_is_mute_fails_and_says_so() {
    let px4 = StandIn::new(MUTE);
    let out = px4.path("out");
    let more = ["--trials", "2", "--threads", "1", "--patience", "3"];
    let output = px4.samara("assess", MISSION, &out, &more);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("trial 0: ") && said.contains("for HEARTBEAT"), "{said}");
    let lines = fs::read_to_string(out.join("drops_px4_x500_px4_tuned.csv")).unwrap();
    assert!(lines.matches(PORT).count() == 2 && out.join("trial_1").is_dir(), "{lines}");
}

/// samara's own autopilot in PX4's place, on real sockets: as PX4 after v1.17 it has parameters of both
/// types, takes none in the other, and tells the kinds of refusal by PARAM_ERROR. What is out of its range
/// stops the drop by name, before anything is armed.
#[test]
fn a_parameter_that_the_vehicle_does_not_take_stops_the_drop_by_its_name() {
    let program = env!("CARGO_BIN_EXE_samara");
    let mission = fs::canonicalize(MISSION).unwrap();
    let script =
        format!("exec {program} autopilot {} --instance {INSTANCE} --once --out own", mission.display());
    let px4 = StandIn::new(&script);
    let file = px4.path("given.params");
    fs::write(&file, "1\t1\tMPC_XY_CRUISE\t1000\t9\n").unwrap();
    let out = px4.path("out");
    let more = ["--params", file.to_str().unwrap(), "--json", "--patience", "30"];
    let output = px4.samara("drop", MISSION, &out, &more);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let reason = json(&output.stdout)["reason"].as_str().unwrap().to_owned();
    let words =
        "stopped before the release: the vehicle does not take MPC_XY_CRUISE = 1000 (out of range there):";
    assert!(reason.starts_with(words), "{reason}\n{said}");
    assert!(!said.contains("armed"), "{said}");
}

/// What is wrong for every trial is one error, and nothing is flown.
#[test]
fn a_campaign_that_cannot_be_flown_is_bad_input() {
    let px4 = StandIn::new(MUTE);
    let silent = changed(px4.place.path(), |mission| mission["sensors"]["barometer"] = serde_json::json!({}));
    let elsewhere = tempfile::tempdir().unwrap();
    let constant = changed(elsewhere.path(), |mission| {
        _ = mission["sensors"].as_object_mut().unwrap().remove("magnetometer")
    });
    let held = std::net::UdpSocket::bind(("127.0.0.1", 14543)).unwrap();
    let refused =
        [(silent.as_str(), "barometer"), (constant.as_str(), "magnetometer"), (MISSION, "port 14543")];
    for (mission, words) in refused {
        let out = px4.path("out");
        let output = px4.samara("assess", mission, &out, &["--trials", "3", "--threads", "1"]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(words) && !said.contains("FAILED"), "{said}");
        assert!(!out.join("place_0").exists() && !out.join("trial_0").exists(), "{said}");
    }
    drop(held);
}

/// A draft of a mission on Earth is for PX4 too: it is started, and only its silence ends the drop. Its
/// estimator starts at rest, and takes readings that never change for a broken sensor's.
#[test]
fn a_drafted_mission_is_one_that_px4_can_fly() {
    let px4 = StandIn::new(MUTE);
    let place = px4.place.path();
    let new = |args: &[&str]| {
        let drafted =
            Command::new(env!("CARGO_BIN_EXE_samara")).arg("new").args(args).current_dir(place).output();
        assert!(drafted.unwrap().status.success());
    };
    new(&[
        "vehicle",
        "kite",
        "--mass",
        "2",
        "--frame",
        "quad-x",
        "--arm",
        "0.25",
        "--propeller",
        "10in",
        "--thrust",
        "10",
    ]);
    new(&["mission", "kite_drop", "--vehicle", "./kite.json", "--planet", "earth", "--altitude", "500"]);
    let mission = px4.path("kite_drop.json");
    let hook_s = &json(&fs::read(&mission).unwrap())["release"]["hook_s"];
    assert!(hook_s.as_f64().unwrap() >= 6.3, "its estimator takes so long");
    let output =
        px4.samara("drop", mission.to_str().unwrap(), &px4.path("out"), &["--patience", "1", "--json"]);
    let said = stderr(&output);
    assert!(output.status.code() == Some(1) && said.contains("within 1 s"), "{said}");
}

/// The folder of the results is somebody's, the build is PX4's: neither is removed.
#[test]
fn what_stands_in_the_way_of_px4s_working_directory_is_left_alone() {
    let px4 = StandIn::new(MUTE);
    let mine = px4.path("mine");
    fs::create_dir_all(mine.join("px4")).unwrap();
    fs::write(mine.join("px4/thesis.txt"), "").unwrap();
    fs::rename(px4.path("build"), px4.path("px4")).unwrap();
    let autopilot = format!("px4={}", px4.path("px4").display());
    for (out, words) in [(mine.clone(), "not one that samara made"), (px4.path(""), "build folder")] {
        let output = Command::new(env!("CARGO_BIN_EXE_samara"))
            .args(["drop", MISSION, "--autopilot", &autopilot, "--instance", INSTANCE, "--out"])
            .arg(&out)
            .output()
            .unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(words) && said.contains("--out"), "{said}");
    }
    assert!(mine.join("px4/thesis.txt").is_file() && px4.path("px4/bin/px4").is_file());
}
