//! The files that a ground station finds: what this component is made of, and what its parameters mean
//! (MAVLink's component metadata, version 1), so that it need not guess from a PX4 release.

use super::table::Role;
use super::{Entry, Parameters};
use crate::checksum::crc32;
use crate::params::metadata::Kind;

/// The file that COMPONENT_METADATA names.
pub const GENERAL: &str = "/etc/extras/component_general.json";
/// The file that [`GENERAL`] names in turn.
pub const PARAMETERS: &str = "/etc/extras/parameters.json";
/// `COMP_METADATA_TYPE_PARAMETER`.
const PARAMETER_TYPE: u8 = 1;

/// Parameters whose values are choices, each with the values that are taken here in PX4's words: ground
/// stations offer them as a list (QGroundControl's safety page), and an empty one without them.
const CHOICES: [(&str, &[(i32, &str)]); 6] = [
    (
        "COM_LOW_BAT_ACT",
        &[
            (0, "Warning"),
            (1, "Return mode"),
            (2, "Land mode"),
            (3, "Return at critical level, land at emergency level"),
        ],
    ),
    ("COM_OBL_RC_ACT", &[(3, "Return mode"), (4, "Land mode"), (5, "Hold mode")]),
    ("COM_TAKEOFF_ACT", &[(0, "Hold"), (1, "Mission (if valid)")]),
    (
        "GF_ACTION",
        &[
            (0, "None"),
            (1, "Warning"),
            (2, "Hold mode"),
            (3, "Return mode"),
            (4, "Terminate"),
            (5, "Land mode"),
        ],
    ),
    (
        "MIS_TKO_LAND_REQ",
        &[
            (0, "No requirements"),
            (1, "Require a takeoff"),
            (2, "Require a landing"),
            (3, "Require a takeoff and a landing"),
            (4, "Require both a takeoff and a landing, or neither"),
        ],
    ),
    ("NAV_DLL_ACT", &[(0, "Disabled"), (1, "Hold mode"), (2, "Return mode"), (3, "Land mode")]),
];

/// A file of the component's description.
#[derive(Clone, Debug)]
pub struct Content {
    /// Absolute path.
    pub path: &'static str,
    /// Content.
    pub bytes: Vec<u8>,
}

/// Every file, by path.
pub fn contents(parameters: &Parameters) -> Vec<Content> {
    let meanings = parameters_json(parameters).into_bytes();
    let crc = crc32(0, &meanings);
    let general = format!(
        "{{\"version\":1,\"metadataTypes\":[{{\"type\":{PARAMETER_TYPE},\"uri\":\"mftp://{PARAMETERS}\",\"fileCrc\":{crc}}}]}}"
    );
    vec![
        Content { path: GENERAL, bytes: general.into_bytes() },
        Content { path: PARAMETERS, bytes: meanings },
    ]
}

fn parameters_json(parameters: &Parameters) -> String {
    let rows: Vec<String> = parameters.iter().map(parameter_json).collect();
    format!("{{\"version\":1,\"parameters\":[\n{}\n]}}", rows.join(",\n"))
}

fn parameter_json(entry: &Entry) -> String {
    let known = &entry.known;
    let kind = if known.kind == Kind::Int { "Int32" } else { "Float" };
    let mut fields = vec![
        ("name", quoted(&entry.name)),
        ("type", quoted(kind)),
        ("group", quoted(group(&entry.name))),
        ("category", quoted("Standard")),
        ("shortDesc", quoted(known.description)),
        ("longDesc", quoted(&entry.role.words())),
        ("default", entry.start.to_string()),
    ];
    if matches!(entry.role, Role::AtBeginning(_)) {
        fields.push(("rebootRequired", "true".to_owned()));
    }
    if !known.unit.is_empty() {
        fields.push(("units", quoted(known.unit)));
    }
    if let Some(decimals) = known.decimals.filter(|_| known.kind == Kind::Float) {
        fields.push(("decimalPlaces", decimals.to_string()));
    }
    // A value of the mission's may lie outside the range by which changes are judged.
    let judged = !matches!(entry.role, Role::Vehicle);
    fields.extend(known.min.filter(|_| judged).map(|min| ("min", min.to_string())));
    fields.extend(known.max.filter(|_| judged).map(|max| ("max", max.to_string())));
    if let Some((_, choices)) = CHOICES.iter().find(|(name, _)| *name == entry.name) {
        let choice =
            |(value, words): &(i32, &str)| format!("{{\"value\":{value},\"description\":{}}}", quoted(words));
        fields.push(("values", format!("[{}]", choices.iter().map(choice).collect::<Vec<_>>().join(","))));
    }
    let fields: Vec<String> = fields.into_iter().map(|(key, value)| format!("\"{key}\":{value}")).collect();
    format!("{{{}}}", fields.join(","))
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// The group under which ground stations show a parameter, as PX4 has it.
fn group(name: &str) -> &'static str {
    match name.split('_').next() {
        Some("CA" | "THR") => "Geometry",
        Some("CAL") => "Sensor Calibration",
        Some("COM" | "NAV") => "Commander",
        Some("EKF2") => "EKF2",
        Some("GF") => "Geofence",
        Some("MAV") => "MAVLink",
        Some("MC") => "Multicopter Attitude and Rate Control",
        Some("MIS") => "Mission",
        Some("MPC") => "Multicopter Position Control",
        Some("RC") => "Radio Calibration",
        Some("RTL") => "Return Mode",
        Some("SYS") => "System",
        _ => "Miscellaneous",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autopilot::Settings;
    use crate::control::Gains;

    /// Property: what is offered is taken, and nothing else is.
    #[test]
    fn choices_are_what_the_settings_take() {
        for (name, choices) in CHOICES {
            for value in -2..10 {
                let mut settings = Settings::beside(&Gains::near_hover());
                let offered = choices.iter().any(|choice| choice.0 == value);
                assert_eq!(settings.set(name, f64::from(value)), offered, "{name} {value}");
            }
        }
    }
}
