//! Events' metadata, from libevents' JSON.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::argument::Argument;
use super::{Description, EventTexts, Role};

/// Why metadata of events cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("metadata of PX4's events: {0}")]
pub struct EventsError(String);

#[derive(Deserialize)]
struct File {
    components: BTreeMap<u32, Component>,
}

#[derive(Deserialize)]
struct Component {
    namespace: String,
    #[serde(default)]
    enums: BTreeMap<String, Enum>,
    #[serde(default)]
    event_groups: BTreeMap<String, Group>,
}

#[derive(Deserialize)]
struct Enum {
    #[serde(rename = "type")]
    kind: String,
    #[serde(default)]
    is_bitfield: bool,
    #[serde(default)]
    entries: BTreeMap<u64, Entry>,
}

#[derive(Deserialize)]
struct Entry {
    name: String,
    #[serde(default)]
    description: String,
}

#[derive(Deserialize)]
struct Group {
    #[serde(default)]
    events: BTreeMap<u32, EventJson>,
}

#[derive(Deserialize)]
struct EventJson {
    #[serde(default)]
    message: String,
    #[serde(default)]
    arguments: Vec<ArgumentJson>,
    #[serde(default, rename = "type")]
    kind: Option<String>,
}

#[derive(Deserialize)]
struct ArgumentJson {
    #[serde(rename = "type")]
    kind: String,
}

/// Groups of events whose first argument has the modes that a check is for.
const CHECKS: [&str; 2] = ["arming_check", "health"];
/// The event that a report begins with: of two summaries the first.
const SUMMARY: &str = "arming_check";

impl EventTexts {
    /// The texts of metadata in libevents' JSON, uncompressed. Events with arguments of a kind that is not
    /// known are left out.
    ///
    /// # Errors
    /// [`EventsError`] where the JSON is none, or not of events.
    pub fn parse(json: &[u8]) -> Result<Self, EventsError> {
        let file: File = serde_json::from_slice(json).map_err(|e| EventsError(e.to_string()))?;
        let mut kinds = BTreeMap::new();
        for component in file.components.values() {
            for (name, of) in &component.enums {
                kinds.insert(format!("{}::{name}", component.namespace), of);
            }
        }
        let mut texts = BTreeMap::new();
        for (id, component) in &file.components {
            for (group, events) in &component.event_groups {
                for (number, event) in &events.events {
                    let of = |argument: &ArgumentJson| kind(&argument.kind, &component.namespace, &kinds);
                    let Some(arguments) = event.arguments.iter().map(of).collect::<Option<Vec<_>>>() else {
                        continue;
                    };
                    let role = match event.kind.as_deref() {
                        Some("summary") if group == SUMMARY => Role::Summary,
                        None if CHECKS.contains(&group.as_str()) => Role::Check,
                        _ => Role::Plain,
                    };
                    let message = event.message.clone();
                    texts.insert(id << 24 | number & 0xFF_FFFF, Description { message, arguments, role });
                }
            }
        }
        Ok(Self(texts))
    }
}

fn kind(name: &str, namespace: &str, enums: &BTreeMap<String, &Enum>) -> Option<Argument> {
    if let Some(plain) = plain(name) {
        return Some(plain);
    }
    let full = if name.contains("::") { name.to_owned() } else { format!("{namespace}::{name}") };
    let of = enums.get(&full)?;
    let bytes = plain(&of.kind)?.bytes() as u8;
    let shown = |entry: &Entry| match entry.description.as_str() {
        "" => entry.name.clone(),
        words => words.to_owned(),
    };
    let names = of.entries.iter().map(|(value, entry)| (*value, shown(entry))).collect();
    Some(Argument::Named { bytes, bits: of.is_bitfield, names })
}

