//! The tables of results in README and docs, beside what flies: each is as its recipe made it, and mission,
//! vehicle, gains and one nominal flight are those of that day. `scripts/regenerate --figures` makes them
//! again.
#![cfg(feature = "cli")]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use serde_json::Value;
use sha2::{Digest, Sha256};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn json(path: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(root().join(path)).unwrap()).unwrap()
}

fn sha256(data: impl AsRef<[u8]>) -> String {
    Sha256::digest(data).iter().map(|byte| format!("{byte:02x}")).collect()
}

fn recipes() -> Value {
    json("docs/results.json")
}

fn lock() -> Value {
    json("docs/results.lock.json")
}

fn pages() -> BTreeMap<String, String> {
    let docs = fs::read_dir(root().join("docs")).unwrap().map(|entry| entry.unwrap().file_name());
    let docs = docs.map(|name| format!("docs/{}", name.to_str().unwrap()));
    let pages = docs.filter(|name| name.ends_with(".md")).chain(["README.md".to_owned()]);
    pages.map(|name| (name.clone(), fs::read_to_string(root().join(name)).unwrap())).collect()
}

/// What stands between the marks of results in a page: name, what the mark says behind it, text.
fn blocks(page: &str) -> Vec<(&str, &str, &str)> {
    let marked = page.split("<!-- results: ").skip(1).map(|rest| {
        let (mark, rest) = rest.split_once(" -->\n").unwrap();
        let (text, _) = rest.split_once("<!-- end -->").expect("a mark of results ends with <!-- end -->");
        let (name, behind) = mark.split_once(", ").unwrap_or((mark, ""));
        (name, behind, text)
    });
    marked.collect()
}

/// What a mission says: its values, and those of the files that it names, without words for people. As
/// `scripts/figures` has it.
#[derive(Default)]
struct Meaning(Vec<String>);

impl Meaning {
    fn of(mission: &Path) -> String {
        let mut meaning = Self::default();
        meaning.file("mission", mission);
        sha256(meaning.0.join("\n"))
    }

    fn file(&mut self, role: &str, path: &Path) {
        let bytes = fs::read(path).unwrap();
        if path.extension().is_some_and(|e| e == "json") {
            self.value(role, &serde_json::from_slice(&bytes).unwrap(), path.parent().unwrap());
        } else {
            self.0.push(format!("{role}=file {}", sha256(bytes)));
        }
    }

    fn value(&mut self, name: &str, value: &Value, folder: &Path) {
        match value {
            Value::Object(keys) => {
                let sorted: BTreeMap<_, _> = keys.iter().collect();
                for (key, value) in sorted {
                    // PX4's parameters are no gains of the cascade: what flies by them is told by the flight.
                    let words = ["about", "$schema", "provenance", "estimated", "origins", "px4_params"];
                    if !words.contains(&key.as_str()) {
                        self.value(&format!("{name}.{key}"), value, folder);
                    }
                }
            }
            Value::Array(items) => {
                for (i, item) in items.iter().enumerate() {
                    self.value(&format!("{name}[{i}]"), item, folder);
                }
            }
            Value::Number(x) => self.0.push(format!("{name}={:016x}", x.as_f64().unwrap().to_bits())),
            Value::String(text) => {
                self.0.push(format!("{name}={text}"));
                let named = folder.join(text);
                if text.contains('.') && named.is_file() {
                    self.file(name, &named);
                }
            }
            Value::Bool(_) | Value::Null => self.0.push(format!("{name}={value}")),
        }
    }
}

/// SHA-256 of what a cheap run flies.
fn flight_of(words: &str) -> String {
    let out = tempfile::tempdir().unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_samara"))
        .current_dir(root())
        .args(words.split(' '))
        .args(["--out", out.path().to_str().unwrap()])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(matches!(run.status.code(), Some(0 | 1)), "samara {words}: {said}");
    let file = match words.split(' ').next() {
        Some("plan") => "trajectory.csv",
        Some("assess") => "trial_1_optimal.csv",
        _ => "flight.csv",
    };
    let text = fs::read_to_string(out.path().join(file)).unwrap();
    let lines: String = text.split_inclusive('\n').filter(|line| !line.starts_with('#')).collect();
    sha256(lines)
}

fn mission_of(words: &str) -> PathBuf {
    root().join("mission").join(format!("{}.json", words.split(' ').nth(1).unwrap()))
}

fn keys(value: &Value) -> BTreeSet<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

/// Marks, recipes and lock name the same tables, each in its page, as it was made; what has no recipe bears
/// its commit and date where readers see them.
#[test]
fn every_table_of_results_is_as_it_was_made() {
    let (recipes, lock, pages) = (recipes(), lock(), pages());
    let recipes = &recipes["tables"];
    let mut marked = BTreeSet::new();
    for (page, text) in &pages {
        for (name, behind, block) in blocks(text) {
            assert!(marked.insert(name), "{name} stands twice");
            assert_eq!(recipes[name]["page"], page.as_str(), "{name}: docs/results.json has another page");
            let kept = &lock[name];
            let again = format!("{page}: {name}; scripts/regenerate --figures {name}");
            if let Some(commit) = kept["flown"].as_str() {
                let date = kept["date"].as_str().unwrap();
                let bears = block.contains(&format!("`{commit}`")) && block.contains(date);
                assert!(bears, "{again}: the table does not say that it is of `{commit}`, {date}");
                continue;
            }
            let made = format!("made at {}", kept["made"].as_str().unwrap_or("no commit"));
            assert_eq!(behind, made, "{again}");
            assert_eq!(kept["table"], sha256(block), "{again}: the table was changed by hand");
        }
    }
    assert_eq!(marked, keys(recipes), "tables in pages, and recipes in docs/results.json");
    assert_eq!(marked, keys(&lock), "tables in pages, and docs/results.lock.json");
}

