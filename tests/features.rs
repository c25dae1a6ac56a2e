//! The table of kinds and features against what the program does: each kind is flown, small, and every cell
//! is looked at.
#![cfg(all(feature = "cli", feature = "shards"))]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use samara::study::card::manifest::Kind as Evidence;
use samara::study::feature::Feature;
use samara::study::kind::About;
use samara::study::kinds::table;

/// A small run of each kind, and what its `--only` takes.
const RUNS: [(&str, &str, &str); 12] = [
    ("own", "assess tests/calm_x500.json --trials 12", "3"),
    ("paper", "assess titan_paper --paper --trials 12", "3"),
    ("drops", "assess tests/calm_x500.json --autopilot px4-model --trials 3", "1"),
    ("effects", "study effects x500_drop --trials 2", "1"),
    ("envelope", "study envelope tests/calm_x500.json --pairs wind:delay --rays 4", "1"),
    ("rare", "study rare tests/calm_x500.json --least 1e-1 --bound 0.3 --per-level 800", "rare_failure.json"),
    ("sobol", "study sobol tests/calm_x500.json --points 64", "1"),
    ("replan", "study replan tests/calm_x500.json --when release --trials 2", "1"),
    ("free_fall", "study free-fall x500_no_wire --hours 1 --trials 20", "1"),
    ("design", "study design tests/data/one_release.json --budget 3 --unseen 4 --finalists 1", "1"),
    ("tune", "study tune tests/data/one_release.json --particles 4 --iterations 1 --unseen 4", "1"),
    (
        "tune_px4",
        "study tune-px4 tests/data/one_release.json --px4-version v1.12 --particles 4 --iterations 1 --unseen 4",
        "1",
    ),
];

/// Most cells that are refused.
const REFUSED_MOST: usize = 15;

fn samara(run: &str, more: &[&str]) -> Output {
    let words = run.split_whitespace().chain(more.iter().copied());
    Command::new(env!("CARGO_BIN_EXE_samara")).args(words).output().unwrap()
}

/// The output of a run that came to an answer.
fn answered(run: &str, more: &[&str]) -> Output {
    let output = samara(run, more);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code().is_some_and(|code| code <= 1), "{run} {more:?}: {said}");
    output
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap()).filter(|e| e.path().is_file());
    entries.map(|e| (e.file_name().into_string().unwrap(), fs::read(e.path()).unwrap())).collect()
}

/// What a refused cell is asked with, if it can be.
fn asks<'a>(feature: Feature, only: &'a str, out: &'a str) -> Option<Vec<&'a str>> {
    match feature {
        Feature::Resume => Some(vec!["--resume", "--out", out]),
        Feature::Shard => Some(vec!["--shard", "0/1", "--out", out]),
        Feature::Only => Some(vec!["--only", only, "--out", out]),
        Feature::Keep => Some(vec!["--keep", "summary", "--out", out]),
        _ => None,
    }
}

/// Every kind has a run here, every refusal a reason, and there are few of them.
#[test]
fn few_cells_are_refused_each_with_a_reason() {
    let kinds: Vec<&str> = table().iter().map(|about| about.name).collect();
    assert_eq!(kinds, RUNS.map(|(name, ..)| name));
    let refusals = table().iter().flat_map(|about| Feature::ALL.map(|f| about.refusal(f))).flatten().count();
    assert!(refusals <= REFUSED_MOST, "{refusals} cells are refused");
    for why in table().iter().flat_map(|about| Feature::ALL.map(|f| about.refusal(f))).flatten() {
        assert!(why.len() > 20 && !why.contains("not built") && !why.contains("not yet"), "{why}");
    }
}

