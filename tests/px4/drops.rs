//! Drops that PX4 flies: to the verdict, two at once, paused.

use std::process::Command;
use std::thread::sleep;
use std::time::Duration;

use rustix::process::{Signal, kill_process};

use super::harness::{INSTANCES, MISSION, mission, number, px4, start_drop, verdict};
use super::traces::{groups, main_process, nothing_is_left};

/// The mission's own limits and target; J_TPF is at least that of the fall (half a second from 5 m/s, with
/// air 9.1 m/s), and the reference autopilot predicts it.
#[test]
fn reference_a_drop_is_flown_to_its_verdict() {
    let Some(px4) = px4("reference_a_drop_is_flown_to_its_verdict") else { return };
    let out = tempfile::tempdir().unwrap();
    let drop = start_drop(&px4, INSTANCES[0], out.path(), &[]);
    drop.until("PX4 started", 1);
    let groups = groups(&out.path().join("px4"));
    let (status, said) = drop.end();
    assert_eq!(status.code(), Some(0), "{said}");
    assert!(!groups.is_empty(), "{said}");
    nothing_is_left(INSTANCES[0], &out.path().join("px4"), &groups);

    let flown = verdict(out.path());
    assert_eq!(flown["completed"], true, "{flown}");
    assert_eq!(flown["failsafe"], false, "{flown}");
    let limit_m_s = number(&mission()["limits"], "speed_m_s");
    assert!(number(&flown, "j_tpf") > 9.1 / limit_m_s && number(&flown, "j_tpf") < 1.0, "{flown}");
    let v = flown["final_v_ned_m_s"].as_array().unwrap();
    for (component, target) in v.iter().zip([2.0, 0.0, 1.0]) {
        assert!((component.as_f64().unwrap() - target).abs() < 0.1, "{flown}");
    }
    let log = std::fs::read(out.path().join("flight.ulg")).unwrap();
    assert!(log.starts_with(b"ULog\x01\x12\x35"), "not PX4's log");

    let predicted = tempfile::tempdir().unwrap();
    let reference = Command::new(env!("CARGO_BIN_EXE_samara"))
        .args(["drop", MISSION, "--out", predicted.path().to_str().unwrap()])
        .status();
    assert!(reference.unwrap().success());
    let predicted = verdict(predicted.path());
    for key in ["j_tpf", "peak_speed_m_s"] {
        let ratio = number(&flown, key) / number(&predicted, key);
        assert!((ratio - 1.0).abs() < 0.1, "{key}: {ratio} of the reference autopilot's");
    }
}

#[test]
fn two_vehicles_side_by_side_do_not_meet() {
    let Some(px4) = px4("two_vehicles_side_by_side_do_not_meet") else { return };
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let drops = [0, 1].map(|i| start_drop(&px4, INSTANCES[i], folders[i].path(), &[]));
    for (drop, (folder, instance)) in drops.into_iter().zip(folders.iter().zip(INSTANCES)) {
        let (status, said) = drop.end();
        assert_eq!(status.code(), Some(0), "{said}");
        // PX4's own number for it.
        assert!(said.contains(&format!("vehicle {} heard", instance + 1)), "{said}");
        assert_eq!(verdict(folder.path())["completed"], true);
    }
    for (folder, instance) in folders.iter().zip(INSTANCES) {
        nothing_is_left(instance, &folder.path().join("px4"), &Default::default());
    }
}

/// One number given twice: the second is refused, and the first flies on.
#[test]
fn a_second_one_of_the_same_number_is_refused() {
    let Some(px4) = px4("a_second_one_of_the_same_number_is_refused") else { return };
    let [one, two] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let first = start_drop(&px4, INSTANCES[0], one.path(), &["--speed", "4"]);
    first.until("PX4 started", 1);
    let (status, said) = start_drop(&px4, INSTANCES[0], two.path(), &[]).end();
    assert_eq!(status.code(), Some(2), "{said}");
    assert!(said.contains("is in use") && said.contains("--instance"), "{said}");
    let (status, said) = first.end();
    assert_eq!(status.code(), Some(0), "{said}");
}

/// A debugger's stop: simulated time stands still, what is waited for is named, and the flight is the same
/// afterwards.
#[test]
fn a_pause_of_px4_loses_nothing() {
    let Some(px4) = px4("a_pause_of_px4_loses_nothing") else { return };
    let fly = |pauses: bool| {
        let out = tempfile::tempdir().unwrap();
        let drop = start_drop(&px4, INSTANCES[0], out.path(), &["--speed", "4"]);
        if pauses {
            for (moment, nth) in [("armed", 1), ("rotors free", 2)] {
                drop.until(moment, 1);
                let id = main_process(&out.path().join("px4")).unwrap();
                kill_process(id, Signal::STOP).unwrap();
                drop.until("for HIL_ACTUATOR_CONTROLS from the autopilot", nth);
                sleep(Duration::from_secs(1));
                kill_process(id, Signal::CONT).unwrap();
            }
        }
        let (status, said) = drop.end();
        assert_eq!(status.code(), Some(0), "{said}");
        verdict(out.path())
    };
    let (straight, paused) = (fly(false), fly(true));
    for (key, spread) in [("j_tpf", 0.01), ("altitude_lost_m", 0.03), ("ended_at_s", 1e-9)] {
        let ratio = number(&paused, key) / number(&straight, key);
        assert!((ratio - 1.0).abs() < spread, "{key}: {ratio}");
    }
}
