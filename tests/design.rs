//! `samara design` as a user meets it: the same design whatever happens on the way, in a mission that flies.
#![cfg(feature = "cli")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn samara(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samara")).current_dir(folder).args(words).output().unwrap()
}

/// A quick mission: 5 s of plan, 10 s of flight, few flights for each design.
fn quick(folder: &Path) -> String {
    let text = fs::read_to_string("mission/x500_drop.json").unwrap();
    let mut mission: serde_json::Value = serde_json::from_str(&text).unwrap();
    mission["design"] = serde_json::json!({ "draws": 8, "settle_s": 5, "search": { "nodes": [38], "feed_forward": [true, false] } });
    let text = mission.to_string();
    let root = env!("CARGO_MANIFEST_DIR");
    let file = folder.join("quick.json");
    fs::write(&file, text.replace("\"../", &format!("\"{root}/"))).unwrap();
    file.display().to_string()
}

fn design(folder: &Path, mission: &str, more: &[&str]) -> Output {
    let words = ["design", mission, "--unseen", "8", "--finalists", "2"];
    samara(folder, &[&words[..], more].concat())
}

const FILES: [&str; 8] = [
    "design.json",
    "design_mission.json",
    "design_gains.json",
    "design.csv",
    "design_front.csv",
    "design_bode.svg",
    "trajectory.csv",
    "plan.json",
];

/// A search on one thread, one on two that ends early and is resumed, and one whose jobs others fly write the
/// same bytes; the mission that is written is read, and its plan is the design's.
#[test]
fn prop_a_design_is_the_same_on_any_threads_resumed_and_judged_by_others() {
    let folder = tempfile::tempdir().unwrap();
    let mission = quick(folder.path());
    let whole =
        design(folder.path(), &mission, &["--budget", "45", "--out", "whole", "--threads", "1", "--json"]);
    let error = String::from_utf8_lossy(&whole.stderr).into_owned();
    assert!(matches!(whole.status.code(), Some(0 | 1)), "{error}");
    let told: serde_json::Value = serde_json::from_slice(&whole.stdout).unwrap();
    // The mission's own, and with trim or more weight on the descent; the best with feed-forward, with its
    // tilt from gravity, and calmer, in rounds; then two generations.
    assert_eq!((&told["designs"], &told["stopped"]), (&45.into(), &false.into()), "{told}");
    assert_eq!(told["finalists"].as_array().map(Vec::len), Some(2));
    assert_eq!(told["fresh"].as_array().map(Vec::len), Some(6), "own and design in three conditions");
    assert_eq!(told["margins"].as_array().map(Vec::len), Some(27), "nine loops in three states");
    let in_parts = |more: &[&str]| {
        let words = [&["--out", "parts"][..], more].concat();
        let output = design(folder.path(), &mission, &words);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&output.stderr));
    };
    in_parts(&["--budget", "29", "--threads", "2"]);
    in_parts(&["--budget", "45", "--threads", "2", "--resume"]);
    let judged_by_others = || design(folder.path(), &mission, &["--budget", "45", "--out", "asked", "--ask"]);
    // From elsewhere; another number of parts each time, the first one judged twice.
    let elsewhere = tempfile::tempdir().unwrap();
    let asks = folder.path().join("asked/shards/study.json").display().to_string();
    let mut steps = 0;
    let last = loop {
        let output = judged_by_others();
        if output.status.code() != Some(4) {
            break output;
        }
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains(" jobs, samara evaluate asked/shards/study.json"), "{said}");
        assert!(said.contains("samara: --ask is now: --shard I/N, and samara merge DIR\n"), "{said}");
        assert!(output.stdout.is_empty());
        steps += 1;
        // In one part, or in two with the first of them twice.
        for cut in if steps % 2 == 1 { &["0/1"][..] } else { &["0/2", "0/2", "1/2"] } {
            let judged = samara(elsewhere.path(), &["evaluate", &asks, "--shard", cut]);
            assert_eq!(judged.status.code(), Some(0), "{}", String::from_utf8_lossy(&judged.stderr));
        }
    };
    assert!(matches!(last.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&last.stderr));
    assert_eq!(steps, 7, "starts, alternatives twice, two generations, finalists, fresh flights");
    // What may go on for longer stays, and nothing else of its rows.
    let rows = |part: &str| fs::read_to_string(folder.path().join(part).join("design_rows.csv")).unwrap();
    assert!(rows("whole") == rows("parts") && rows("whole").lines().count() == 1 + 45);
    let manifest = fs::read_to_string(folder.path().join("whole/design_manifest.json")).unwrap();
    assert!(manifest.contains("\"design_rows.csv\""), "{manifest}");
    for file in FILES {
        let read = |part: &str| fs::read(folder.path().join(part).join(file)).unwrap();
        assert!(read("whole") == read("parts"), "{file}");
        assert!(read("whole") == read("asked"), "{file}, flown by others");
    }
    let check = samara(folder.path(), &["check", "whole/design_mission.json"]);
    // It reads; loops of so short a search need not keep their margins.
    assert!(matches!(check.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&check.stderr));
    let plan = samara(folder.path(), &["plan", "whole/design_mission.json", "--out", "plan"]);
    // Found, be its nodes too few for what flies between them.
    assert!(matches!(plan.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&plan.stderr));
    let nodes = |part: &str| {
        let text = fs::read_to_string(folder.path().join(part).join("trajectory.csv")).unwrap();
        text.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(nodes("plan"), nodes("whole"));
}

