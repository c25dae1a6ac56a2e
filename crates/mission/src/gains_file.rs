//! The gains file: `params/gains/*.json`, read and written.

use std::path::Path;

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::ConfigError;
use super::number::{Name, NonNegative};
use super::source::{InputHash, Source};
use samara_core::control::Gains;
use samara_core::table_of_gains;

/// Gains as their file gives them.
#[derive(Clone, Debug, PartialEq)]
pub struct GainsFile {
    /// Name of the set.
    pub name: String,
    /// The gains.
    pub gains: Gains,
}

macro_rules! gains_json {
    (
        [$($(#[$doc:meta])* $name:ident $key:literal)*]
        [$($(#[$yaw_doc:meta])* $yaw_name:ident $yaw_key:literal)*]
    ) => {
        /// Gains of the cascade, acceleration-normalised: they carry neither mass nor inertia. Table 4, and
        /// yaw.
        #[derive(Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub(super) struct GainsJson {
        /// JSON schema of the file, for editors; samara does not read it.
        #[serde(rename = "$schema")]
        _schema: Option<String>,
            /// Where the gains come from.
            #[serde(rename = "about")]
            _about: Option<String>,
            /// Name of the set.
            name: Name,
            $($(#[$doc])* #[serde(rename = $key)] $name: NonNegative<1_000_000>,)*
            $($(#[$yaw_doc])* #[serde(rename = $yaw_key)] $yaw_name: NonNegative<1_000_000>,)*
        }

        impl GainsJson {
            fn gains(&self) -> Gains {
                Gains { $($name: self.$name.get(),)* $($yaw_name: self.$yaw_name.get(),)* }
            }
        }
    };
}
table_of_gains!(gains_json);

/// Reads a gains file.
///
/// # Errors
/// [`ConfigError`] with the place in the file, when it cannot be read or does not hold gains.
pub fn load_gains(path: &Path) -> Result<GainsFile, ConfigError> {
    gains_of(&Source::read(path, "gains file", None)?, &mut InputHash::default())
}

/// The gains of a text; it goes into `hash`.
pub(super) fn gains_of(source: &Source, hash: &mut InputHash) -> Result<GainsFile, ConfigError> {
    let json: GainsJson = source.parse()?;
    hash.absorb("gains", &source.text);
    Ok(GainsFile { gains: json.gains(), name: json.name.0 })
}

/// The text of a gains file, as [`load_gains`] reads it back to the last bit. `name` must be a plain name
/// (letters, digits, `_`, `-`).
pub fn gains_json(name: &str, about: &str, gains: &Gains) -> String {
    let text = |s: &str| serde_json::Value::from(s).to_string();
    let rows = gains.named().map(|(_, key, k)| format!("  \"{key}\": {k:?}"));
    format!("{{\n  \"about\": {},\n  \"name\": {},\n{}\n}}\n", text(about), text(name), rows.join(",\n"))
}
