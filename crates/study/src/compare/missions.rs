//! Two missions: keys of their files and of their vehicles' and gains' files that differ, and derived numbers
//! that do.

use serde_json::Value;

use samara_core::math::with_digits;
use samara_mission::{Mission, derived};
use samara_report::document::{Grid, Passage};
use samara_report::json::result_objects;

/// Keys for the reader, and of where numbers are from: they change no flight.
const FOR_THE_READER: [&str; 4] = ["$schema", "about", "provenance", "origins"];
/// Longest value that a table shows.
const WIDEST: usize = 36;
/// Digits of derived numbers that are shown.
const DIGITS: u32 = 5;

/// What differs between two missions.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MissionPair {
    /// Keys whose values differ: those of the mission's file, then `vehicle.` and `gains.` with those of the
    /// files that it names.
    pub keys: Vec<Difference>,
    /// Derived numbers that differ.
    pub derived: Vec<Difference>,
}

/// A value that differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Path of the key; of a derived number its group and key.
    pub key: String,
    /// The values of A and of B as JSON; `None` where there is none.
    pub values: [Option<String>; 2],
}

impl MissionPair {
    /// What differs between two missions, of which each has the texts of its files: the name of the file and
    /// its text, `mission.json` first.
    pub fn new(missions: [&Mission; 2], texts: [&[(String, String)]; 2]) -> Self {
        let of_files =
            texts.map(|files| files.iter().flat_map(|(name, text)| leaves_of(name, text)).collect());
        let of_numbers = missions.map(|mission| {
            let groups = derived(mission).groups.into_iter();
            let rows = groups.flat_map(|group| group.rows.into_iter().map(move |row| (group.name, row)));
            rows.map(|(group, row)| {
                let numbers: Vec<String> =
                    row.values.iter().map(|x| with_digits(*x, DIGITS).to_string()).collect();
                (format!("{}.{}", group.replace(' ', "_"), row.key), numbers.join(", "))
            })
            .filter(|(_, numbers)| !numbers.is_empty())
            .collect()
        });
        Self { keys: differences(of_files), derived: differences(of_numbers) }
    }

    /// What is said of it.
    pub fn passages(&self) -> Vec<Passage> {
        if self.keys.is_empty() && self.derived.is_empty() {
            return vec![Passage::Said(
                "Both missions are the same, but for words for the reader.".to_owned(),
            )];
        }
        let grid = |title: &str, of: &[Difference]| {
            let mut grid = Grid::new(title, ["key", "A", "B"]);
            for Difference { key, values } in of {
                grid.row(key, values.each_ref().map(|value| value.as_deref().map_or("-".to_owned(), cut)));
            }
            Passage::Table(grid)
        };
        let tables = [("Keys that differ", &self.keys), ("Derived numbers that differ", &self.derived)];
        tables.into_iter().filter(|(_, of)| !of.is_empty()).map(|(title, of)| grid(title, of)).collect()
    }
}

/// A value as a table shows it.
fn cut(value: &str) -> String {
    if value.chars().count() <= WIDEST {
        return value.to_owned();
    }
    value.chars().take(WIDEST - 3).chain(" ..".chars()).collect()
}

type Leaf = (String, String);

/// The values that differ, in the order of A, then those that B has alone.
fn differences([a, b]: [Vec<Leaf>; 2]) -> Vec<Difference> {
    let find = |leaves: &[Leaf], key: &str| {
        leaves.iter().find(|(known, _)| known == key).map(|(_, value)| value.clone())
    };
    let of_a = a.iter().map(|(key, value)| (key, [Some(value.clone()), find(&b, key)]));
    let alone = b.iter().filter(|(key, _)| find(&a, key).is_none());
    let of_b = alone.map(|(key, value)| (key, [None, Some(value.clone())]));
    let all = of_a.chain(of_b).filter(|(_, [a, b])| a != b);
    all.map(|(key, values)| Difference { key: key.clone(), values }).collect()
}

/// The values of a file by their paths: those of the mission's file begin with nothing, others with what they
/// are of.
fn leaves_of(name: &str, text: &str) -> Vec<Leaf> {
    let before = match name.trim_end_matches(".json") {
        "mission" => String::new(),
        other => format!("{other}."),
    };
    let mut leaves = Vec::new();
    match serde_json::from_str(text) {
        Ok(value) => push_leaves(&before, &value, &mut leaves),
        // What was read as a mission is JSON; a table beside it has no keys.
        Err(_) => leaves.push((name.to_owned(), format!("{} bytes", text.len()))),
    }
    leaves
}

fn push_leaves(path: &str, value: &Value, leaves: &mut Vec<Leaf>) {
    let is_plain = |value: &Value| !value.is_object() && !value.is_array();
    match value {
        Value::Object(keys) => {
            for (key, value) in keys.iter().filter(|(key, _)| !FOR_THE_READER.contains(&key.as_str())) {
                let between = if path.is_empty() || path.ends_with('.') { "" } else { "." };
                push_leaves(&format!("{path}{between}{key}"), value, leaves);
            }
        }
        Value::Array(items) if !items.iter().all(is_plain) => {
            for (i, item) in items.iter().enumerate() {
                push_leaves(&format!("{path}[{i}]"), item, leaves);
            }
        }
        // Numbers in a list are one value, such as a vector.
        plain => leaves.push((path.to_owned(), shown(plain))),
    }
}

/// A value as JSON, in which 5.0 is 5.
fn shown(value: &Value) -> String {
    match value {
        Value::Number(x) if x.is_f64() => x.as_f64().map_or_else(|| x.to_string(), |x| x.to_string()),
        Value::Array(items) => format!("[{}]", items.iter().map(shown).collect::<Vec<_>>().join(", ")),
        plain => plain.to_string(),
    }
}

result_objects! {
    /// What differs between two missions.
    MissionPairObject(pair: &MissionPair) {
        /// Keys whose values differ: of the mission's file, then of the vehicle's and the gains' (`vehicle.`,
        /// `gains.`).
        keys: Vec<DifferenceObject> = pair.keys.iter().map(DifferenceObject::of).collect(),
        /// Derived numbers that differ, in five digits.
        derived: Vec<DifferenceObject> = pair.derived.iter().map(DifferenceObject::of).collect(),
    }

    /// A value that differs.
    DifferenceObject(of: &Difference) [let [a, b] = &of.values;] {
        /// Path of the key; of a derived number its group and key.
        key: String = of.key.clone(),
        /// The value of A as JSON; null where there is none.
        a: Option<String> = a.clone(),
        /// The value of B as JSON; null where there is none.
        b: Option<String> = b.clone(),
    }
}