/// Rows of another search are refused, with what differs; so is a time limit that is none.
#[test]
fn what_is_not_of_the_search_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mission = quick(folder.path());
    let first = design(folder.path(), &mission, &["--budget", "4", "--out", "out"]);
    assert!(matches!(first.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&first.stderr));
    for (more, words) in [
        (&["--resume", "--seed", "2", "--out", "out"][..], "seed was 1, is 2"),
        (&["--resume", "--start", "x500_hover", "--out", "out"], "gains was x500, is x500_hover"),
        (&["--resume", "--out", "nowhere"], "design_rows.csv: no such file: nothing to go on with"),
        (&["--time-limit", "0"], "a positive number is expected"),
        (&["--time-limit", "9", "--ask", "--out", "out"], "cannot be used with"),
        (&["--ask"], "--out <DIR>"),
        (&["--against", "nobody"], "nobody"),
    ] {
        let output = design(folder.path(), &mission, more);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && error.contains(words), "{more:?}: {error}");
    }
}

/// A file that asks for nothing, for what there is not, or for another search than it leads to is refused,
/// and nothing is written; rows of another search are not taken, those of a longer one are.
#[test]
fn what_others_cannot_judge_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mission = quick(folder.path());
    let ask = |more: &[&str]| design(folder.path(), &mission, &[&["--out", "out", "--ask"], more].concat());
    let asked = ask(&["--budget", "4"]);
    assert_eq!(asked.status.code(), Some(4), "{}", String::from_utf8_lossy(&asked.stderr));
    let asks = fs::read_to_string(folder.path().join("out/shards/study.json")).unwrap();
    let refused = |text: &str, words: &str| {
        fs::create_dir_all(folder.path().join("other/shards")).unwrap();
        fs::write(folder.path().join("other/shards/study.json"), text).unwrap();
        for more in [&["--check"][..], &[]] {
            let words_of = ["evaluate", "other/shards/study.json", "--out", "none"];
            let output = samara(folder.path(), &[&words_of[..], more].concat());
            let error = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.code() == Some(2) && error.contains(words), "{words}: {error}");
        }
        assert!(!folder.path().join("none/shards").exists(), "{words}");
    };
    refused("{}", "missing field `study`");
    refused(&asks.replace("\"study\": \"design\"", "\"study\": \"plan\""), "found `plan`");
    refused(&asks.replace("\"budget\"", "\"badget\""), "settings.badget: no such setting");
    refused(&asks.replace("\"seed\": 1", "\"seed\": 2"), "hash of the inputs");
    refused(&asks.replace("\\\"seed\\\":1", "\\\"seed\\\":3"), "seed was 3, is 1");
    refused("{", "study.json");
    let good = samara(folder.path(), &["evaluate", "out/shards/study.json", "--check"]);
    assert_eq!(good.status.code(), Some(0), "{}", String::from_utf8_lossy(&good.stderr));
    let rows = || fs::read_dir(folder.path().join("out/shards")).unwrap().count() - 1;
    assert_eq!(rows(), 0);
    // Judged for one seed, asked for by another.
    let judged = samara(folder.path(), &["evaluate", "out/shards/study.json"]);
    assert_eq!((judged.status.code(), rows()), (Some(0), 1), "{}", String::from_utf8_lossy(&judged.stderr));
    let other = ask(&["--budget", "4", "--seed", "2"]);
    let error = String::from_utf8_lossy(&other.stderr).into_owned();
    assert!(other.status.code() == Some(2) && error.contains("seed was 1, is 2"), "{error}");
    assert_eq!(ask(&["--budget", "45"]).status.code(), Some(4));
}