fn plain(name: &str) -> Option<Argument> {
    Some(match name {
        "uint8_t" => Argument::Unsigned(1),
        "uint16_t" => Argument::Unsigned(2),
        "uint32_t" => Argument::Unsigned(4),
        "uint64_t" => Argument::Unsigned(8),
        "int8_t" => Argument::Signed(1),
        "int16_t" => Argument::Signed(2),
        "int32_t" => Argument::Signed(4),
        "int64_t" => Argument::Signed(8),
        "float" => Argument::Float,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::super::{Event, HealthReport};
    use super::*;

    /// In the form of PX4 v1.16's `all_events.json`: numbers, kinds and messages are its own.
    const JSON: &str = r#"{ "version": 2, "components": {
        "1": { "namespace": "px4",
            "enums": {
                "arm_disarm_reason_t": { "type": "uint8_t", "entries": {
                    "4": { "name": "command_external", "description": "external command" } } },
                "navigation_mode_group_t": { "type": "uint32_t", "is_bitfield": true, "entries": {
                    "16384": { "name": "offboard", "description": "Offboard" } } },
                "health_component_t": { "type": "uint64_t", "is_bitfield": true, "entries": {} } },
            "event_groups": {
                "default": { "events": {
                    "7": { "name": "armed_by", "message": "Armed by {1}",
                        "arguments": [{ "name": "a", "type": "px4::arm_disarm_reason_t" }] },
                    "8": { "name": "strange", "message": "?", "arguments": [{ "name": "a", "type": "what_t" }] } } },
                "health": { "events": {
                    "11047905": { "name": "health_summary", "type": "summary", "message": "s", "arguments": [] } } },
                "arming_check": { "events": {
                    "11047904": { "name": "summary", "type": "summary", "message": "Arming check summary event",
                        "arguments": [{ "name": "chunk_idx", "type": "uint8_t" }] },
                    "9": { "name": "bias", "message": "High Accelerometer Bias on axis {3:.1}",
                        "arguments": [{ "name": "modes", "type": "navigation_mode_group_t" },
                            { "name": "c", "type": "uint8_t" }, { "name": "x", "type": "float" }] } } } } } } }"#;

    fn event(number: u32, level: u8, arguments: &[u8]) -> Event {
        let mut all = [0; 40];
        all[..arguments.len()].copy_from_slice(arguments);
        Event { id: 1 << 24 | number, sequence: 0, level, arguments: all }
    }

    #[test]
    fn events_are_told_in_their_own_words() {
        let texts = EventTexts::parse(JSON.as_bytes()).unwrap();
        assert_eq!(texts.text(&event(7, 6, &[4])).unwrap(), "Armed by external command");
        assert_eq!(texts.text(&event(7, 6, &[9])).unwrap(), "Armed by 9");
        assert_eq!(texts.text(&event(8, 6, &[])), None, "an argument of no known kind");
        assert_eq!(texts.len(), 4);
    }

    /// A report holds until the next summary; only errors for the mode that is asked about are reasons.
    #[test]
    fn a_report_names_the_checks_that_are_against_a_mode() {
        const OFFBOARD: u8 = 14;
        let texts = EventTexts::parse(JSON.as_bytes()).unwrap();
        let bias = |modes: u32, level| {
            let mut arguments = modes.to_le_bytes().to_vec();
            arguments.push(0);
            arguments.extend(1.26_f32.to_le_bytes());
            event(9, level, &arguments)
        };
        let mut report = HealthReport::default();
        report.take(bias(1 << OFFBOARD, 3));
        assert_eq!(report.against(OFFBOARD, &texts), ["High Accelerometer Bias on axis 1.3"]);
        assert!(report.against(OFFBOARD + 1, &texts).is_empty() && report.against(200, &texts).is_empty());
        report.take(event(11_047_905, 8, &[]));
        assert_eq!(report.against(OFFBOARD, &texts).len(), 1, "the other summary begins nothing");
        report.take(event(11_047_904, 8, &[]));
        report.take(bias(1 << OFFBOARD, 4));
        assert!(report.against(OFFBOARD, &texts).is_empty(), "a warning keeps nobody from arming");
    }

    #[test]
    fn what_is_no_metadata_is_refused() {
        for json in ["", "[]", "{\"components\": 1}", "{\"components\": {\"1\": {}}}"] {
            let error = EventTexts::parse(json.as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with("metadata of PX4's events: "), "{error}");
        }
    }
}
