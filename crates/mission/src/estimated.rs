//! Where the numbers of a file are from, and which of them are estimated or guessed, as the file says it: the
//! keys `origins` and `estimated`.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value;

use super::error::ConfigError;
use super::source::Source;

/// Keys whose numbers are estimated or guessed, of the files of a mission, as paths
/// (`motor.first_order.tau_up_s`); a section's key stands for all that is in it. `None`: the file does not
/// say, so that nobody knows; none of them: everything is measured or given.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Estimated {
    /// Of the vehicle's file.
    pub vehicle: Option<Vec<String>>,
    /// Of the mission's file.
    pub mission: Option<Vec<String>>,
    /// Where numbers of the vehicle's file are from, as far as it says so.
    pub origins: Vec<Origin>,
}

/// How a number came to be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OriginKind {
    /// Measured on the vehicle, or read off its logs.
    Measured,
    /// Given by a data sheet, a drawing or a file of another program.
    Given,
    /// Computed from other numbers by a formula.
    Estimated,
    /// Assumed.
    Guessed,
}

impl OriginKind {
    /// The word in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Given => "given",
            Self::Estimated => "estimated",
            Self::Guessed => "guessed",
        }
    }

    /// Whether a release card asks for the acceptance of such numbers.
    pub fn is_estimate(self) -> bool {
        matches!(self, Self::Estimated | Self::Guessed)
    }
}

/// Where numbers of a file are from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Keys of the numbers, as paths; a section's key stands for all that is in it.
    pub keys: Vec<String>,
    /// How they came to be known.
    pub kind: OriginKind,
    /// The file, page or address that they are from.
    pub file: Option<String>,
    /// The formula that they were computed by, or how they were measured, in words.
    pub formula: Option<String>,
}

impl Origin {
    /// The origin in words, without the keys: "estimated: a solid sphere (airframe.params)".
    pub fn words(&self) -> String {
        let formula = self.formula.as_ref().map_or_else(String::new, |formula| format!(": {formula}"));
        let file = self.file.as_ref().map_or_else(String::new, |file| format!(" ({file})"));
        format!("{}{formula}{file}", self.kind.word())
    }
}

/// Where numbers of the file are from.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct OriginJson {
    /// Keys of the numbers, as paths (`inertia_kg_m2`, `motor.first_order.tau_up_s`); a section's key stands
    /// for all that is in it.
    keys: Vec<String>,
    /// How they came to be known.
    kind: OriginKind,
    /// The file, page or address that they are from.
    file: Option<String>,
    /// The formula that they were computed by, or how they were measured, in words.
    formula: Option<String>,
}

/// Where a file says that its numbers are from, and the keys whose numbers are estimated: those that it calls
/// so and those whose origin says so, in order; `None`: it has neither key.
pub(super) fn origins_and_estimates(
    source: &Source,
    origins: Option<&Vec<OriginJson>>,
    estimated: Option<&Vec<String>>,
) -> Result<(Vec<Origin>, Option<Vec<String>>), ConfigError> {
    let called = estimated_keys(source, estimated)?;
    let Some(given) = origins else { return Ok((Vec::new(), called)) };
    let file: Value = source.parse()?;
    let mut keys = called.unwrap_or_default();
    let mut origins: Vec<Origin> = Vec::new();
    for (i, json) in given.iter().enumerate() {
        for (k, key) in json.keys.iter().enumerate() {
            let place = format!("origins[{i}].keys[{k}]");
            check_key(source, &file, &place, key)?;
            if origins.iter().any(|before| before.keys.contains(key)) {
                let message = format!("expected each key once, found `{key}` again");
                return Err(source.refuse(&place, message));
            }
            if json.kind.is_estimate() && !keys.contains(key) {
                keys.push(key.clone());
            }
        }
        let OriginJson { keys, kind, file, formula } = json;
        origins.push(Origin {
            keys: keys.clone(),
            kind: *kind,
            file: file.clone(),
            formula: formula.clone(),
        });
    }
    keys.sort_unstable();
    Ok((origins, Some(keys)))
}

/// The keys that a file calls estimated; each must be one of the file's.
pub(super) fn estimated_keys(
    source: &Source,
    given: Option<&Vec<String>>,
) -> Result<Option<Vec<String>>, ConfigError> {
    let Some(keys) = given else { return Ok(None) };
    let file: Value = source.parse()?;
    for (i, key) in keys.iter().enumerate() {
        check_key(source, &file, &format!("estimated[{i}]"), key)?;
    }
    Ok(Some(keys.clone()))
}

/// A key must be one of the file's.
fn check_key(source: &Source, file: &Value, place: &str, key: &str) -> Result<(), ConfigError> {
    if key.split('.').try_fold(file, |within, name| within.get(name)).is_some() {
        return Ok(());
    }
    let message =
        format!("expected a key of this file, such as `limits.speed_m_s`, found `{key}`, which is none");
    Err(source.refuse(place, message))
}