/// A search that its time limit ends is reported, and tried, as far as it came; in shards there is no clock.
#[test]
fn a_time_limit_ends_the_search_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let mission = quick(folder.path());
    let limited = ["--budget", "100000", "--time-limit", "4", "--out", "out", "--json"];
    let output = design(folder.path(), &mission, &limited);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(matches!(output.status.code(), Some(0 | 1)), "{error}");
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(told["stopped"] == true && told["designs"].as_u64().unwrap() < 100_000, "{told}");
    assert_eq!(told["fresh"].as_array().map(|fresh| fresh.len() % 3), Some(0));
    assert!(told["wall_s"].as_f64().unwrap() >= 4.0);
    let output = design(folder.path(), &mission, &["--time-limit", "4", "--shard", "0/2", "--out", "out"]);
    assert_eq!(output.status.code(), Some(2));
}

/// A vehicle that is drafted from its data sheet, with six rotors, is designed like any other.
#[test]
#[ignore = "half a minute: scripts/test --all"]
fn a_hexacopter_of_one_s_own_is_designed() {
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str| {
        let words: Vec<&str> = line.split(' ').collect();
        let output = samara(folder.path(), &words);
        let code = output.status.code();
        assert!(matches!(code, Some(0 | 1)), "{line}: {code:?} {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    run("new vehicle heron --mass 4.5 --frame hexa-x --arm 0.4 --propeller 15in --thrust 18");
    run(
        "new mission heron_drop --vehicle heron.json --planet earth --altitude 3000 --from balloon --target 0,0,0",
    );
    let said = run("design heron_drop.json --budget 4 --unseen 16 --finalists 1 --out out");
    let decided = said.lines().find(|line| line.starts_with("design is ")).unwrap();
    assert!(decided.contains("J_TPF in turbulence"), "{said}");
    assert!(folder.path().join("out/design_mission.json").exists());
}

/// The commands that the help recommends after a design, in the folders that they have by themselves: what
/// the campaign of the mission had written is there to the byte, and a card of the design finds the design.
#[test]
fn regress_the_drop_of_a_design_keeps_the_missions_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let mission = quick(folder.path());
    let well = |words: &[&str], codes: &[i32]| {
        let output = samara(folder.path(), words);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(codes.contains(&output.status.code().unwrap()), "{words:?}: {said}");
        (String::from_utf8_lossy(&output.stdout).into_owned(), said)
    };
    well(&["assess", &mission, "--autopilot", "px4-model", "--trials", "2"], &[0]);
    let out = folder.path().join("out/x500_drop");
    let manifest = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path()).find(|path| {
        let name = path.file_name().unwrap().to_str().unwrap();
        name.starts_with("drops_px4-model") && name.ends_with("_manifest.json")
    });
    let manifest = manifest.unwrap();
    let campaign: serde_json::Value = serde_json::from_slice(&fs::read(&manifest).unwrap()).unwrap();
    let files: Vec<&String> = campaign["files"].as_object().unwrap().keys().collect();
    let read = |place: &Path| {
        files.iter().map(|name| fs::read(place.join(name)).unwrap_or_default()).collect::<Vec<_>>()
    };
    let before = read(&out);
    let (_, said) =
        well(&["design", &mission, "--budget", "2", "--unseen", "12", "--finalists", "1"], &[0, 1]);
    assert!(
        said.contains("samara: the results of `samara assess --autopilot px4-model` of x500_drop"),
        "{said}"
    );
    let aside: Vec<_> = fs::read_dir(out.join("earlier")).unwrap().map(|e| e.unwrap().path()).collect();
    assert!(aside.len() == 1 && read(&aside[0]) == before, "{aside:?}");
    assert_eq!(fs::read(aside[0].join(manifest.file_name().unwrap())).unwrap(), fs::read(&manifest).unwrap());

    let designed = "out/x500_drop/design_mission.json";
    let listing = || {
        let names = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name());
        names.collect::<std::collections::BTreeSet<_>>()
    };
    let left = listing();
    let (_, said) = well(&["drop", designed], &[0, 1]);
    assert!(!said.contains("replaces") && !said.contains("set aside"), "{said}");
    assert_eq!(listing(), left);
    assert!(folder.path().join("out/x500_drop_design/drop.json").exists());
    let (card, _) = well(&["card", designed, "--json"], &[1]);
    let card: serde_json::Value = serde_json::from_str(&card).unwrap();
    let kinds: Vec<_> =
        card["evidence"].as_array().unwrap().iter().map(|e| (&e["kind"], &e["refused"])).collect();
    let null = &serde_json::Value::Null;
    assert_eq!(kinds, [(&"design".into(), null), (&"drop".into(), null)]);
}
