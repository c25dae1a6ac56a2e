//! Which numbers of a file are estimated or guessed, as the file says it: the key `estimated`.

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
}

/// The keys that a file calls estimated; each must be one of the file's.
pub(super) fn estimated_keys(
    source: &Source,
    given: Option<&Vec<String>>,
) -> Result<Option<Vec<String>>, ConfigError> {
    let Some(keys) = given else { return Ok(None) };
    let file: Value = source.parse()?;
    for (i, key) in keys.iter().enumerate() {
        let found = key.split('.').try_fold(&file, |within, name| within.get(name));
        if found.is_none() {
            let message = format!(
                "expected a key of this file, such as `limits.speed_m_s`, found `{key}`, which is none"
            );
            return Err(source.refuse(&format!("estimated[{i}]"), message));
        }
    }
    Ok(Some(keys.clone()))
}
