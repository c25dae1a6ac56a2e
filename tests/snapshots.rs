//! What the program prints and writes, as it was last looked at: texts, objects and pages, kept in
//! `tests/snapshots`. A change that is meant is reviewed with `cargo insta review`, or taken by
//! `INSTA_UPDATE=always cargo test --test integration snapshots::` and read in the difference.
//!
//! Numbers stand with six digits here: bits are the business of `scripts/fingerprints`.
#![cfg(all(feature = "cli", feature = "files", feature = "link", feature = "shards"))]

use std::fs;
use std::path::Path;
use std::process::Command;

use samara::{report, study};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// A folder in which commands run one after another; `OUT` stands for it.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self) -> &str {
        self.0.path().to_str().unwrap()
    }

    /// Runs a command with this exit code; what it prints and says.
    fn run(&self, code: i32, line: &str) -> String {
        let words = line.split(' ').map(|word| word.replace("OUT", self.path()));
        let mut command = Command::new(env!("CARGO_BIN_EXE_samara"));
        let done = command.args(words).env("NO_COLOR", "1").output().unwrap();
        let (said, printed) = (String::from_utf8_lossy(&done.stderr), String::from_utf8_lossy(&done.stdout));
        assert_eq!(done.status.code(), Some(code), "{line}: {said}{printed}");
        results_are_of_their_types(self.0.path());
        match said.lines().all(is_of_the_clock) {
            true => printed.into_owned(),
            false => format!("{printed}--- stderr\n{said}"),
        }
    }

    /// Snapshot of what a command prints and says.
    fn says(&self, name: &str, code: i32, line: &str) {
        self.is(name, line, &self.run(code, line));
    }

    /// Snapshot of a file that a command has left.
    fn wrote(&self, name: &str, file: &str) {
        let text = fs::read_to_string(self.0.path().join(file)).unwrap();
        let text = if Path::new(file).extension().is_some_and(|e| e == "html") { page(&text) } else { text };
        self.is(name, file, &text);
    }

    /// Snapshot of a text, without what changes with machine, build and time of day.
    fn is(&self, name: &str, of: &str, text: &str) {
        let root = fs::canonicalize(".").unwrap().display().to_string();
        let text = text.replace(self.path(), "OUT").replace(&root, "ROOT");
        let text = text.replace(env!("CARGO_PKG_VERSION"), "VERSION");
        let lines = text.lines().filter(|line| !is_of_the_clock(line));
        let text: Vec<String> = lines.map(neutral).collect();
        let mut settings = insta::Settings::clone_current();
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        settings.set_description(of);
        settings.bind(|| insta::assert_snapshot!(name, text.join("\n")));
    }
}

/// Every result below a folder is read as its type and written again as it was.
fn results_are_of_their_types(folder: &Path) {
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            results_are_of_their_types(&entry);
        } else if let Some(name) = entry.file_name().and_then(|name| name.to_str()) {
            let Some(again) = type_of(name, &entry) else { continue };
            let text = fs::read_to_string(&entry).unwrap();
            let again = again(&text).unwrap_or_else(|error| panic!("{}: {error}", entry.display()));
            if name == "cases.json" {
                // Its lines are broken elsewhere.
                let [read, written] =
                    [&again, &text].map(|text| serde_json::from_str::<Value>(text).unwrap());
                assert_eq!(read, written, "{}", entry.display());
            } else {
                assert_eq!(again, text, "{}", entry.display());
            }
        }
    }
}

type Again = fn(&str) -> serde_json::Result<String>;

