//! Which keys can be set, and missions with keys that are: `--set limits.pitch_deg=40`.

use std::path::Path;
use std::sync::LazyLock;

use serde_json::Value;

use super::error::{ConfigError, did_you_mean};
use super::mission::{Mission, load_with};
use super::names::nearest;
use super::overrides::{Override, Overrides};
use super::schema::schemas;

/// Reads a mission as [`load_mission`](crate::load_mission) does, with other values of keys of its file and
/// of its vehicle's. They are choices of its inputs, `set KEY`; the hash follows.
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
        };
        file.push((path.to_owned(), given.clone()));
    }
    load_with(path, &placed)
}

/// Whether a key is one of the vehicle's file.
///
/// # Errors
/// [`ConfigError::Override`] of a key that neither file has.
pub fn is_of_vehicle(given: &Override) -> Result<bool, ConfigError> {
    Ok(place(given)?.0 == Of::Vehicle)
}

/// Every key that can be set, as a path: the mission's, then the vehicle's.
pub fn settable_keys() -> impl Iterator<Item = &'static str> {
    KEYS.mission.iter().chain(&KEYS.vehicle).map(String::as_str)
}

/// Which file a key is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Of {
    Mission,
    Vehicle,
}

/// Which of the two files a key is of, and its path there. One that both have is the mission's.
fn place(given: &Override) -> Result<(Of, &str), ConfigError> {
    for (before, of) in [("mission.", Of::Mission), ("vehicle.", Of::Vehicle)] {
        if let Some(path) = given.path_behind(before) {
            return Ok((of, path));
        }
    }
    let key = given.key();
    let first = first_of(key);
    let has = |keys: &[String]| keys.iter().any(|key| first_of(key) == first);
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
    let alike = settable_keys().filter(|key| key.ends_with(&inner));
    let near = alike.min_by_key(|key| key.len()).or_else(|| nearest(given.key(), settable_keys()));
    given.refuse(format!(
        "neither the mission's file nor the vehicle's has such a key{} expected a path such as \
         `limits.pitch_deg`, or `mass_kg` of the vehicle",
        did_you_mean(near)
    ))
}

/// The keys of both files as paths, in the order of their schemas; of lists of objects the first entry's.
struct Keys {
    mission: Vec<String>,
    vehicle: Vec<String>,
}

static KEYS: LazyLock<Keys> = LazyLock::new(|| {
    let [(_, mission), (_, vehicle), _] = schemas();
    Keys { mission: paths_of(&mission), vehicle: paths_of(&vehicle) }
});

fn paths_of(schema: &str) -> Vec<String> {
    let root: Value = serde_json::from_str(schema).unwrap_or_default();
    let mut paths = Vec::new();
    walk(&root, &root, String::new(), &mut paths);
    paths
}

/// Deeper than any key stands.
const DEPTH_MOST: usize = 8;

fn walk(root: &Value, schema: &Value, path: String, paths: &mut Vec<String>) {
    if path.matches('.').count() > DEPTH_MOST {
        return;
    }
    let named = schema["$ref"].as_str().and_then(|name| root.pointer(name.trim_start_matches('#')));
    let schema = named.unwrap_or(schema);
    for (key, value) in schema["properties"].as_object().into_iter().flatten() {
        let inner = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        if !paths.contains(&inner) {
            paths.push(inner.clone());
        }
        walk(root, value, inner, paths);
    }
    let forms = ["anyOf", "oneOf", "allOf"].iter().filter_map(|form| schema[*form].as_array());
    for form in forms.flatten() {
        walk(root, form, path.clone(), paths);
    }
    if schema["items"].is_object() {
        walk(root, &schema["items"], format!("{path}[0]"), paths);
    }
}
