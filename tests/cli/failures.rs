//! What goes wrong: exit codes, one message, and nothing on stdout that is not the result.

use std::fs;
use std::process::{Command, Stdio};

use super::{code, json, samara, spoilt_mission, stderr};

/// A mission that a drop never gets out of its parachute in.
fn never_released(folder: &std::path::Path) -> String {
    let path = spoilt_mission(
        folder,
        "\"trigger\": \"command\"",
        "\"trigger\": { \"altitude\": { \"altitude_m\": -500 } }",
    );
    let text = fs::read_to_string(&path).unwrap().replace("\"duration_s\": 45", "\"duration_s\": 10.6");
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_vehicle_that_is_never_released_has_an_object_without_a_verdict() {
    let out = tempfile::tempdir().unwrap();
    let (mission, folder) = (never_released(out.path()), out.path().join("results"));
    let output = samara(&["drop", &mission, "--json", "--out", folder.to_str().unwrap()]);
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    let told = json(&output);
    assert_eq!(
        (&told["reason"], &told["completed"]),
        (&"the vehicle was never released".into(), &true.into())
    );
    assert!((told["ended_at_s"].as_f64().unwrap() - 10.6).abs() < 1e-9);
    for key in ["j_tpf", "peak_speed_m_s", "limits_passed", "steady_after_s", "final_v_ned_m_s"] {
        assert!(told[key].is_null() && told.as_object().unwrap().contains_key(key), "{key}");
    }
    let kept: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.join("drop.json")).unwrap()).unwrap();
    assert_eq!(kept["reason"], told["reason"]);
}

#[test]
fn a_passed_limit_says_no_and_names_it() {
    let out = tempfile::tempdir().unwrap();
    let mission = spoilt_mission(out.path(), "\"speed_m_s\": 12.0", "\"speed_m_s\": 5.0");
    let folder = out.path().to_str().unwrap();
    let output = samara(&["drop", &mission, "--json", "--out", folder]);
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    assert_eq!(json(&output)["limits_passed"], serde_json::json!(["speed"]));
    assert!(json(&output)["j_tpf"].as_f64().unwrap() > 1.0);
    let text = samara(&["drop", &mission, "--out", folder]);
    assert!(String::from_utf8_lossy(&text.stdout).contains("EXCEEDED"));
}

/// A wire that is scaled for PX4, and what is for PX4, are not for the reference autopilot; nor the other way
/// round.
#[test]
fn what_is_for_px4_by_froude_scaling_is_refused_elsewhere() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let refused = |args: &[&str], words: &[&str]| {
        let output = samara(&[args, &["--out", folder]].concat());
        assert_eq!(code(&output), 2, "{args:?}: {}", stderr(&output));
        for word in words {
            assert!(stderr(&output).contains(word), "{args:?}: {}", stderr(&output));
        }
    };
    refused(&["autopilot", "mission/titan_px4.json"], &["px4_clock", "samara drop"]);
    refused(&["drop", "--params", "params/px4/titan_px4_froude.params"], &["px4-froude", "--for samara"]);
    refused(&["drop", "--case", "case_7"], &["case_7", "case_0, case_1"]);
    let weightless = spoilt_mission(out.path(), "\"gravity_m_s2\": 1.35", "\"gravity_m_s2\": 0.05");
    let text = fs::read_to_string(&weightless)
        .unwrap()
        .replace("\"seed\": 1,", "\"seed\": 1, \"px4_clock\": \"froude\",");
    fs::write(&weightless, text).unwrap();
    refused(&["plan", &weightless], &["px4_clock", "below 0.1"]);
}

