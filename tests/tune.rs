//! `samara tune` as a user meets it: the same gains whatever happens on the way.
#![cfg(all(feature = "cli", unix))]

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

/// A quick search: seven flights of 9.5 s for each candidate.
const QUICK: [&str; 11] = [
    "tune",
    "mission/x500_drop.json",
    "--objective",
    "rms",
    "--particles",
    "8",
    "--unseen",
    "8",
    "--stall",
    "100000",
    "--json",
];

fn tune(out: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_samara"));
    // What is given more than once counts as it is given last.
    let given = |option: &str| more.contains(&option);
    let quick = QUICK.chunks(2).filter(|pair| !given(pair[0])).flatten();
    command.args(quick).args(more).arg("--out").arg(out).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn run(out: &Path, more: &[&str]) -> Output {
    tune(out, more).output().unwrap()
}

fn json(output: &Output) -> serde_json::Value {
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.stdout.is_empty(), "{error}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A search for PX4's parameters, four candidates an iteration, in a version that flies without an estimator.
fn tune_for_px4(out: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_samara"));
    let quick = [
        "tune",
        "tests/data/one_release.json",
        "--for",
        "px4",
        "--px4-version",
        "v1.12",
        "--particles",
        "4",
        "--unseen",
        "2",
        "--json",
    ];
    command.args(quick).args(more).arg("--out").arg(out).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Starts a search and waits until its rows hold its first iterations.
fn under_way(search: Command, out: &Path, rows: &str) -> Child {
    let iterations = if rows == ROWS { 10 } else { 4 };
    kept(search, &out.join(rows), |text| text.lines().count() > iterations)
}

/// Starts a search and waits until its rows are so.
fn kept(mut search: Command, rows: &Path, are: impl Fn(&str) -> bool) -> Child {
    let child = search.spawn().unwrap();
    for _ in 0..6000 {
        if fs::read_to_string(rows).is_ok_and(|text| are(&text)) {
            return child;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    child
}

const ROWS: &str = "tune_rows.csv";
const ROWS_FOR_PX4: &str = "tune_px4_rows.csv";

const FILES: [&str; 6] =
    ["gains.json", "gains.params", "convergence.csv", "convergence.svg", "front.csv", ROWS];

#[test]
fn prop_killed_and_resumed_is_as_if_nothing_had_happened() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    let search = ["--iterations", "15", "--threads"];
    let first = run(&whole, &[&search[..], &["1"]].concat());
    assert_eq!(first.status.code(), Some(0), "{}", String::from_utf8_lossy(&first.stderr));
    let told = json(&first);
    assert_eq!((&told["evaluations"], &told["iterations"]), (&120.into(), &15.into()));
    assert!(told["gains"]["k_pq_per_s"].as_f64().unwrap() > 0.0 && told["cost"] == told["rms"]);
    // Killed without a word, then resumed with another number of threads.
    let mut child = under_way(tune(&parts, &[&search[..], &["2"]].concat()), &parts, ROWS);
    child.kill().unwrap();
    child.wait().unwrap();
    let resumed = run(&parts, &[&search[..], &["2", "--resume"]].concat());
    assert_eq!(resumed.status.code(), Some(0), "{}", String::from_utf8_lossy(&resumed.stderr));
    for file in FILES {
        let [a, b] = [&whole, &parts].map(|folder| fs::read(folder.join(file)).unwrap());
        assert!(a == b, "{file} differs");
    }
    // Rows of another search are refused with their place and what is other about it, and nothing else.
    let other = run(&parts, &["--iterations", "15", "--resume", "--seed", "9", "--robust"]);
    let error = String::from_utf8_lossy(&other.stderr).into_owned();
    assert_eq!(other.status.code(), Some(2), "{error}");
    assert!(
        error.contains(
            "tune_rows.csv:1: these rows are of another study: seed was 1, is 9; robust was false, is true: begin anew"
        ) && error.ends_with("in another folder with --out\n"),
        "{error}"
    );
    let none = run(&folder.path().join("nothing"), &["--resume"]);
    assert_eq!(none.status.code(), Some(2));
}

/// A search of gains and one of PX4's parameters whose jobs other processes fly, in three parts, come to the
/// same bytes; one that searches nothing asks for nothing.
#[test]
fn prop_judged_by_others_is_as_if_nobody_else_had() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, asked) = (folder.path().join("whole"), folder.path().join("asked"));
    type Search = fn(&Path, &[&str]) -> Command;
    // PX4's begins with the vehicle's own parameters.
    let kinds: [(Search, &str, &[&str], u32); 2] =
        [(tune, "2", &FILES[..5], 4), (tune_for_px4, "1", &["gains.params", "px4_gains.txt"], 3)];
    for (search, iterations, files, rounds) in kinds {
        let more = ["--iterations", iterations];
        let first = search(&whole, &more).output().unwrap();
        let mut asks = 0;
        let last = loop {
            let output = search(&asked, &[&more[..], &["--ask"]].concat()).output().unwrap();
            if output.status.code() != Some(4) {
                break output;
            }
            asks += 1;
            for part in ["2/3", "0/3", "1/3"] {
                let mut evaluate = Command::new(env!("CARGO_BIN_EXE_samara"));
                let judged = evaluate
                    .arg("evaluate")
                    .arg(asked.join("shards/study.json"))
                    .args(["--shard", part])
                    .output();
                assert_eq!(judged.unwrap().status.code(), Some(0));
            }
        };
        // Two generations; release cases and unseen flights of gains, unseen drops of PX4's parameters.
        assert_eq!(asks, rounds);
        assert_eq!(last.status.code(), first.status.code(), "{}", String::from_utf8_lossy(&last.stderr));
        for file in files {
            assert!(fs::read(whole.join(file)).unwrap() == fs::read(asked.join(file)).unwrap(), "{file}");
        }
        fs::remove_dir_all(&whole).unwrap();
        fs::remove_dir_all(&asked).unwrap();
    }
    let nothing = run(&asked, &["--method", "near-hover", "--ask"]);
    let error = String::from_utf8_lossy(&nothing.stderr).into_owned();
    assert!(nothing.status.code() == Some(2) && error.contains("--ask has no meaning"), "{error}");
}

/// The most iterations end a search and shape nothing else: more of them continue it.
#[test]
fn prop_resumed_for_longer_is_as_if_it_had_been_longer_from_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    let search = |out: &Path, more: &[&str]| {
        let output = run(out, more);
        // Whether they beat the mission's own gains does not matter here.
        assert!(output.status.code().is_some_and(|c| c < 2), "{}", String::from_utf8_lossy(&output.stderr));
        json(&output)
    };
    // Fifteen iterations of the swarm, then those of the strategy; the first part ends in the swarm.
    let at_once = search(&whole, &["--iterations", "18"]);
    assert_eq!(at_once["evaluations"], 15 * 8 + 3 * 16);
    let first = search(&parts, &["--iterations", "4"]);
    assert!(first["cost"].as_f64().unwrap() > at_once["cost"].as_f64().unwrap());
    search(&parts, &["--iterations", "18", "--resume"]);
    for file in FILES {
        let [a, b] = [&whole, &parts].map(|folder| fs::read(folder.join(file)).unwrap());
        assert!(a == b, "{file} differs");
    }
}

/// Four candidates at random do not track as well as the mission's own gains: the last line says so, the exit
/// code is 1, and the gains are written all the same.
#[test]
fn the_answer_is_whether_the_gains_are_better_than_the_missions_own() {
    let folder = tempfile::tempdir().unwrap();
    // In a range of its own: then nothing but chance gives candidates.
    let text = fs::read_to_string("mission/x500_drop.json").unwrap();
    let mut mission: serde_json::Value = serde_json::from_str(&text).unwrap();
    mission["tuning"]["gains"] = serde_json::json!([1e-4, 5.0]);
    let text = mission.to_string().replace("\"../", &format!("\"{}/", env!("CARGO_MANIFEST_DIR")));
    let file = folder.path().join("x500.json");
    fs::write(&file, text).unwrap();
    let file = file.display().to_string();
    let search = |more: &[&str]| {
        let mut args = vec!["tune", &file, "--unseen", "8", "--objective", "rms"];
        args.extend(more);
        let mut command = Command::new(env!("CARGO_BIN_EXE_samara"));
        command.args(args).arg("--out").arg(folder.path()).output().unwrap()
    };
    let random = search(&["--method", "pso", "--particles", "4", "--iterations", "1"]);
    let text = String::from_utf8(random.stdout).unwrap();
    assert_eq!(random.status.code(), Some(1), "{text}");
    // The answer, and behind it what there is to do.
    let last: Vec<&str> = text.lines().rev().take(3).collect();
    let (answer, cause, command) = (last[2], last[1], last[0]);
    assert!(answer.starts_with("tuned is not better than x500 (worst tracking RMS "), "{text}");
    assert!(answer.ends_with(" on 8 unseen flights): keep x500"), "{text}");
    assert!(cause.starts_with("  cause: ") && command.starts_with("  samara design "), "{text}");
    assert!(folder.path().join("gains.json").exists());
}

/// A search for PX4's parameters: killed and resumed, resumed for longer, and another search's rows.
#[test]
fn prop_a_search_for_px4_goes_on_from_its_rows() {
    const FILES: [&str; 3] = ["gains.params", "px4_gains.txt", ROWS_FOR_PX4];
    let folder = tempfile::tempdir().unwrap();
    let [whole, parts, longer] = ["whole", "parts", "longer"].map(|name| folder.path().join(name));
    let search = |out: &Path, more: &[&str]| {
        let output = tune_for_px4(out, more).output().unwrap();
        // Whether they beat PX4's defaults on two drops does not matter here.
        assert!(output.status.code().is_some_and(|c| c < 2), "{}", String::from_utf8_lossy(&output.stderr));
        output
    };
    let at_once = search(&whole, &["--iterations", "6", "--threads", "1"]);
    let told = json(&at_once);
    assert_eq!((&told["evaluations"], &told["stopped"]), (&(2 + 6 * 4).into(), &false.into()));
    // Killed without a word, then resumed with another number of threads.
    let mut child =
        under_way(tune_for_px4(&parts, &["--iterations", "6", "--threads", "2"]), &parts, ROWS_FOR_PX4);
    child.kill().unwrap();
    child.wait().unwrap();
    let resumed = search(&parts, &["--iterations", "6", "--threads", "2", "--resume"]);
    let first = json(&search(&longer, &["--iterations", "2"]));
    assert_eq!(first["evaluations"], 2 + 2 * 4);
    let prolonged = search(&longer, &["--iterations", "6", "--resume"]);
    for (folder, output) in [(&parts, resumed), (&longer, prolonged)] {
        assert_eq!(output.stdout, at_once.stdout);
        for file in FILES {
            let [a, b] = [&whole, folder].map(|folder| fs::read(folder.join(file)).unwrap());
            assert!(a == b, "{file} differs");
        }
    }
    let refused = |mut command: Command| {
        let output = command.output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{error}");
        error
    };
    let other = refused(tune_for_px4(&parts, &["--resume", "--seed", "9"]));
    assert!(
        other.contains("tune_px4_rows.csv:1: these rows are of another study: seed was 1, is 9: "),
        "{other}"
    );
    // A search of the other kind has rows of its own.
    for nothing in [tune(&parts, &["--resume"]), tune_for_px4(&folder.path().join("nothing"), &["--resume"])]
    {
        let error = refused(nothing);
        assert!(error.contains("nothing to go on with"), "{error}");
    }
}

/// Trying what was found on unseen flights can be stopped: then it is written without, and goes on.
#[test]
fn ctrl_c_stops_the_unseen_flights_too() {
    let folder = tempfile::tempdir().unwrap();
    let endless = ["--iterations", "1", "--unseen", "1000000"];
    // The line of the flights behind the search, and some of them.
    let tried = |text: &str| text.rsplit_once("\n# ").is_some_and(|(_, rows)| rows.lines().count() > 9);
    let child = kept(tune(folder.path(), &endless), &folder.path().join(ROWS), tried);
    let stopped = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(stopped.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let told = json(&output);
    assert_eq!((&told["stopped"], &told["best"]), (&false.into(), &serde_json::Value::Null));
    assert_eq!(told["contenders"].as_array().map(Vec::len), Some(0));
    for file in FILES {
        assert!(folder.path().join(file).exists(), "{file}");
    }
}

#[test]
fn ctrl_c_keeps_the_best_so_far() {
    let folder = tempfile::tempdir().unwrap();
    let child = under_way(tune(folder.path(), &["--iterations", "100000"]), folder.path(), ROWS);
    let stopped = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(stopped.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let told = json(&output);
    assert_eq!(told["stopped"], true);
    assert!(told["evaluations"].as_u64().unwrap() >= 8);
    for file in FILES {
        assert!(folder.path().join(file).exists(), "{file}");
    }
}

#[test]
fn ctrl_c_keeps_the_best_so_far_for_px4() {
    let folder = tempfile::tempdir().unwrap();
    let child =
        under_way(tune_for_px4(folder.path(), &["--iterations", "100000"]), folder.path(), ROWS_FOR_PX4);
    let stopped = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(stopped.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let told = json(&output);
    assert!(told["stopped"] == true && told["evaluations"].as_u64().unwrap() >= 2, "{told}");
    for file in ["gains.params", "px4_gains.txt", ROWS_FOR_PX4, "tune_manifest.json"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
}

#[test]
fn bad_options_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (wrong, expected) in [
        (vec!["--start", "nowhere"], "nowhere"),
        (vec!["--name", "a b"], "letters, digits"),
        (vec!["--rms-bound", "0"], "positive"),
        (vec!["--method", "luck"], "near-hover"),
    ] {
        let output = run(folder.path(), &wrong);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{wrong:?}: {error}");
        assert!(error.contains(expected), "{wrong:?}: {error}");
    }
}
