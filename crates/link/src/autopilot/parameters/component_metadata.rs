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

/// Values of a parameter with their words.
type Choices = &'static [(i32, &'static str)];

const YES_OR_NO: Choices = &[(0, "Disabled"), (1, "Enabled")];
const UNASSIGNED: Choices = &[(-1, "Unassigned")];
const NO_CHANNEL: Choices = &[(0, "Unassigned")];

/// Parameters whose values are choices, each with the values that it takes here in PX4's words: ground
/// stations offer them as a list (QGroundControl's safety page), and an empty one without them. A `#` stands
/// for what follows. A fact has the one value that it has.
const CHOICES: [(&str, Choices); 23] = [
    ("BAT1_SOURCE", &[(-1, "Disabled")]),
    ("CA_AIRFRAME", &[(0, "Multirotor")]),
    (
        "COM_ACT_FAIL_ACT",
        &[(0, "Warning only"), (1, "Hold mode"), (2, "Land mode"), (3, "Return mode"), (4, "Terminate")],
    ),
    ("COM_FLTMODE#", UNASSIGNED),
    (
        "COM_LOW_BAT_ACT",
        &[
            (0, "Warning"),
            (1, "Return mode"),
            (2, "Land mode"),
            (3, "Return at critical level, land at emergency level"),
        ],
    ),
    (
        "COM_OBL_RC_ACT",
        &[
            (0, "Position mode"),
            (1, "Altitude mode"),
            (2, "Manual"),
            (3, "Return mode"),
            (4, "Land mode"),
            (5, "Hold mode"),
            (6, "Terminate"),
            (7, "Disarm"),
        ],
    ),
    (
        "COM_RC_IN_MODE",
        &[
            (0, "RC Transmitter only"),
            (1, "Joystick only"),
            (2, "RC and Joystick with fallback"),
            (3, "RC or Joystick keep first"),
            (4, "Stick input disabled"),
        ],
    ),
    ("COM_TAKEOFF_ACT", &[(0, "Hold"), (1, "Mission (if valid)")]),
    ("EKF2_EN", YES_OR_NO),
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
    ("GF_SOURCE", &[(0, "GPOS")]),
    ("MAV_TYPE", &[(2, "Quadrotor")]),
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
    ("MPC_POS_MODE", &[(0, "Simple position control")]),
    ("MPC_THR_CURVE", &[(0, "Rescale to hover thrust"), (1, "No Rescale")]),
    (
        "NAV_DLL_ACT",
        &[
            (0, "Disabled"),
            (1, "Hold mode"),
            (2, "Return mode"),
            (3, "Land mode"),
            (5, "Terminate"),
            (6, "Disarm"),
        ],
    ),
    (
        "NAV_RCL_ACT",
        &[(1, "Hold mode"), (2, "Return mode"), (3, "Land mode"), (5, "Terminate"), (6, "Disarm")],
    ),
    ("PD_GRIPPER_EN", &[(1, "Enabled")]),
    ("PD_GRIPPER_TYPE", &[(0, "Servo")]),
    ("RC_MAP_#", NO_CHANNEL),
    ("SYS_AUTOCONFIG", &[(0, "Keep parameters")]),
    ("SYS_AUTOSTART", &[(4001, "Generic Quadcopter")]),
    ("SYS_FAILURE_EN", &[(0, "Disabled"), (1, "Enabled")]),
];

/// Parameters that are made of bits, with PX4's words for them from bit 0 on.
const BITS: [(&str, &[&str]); 2] = [
    ("COM_RCL_EXCEPT", &["Mission", "Hold", "Offboard"]),
    ("COM_RC_OVERRIDE", &["Enable override during auto modes", "Enable override during offboard mode"]),
];

fn choices(name: &str) -> Option<Choices> {
    let is_meant = |pattern: &str| match pattern.strip_suffix('#') {
        Some(beginning) => name.starts_with(beginning),
        None => name == pattern,
    };
    CHOICES.iter().find(|(pattern, _)| is_meant(pattern)).map(|(_, choices)| *choices)
}

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
    fields.extend(known.min.map(|min| ("min", min.to_string())));
    fields.extend(known.max.map(|max| ("max", max.to_string())));
    if let Some(choices) = choices(&entry.name) {
        fields.push(("values", list("value", choices.iter().copied())));
    }
    if let Some((_, bits)) = BITS.iter().find(|(name, _)| *name == entry.name) {
        fields.push(("bitmask", list("index", (0..).zip(bits.iter().copied()))));
    }
    // MAVLink's schema has it; PX4 writes none, and QGroundControl does not read it.
    if !entry.role.is_settable() {
        fields.push(("readOnly", "true".to_owned()));
    }
    let fields: Vec<String> = fields.into_iter().map(|(key, value)| format!("\"{key}\":{value}")).collect();
    format!("{{{}}}", fields.join(","))
}

/// Objects with a number under a key, and words.
fn list(key: &str, items: impl Iterator<Item = (i32, &'static str)>) -> String {
    let item =
        |(number, words): (i32, &str)| format!("{{\"{key}\":{number},\"description\":{}}}", quoted(words));
    format!("[{}]", items.map(item).collect::<Vec<_>>().join(","))
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
        Some("PD") => "Payload Deliverer",
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
    use crate::autopilot::parameters::table::table;
    use crate::control::Gains;
    use crate::params::Value;

    /// Property: what is offered is taken, and nothing else is; a fact offers itself.
    #[test]
    fn prop_choices_are_what_the_settings_take() {
        let mut with_choices = 0;
        for declared in table() {
            let bits = BITS.iter().find(|(name, _)| *name == declared.name).map(|(_, bits)| bits.len());
            let Some(choices) = choices(declared.name) else {
                if let Some(bits) = bits {
                    for value in -1..=(1 << bits) {
                        let mut settings = Settings::beside(&Gains::near_hover());
                        let offered = (0..1 << bits).contains(&value);
                        assert_eq!(
                            settings.set(declared.name, f64::from(value)),
                            offered,
                            "{}",
                            declared.name
                        );
                    }
                }
                continue;
            };
            with_choices += 1;
            assert_eq!(bits, None, "{}: either or", declared.name);
            match declared.role {
                Role::Setting => {
                    for value in -2..10 {
                        let mut settings = Settings::beside(&Gains::near_hover());
                        let offered = choices.iter().any(|choice| choice.0 == value);
                        assert_eq!(
                            settings.set(declared.name, f64::from(value)),
                            offered,
                            "{}",
                            declared.name
                        );
                    }
                }
                Role::Fact(Value::Int(value)) => {
                    assert_eq!(choices.iter().map(|c| c.0).collect::<Vec<_>>(), [value], "{}", declared.name);
                }
                Role::Estimator | Role::Vehicle => {}
                role => panic!("{}: {role:?}", declared.name),
            }
        }
        // Six of COM_FLTMODE and seven of RC_MAP have a row together.
        assert_eq!(with_choices, CHOICES.len() - 2 + 6 + 7, "a row without its parameter");
    }
}