/// With --json, stdout holds exactly one object, or nothing when there is no result.
#[test]
fn stdout_holds_one_object_or_nothing() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().join("results");
    let weak = out.path().join("weak");
    fs::create_dir(&weak).unwrap();
    let weak = spoilt_mission(&weak, "\"thrust_max_n\": 300.0", "\"thrust_max_n\": 200.0");
    let never = never_released(out.path());
    let cases: [(&[&str], i32, bool); 7] = [
        (&["drop", &weak], 1, true),
        (&["plan", &weak], 1, true),
        (&["drop", &never], 1, true),
        (&["plan", "--max-iterations", "2"], 1, true),
        (&["drop", "mission/nowhere.json"], 2, false),
        (&["drop", "--gains", "nobody"], 2, false),
        (&["drop", "--trajectory", "nowhere.csv"], 2, false),
    ];
    for (i, (arguments, expected, has_object)) in cases.into_iter().enumerate() {
        // A folder each: what replaces another run's results says so.
        let folder = folder.join(i.to_string());
        let output = samara(&[arguments, &["--json", "--out", folder.to_str().unwrap()]].concat());
        assert_eq!(code(&output), expected, "{arguments:?}: {}", stderr(&output));
        if has_object {
            assert!(json(&output).is_object(), "{arguments:?}");
            assert!(stderr(&output).is_empty(), "{arguments:?}: {}", stderr(&output));
        } else {
            assert!(output.stdout.is_empty() && stderr(&output).starts_with("samara: "), "{arguments:?}");
        }
    }
}

/// A plan whose nodes do not tell what flies: `plan` says both numbers and how many nodes would do, and no; a
/// drop flies it, and warns.
#[test]
fn a_plan_of_too_few_nodes_says_no_and_is_flown_with_a_warning() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let output = samara(&["plan", "titan_paper", "--nodes", "10", "--out", folder]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(code(&output), 1, "{said}{}", stderr(&output));
    for words in [
        "J_TPF 0.5656 (0.5617 at its nodes), 10 nodes over 30 s",
        "J_TPF is 0.5656 along it and 0.5617 at its nodes (0.003 apart at most)",
        " nodes would do (plan.nodes, --nodes)",
    ] {
        assert!(said.contains(words), "{said}");
    }
    let told = json(&samara(&["plan", "titan_paper", "--nodes", "10", "--json", "--out", folder]));
    let enough = told["nodes_enough"].as_u64().unwrap().to_string();
    let finer = samara(&["plan", "titan_paper", "--nodes", &enough, "--json", "--out", folder]);
    assert_eq!(code(&finer), 0, "{}", stderr(&finer));
    assert!(json(&finer).get("nodes_enough").is_none());

    let coarse = spoilt_mission(out.path(), "\"nodes\": 38", "\"nodes\": 10");
    let flown = samara(&["drop", &coarse, "--json", "--out", folder]);
    let warned = "samara: the plan of 10 nodes: J_TPF is 0.5656 along it and 0.5617 at its nodes";
    assert!(stderr(&flown).contains(warned), "{}", stderr(&flown));
    let drop = json(&flown);
    assert!(drop["j_tpf"].is_number() && drop["completed"] == true, "{drop}");
    assert!((drop["plan_j_tpf"].as_f64().unwrap() - 0.5656).abs() < 6e-5, "{drop}");
}

