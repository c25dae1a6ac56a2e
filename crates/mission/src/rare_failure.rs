//! `rare_failure.json`: the most likely way to fail that a search found, to be flown again.

use std::path::Path;

use serde::Deserialize;

use super::error::ConfigError;
use super::mission::Mission;
use super::number::Within;
use super::source::Source;

/// Version of this program.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// A way to fail as its file gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct RareFailureFile {
    /// J_TPF from which on a trial counts as a failure.
    pub bound: f64,
    /// Whether the controller's unknowns were drawn too.
    pub unknowns: bool,
    /// Coordinates of the trial, independent standard-normal variables.
    pub coordinates: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RareFailureJson {
    mission: String,
    version: String,
    #[serde(rename = "seed")]
    _seed: u64,
    input_hash: String,
    #[serde(rename = "gains")]
    _gains: String,
    bound: Within<1_000_000>,
    unknowns: bool,
    #[serde(rename = "j_tpf")]
    _j_tpf: Option<f64>,
    #[serde(rename = "distance")]
    _distance: f64,
    coordinates: Vec<Within<1000>>,
}

/// Reads a way to fail of a mission.
///
/// # Errors
/// [`ConfigError`] with the place in the file, when it cannot be read, holds something else, or is of other
/// inputs than this mission's.
pub fn load_rare_failure(path: &Path, mission: &Mission) -> Result<RareFailureFile, ConfigError> {
    let source = Source::read(path, "failure of --rare", None)?;
    let json: RareFailureJson = source.parse()?;
    // What a coordinate means is the program's.
    if json.version != VERSION {
        let message =
            format!("a failure that samara {VERSION} found is expected, found one by {}", json.version);
        return Err(source.refuse("version", message));
    }
    let expected = &mission.inputs.hash;
    if json.input_hash != *expected {
        let message = format!(
            "a failure of {}, whose inputs have the hash {expected}, is expected, found one of {} with {}: the mission and \
             choices (--gains, --seed, ..) of the search itself are needed",
            mission.name, json.mission, json.input_hash
        );
        return Err(source.refuse("input_hash", message));
    }
    Ok(RareFailureFile {
        bound: json.bound.get(),
        unknowns: json.unknowns,
        coordinates: json.coordinates.into_iter().map(Within::get).collect(),
    })
}