/// What reads a file as a result and writes it again; `None`: it is no result.
fn type_of(name: &str, path: &Path) -> Option<Again> {
    fn again<T: Serialize + DeserializeOwned>(text: &str) -> serde_json::Result<String> {
        Ok(serde_json::to_string_pretty(&serde_json::from_str::<T>(text)?)? + "\n")
    }
    let of: Again = match name {
        "drop.json" => again::<report::json::DropObject>,
        "cases.json" => again::<report::json::CasesObject>,
        "plan.json" => again::<report::plan::PlanObject>,
        "assess.json" if path.with_file_name("table5.csv").exists() => {
            again::<study::paper::records::StudyObject>
        }
        "assess.json" => again::<study::campaign::json::AssessObject>,
        "envelope.json" => again::<study::envelope::report::EnvelopeObject>,
        "rare.json" => again::<study::rare::report::RareObject>,
        "rare_failure.json" => again::<study::rare::report::RareFailureObject>,
        "design.json" => again::<study::designing::report::DesignObject>,
        "effects.json" => again::<study::effects::report::EffectsObject>,
        "replan.json" => again::<study::replan::report::ReplanObject>,
        "sobol.json" => again::<study::sobol::report::SobolObject>,
        "fidelity.json" => again::<study::fidelity::FidelityObject>,
        "free_fall.json" => again::<study::free_fall::report::FreeFallObject>,
        "plan_grid.json" => again::<study::plan_grid::report::PlanGridObject>,
        "compare.json" => again::<study::compare::CompareObject>,
        "card.json" => again::<study::card::json::CardObject>,
        name if name.ends_with("_manifest.json") => again::<study::card::manifest::RunManifest>,
        name if name.starts_with("drops_") && name.ends_with(".json") => {
            again::<study::campaign::json::AssessObject>
        }
        _ => return None,
    };
    Some(of)
}

/// Whether a line says how long something took, and nothing else.
fn is_of_the_clock(line: &str) -> bool {
    let keys = [
        "real_time_factor",
        "solve_ms",
        "wall_s",
        "_per_s\"",
        "times real time",
        " s left",
        " min left",
        "takes about",
    ];
    keys.iter().any(|key| line.contains(key))
}

/// A line with six digits of each number, and without hashes and durations.
fn neutral(line: &str) -> String {
    let mut shown = String::new();
    // How a drafted file comes to the schemas hangs on where the temporary folder is.
    let mut rest = line.trim_start();
    shown += &line[..line.len() - rest.len()];
    if let Some((key, place)) = rest.split_once(": ").filter(|(key, _)| *key == "\"$schema\"") {
        shown += &format!("{key}: \"ROOT");
        rest = place.find("/params/schema").map_or(place, |at| &place[at..]);
    }
    while let Some(at) = rest.find(|c: char| c.is_ascii_alphanumeric()) {
        shown += &rest[..at];
        rest = &rest[at..];
        let in_number = |c: char| c.is_ascii_alphanumeric() || c == '.' || c == '_';
        let mut end = rest.find(|c: char| !in_number(c)).unwrap_or(rest.len());
        // The exponent of 1.5e-7.
        let digits = rest.starts_with(|c: char| c.is_ascii_digit());
        if digits && rest[..end].ends_with('e') && rest[end..].starts_with(['-', '+']) {
            let more = rest[end + 1..].find(|c: char| !c.is_ascii_digit());
            end = more.map_or(rest.len(), |more| end + 1 + more);
        }
        let word = &rest[..end];
        let is_hash = word.len() >= 8
            && word.bytes().all(|b| b.is_ascii_hexdigit())
            && word.bytes().any(|b| b.is_ascii_digit())
            && (word.len() == 64 || word.bytes().any(|b| b.is_ascii_alphabetic()));
        let number: Option<f64> =
            word.parse().ok().filter(|_| digits && word.contains('.') && word.len() > 7);
        // `in 4.5 ms`, `in 2 s`, `532 a second`.
        let unit =
            rest[end..].split(|c: char| !c.is_ascii_alphabetic() && c != ' ').next().unwrap_or_default();
        let is_duration = digits
            && match unit.split(' ').nth(1) {
                Some("ms") => word.contains('.'),
                Some("s") => shown.ends_with(" in "),
                Some("a") => unit.starts_with(" a second"),
                _ => false,
            };
        shown += &match number {
            _ if is_hash => "HASH".to_owned(),
            _ if is_duration => "T".to_owned(),
            Some(x) => six(x),
            None => word.to_owned(),
        };
        rest = &rest[end..];
    }
    shown + rest
}

/// Six digits that count.
fn six(x: f64) -> String {
    let short: f64 = format!("{x:.5e}").parse().unwrap();
    format!("{short:?}")
}