/// A message and its causes, each told once.
#[test]
fn no_message_says_the_same_twice() {
    let out = tempfile::tempdir().unwrap();
    let file = out.path().join("file");
    fs::write(&file, "").unwrap();
    let (below, wrong) = (file.join("x"), file.to_str().unwrap().to_owned());
    let fast =
        spoilt_mission(out.path(), "\"target_v_ned_m_s\": [4, 0, 4]", "\"target_v_ned_m_s\": [300, 0, 4]");
    let text =
        fs::read_to_string(&fast).unwrap().replace("\"v_ned_m_s\": [4, 0, 4]", "\"v_ned_m_s\": [300, 0, 4]");
    fs::write(&fast, text).unwrap();
    let cases: [&[&str]; 7] = [
        &["plan", &fast],
        &["plan", "mission/nowhere.json"],
        &["plan", &wrong],
        &["plan", "--out", below.to_str().unwrap()],
        &["drop", "--params", &wrong],
        &["drop", "--trajectory", &wrong],
        &["drop", "--instance", "60000"],
    ];
    for arguments in cases {
        let output = samara(
            &[arguments, &["--out", below.to_str().unwrap()][..usize::from(arguments.len() < 3) * 2]]
                .concat(),
        );
        assert_eq!(code(&output), 2, "{arguments:?}: {}", stderr(&output));
        let message = stderr(&output);
        let parts: Vec<&str> = message.trim().split(": ").collect();
        for (i, part) in parts.iter().enumerate() {
            assert!(!parts[..i].contains(part), "{arguments:?}: {message}");
        }
    }
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let out = tempfile::tempdir().unwrap();
    let file = out.path().join("file");
    fs::write(&file, "").unwrap();
    let below = file.join("x");
    for verb in ["plan", "drop"] {
        let output = samara(&[verb, "--json", "--out", below.to_str().unwrap()]);
        assert_eq!(code(&output), 2);
        assert!(stderr(&output).contains("cannot make the output folder"), "{}", stderr(&output));
        assert!(output.stdout.is_empty());
    }
    // A folder stands where a file is to be.
    let taken = out.path().join("taken");
    fs::create_dir_all(taken.join("plan.json")).unwrap();
    let output = samara(&["plan", "--out", taken.to_str().unwrap()]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("cannot write") && stderr(&output).contains("plan.json"));
    assert!(!taken.join("plan.json.partial").exists(), "no half of a file is left");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_reported_and_a_closed_pipe_is_not() {
    let out = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_samara"));
        command.args(arguments).args(["--out", out.path().to_str().unwrap()]);
        command
    };
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for arguments in [&["plan"][..], &["plan", "--json"], &["drop", "--json"]] {
        let output = run(arguments).stdout(full()).output().unwrap();
        assert_eq!(code(&output), 2, "{}", stderr(&output));
        assert!(
            stderr(&output).starts_with("samara: cannot write to stdout: No space left"),
            "{}",
            stderr(&output)
        );
    }
    // Nobody reads what is told of a bad mission: the exit code still is 2.
    let status = run(&["plan", "mission/nowhere.json"]).stderr(full()).status().unwrap();
    assert_eq!(status.code(), Some(2));
    let mut child = run(&["plan"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((code(&output), stderr(&output).as_str()), (0, ""));
}

/// What is no regular file is written through: it is there as it was afterwards, and a link leads to what has
/// been written.
#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_written_through() {
    use std::os::unix::fs::{FileTypeExt as _, symlink};
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    let export =
        |to: &std::path::Path| samara(&["params", "export", "x500_drop", "--out", to.to_str().unwrap()]);
    assert_eq!(code(&export(&at("plain"))), 0);
    let plain = fs::read_to_string(at("plain")).unwrap();
    // A link to a file, and one to a device: both stay links.
    fs::write(at("file"), "older").unwrap();
    symlink("file", at("link")).unwrap();
    assert_eq!(code(&export(&at("link"))), 0);
    assert_eq!(fs::read_to_string(at("file")).unwrap(), plain);
    symlink("/dev/null", at("nowhere")).unwrap();
    assert_eq!(code(&export(&at("nowhere"))), 0);
    for link in ["link", "nowhere"] {
        assert!(fs::symlink_metadata(at(link)).unwrap().is_symlink(), "{link}");
    }
    // A pipe, read by somebody.
    assert!(Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
    let pipe = at("pipe");
    let reader = std::thread::spawn(move || fs::read_to_string(pipe).unwrap());
    assert_eq!(code(&export(&at("pipe"))), 0);
    assert_eq!(reader.join().unwrap(), plain);
    assert!(fs::metadata(at("pipe")).unwrap().file_type().is_fifo());
    assert!(
        fs::read_dir(place.path())
            .unwrap()
            .flatten()
            .all(|e| !e.path().to_string_lossy().contains("partial"))
    );
}

/// A device without room, a file that may not grow and too few descriptors: exit code 2, and which it was.
/// The device is reached by a link, so that a program that replaces what it is given replaces the link.
#[cfg(target_os = "linux")]
#[test]
fn limits_of_the_system_are_errors_that_name_what_was_written() {
    let place = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("/dev/full", place.path().join("full")).unwrap();
    let full = place.path().join("full");
    let output = samara(&["params", "export", "x500_drop", "--out", full.to_str().unwrap()]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("full: No space left"), "{}", stderr(&output));
    let limited = |limit: &str, arguments: &str| {
        let out = place.path().join("out");
        let line = format!(
            "ulimit {limit}; exec {} {arguments} --out {}",
            env!("CARGO_BIN_EXE_samara"),
            out.display()
        );
        Command::new("bash").args(["-c", &line]).output().unwrap()
    };
    for (limit, arguments, told) in [
        ("-f 20", "drop x500_drop", "File too large"),
        ("-n 6", "drop x500_drop --speed 50", "too few files may be open"),
        ("-n 6", "sim x500_drop", "too few files may be open"),
    ] {
        let output = limited(limit, arguments);
        assert_eq!(code(&output), 2, "{limit} {arguments}: {}", stderr(&output));
        assert!(stderr(&output).contains(told), "{limit} {arguments}: {}", stderr(&output));
    }
}

/// Ctrl-C on a watched drop, or a terminal that is closed: what was flown is kept, and the files say that it
/// is not all.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_drop_says_so_in_its_files() {
    interrupted_by("-INT");
    // Under nohup, where these tests may run, a closed terminal ends nothing.
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap().trim();
    if u64::from_str_radix(ignored, 16).unwrap() & 1 == 0 {
        interrupted_by("-HUP");
    }
}

#[cfg(target_os = "linux")]
fn interrupted_by(signal: &str) {
    use std::io::{BufRead as _, BufReader};
    let out = tempfile::tempdir().unwrap();
    // Somebody else on this machine may have an instance's ports.
    let flying = (0..=9).rev().find_map(|instance: u32| {
        let mut child = Command::new(env!("CARGO_BIN_EXE_samara"))
            .args(["drop", "--speed", "1", "--instance", &instance.to_string()])
            .args(["--out", out.path().to_str().unwrap()])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
        // Armed: it flies, and Ctrl-C is waited for.
        let armed = lines.any(|line| line.contains("armed"));
        if !armed {
            assert_eq!(child.wait().unwrap().code(), Some(2), "only a busy port is an excuse");
        }
        armed.then_some((child, lines))
    });
    let (mut child, lines) = flying.expect("all instances are taken");
    let pid = child.id().to_string();
    assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
    lines.for_each(drop);
    assert_eq!(child.wait().unwrap().code(), Some(1));
    let told: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.path().join("drop.json")).unwrap()).unwrap();
    assert_eq!((&told["completed"], &told["reason"]), (&false.into(), &"stopped before the release".into()));
    let ended_s = told["ended_at_s"].as_f64().unwrap();
    assert!(ended_s > 0.4 && ended_s < 44.0, "{ended_s}");
}

