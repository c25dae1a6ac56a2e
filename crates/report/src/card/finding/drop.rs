//! A drop, and drops of the release cases.

use crate::json::DropObject;

impl DropObject {
    /// Why it was not safe, if it was not, in the judge's words: `samara drop` answers by the same.
    pub fn fault(&self) -> Option<String> {
        (!self.safe).then(|| self.objections.join("; "))
    }

    /// The pilot, in words.
    pub fn pilot(&self) -> String {
        pilot_words(
            self.autopilot.as_deref().unwrap_or("an unknown autopilot"),
            self.autopilot_version.as_deref(),
        )
    }
}

/// An autopilot of results, in words.
pub fn pilot_words(name: &str, version: Option<&str>) -> String {
    let version = version.map_or_else(String::new, |version| format!(" {version}"));
    match name {
        "reference" => "the reference autopilot on the true state".to_owned(),
        "reference_ekf" => "the reference autopilot on its own estimator".to_owned(),
        "px4" => format!("PX4{version}"),
        "px4-model" => format!("the model of PX4{version}'s control law"),
        other => other.to_owned(),
    }
}
