//! `samara doctor` on machines that are made for it: a port that is taken, a folder that is none, programs
//! that stand in for Python and PX4.

use std::fs;
use std::net::{TcpListener, UdpSocket};
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde_json::Value;

use super::{code, json, stderr};

/// A vehicle that no other test has.
const INSTANCE: &str = "8";
const SIMULATOR: u16 = 4568;
const PARACHUTE: u16 = 14608;

/// The vehicle's ports are one test's at a time.
static PORTS: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    PORTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The program in a folder, with that folder for all that is found by name.
fn doctor(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_samara"));
    command.current_dir(folder).args(["doctor", "--instance", INSTANCE, "--json"]).args(args);
    command.env("PATH", folder).env_remove("SAMARA_PX4").output().unwrap()
}

fn check(output: &Output, of: &str) -> Value {
    let object = json(output);
    let checks = object["checks"].as_array().unwrap();
    checks.iter().find(|check| check["of"] == of).unwrap_or_else(|| panic!("{of} in {object}")).clone()
}

#[test]
fn a_port_that_is_taken_is_said_to_be() {
    let (_alone, place) = (alone(), tempfile::tempdir().unwrap());
    let free = doctor(place.path(), &[]);
    assert_eq!((code(&free), stderr(&free).as_str()), (0, ""));
    assert_eq!(json(&free)["ok"], true);
    assert!(!place.path().join("out").exists(), "nothing is left");
    let _tcp = TcpListener::bind(("127.0.0.1", SIMULATOR)).unwrap();
    let _udp = UdpSocket::bind(("127.0.0.1", PARACHUTE)).unwrap();
    let taken = doctor(place.path(), &[]);
    assert_eq!((code(&taken), &json(&taken)["ok"]), (1, &Value::Bool(false)));
    for (of, party) in [("TCP 4568", "simulator"), ("UDP 14608", "parachute")] {
        let check = check(&taken, of);
        assert_eq!(check["state"], "NO", "{check}");
        assert!(check["found"].as_str().unwrap().contains(party), "{check}");
        assert!(check["advice"].as_str().unwrap().contains("another --instance"), "{check}");
        assert_eq!(self::check(&free, of)["state"], "ok");
    }
    assert_eq!(check(&taken, "UDP 14548")["state"], "ok");
}

#[test]
fn where_nothing_can_be_written_is_said() {
    let (_alone, place) = (alone(), tempfile::tempdir().unwrap());
    fs::write(place.path().join("out"), "a file").unwrap();
    let output = doctor(place.path(), &[]);
    assert_eq!((code(&output), check(&output, "results")["state"].as_str()), (1, Some("NO")));
}

#[cfg(unix)]
fn script(folder: &Path, name: &str, text: &str) {
    use std::os::unix::fs::PermissionsExt as _;
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(&path, format!("#!/bin/sh\n{text}\n")).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
}

/// A Python that is not there, one with a module of another version, one that never answers.
#[test]
#[cfg(unix)]
fn python_is_asked() {
    let (_alone, place) = (alone(), tempfile::tempdir().unwrap());
    let state = |output: &Output, of: &str| check(output, of)["state"].as_str().unwrap().to_owned();
    let none = doctor(place.path(), &[]);
    assert_eq!((code(&none), state(&none, "python3").as_str()), (0, "-"));
    let versions = "case \"$2\" in *samara_tpf*) echo 0.0.1;; *pymavlink*) echo gone >&2; exit 1;; *) echo 3.12.0;; esac";
    script(place.path(), "python3", versions);
    let other = doctor(place.path(), &[]);
    assert_eq!(code(&other), 1, "{}", stderr(&other));
    let states = ["python3", "pymavlink", "samara_tpf"].map(|of| state(&other, of));
    assert_eq!(states, ["ok", "-", "NO"]);
    assert_eq!(check(&other, "pymavlink")["found"], "gone");
    script(place.path(), "python3", "exec /bin/sleep 60");
    let mute = doctor(place.path(), &[]);
    assert_eq!(check(&mute, "python3")["found"], "no answer within 2 s");
}

#[test]
#[cfg(unix)]
fn a_build_folder_of_px4_is_looked_into() {
    let (_alone, place) = (alone(), tempfile::tempdir().unwrap());
    let none = doctor(place.path(), &["--px4", "."]);
    assert_eq!((code(&none), check(&none, "PX4")["state"].as_str()), (1, Some("NO")));
    let build = place.path().join("build");
    script(&build, "etc/init.d-posix/rcS", "");
    script(&build, "bin/px4", "# \0SYS_AUTOSTART\0COM_SPOOLUP_TIME\0");
    let found = doctor(place.path(), &["--px4", "build"]);
    assert_eq!(code(&found), 0, "{}", stderr(&found));
    let version = check(&found, "PX4 version");
    assert!(version["found"].as_str().unwrap().starts_with("v1.14, by its parameters"), "{version}");
}