/// Files that a run leaves are those that its row promises, and no others; `--json` prints one object.
#[test]
#[ignore = "half a minute: scripts/test --all"]
fn every_kind_writes_what_its_row_has() {
    for (about, (_, run, _)) in table().iter().zip(RUNS) {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().to_str().unwrap();
        let output = answered(run, &["--out", out, "--json"]);
        let object: Result<serde_json::Value, _> = serde_json::from_slice(&output.stdout);
        let files = files(folder.path());
        let of_plan = ["plan.svg", "trajectory.csv"];
        let any = |ending: &str| {
            files.keys().any(|name| name.ends_with(ending) && !of_plan.contains(&name.as_str()))
        };
        // Names of drops go on with the autopilot's.
        let is_read = |verb: &str| [verb, &format!("{verb}_")].iter().any(|v| Evidence::of_verb(v).is_some());
        let found = [
            (Feature::Page, any(".html")),
            (Feature::Junit, any("junit.xml")),
            (Feature::Figure, any(".svg")),
            (Feature::Csv, any(".csv")),
            (Feature::Json, object.is_ok_and(|object| object.is_object())),
            // The card tells the paper's study from a mission's own by what is in it.
            (Feature::Card, is_read(about.manifest) && about.name != "paper"),
        ];
        for (feature, has) in found {
            assert_eq!(
                has,
                about.refusal(feature).is_none(),
                "{}: {feature:?}: {:?}",
                about.name,
                files.keys()
            );
        }
    }
}

/// What is refused is refused in the words of the table.
#[test]
fn what_a_row_refuses_is_refused_in_its_words() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    for (about, (_, run, only)) in table().iter().zip(RUNS) {
        for feature in Feature::ALL {
            let Some(asked) = asks(feature, only, out.to_str().unwrap()) else { continue };
            let Some(why) = about.refusal(feature) else { continue };
            let output = samara(run, &asked);
            let said = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{} {feature:?}: {said}", about.name);
            assert!(
                said.contains(&format!("--{}: {why}", feature.name())),
                "{} {feature:?}: {said}",
                about.name
            );
        }
    }
    assert!(!out.exists());
}

/// One flight again, rows that stay, going on from them, shards: of each kind that has them.
#[test]
#[ignore = "a minute: scripts/test --all"]
fn prop_what_a_row_has_ends_in_the_same_bytes() {
    for (about, (_, run, only)) in table().iter().zip(RUNS) {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let [whole, apart, kept] = ["whole", "apart", "kept"].map(place);
        answered(run, &["--out", &whole]);
        if about.refusal(Feature::Shard).is_none() {
            in_shards(about, run, &apart);
            assert!(files(Path::new(&whole)) == files(Path::new(&apart)), "{}", about.name);
        }
        if about.refusal(Feature::Keep).is_none() {
            let is_study = run.starts_with("study");
            answered(
                run,
                &[&["--keep"][..], if is_study { &[] } else { &["all"] }, &["--out", &kept]].concat(),
            );
            let resumed = answered(run, &["--resume", "--out", &kept]);
            assert!(files(Path::new(&whole)) == files(Path::new(&kept)), "{}: {resumed:?}", about.name);
        } else {
            answered(run, &["--resume", "--out", &whole]);
        }
        if about.refusal(Feature::Only).is_none() {
            let failure = Path::new(&whole).join(only);
            let only = if only.ends_with(".json") { failure.to_str().unwrap() } else { only };
            let run = run.split(" --trials").next().unwrap().split(" --least").next().unwrap();
            answered(run, &["--only", only, "--out", &place("alone")]);
            // What has a table has the rows of that one flight.
            let rows = |folder: &str, file: String| fs::read_to_string(Path::new(folder).join(file));
            if let Ok(alone) = rows(&place("alone"), format!("{}_only.csv", about.name)) {
                let all = rows(&whole, format!("{}.csv", about.name)).unwrap();
                let of_trial: Vec<&str> = all.lines().filter(|row| row.starts_with("1,")).collect();
                let found: Vec<&str> = alone.lines().filter(|row| row.starts_with("1,")).collect();
                assert!(!found.is_empty() && found == of_trial, "{}", about.name);
            }
        }
    }
}

/// Flies a run in two shards, round by round, and puts them together.
fn in_shards(about: &About, run: &str, out: &str) {
    for _ in 0..300 {
        for cut in ["1/2", "0/2"] {
            answered(run, &["--shard", cut, "--out", out]);
        }
        let merged = samara("merge", &[out]);
        if merged.status.code().is_some_and(|code| code <= 1) {
            return;
        }
        let said = String::from_utf8_lossy(&merged.stderr);
        assert!(said.contains("are missing"), "{}: {said}", about.name);
    }
    panic!("{}: rounds without an end", about.name);
}