/// What of a page is for people: its elements, a line each, without scripts, styles and courses of curves.
fn page(text: &str) -> String {
    let mut shown = text.to_owned();
    for name in ["script", "style"] {
        let mut kept = String::new();
        let mut rest = shown.as_str();
        while let Some((before, after)) = rest.split_once(&format!("<{name}")) {
            let (attributes, inner) = after.split_once('>').unwrap();
            kept += &format!("{before}<{name}{attributes}>..");
            rest = &inner[inner.find(&format!("</{name}>")).unwrap()..];
        }
        shown = kept + rest;
    }
    for attribute in [" d=\"", " points=\"", "sha256-"] {
        let mut kept = String::new();
        let mut rest = shown.as_str();
        while let Some((before, after)) = rest.split_once(attribute) {
            kept += &format!("{before}{attribute}..");
            rest = &after[after.find(['"', '\'']).unwrap()..];
        }
        shown = kept + rest;
    }
    let shown = shown.replace("><", ">\n<");
    let drawn = [
        "<path",
        "<circle",
        "<polyline",
        "<polygon",
        "<rect",
        "<line",
        "</line",
        "</circle",
        "</rect",
        "</path",
    ];
    let lines = shown.lines().filter(|line| !drawn.iter().any(|tag| line.trim_start().starts_with(tag)));
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn drops() {
    let place = Place::new();
    place.says("drop", 0, "drop titan_drop --out OUT/a");
    place.wrote("drop_json", "a/drop.json");
    place.wrote("drop_page", "a/drop.html");
    place.wrote("drop_manifest", "a/drop_manifest.json");
    place.says("drop_again", 0, "drop titan_drop --gains safety --out OUT/a --no-html");
    place.says("drop_json_printed", 0, "drop x500_drop --json --out OUT/b --no-html");
    place.says("drop_cases", 0, "drop x500_drop --cases --out OUT/c --no-html");
    place.says("drop_replan", 0, "drop x500_drop --replan 10 --out OUT/d --no-html");
    place.says("drop_titan_air", 0, "drop titan_drop --out OUT/e --no-html");
    place.wrote("drop_titan_air_json", "e/drop.json");
}

/// Drops from too low and never steady; keys and values that are none; campaigns of a limit that is passed.
#[test]
fn objections() {
    let place = Place::new();
    let mission = |name: &str, from: &str, to: &str| {
        let text = fs::read_to_string("mission/x500_drop.json").unwrap();
        assert!(text.contains(from), "{from}");
        let root = fs::canonicalize(".").unwrap();
        let text = text.replace("\"../params", &format!("\"{}/params", root.display())).replacen(from, to, 1);
        fs::write(place.0.path().join(name), text).unwrap();
    };
    mission("low.json", "\"ground_altitude_m\": 488", "\"ground_altitude_m\": 590");
    place.says("drop_too_low", 1, "drop OUT/low.json --out OUT/a --no-html");
    mission("close.json", "\"steady_within_m_s\": 0.3", "\"steady_within_m_s\": 1e-4");
    place.says("drop_never_steady", 1, "drop OUT/close.json --out OUT/b");
    place.wrote("drop_never_steady_page", "b/drop.html");
    place.says("assess_never_steady", 1, "assess OUT/close.json --trials 100 --out OUT/c");
    mission("key.json", "\"limits\": {", "\"limits\": { \"steady_within_m\": 1,");
    place.says("bad_key", 2, "drop OUT/key.json --out OUT/d");
    mission("value.json", "\"descent_m_s\": 5.0", "\"descent_m_s\": -5.0");
    place.says("bad_value", 2, "drop OUT/value.json --out OUT/e");
    place.says("bad_name", 2, "drop x500_dorp --out OUT/f");
}

#[test]
fn plans() {
    let place = Place::new();
    place.says("plan", 0, "plan titan_drop --out OUT/a");
    place.wrote("plan_json", "a/plan.json");
    place.says("plan_few_nodes", 1, "plan titan_drop --nodes 10 --out OUT/b");
    place.says("plan_grid", 0, "plan x500_drop --grid=2x2x3x3 --grid-check 20 --out OUT/c");
    place.says("check", 0, "check x500_drop");
}

#[test]
fn studies() {
    let place = Place::new();
    place.says("assess", 0, "assess x500_drop --trials 300 --out OUT/a");
    place.wrote("assess_json", "a/assess.json");
    place.wrote("assess_page", "a/assess.html");
    place.wrote("assess_junit", "a/junit.xml");
    place.says("assess_paper", 0, "assess --paper --trials 60 --out OUT/b");
    place.wrote("assess_paper_page", "b/assess.html");
    place.says("assess_model", 0, "assess x500_drop --autopilot px4-model --trials 12 --out OUT/c");
    place.says(
        "assess_envelope",
        0,
        "study envelope tests/calm_x500.json --pairs pitch:pitch_rate --rays 4 --out OUT/d",
    );
    place.says("assess_only", 0, "assess x500_drop --only 3 --out OUT/e");
}

#[test]
fn studies_of_causes() {
    let place = Place::new();
    place.says("assess_sobol", 0, "study sobol x500_drop --points 64 --out OUT/a");
    let calm = "tests/calm_x500.json";
    place.says(
        "assess_rare",
        1,
        &format!("study rare {calm} --least 1e-2 --bound 0.5 --per-level 800 --out OUT/b"),
    );
    place.says("assess_effects", 0, "study effects x500_drop --trials 4 --out OUT/c");
    place.says("assess_replan", 0, "study replan x500_drop --when release --trials 4 --out OUT/d");
    place.says("assess_free_fall", 0, "study free-fall x500_no_wire --hours 1 --trials 20 --out OUT/e");
}

#[test]
fn searches() {
    let place = Place::new();
    place.says(
        "tune",
        1,
        "tune titan_drop --seed 4 --method cma-es --start safety --iterations 2 --unseen 20 --out OUT/a",
    );
    place.says("tune_px4", 1, "tune x500_drop --for px4 --particles 4 --iterations 1 --unseen 4 --out OUT/c");
    place.wrote("tune_px4_params", "c/gains.params");
    let few = "--set design.draws=8 --budget 8 --finalists 1 --unseen 8";
    place.says("design", 1, &format!("design x500_drop {few} --out OUT/d"));
    place.wrote("design_json", "d/design.json");
}

/// Evidence, and the card that is made of it.
#[test]
fn cards() {
    let place = Place::new();
    place.run(0, "drop x500_drop --out OUT/a --no-html");
    place.run(0, "assess x500_drop --autopilot reference --trials 20 --out OUT/b --no-html");
    let evidence = "card x500_drop --evidence OUT/a --evidence OUT/b --p-failure 0.2 --out";
    place.says("card", 1, &format!("{evidence} OUT/card"));
    place.wrote("card_json", "card/card.json");
    place.wrote("card_page", "card/card.html");
    place.run(0, "assess x500_drop --autopilot px4-model --trials 30 --out OUT/m --no-html");
    let ways = "--by OUT/b/drops_reference_x500.csv --by OUT/m/drops_px4-model_x500_px4_tuned.csv";
    place.says("fidelity", 0, &format!("fidelity x500_drop {ways} --out OUT/f"));
}

/// What a beginner makes of a data sheet, and parameters.
#[test]
fn beginnings() {
    let place = Place::new();
    let sheet = "--mass 1.2 --frame quad-x --arm 0.2 --propeller 9in --thrust 7";
    place.says("new_vehicle", 0, &format!("new vehicle quad7 {sheet} --out OUT/quad7.json"));
    place.wrote("new_vehicle_file", "quad7.json");
    let site = "--planet earth --altitude 800 --out OUT/quad7_drop.json";
    place.says("new_mission", 0, &format!("new mission quad7_drop --vehicle OUT/quad7.json {site}"));
    place.wrote("new_mission_file", "quad7_drop.json");
    place.says("params_check", 1, "params check params/px4/titan_px4.params");
    place.says("params_diff", 1, "params diff params/px4/titan_px4.params params/px4/titan_samara.params");
    place.says("params_export", 0, "params export x500_drop --for px4 --out OUT/x500.params");
    place.wrote("params_export_file", "x500.params");
}
