//! The gains file: `params/gains/*.json`, read and written.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Deserialize;

use super::ConfigError;
use super::number::{Name, NonNegative};
use super::source::{InputHash, Source};
use crate::control::Gains;

/// Gains as their file gives them.
#[derive(Clone, Debug, PartialEq)]
pub struct GainsFile {
    /// Name of the set.
    pub name: String,
    /// The gains.
    pub gains: Gains,
}

/// Gains of the cascade, acceleration-normalised: they carry neither mass nor inertia. Table 4, and yaw.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GainsJson {
    /// Where the gains come from.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Name of the set.
    name: Name,
    /// Pitch (and roll) rate, proportional [1/s].
    k_pq_per_s: NonNegative<1_000_000>,
    /// Pitch (and roll) rate, integral [1/s^2].
    k_iq_per_s2: NonNegative<1_000_000>,
    /// Pitch (and roll) angle, proportional [1/s].
    k_ptheta_per_s: NonNegative<1_000_000>,
    /// Vertical velocity, proportional [1/s].
    k_pvz_per_s: NonNegative<1_000_000>,
    /// Vertical velocity, integral [1/s^2].
    k_ivz_per_s2: NonNegative<1_000_000>,
    /// Horizontal velocity, proportional [1/s].
    k_pvx_per_s: NonNegative<1_000_000>,
    /// Horizontal velocity, integral [1/s^2].
    k_ivx_per_s2: NonNegative<1_000_000>,
    /// Heading, proportional [1/s].
    k_ppsi_per_s: NonNegative<1_000_000>,
    /// Yaw rate, proportional [1/s].
    k_pr_per_s: NonNegative<1_000_000>,
}

/// Reads a gains file.
///
/// # Errors
/// [`ConfigError`] with the place in the file, when it cannot be read or does not hold gains.
pub fn load_gains(path: &Path) -> Result<GainsFile, ConfigError> {
    load_named_gains(path, None, &mut InputHash::default())
}

/// As [`load_gains`], for gains that another file names; the bytes read go into `hash`.
pub(super) fn load_named_gains(
    path: &Path,
    named_in: Option<&Path>,
    hash: &mut InputHash,
) -> Result<GainsFile, ConfigError> {
    let source = Source::read(path, "gains file", named_in)?;
    let json: GainsJson = source.parse()?;
    hash.absorb("gains", &source);
    let gains = Gains {
        k_pq: json.k_pq_per_s.get(),
        k_iq: json.k_iq_per_s2.get(),
        k_ptheta: json.k_ptheta_per_s.get(),
        k_pvz: json.k_pvz_per_s.get(),
        k_ivz: json.k_ivz_per_s2.get(),
        k_pvx: json.k_pvx_per_s.get(),
        k_ivx: json.k_ivx_per_s2.get(),
        k_ppsi: json.k_ppsi_per_s.get(),
        k_pr: json.k_pr_per_s.get(),
    };
    Ok(GainsFile { name: json.name.0, gains })
}

/// The file that `name_or_path` means: a path when it has a directory or ends in `.json`, otherwise the name of a file in
/// `directory`.
pub fn gains_path(name_or_path: &str, directory: &Path) -> PathBuf {
    let path = Path::new(name_or_path);
    let is_file = path.components().count() > 1 || path.is_absolute() || name_or_path.ends_with(".json");
    if is_file { path.to_owned() } else { directory.join(format!("{name_or_path}.json")) }
}

/// The text of a gains file, as [`load_gains`] reads it back to the last bit. `name` must be a plain name (letters,
/// digits, `_`, `-`).
pub fn gains_json(name: &str, about: &str, gains: &Gains) -> String {
    let text = |s: &str| serde_json::Value::from(s).to_string();
    let rows = [
        ("k_pq_per_s", gains.k_pq),
        ("k_iq_per_s2", gains.k_iq),
        ("k_ptheta_per_s", gains.k_ptheta),
        ("k_pvz_per_s", gains.k_pvz),
        ("k_ivz_per_s2", gains.k_ivz),
        ("k_pvx_per_s", gains.k_pvx),
        ("k_ivx_per_s2", gains.k_ivx),
        ("k_ppsi_per_s", gains.k_ppsi),
        ("k_pr_per_s", gains.k_pr),
    ];
    let rows: Vec<String> = rows.iter().map(|(key, k)| format!("  \"{key}\": {k:?}")).collect();
    format!("{{\n  \"about\": {},\n  \"name\": {},\n{}\n}}\n", text(about), text(name), rows.join(",\n"))
}