/// Ctrl-C in a series of drops: no further one begins, what was flown is in the table, and the answer is no.
#[cfg(target_os = "linux")]
#[test]
fn regress_an_interrupted_series_of_drops_flies_no_more_of_them() {
    use std::io::{BufRead as _, BufReader};
    let out = tempfile::tempdir().unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_samara"))
        .args(["drop", "--cases", "--out", out.path().to_str().unwrap()])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.starts_with("case_0 ")), "{:?}", child.wait());
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let rest: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(1));
    let stopped = "stopped: the cases that follow were not flown";
    assert_eq!(rest.iter().filter(|line| *line == stopped).count(), 1, "{rest:?}");
    let table = fs::read_to_string(out.path().join("cases.csv")).unwrap();
    let flown = table.lines().filter(|line| line.starts_with("case_")).count();
    assert!((1..7).contains(&flown), "{table}");
    assert!(out.path().join("cases_manifest.json").exists());
}

#[test]
fn options_out_of_range_are_refused() {
    for tolerance in ["1e-13", "1", "nan", "-1e-8"] {
        let output = samara(&["plan", &format!("--tolerance={tolerance}")]);
        assert_eq!(code(&output), 2);
        assert!(stderr(&output).contains("a number from 1e-12 to 0.01"), "{}", stderr(&output));
    }
}

/// -v shows the planner at work, on stderr, wherever something is planned.
#[test]
fn verbose_shows_the_iterations() {
    let out = tempfile::tempdir().unwrap();
    for verb in ["plan", "drop"] {
        let output = samara(&[verb, "-v", "--json", "--out", out.path().to_str().unwrap()]);
        assert!(stderr(&output).starts_with("iter "), "{}", stderr(&output));
        assert!(json(&output).is_object());
    }
}