/// Mission, vehicle and gains of each table mean what they meant, and one nominal flight of each is the same
/// to the bit; so is a trial of those whose numbers are drawn.
#[test]
fn regress_tables_of_results_are_of_what_flies_today() {
    let (recipes, lock) = (recipes(), lock());
    let made = lock.as_object().unwrap().iter().filter(|(_, kept)| kept.get("made").is_some());
    let mut tables: BTreeMap<&str, Vec<(&str, &Value)>> = BTreeMap::new();
    for (name, kept) in made {
        for (words, witness) in kept["witnesses"].as_object().unwrap() {
            tables.entry(words).or_default().push((name, witness));
        }
    }
    let (waiting, stale) = (Mutex::new(tables.into_iter()), Mutex::new(BTreeMap::new()));
    let work = || {
        loop {
            let Some((words, of)) = waiting.lock().unwrap().next() else { break };
            let (meaning, flight) = (Meaning::of(&mission_of(words)), flight_of(words));
            for (name, witness) in of {
                let changed = if witness["meaning"] != meaning.as_str() {
                    "has another meaning"
                } else if witness["flight"] != flight.as_str() {
                    "flies other bits"
                } else {
                    continue;
                };
                stale.lock().unwrap().insert(name, format!("`samara {words}` {changed}"));
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    let mut said = String::new();
    for (name, why) in stale.into_inner().unwrap() {
        let page = &recipes["tables"][name]["page"];
        writeln!(said, "{page}, {name}: {why}; scripts/regenerate --figures {name}").unwrap();
    }
    assert!(said.is_empty(), "tables of results are stale:\n{said}");
}

/// A table of numbers is of results, with a recipe or a date, or named as something else.
#[test]
fn no_table_of_numbers_is_without_recipe_or_reason() {
    let recipes = recipes();
    let other = &recipes["no_results"];
    let mut named = BTreeSet::new();
    for (page, text) in &pages() {
        let mut outside = text.clone();
        for (_, _, block) in blocks(text) {
            outside = outside.replace(block, "");
        }
        for table in tables_of_numbers(&outside) {
            let head = table.lines().next().unwrap();
            let reason = &other[page.as_str()][head];
            assert!(
                reason.is_string(),
                "{page}: {head}: a table of numbers without `<!-- results: NAME -->`, nor in `no_results` of docs/results.json"
            );
            named.insert((page.clone(), head.to_owned()));
        }
    }
    for (page, heads) in other.as_object().unwrap() {
        for head in keys(heads) {
            assert!(named.contains(&(page.clone(), head.to_owned())), "{page}: no table {head}");
        }
    }
}

/// The tables of a page of which a third of the cells, and four at least, are numbers with a decimal point.
fn tables_of_numbers(page: &str) -> Vec<String> {
    let mut tables = vec![String::new()];
    for line in page.lines() {
        if line.starts_with('|') {
            let table = tables.last_mut().unwrap();
            *table += line;
            table.push('\n');
        } else if !tables.last().unwrap().is_empty() {
            tables.push(String::new());
        }
    }
    let is_number = |cell: &str| {
        let cell = cell.trim().trim_start_matches(['*', '-', '+']);
        cell.split_once('.').is_some_and(|(whole, part)| {
            !whole.is_empty()
                && whole.bytes().all(|b| b.is_ascii_digit())
                && part.starts_with(|c: char| c.is_ascii_digit())
        })
    };
    tables.retain(|table| {
        let cells = table.lines().skip(2).flat_map(|line| line.trim_matches('|').split('|').skip(1));
        let (all, numbers) = cells.fold((0, 0), |(all, n), cell| (all + 1, n + usize::from(is_number(cell))));
        numbers >= 4 && 3 * numbers >= all
    });
    tables
}

/// A table of a page without marks is found, one of words is not.
#[test]
fn closed_form_what_a_table_of_numbers_is() {
    let numbers = "| a | J |\n|---|---|\n| x | 0.5 |\n| y | +0.6 |\n| z | **0.7** |\n| w | -1.2 m |\n";
    assert_eq!(tables_of_numbers(&format!("words\n\n{numbers}\nwords\n")), [numbers]);
    assert!(tables_of_numbers(&numbers.replace("0.5", "v1.16")).is_empty());
    assert!(tables_of_numbers("| key | what |\n|---|---|\n| `a` | 0.5 of it |\n").is_empty());
}

/// Words for people are no part of a mission's meaning, each of its values is, and so is a gains file's.
#[test]
fn prop_a_meaning_is_of_values_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (mission, gains) = (folder.path().join("m.json"), folder.path().join("g.json"));
    let write = |about: &str, seed: &str, k: &str| {
        fs::write(&mission, format!(r#"{{"about": "{about}", "seed": {seed}, "gains": "g.json"}}"#)).unwrap();
        fs::write(&gains, format!(r#"{{"k": {k}}}"#)).unwrap();
        Meaning::of(&mission)
    };
    let first = write("one", "1", "0.5");
    assert_eq!(first, write("two", "1.0", "5e-1"));
    assert_ne!(first, write("one", "2", "0.5"));
    assert_ne!(first, write("one", "1", "0.25"));
}
