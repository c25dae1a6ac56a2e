//! Which keys can be set, and missions with keys that are: `--set limits.pitch_deg=40`.

use std::path::Path;
use std::sync::LazyLock;

use serde_json::Value;

use super::error::{ConfigError, did_you_mean};
use super::mission::{Mission, load_with};
use super::names::nearest;
use super::overrides::{Override, Overrides};
use super::schema::schemas;
use samara_core::units::unit_of;

/// Reads a mission as [`load_mission`](crate::load_mission) does, with other values of keys of its file, of
/// its vehicle's and of its gains'. They are choices of its inputs, `set KEY`; the hash follows.
///
/// # Errors
/// [`ConfigError`] with the place in the file, or the key, that is refused.
pub fn load_mission_with(path: &Path, overrides: &[Override]) -> Result<Mission, ConfigError> {
    let mut placed = Overrides { all: overrides.to_vec(), ..Overrides::default() };
    for given in overrides {
        let (of, path) = place(given)?;
        let file = match of {
            Of::Mission => &mut placed.mission,
            Of::Vehicle => &mut placed.vehicle,
            Of::Gains => &mut placed.gains,
        };
        file.push((path.to_owned(), given.clone()));
    }
    load_with(path, &placed)
}

/// Whether a key is one of the vehicle's file.
///
/// # Errors
/// [`ConfigError::Override`] of a key that no file has.
pub fn is_of_vehicle(given: &Override) -> Result<bool, ConfigError> {
    Ok(place(given)?.0 == Of::Vehicle)
}

/// Every key that can be set, as a path: the mission's, the vehicle's, then the gains' behind `gains.`.
pub fn settable_keys() -> impl Iterator<Item = &'static SettableKey> {
    [&KEYS.mission, &KEYS.vehicle, &KEYS.gains].into_iter().flatten()
}

/// A key that can be set, as the schema of its file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct SettableKey {
    /// The key as `--set` takes it: `limits.pitch_deg`, `mass_kg`, `gains.k_pq_per_s`.
    pub path: String,
    /// The meaning, in words.
    pub description: String,
    /// Unit of its number or numbers, where they have one.
    pub unit: Option<String>,
    /// "number", "integer", "string", "boolean", "array" or "object".
    pub kind: &'static str,
    /// Least number, or number of a list; it may be excluded.
    pub minimum: Option<f64>,
    /// Greatest number, or number of a list; it may be excluded.
    pub maximum: Option<f64>,
    /// The words that it may be, where it is one of some.
    pub choices: Vec<String>,
}

/// Which file a key is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Of {
    Mission,
    Vehicle,
    Gains,
}

/// What stands before a key of the gains' file, whose own key in the mission is a name.
const OF_GAINS: &str = "gains.";

/// Which file a key is of, and its path there. One that mission and vehicle have is the mission's.
pub(super) fn place(given: &Override) -> Result<(Of, &str), ConfigError> {
    for (before, of) in [("mission.", Of::Mission), ("vehicle.", Of::Vehicle), (OF_GAINS, Of::Gains)] {
        if let Some(path) = given.path_behind(before) {
            return Ok((of, path));
        }
    }
    let key = given.key();
    let first = first_of(key);
    let has = |keys: &[SettableKey]| keys.iter().any(|key| first_of(&key.path) == first);
    match (has(&KEYS.mission), has(&KEYS.vehicle)) {
        (true, _) => Ok((Of::Mission, key)),
        (false, true) => Ok((Of::Vehicle, key)),
        (false, false) => Err(unknown(given)),
    }
}

fn first_of(key: &str) -> &str {
    key.split(['.', '[']).next().unwrap_or_default()
}

fn unknown(given: &Override) -> ConfigError {
    let inner = format!(".{}", given.key());
    let keys = || settable_keys().map(|key| key.path.as_str());
    let alike = keys().filter(|key| key.ends_with(&inner));
    let near = alike.min_by_key(|key| key.len()).or_else(|| nearest(given.key(), keys()));
    given.refuse(format!(
        "neither the mission's file nor the vehicle's has such a key{} expected a path such as \
         `limits.pitch_deg`, or `mass_kg` of the vehicle",
        did_you_mean(near)
    ))
}

