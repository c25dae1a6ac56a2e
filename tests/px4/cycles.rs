//! Again and again: start, drop, an end at a random moment, start again. SAMARA_PX4_CYCLES says how often.

use std::thread::sleep;
use std::time::Duration;

use rustix::process::{Signal, kill_process};

use super::harness::{INSTANCES, Running, mission, px4, start_drop};
use super::restarts::parameters;
use super::traces::{groups, main_process, nobody_works_in, nothing_is_left, resident_kb};

/// A few, where nobody asks for more: each way to end once.
const CYCLES: u64 = 4;
/// Memory may vary by so much [kB]: a flight's log.
const VARIES_KB: u64 = 4096;

fn cycles() -> u64 {
    std::env::var("SAMARA_PX4_CYCLES").map_or(CYCLES, |text| text.parse().unwrap())
}

/// A random number for each cycle, the same in each run (Steele's splitmix64).
fn random(cycle: u64) -> u64 {
    let mut z = cycle.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// PX4 killed alone, which leaves its start-up script behind; we asked to end, by Ctrl-C and by SIGTERM; we
/// killed without a word.
#[test]
fn whoever_ends_and_however_nothing_is_left() {
    let Some(px4) = px4("whoever_ends_and_however_nothing_is_left") else { return };
    let out = tempfile::tempdir().unwrap();
    let work = out.path().join("px4");
    for cycle in 0..cycles() {
        let drop = start_drop(&px4, INSTANCES[0], out.path(), &[]);
        drop.until("PX4 started", 1);
        let groups = groups(&work);
        sleep(Duration::from_millis(random(cycle) % 2_000));
        match cycle % 4 {
            0 => _ = main_process(&work).map(|id| kill_process(id, Signal::KILL)),
            1 => drop.signal(Signal::INT),
            2 => drop.signal(Signal::TERM),
            _ => drop.signal(Signal::KILL),
        }
        let (status, said) = drop.end();
        let killed = cycle % 4 == 3 && status.code().is_none();
        assert!(killed || matches!(status.code(), Some(0 | 1)), "cycle {cycle}: {status}\n{said}");
        nothing_is_left(INSTANCES[0], &work, &groups);
    }
    let (status, said) = start_drop(&px4, INSTANCES[0], out.path(), &[]).end();
    assert_eq!(status.code(), Some(0), "{said}");
}

/// One simulator, many PX4s.
#[test]
fn a_simulator_takes_one_px4_after_another_and_no_more_memory() {
    let Some(px4) = px4("a_simulator_takes_one_px4_after_another_and_no_more_memory") else { return };
    let (out, work) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (instance, folder) = (INSTANCES[1].to_string(), out.path().to_str().unwrap());
    let mission = falling(out.path());
    let sim = Running::samara(&["sim", &mission, "--instance", &instance, "--speed", "5", "--out", folder]);
    sim.until("simulator, for the autopilot", 1);
    let mut memory_kb = Vec::new();
    for cycle in 0..cycles() {
        let px4 = Running::px4(&px4.build, INSTANCES[1], &work.path().join("px4"), &parameters());
        let n = usize::try_from(cycle).unwrap() + 1;
        sim.until("connected to autopilot", n);
        sleep(Duration::from_millis(random(cycle) % 2_500));
        drop(px4);
        sim.until("connection to", n);
        nobody_works_in(&work.path().join("px4"), INSTANCES[1]);
        memory_kb.push(resident_kb(sim.id()));
    }
    println!("memory in use after each cycle [kB]: {memory_kb:?}");
    let (settled, later) = memory_kb.split_at(memory_kb.len() / 2);
    let most = |of: &[u64]| *of.iter().max().unwrap();
    assert!(most(later) <= most(settled) + VARIES_KB, "{memory_kb:?}");
    sim.signal(Signal::TERM);
    let (status, said) = sim.end();
    assert_eq!(status.code(), Some(1), "{said}");
}

/// The mission, released by time: so each of them falls, some seconds after it has come.
fn falling(folder: &std::path::Path) -> String {
    let mut mission = mission();
    for key in ["vehicle", "gains"] {
        let path = std::fs::canonicalize(format!("mission/{}", mission[key].as_str().unwrap())).unwrap();
        mission[key] = path.to_str().unwrap().into();
    }
    mission["duration_s"] = 60.into();
    mission["release"] = serde_json::json!({ "start": "release", "hang_s": 5, "trigger": "time" });
    let path = folder.join("falling.json");
    std::fs::write(&path, mission.to_string()).unwrap();
    path.to_str().unwrap().to_owned()
}
