//! `samara plan --grid`: what it writes, what reads it, what it refuses.
#![cfg(feature = "cli")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use samara::config::{PlanGridFile, decode_plan_grid};
use samara::units::DEG_PER_RAD;
use serde_json::Value;

fn samara(words: &[&str], out: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara")).args(words).arg("--out").arg(out).output().unwrap()
}

fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// A small grid, and the grid that its binary holds.
fn small(words: &[&str], out: &Path) -> PlanGridFile {
    let output = samara(&[&["plan", "x500_drop", "--nodes", "12", "--grid=2x1x2x3"], words].concat(), out);
    // Twelve nodes do not tell what flies between them, which is said.
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    decode_plan_grid(&fs::read(out.join("plan_grid.bin")).unwrap()).unwrap()
}

/// The program of a language on the page of the format, written to a folder.
fn program(language: &str, folder: &Path) -> PathBuf {
    let page = fs::read_to_string("docs/plan_grid.md").unwrap();
    let (_, rest) = page.split_once(&format!("```{language}\n")).expect("a program on the page");
    let (text, _) = rest.split_once("```\n").unwrap();
    let path = folder.join(format!("plan_grid.{language}"));
    fs::write(&path, text).unwrap();
    path
}

/// Whether a program is there.
fn there(name: &str) -> bool {
    Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success())
}

/// Velocity and acceleration that a reader prints for a release state at a time.
fn printed(reader: &mut Command, file: &Path, state: &[f64; 4], t_s: f64) -> Vec<f64> {
    let numbers = state.iter().chain([&t_s]).map(|x| format!("{x:?}"));
    let output = reader.arg(file).args(numbers).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    text.split_whitespace().map(|number| number.parse().unwrap()).collect()
}

/// The interpolation of the library is the reference of the readers on the page, in C and in Python: at grid
/// points, between them, outside the grid, before the first node and after the last one.
#[test]
fn reference_readers_on_the_page_agree() {
    let folder = tempfile::tempdir().unwrap();
    let PlanGridFile { grid, target_v_ned, .. } = small(&["--grid-check", "0"], folder.path());
    let file = folder.path().join("plan_grid.bin");
    let mut readers: Vec<Box<dyn Fn() -> Command>> = Vec::new();
    if there("cc") {
        let (source, built) = (program("c", folder.path()), folder.path().join("reader"));
        let mut cc = Command::new("cc");
        cc.args(["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1", "-ffp-contract=off", "-o"]);
        let output = cc.arg(&built).arg(source).output().unwrap();
        assert!(output.status.success(), "{}", said(&output));
        readers.push(Box::new(move || Command::new(&built)));
    }
    if there("python3") {
        let source = program("python", folder.path());
        readers.push(Box::new(move || {
            let mut python = Command::new("python3");
            python.arg(&source);
            python
        }));
    }
    let end_s = grid.plans()[0].end_s();
    let states = [grid.axes().state(4), [0.1, 9.0, 0.01, -0.2], [-9.0, 0.0, 0.4, 0.3], [0.3, 9.3, -0.1, 0.4]];
    for reader in &readers {
        for (state, t_s) in states.iter().zip([0.0, 1.2345, 0.777, -0.1]).chain([(&states[1], end_s)]) {
            let found = printed(&mut reader(), &file, state, t_s);
            let plan = grid.at(state).trajectory;
            let v = if t_s < end_s { plan.velocity_ned(t_s) } else { target_v_ned };
            let a = plan.acceleration_ned(t_s);
            for (found, expected) in found.iter().zip(v.iter().chain(a.iter())) {
                let off = (found - expected).abs();
                assert!(off < 1e-12 * expected.abs().max(10.0), "{state:?} at {t_s}: {found} {expected}");
            }
            assert_eq!(found.len(), 6);
        }
    }
    let mut cut = fs::read(&file).unwrap();
    cut.truncate(200);
    let cut_file = folder.path().join("cut.bin");
    fs::write(&cut_file, cut).unwrap();
    for reader in &readers {
        let output = reader().arg(&cut_file).args(["0", "9", "0", "0", "1"]).output().unwrap();
        assert!(!output.status.success(), "{}", said(&output));
    }
}

