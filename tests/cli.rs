//! The program as a user meets it: exit codes, messages, files.
#![cfg(feature = "cli")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

mod anywhere;
mod asked;
mod bad_inputs;
mod compare;
mod doctor;
mod drafts;
mod failures;
mod faults;
mod go;
mod hints;
mod list;
mod replay;
mod results;
mod titan_px4;

fn samara(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara")).args(args).output().unwrap()
}

fn samara_in(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara")).current_dir(folder).args(args).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic_with(output, &e))
}

#[expect(clippy::panic, reason = "the message of a failed test")]
fn panic_with(output: &Output, error: &dyn std::fmt::Display) -> serde_json::Value {
    panic!("{error}: stdout {:?} stderr {:?}", String::from_utf8_lossy(&output.stdout), stderr(output))
}

/// A mission whose text is changed, in a folder of its own beside links to the shipped vehicle and gains.
fn spoilt_mission(folder: &Path, from: &str, to: &str) -> String {
    let text = fs::read_to_string("mission/titan_paper.json").unwrap();
    assert!(text.contains(from), "{from} is not in the mission");
    let root = fs::canonicalize(".").unwrap();
    let text = text.replace("\"../params", &format!("\"{}/params", root.display())).replace(from, to);
    let path = folder.join("mission.json");
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// MODEL figures of an independent implementation: nominal J_TPF .5551, steady to 1 % at 31.24 s (start `t0`;
/// the drop starts at the release and differs in the third digit of v_d).
#[test]
fn reference_drop_of_titan() {
    let out = tempfile::tempdir().unwrap();
    let output = samara(&[
        "drop",
        "mission/titan_paper.json",
        "--gains",
        "safety",
        "--json",
        "--out",
        out.path().to_str().unwrap(),
    ]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let verdict = json(&output);
    let number = |key: &str| verdict[key].as_f64().unwrap();
    assert!((number("j_tpf") / 0.5551 - 1.0).abs() < 0.005, "{verdict}");
    assert!((number("steady_after_s") - 31.24).abs() < 0.1, "{verdict}");
    // The implementation's J_TPF of the plan is that at its nodes, as the paper's; the drop's is along it.
    let plan: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.path().join("plan.json")).unwrap()).unwrap();
    assert!((plan["j_tpf_at_nodes"].as_f64().unwrap() - 0.5531828).abs() < 1e-6, "{plan}");
    assert_eq!(verdict["plan_j_tpf"], plan["j_tpf"]);
    let between = samara::assess::BETWEEN_NODES_MOST;
    assert!((0.0..between).contains(&(number("plan_j_tpf") - 0.5531828)), "{verdict}");
    assert_eq!(verdict["limits_passed"].as_array().unwrap().len(), 0);
    assert_eq!(verdict["failsafe"], false);
    let released = &verdict["events"][1];
    assert_eq!((&released["t_s"], &released["text"]), (&10.0.into(), &"released by command".into()));
    for key in
        ["peak_speed_m_s", "peak_pitch_deg", "peak_pitch_rate_deg_s", "altitude_lost_m", "real_time_factor"]
    {
        assert!(number(key) > 0.0, "{key}");
    }
}