/// The keys of the files as paths, in the order of their schemas; of lists of objects the first entry's.
struct Keys {
    mission: Vec<SettableKey>,
    vehicle: Vec<SettableKey>,
    gains: Vec<SettableKey>,
}

static KEYS: LazyLock<Keys> = LazyLock::new(|| {
    let [mission, vehicle, gains] = schemas().map(|(_, schema)| keys_of(&schema));
    let behind = |key: SettableKey| SettableKey { path: OF_GAINS.to_owned() + &key.path, ..key };
    Keys { mission, vehicle, gains: gains.into_iter().map(behind).collect() }
});

fn keys_of(schema: &str) -> Vec<SettableKey> {
    let root: Value = serde_json::from_str(schema).unwrap_or_default();
    let mut keys = Vec::new();
    walk(&root, &root, String::new(), &mut keys);
    keys
}

/// Deeper than any key stands.
const DEPTH_MOST: usize = 8;

fn walk(root: &Value, schema: &Value, path: String, keys: &mut Vec<SettableKey>) {
    if path.matches('.').count() > DEPTH_MOST {
        return;
    }
    let schema = named(root, schema);
    for (key, value) in schema["properties"].as_object().into_iter().flatten() {
        let inner = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        if !keys.iter().any(|key| key.path == inner) {
            keys.push(SettableKey::new(root, value, inner.clone()));
        }
        walk(root, value, inner, keys);
    }
    for form in forms(schema) {
        walk(root, form, path.clone(), keys);
    }
    if schema["items"].is_object() {
        walk(root, &schema["items"], format!("{path}[0]"), keys);
    }
}

/// The schema that a schema names, or itself.
fn named<'a>(root: &'a Value, schema: &'a Value) -> &'a Value {
    let named = schema["$ref"].as_str().and_then(|name| root.pointer(name.trim_start_matches('#')));
    named.unwrap_or(schema)
}

/// The alternatives of a schema.
fn forms(schema: &Value) -> impl Iterator<Item = &Value> {
    ["anyOf", "oneOf", "allOf"].iter().filter_map(|form| schema[*form].as_array()).flatten()
}

impl SettableKey {
    fn new(root: &Value, schema: &Value, path: String) -> Self {
        // The schema, its alternatives, and theirs: those of a word that may be left out.
        let mut all = vec![named(root, schema)];
        for depth in 0..2 {
            let inner: Vec<&Value> = all.iter().skip(depth).flat_map(|of| forms(of)).collect();
            all.extend(inner.into_iter().map(|form| named(root, form)));
        }
        // Those of the numbers of a list are the list's.
        let bound = |names: [&str; 2]| {
            let of = |schema: &Value| names.iter().find_map(|name| schema[*name].as_f64());
            all.iter().find_map(|schema| of(schema).or_else(|| of(&schema["items"])))
        };
        let words = |schema: &Value| -> Vec<String> {
            let listed = schema["enum"].as_array().into_iter().flatten().chain(schema.get("const"));
            listed.filter_map(|word| Some(word.as_str()?.to_owned())).collect()
        };
        let description = [schema, all[0]].into_iter().find_map(|schema| schema["description"].as_str());
        let description = description.unwrap_or_default().to_owned();
        let written = |(_, rest): (&str, &str)| rest.split_once(']').map(|(unit, _)| unit.to_owned());
        let last = path.rsplit('.').next().unwrap_or_default();
        Self {
            unit: unit_of(last)
                .map(str::to_owned)
                .or_else(|| description.split_once('[').and_then(written))
                .filter(|unit| !unit.contains(' ')),
            kind: all.iter().find_map(|schema| kind(schema)).unwrap_or("object"),
            minimum: bound(["minimum", "exclusiveMinimum"]),
            maximum: bound(["maximum", "exclusiveMaximum"]),
            choices: all.iter().flat_map(|schema| words(schema)).collect(),
            path,
            description,
        }
    }
}

/// The type that a schema names, beside null.
fn kind(schema: &Value) -> Option<&'static str> {
    let is = |kind: &&str| {
        let types = schema["type"].as_array();
        schema["type"] == **kind || types.is_some_and(|types| types.iter().any(|one| *one == **kind))
    };
    ["number", "integer", "string", "boolean", "array", "object"].into_iter().find(|kind| is(kind))
}