/// Inside half a width of 1e-7 m/s the solver converges; below there is no room for it, and the option says
/// so.
#[test]
fn a_terminal_tolerance_has_a_floor() {
    let out = tempfile::tempdir().unwrap();
    let plan = |tolerance: &str| {
        samara(&["plan", "--terminal-tolerance", tolerance, "--out", out.path().to_str().unwrap()])
    };
    assert_eq!(code(&plan("1e-7")), 0);
    let refused = plan("1e-9");
    assert_eq!(code(&refused), 2);
    assert!(stderr(&refused).contains("at least 1e-7 m/s"), "{}", stderr(&refused));
}

/// A plan may ask for thrust that the rotors do not have: it is made, and the number stands on stderr.
#[test]
fn a_thrust_that_the_rotors_do_not_have_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = spoilt_mission(folder.path(), "\"thrust_max_n\": 300.0", "\"thrust_max_n\": 5000.0");
    let output = samara(&["plan", &path, "--out", folder.path().to_str().unwrap()]);
    let said = stderr(&output);
    assert!(said.contains("titan_paper: plan.thrust_max_n 5000 N: a rotor makes "), "{said}");
}

/// An x_ss with another attitude than this vehicle's steady one: 10 deg nose up.
#[test]
fn regress_an_x_ss_of_another_vehicle_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    assert_eq!(stderr(&samara(&["plan", "--out", out])), "");
    let path = spoilt_mission(folder.path(), "[1, 0, -0.0026, 0]", "[0.99619, 0, 0.08716, 0]");
    let output = samara(&["plan", &path, "--out", out]);
    assert!(
        stderr(&output).contains("plan.x_ss is 10.3 deg off the steady state of this vehicle"),
        "{}",
        stderr(&output)
    );
}

/// Files that never end are refused, whichever verb reads them, in the memory of their bounds.
#[cfg(target_os = "linux")]
#[test]
fn files_without_an_end_are_refused() {
    let place = tempfile::tempdir().unwrap();
    let out = place.path().to_str().unwrap();
    for (arguments, told) in [
        (&["replay", "/dev/zero", "x500_drop"][..], "larger than 512 MiB"),
        (&["fidelity", "x500_drop", "--by", "/dev/zero", "--by", "/dev/zero"], "longer than 65536 bytes"),
        (&["drop", "/dev/zero"], "larger than 64 MiB"),
        (&["drop", "x500_drop", "--gains", "/dev/zero"], "larger than 64 MiB"),
        (&["drop", "x500_drop", "--trajectory", "/dev/zero"], "larger than 64 MiB"),
        (&["params", "diff", "/dev/zero", "/dev/zero"], "larger than 64 MiB"),
    ] {
        let of_out: &[&str] = if arguments[0] == "params" { &[] } else { &["--out", out] };
        let output = samara(&[arguments, of_out].concat());
        assert_eq!(code(&output), 2, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(told), "{arguments:?}: {}", stderr(&output));
    }
}

/// A path that holds what acts on a terminal is shown as words, on one line.
#[cfg(unix)]
#[test]
fn a_path_that_acts_on_a_terminal_is_shown_as_words() {
    let output = samara(&["drop", "x500_drop", "--gains", "./x\n=cmd\u{1b}]0;own\u{7}\u{202e}.json"]);
    assert_eq!(code(&output), 2);
    let said = stderr(&output);
    assert!(said.contains(r"./x\x0a=cmd\x1b]0;own\x07\u{202e}.json") && said.lines().count() == 1, "{said}");
}

/// Where PX4 flies, --gains takes a parameter file as --params does; where it does not, the option that does
/// is named.
#[test]
fn gains_that_are_a_parameter_file_are_px4s() {
    let place = tempfile::tempdir().unwrap();
    let file = "params/px4/x500_px4_tuned.params";
    let fly = |option: &str| {
        let out = place.path().join(option);
        let args =
            ["assess", "x500_drop", "--autopilot", "px4-model", "--trials", "2", "--json", option, file];
        let output = samara(&[&args[..], &["--out", out.to_str().unwrap()]].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        output.stdout
    };
    assert_eq!(fly("--gains"), fly("--params"));
    let refused = samara(&["drop", "x500_drop", "--gains", file]);
    assert_eq!(code(&refused), 2);
    assert!(stderr(&refused).contains("a parameter file is chosen with --params"), "{}", stderr(&refused));
}