/// Shipped missions become steady with the gains they ship, within their limits; the lander before its plan
/// ends, since that plan comes to rest.
#[test]
fn shipped_missions_come_to_rest() {
    let out = tempfile::tempdir().unwrap();
    for mission in ["mission/titan_drop.json", "mission/x500_drop.json"] {
        let output = samara(&["drop", mission, "--json", "--out", out.path().to_str().unwrap()]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let steady_after_s = json(&output)["steady_after_s"].as_f64().unwrap();
        assert!(steady_after_s < 29.0, "{mission}: {}", json(&output));
    }
}

#[test]
fn prop_two_drops_write_the_same_bytes() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    for folder in &folders {
        let output = samara(&["drop", "--out", folder.path().to_str().unwrap()]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
    }
    let mut names: Vec<_> =
        fs::read_dir(folders[0].path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert!(names.len() >= 7, "{names:?}");
    for name in names {
        let [a, b] = [0, 1].map(|i: usize| fs::read(folders[i].path().join(&name)).unwrap());
        assert!(a == b, "{name:?} differs");
    }
}

/// The variant of the C library's mathematics that suits the processor makes no difference: one without FMA,
/// as on an older or masked processor (glibc's `glibc.cpu.hwcaps`), gives the same flight.
#[test]
fn regress_the_c_librarys_mathematics_change_no_byte() {
    let fly = |tunables: &str| {
        let folder = tempfile::tempdir().unwrap();
        let mut drop = Command::new(env!("CARGO_BIN_EXE_samara"));
        drop.args(["drop", "--out", folder.path().to_str().unwrap()]).env("GLIBC_TUNABLES", tunables);
        assert_eq!(code(&drop.output().unwrap()), 0);
        fs::read(folder.path().join("flight.csv")).unwrap()
    };
    assert!(fly("") == fly("glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F,-AVX"));
}

/// The figure of the README's campaign is of the mission, the vehicle and the gains that there are, by its
/// hash; 3000 drops are too many to be flown here.
#[test]
fn regress_the_campaign_of_the_readme_is_of_todays_inputs() {
    let checked = json(&samara(&["check", "mission/x500_drop.json", "--seed", "771177", "--json"]));
    let figure = fs::read_to_string("docs/x500_drops.svg").unwrap();
    let inputs = format!("inputs sha256 {}</desc>", checked["input_hash"].as_str().unwrap());
    assert!(figure.contains(&inputs), "docs/x500_drops.svg is stale: run scripts/regenerate");
}

/// The README's figure is the one that the program draws; `scripts/regenerate` makes it.
#[test]
fn regress_the_figure_of_the_readme_is_current() {
    let out = tempfile::tempdir().unwrap();
    samara(&["drop", "--out", out.path().to_str().unwrap()]);
    let drawn = fs::read(out.path().join("drop.svg")).unwrap();
    assert!(
        drawn == fs::read("docs/titan_drop.svg").unwrap(),
        "docs/titan_drop.svg is stale: run scripts/regenerate"
    );
}

#[test]
fn links_without_sockets_are_refused_before_anything_is_flown() {
    for args in [["drop", "--link", "tcpin:127.0.0.1:5760"], ["drop", "--sign-key", "key.txt"]] {
        let output = samara(&args);
        assert_eq!(code(&output), 2);
        assert!(stderr(&output).contains("--speed FACTOR is expected"), "{}", stderr(&output));
    }
    let output = samara(&["autopilot", "--link", "udp:127.0.0.1:14550"]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("udpin, udpout, tcpin or tcpout is expected"), "{}", stderr(&output));
}

#[test]
fn a_plan_that_is_not_found_says_no_and_leaves_nothing_to_fly() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    // What an earlier plan left would be flown for this one's.
    assert_eq!(code(&samara(&["plan", "--out", folder])), 0);
    assert!(out.path().join("trajectory.csv").exists() && out.path().join("plan.svg").exists());
    let output = samara(&["plan", "--max-iterations", "4", "--json", "--out", folder]);
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    assert_eq!(json(&output)["status"], "iteration_limit");
    assert!(json(&output)["diagnosis"].as_str().unwrap().contains("best point"));
    assert_eq!(json(&output)["j_tpf"], serde_json::Value::Null);
    let names: Vec<_> = fs::read_dir(out.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(names.len() == 2 && names.iter().all(|name| name == "plan.json" || name == "plan_manifest.json"));
    assert!(!stderr(&output).contains("J_TPF"), "{}", stderr(&output));
}

#[test]
fn a_vehicle_too_weak_to_fly_is_an_answer() {
    let out = tempfile::tempdir().unwrap();
    let mission = spoilt_mission(out.path(), "\"thrust_max_n\": 300.0", "\"thrust_max_n\": 200.0");
    for verb in ["plan", "drop"] {
        let output = samara(&[verb, &mission, "--out", out.path().to_str().unwrap()]);
        assert_eq!(code(&output), 1, "{}", stderr(&output));
        assert!(String::from_utf8_lossy(&output.stdout).contains("too weak to fly"));
    }
}

#[test]
fn bad_missions_are_refused_with_the_place() {
    let out = tempfile::tempdir().unwrap();
    let refused = |mission: &str, expected: &[&str]| {
        let output = samara(&["drop", mission, "--out", out.path().join("results").to_str().unwrap()]);
        assert_eq!(code(&output), 2, "{}", stderr(&output));
        for text in expected {
            assert!(stderr(&output).contains(text), "{text} not in {}", stderr(&output));
        }
        assert!(!out.path().join("results").exists(), "nothing is written");
    };
    refused("mission/nowhere.json", &["cannot read mission file mission/nowhere.json"]);
    let spoilt = |from: &str, to: &str| spoilt_mission(out.path(), from, to);
    refused(&spoilt("\"nodes\": 38", "\"nodes\": -1"), &["mission.json:", "plan.nodes"]);
    refused(&spoilt("\"seed\": 1", "\"sede\": 1"), &["mission.json:", "unknown field `sede`"]);
    refused(&spoilt("\"duration_s\": 45", "\"duration_s\": NaN"), &["mission.json:", "duration_s"]);
    refused(
        &spoilt("params/vehicles/titan.json", "params/vehicles/titanic.json"),
        &["titanic.json", "mission.json"],
    );
}

/// A mission with another target; x_ss, the steady state at the target, goes with it.
fn with_target(folder: &Path, target: &str) -> String {
    let path =
        spoilt_mission(folder, "\"target_v_ned_m_s\": [4, 0, 4]", &format!("\"target_v_ned_m_s\": {target}"));
    let text = fs::read_to_string(&path).unwrap();
    let moved = text.replace("\"v_ned_m_s\": [4, 0, 4]", &format!("\"v_ned_m_s\": {target}"));
    assert_ne!(text, moved);
    fs::write(&path, moved).unwrap();
    path
}

#[test]
fn an_unreachable_target_velocity_is_refused() {
    let out = tempfile::tempdir().unwrap();
    for target in ["[300, 0, 4]", "[999, 0, 0]"] {
        let mission = with_target(out.path(), target);
        let output = samara(&["plan", &mission, "--out", out.path().join("results").to_str().unwrap()]);
        assert_eq!(code(&output), 2, "{target}: {}", stderr(&output));
        assert!(stderr(&output).contains("target velocity cannot be reached"), "{}", stderr(&output));
    }
}

/// Faster down than the body falls (23 m/s): rotors would have to pull.
#[test]
fn a_target_beyond_terminal_velocity_is_infeasible() {
    let out = tempfile::tempdir().unwrap();
    let mission = with_target(out.path(), "[0, 0, 45]");
    let output = samara(&["plan", &mission, "--json", "--out", out.path().to_str().unwrap()]);
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    assert_eq!(json(&output)["status"], "infeasible");
}

#[test]
fn a_target_that_x_ss_contradicts_is_refused() {
    let out = tempfile::tempdir().unwrap();
    let mission =
        spoilt_mission(out.path(), "\"target_v_ned_m_s\": [4, 0, 4]", "\"target_v_ned_m_s\": [0, 4, 4]");
    let output = samara(&["plan", &mission, "--out", out.path().to_str().unwrap()]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("plan.x_ss.v_ned_m_s"), "{}", stderr(&output));
}

/// Released at once by the mission's time, with a delay that is no multiple of the setpoints' period: the
/// plan is flown.
#[test]
fn a_release_at_the_very_start_is_flown() {
    let out = tempfile::tempdir().unwrap();
    let path = spoilt_mission(out.path(), "\"trigger\": \"command\"", "\"trigger\": \"armed_offboard\"");
    let text = fs::read_to_string(&path).unwrap().replace("\"hang_s\": 10", "\"hang_s\": 1");
    fs::write(&path, text.replace("\"delay_s\": 0.5", "\"delay_s\": 0.515")).unwrap();
    let output = samara(&["drop", &path, "--json", "--out", out.path().to_str().unwrap()]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!((json(&output)["j_tpf"].as_f64().unwrap() / 0.5551 - 1.0).abs() < 0.02, "{}", json(&output));
}

#[test]
fn bad_trajectory_files_are_refused_with_the_line() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    assert_eq!(code(&samara(&["plan", "--out", folder])), 0);
    let good = fs::read_to_string(out.path().join("trajectory.csv")).unwrap();
    let lines: Vec<&str> = good.lines().collect();
    let attempt = |line: usize, text: String, expected: &str| {
        let mut lines = lines.clone();
        lines[line] = &text;
        let path = out.path().join("spoilt.csv");
        fs::write(&path, lines.join("\n")).unwrap();
        let output = samara(&["drop", "--trajectory", path.to_str().unwrap(), "--out", folder]);
        assert_eq!(code(&output), 2);
        let place = format!("spoilt.csv:{}:", line + 1);
        assert!(
            stderr(&output).contains(&place) && stderr(&output).contains(expected),
            "{}",
            stderr(&output)
        );
    };
    let row = lines[10].to_owned();
    let (time, rest) = row.split_once(',').unwrap();
    attempt(10, format!("NaN,{rest}"), "finite");
    attempt(10, format!("0.001,{rest}"), "increase");
    attempt(10, format!("{time},{rest},1"), "");
    // The good one is flown, to the same verdict as the plan it came from.
    let path = out.path().join("trajectory.csv");
    let copy = out.path().join("copy.csv");
    fs::copy(&path, &copy).unwrap();
    let flown = samara(&["drop", "--trajectory", copy.to_str().unwrap(), "--json", "--out", folder]);
    let planned = samara(&["drop", "--json", "--out", folder]);
    assert_eq!(json(&flown)["j_tpf"], json(&planned)["j_tpf"]);
}

#[test]
fn gains_are_chosen_by_name_or_file() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let by_name = samara(&["drop", "--gains", "paper_pso", "--json", "--out", folder]);
    let by_file = samara(&["drop", "--gains", "params/gains/paper_pso.json", "--json", "--out", folder]);
    assert_eq!(json(&by_name)["j_tpf"], json(&by_file)["j_tpf"]);
    assert_eq!(json(&by_name)["gains"], "paper_pso");
    let unknown = samara(&["drop", "--gains", "best", "--out", folder]);
    assert_eq!(code(&unknown), 2);
    assert!(stderr(&unknown).contains("best"), "{}", stderr(&unknown));
}

#[test]
fn every_verb_has_help_with_examples() {
    let help = String::from_utf8(samara(&["--help"]).stdout).unwrap();
    let verbs: Vec<&str> = help
        .lines()
        .skip_while(|l| !l.starts_with("Commands:"))
        .skip(1)
        .take_while(|l| l.starts_with("  "))
        // Continuation lines of a description stand further in.
        .filter(|l| !l.starts_with("   "))
        .filter_map(|l| l.split_whitespace().next())
        .filter(|v| *v != "help")
        .collect();
    assert!(verbs.contains(&"drop") && verbs.contains(&"plan"), "{verbs:?}");
    for verb in verbs {
        let help = String::from_utf8(samara(&[verb, "--help"]).stdout).unwrap();
        assert!(help.contains("Examples:"), "{verb} has no examples");
    }
}

/// Port 14540 + 10 would be the ground station's.
#[test]
fn instances_that_would_share_ports_are_refused_with_the_range() {
    for verb in ["drop", "sim", "autopilot", "stream"] {
        for number in ["10", "254", "65535", "70000", "-1", "one"] {
            let output = samara(&[verb, "--instance", number]);
            assert_eq!(code(&output), 2, "{verb} {number}");
            let said = stderr(&output);
            assert!(said.contains("0 to 9"), "{said}");
        }
    }
}