/// A grid point of the table is that of the binary, to single precision; the nominal plan stands beside them.
#[test]
fn reference_table_and_binary_hold_one_grid() {
    let folder = tempfile::tempdir().unwrap();
    let PlanGridFile { grid, .. } = small(&["--grid-check", "0"], folder.path());
    let text = fs::read_to_string(folder.path().join("plan_grid.csv")).unwrap();
    let mut rows = text.lines().filter(|line| !line.starts_with('#'));
    let head: Vec<&str> = rows.next().unwrap().split(',').collect();
    assert_eq!(head[..6], ["point", "v_north_m_s", "v_down_m_s", "pitch_deg", "pitch_rate_deg_s", "t_s"]);
    let column = |name: &str| head.iter().position(|known| *known == name).unwrap();
    let rows: Vec<Vec<f64>> =
        rows.map(|row| row.split(',').map(|field| field.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 12 * 12);
    for (number, plan) in grid.plans().iter().enumerate() {
        for (node, row) in plan.nodes().iter().zip(&rows[12 * number..]) {
            assert_eq!(row[0], number as f64);
            let degrees = [1.0, 1.0, DEG_PER_RAD, DEG_PER_RAD];
            let state = grid.axes().state(number);
            assert_eq!(row[1..5], std::array::from_fn::<f64, 4, _>(|axis| state[axis] * degrees[axis]));
            assert_eq!(row[column("t_s")], node.t_s);
            for (name, value) in
                [("vn_m_s", node.v_ned.x), ("ad_m_s2", node.a_ned.z), ("t4_n", node.thrust_n[3])]
            {
                assert_eq!(f64::from(row[column(name)] as f32), value, "{name}");
            }
        }
    }
    let manifest: Value =
        serde_json::from_slice(&fs::read(folder.path().join("plan_grid_manifest.json")).unwrap()).unwrap();
    let files: Vec<&String> = manifest["files"].as_object().unwrap().keys().collect();
    let expected =
        ["plan.json", "plan.svg", "plan_grid.bin", "plan_grid.csv", "plan_grid.json", "trajectory.csv"];
    assert_eq!(files, expected);
    assert_eq!(manifest["circumstances"]["grid"], "2x1x2x3");
}

/// One thread and three write equal bytes, flights included.
#[test]
fn prop_threads_do_not_matter() {
    let [one, three] = ["1", "3"].map(|threads| {
        let folder = tempfile::tempdir().unwrap();
        small(&["--grid-check", "4", "--threads", threads], folder.path());
        let mut files: Vec<PathBuf> =
            fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files.iter().map(|path| fs::read(path).unwrap()).collect::<Vec<_>>()
    });
    assert!(one == three && one.len() == 7, "{}", one.len());
}

/// Of the lander the table says how much a small error of the pitch rate makes, beside what a small grid
/// makes, which stays below the bar for most.
#[test]
fn the_landers_loss_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["plan", "titan_paper", "--grid=2x1x3x9", "--grid-check", "20", "--json"];
    let output = samara(&words, folder.path());
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let loss = &found["loss"];
    let number_of = |of: &Value, key: &str| of[key].as_f64().unwrap();
    let number = |of: &str, key: &str| number_of(&loss[of], key);
    assert_eq!((loss["releases"].as_u64(), loss["unsolved"].as_u64()), (Some(20), Some(0)), "{found:#}");
    assert!(number("by_release", "p50").abs() < 0.01 && number("misread", "max") > 1e-4, "{found:#}");
    assert!((number("j_tpf_interpolated", "p50") - number("j_tpf_solved", "p50")).abs() < 0.01, "{found:#}");
    let is_good = number("by_release", "p99") <= number("misread", "p99").max(number_of(loss, "p99_most"));
    assert_eq!(output.status.code(), Some(i32::from(!is_good)), "{found:#}");
}

/// What cannot be gridded is refused with what was expected; what has no plan is named, and leaves no grid.
#[test]
fn refusals_say_what_is_expected() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |words: &[&str], expected: &str| {
        let output = samara(words, folder.path());
        let said = said(&output);
        assert!(output.status.code() == Some(2) && said.contains(expected), "{words:?}: {said}");
    };
    refused(&["plan", "--grid=2x2"], "four numbers of points from 1 to 64 are expected, such as");
    refused(&["plan", "--grid=0x1x1x1"], "four numbers of points from 1 to 64 are expected");
    refused(&["plan", "--grid=64x64x64x1"], "at most 10000 grid points are expected, found 262144");
    refused(&["plan", "--grid=9x9x9x9", "--nodes", "200"], "at most 1000000 nodes in all are expected");
    refused(
        &["plan", "--grid", "--grid-range", "roll=0:1"],
        "of v_north, v_down, pitch, pitch_rate are expected",
    );
    refused(&["plan", "--grid-check", "3"], "--grid");
    refused(&["plan", "--grid", "--time-limit", "3"], "cannot be used with");
    refused(&["plan", "x500_ground", "--grid"], "this mission begins on the ground");
    let text = fs::read_to_string("mission/x500_drop.json").unwrap();
    let free = "\"plan\": { \"free_horizon\": { \"least_s\": 4, \"greatest_s\": 6 },";
    let text = text.replacen("\"plan\": {", free, 1);
    let text = text.replace("\"../", &format!("\"{}/", env!("CARGO_MANIFEST_DIR")));
    let file = folder.path().join("free.json");
    fs::write(&file, text).unwrap();
    refused(&["plan", &file.display().to_string(), "--grid"], "nodes at times of their own");
    // No plan is found for one that goes up and north at 1400 m/s.
    small(&["--grid-check", "0"], folder.path());
    let words = ["plan", "x500_drop", "--nodes", "12", "--terminal-tolerance", "0.001", "--grid=1x1x1x2"];
    let output = samara(
        &[&words[..], &["--grid-range", "v_north=990:990,v_down=-990:-990,pitch_rate=-26:26"]].concat(),
        folder.path(),
    );
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("no grid: 2 of 2 grid points have no plan"), "{}", said(&output));
    assert!(said(&output).contains("-990.00 m/s down"), "{}", said(&output));
    assert!(!folder.path().join("plan_grid.bin").exists() && folder.path().join("plan.json").exists());
}
