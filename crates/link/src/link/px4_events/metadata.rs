//! Events' metadata, from libevents' JSON.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Deserialize;

use super::argument::Argument;
use super::{ARGUMENTS, Description, EventTexts, Role};

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
/// Most entries of an enum: PX4's have some dozen.
const MOST_ENTRIES: usize = 256;
/// Most bytes of an event's message: PX4's have some hundred.
const LONGEST_MESSAGE: usize = 2000;
/// The event that a report begins with: of two summaries the first.
const SUMMARY: &str = "arming_check";

impl EventTexts {
    /// The texts of metadata in libevents' JSON, uncompressed. Events with arguments of a kind that is not
    /// known are left out.
    ///
    /// # Errors
    /// [`EventsError`] where the JSON is none, or not of events, or holds more than events can: arguments of
    /// more than 40 bytes, enums of more than 256 entries, messages of more than 2000 bytes.
    pub fn parse(json: &[u8]) -> Result<Self, EventsError> {
        let file: File = serde_json::from_slice(json).map_err(|e| EventsError(e.to_string()))?;
        let mut enums = BTreeMap::new();
        for component in file.components.values() {
            for (name, of) in &component.enums {
                let full = format!("{}::{name}", component.namespace);
                if of.entries.len() > MOST_ENTRIES {
                    return Err(too_many(&full, of.entries.len(), "entries", MOST_ENTRIES));
                }
                if let Some(argument) = named(of) {
                    enums.insert(full, argument);
                }
            }
        }
        let mut texts = BTreeMap::new();
        for (id, component) in &file.components {
            for (group, events) in &component.event_groups {
                for (number, event) in &events.events {
                    let what = || format!("event {number} of {}", component.namespace);
                    if event.message.len() > LONGEST_MESSAGE {
                        let bytes = event.message.len();
                        return Err(too_many(&what(), bytes, "bytes of message", LONGEST_MESSAGE));
                    }
                    // Each has a byte at the least.
                    if event.arguments.len() > ARGUMENTS {
                        return Err(too_many(&what(), event.arguments.len(), "arguments", ARGUMENTS));
                    }
                    let of = |argument: &ArgumentJson| kind(&argument.kind, &component.namespace, &enums);
                    let Some(arguments) = event.arguments.iter().map(of).collect::<Option<Vec<_>>>() else {
                        continue;
                    };
                    let bytes = arguments.iter().map(Argument::bytes).sum();
                    if bytes > ARGUMENTS {
                        return Err(too_many(&what(), bytes, "bytes of arguments", ARGUMENTS));
                    }
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

fn too_many(what: &str, number: usize, of: &str, most: usize) -> EventsError {
    EventsError(format!("{what} has {number} {of}, {most} at most are expected"))
}

fn kind(name: &str, namespace: &str, enums: &BTreeMap<String, Argument>) -> Option<Argument> {
    if let Some(plain) = plain(name) {
        return Some(plain);
    }
    let full = if name.contains("::") { name.to_owned() } else { format!("{namespace}::{name}") };
    enums.get(&full).cloned()
}

/// The kind of an enum's arguments; `None` where it is of a type that is not known.
fn named(of: &Enum) -> Option<Argument> {
    let bytes = plain(&of.kind)?.bytes() as u8;
    let shown = |entry: &Entry| match entry.description.as_str() {
        "" => entry.name.clone(),
        words => words.to_owned(),
    };
    let names = of.entries.iter().map(|(value, entry)| (*value, shown(entry))).collect();
    Some(Argument::Named { bytes, bits: of.is_bitfield, names: Arc::new(names) })
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

    /// 8 kB of xz, and 3 GB once each argument had a copy of its enum's entries: the process was aborted.
    #[test]
    fn regress_metadata_that_hold_more_than_events_can_are_refused_by_the_bound() {
        let file = |entries: usize, message: usize, arguments: &[&str]| {
            let entries: Vec<String> = (0..entries).map(|i| format!(r#""{i}":{{"name":"n"}}"#)).collect();
            let arguments: Vec<String> = arguments.iter().map(|of| format!(r#"{{"type":"{of}"}}"#)).collect();
            let json = format!(
                r#"{{"components":{{"1":{{"namespace":"px4",
                "enums":{{"e":{{"type":"uint32_t","entries":{{{}}}}}}},
                "event_groups":{{"g":{{"events":{{"7":{{"message":"{}","arguments":[{}]}}}}}}}}}}}}}}"#,
                entries.join(","),
                "m".repeat(message),
                arguments.join(","),
            );
            EventTexts::parse(json.as_bytes()).map(|texts| texts.len()).map_err(|e| e.to_string())
        };
        assert_eq!(file(256, 2000, &["e"; 10]), Ok(1), "as much as fits");
        for (entries, message, arguments, why) in [
            (20_000, 0, vec!["e"; 20_000], "px4::e has 20000 entries, 256 at most"),
            (256, 0, vec!["e"; 20_000], "event 7 of px4 has 20000 arguments, 40 at most"),
            (256, 0, vec!["e"; 11], "event 7 of px4 has 44 bytes of arguments, 40 at most"),
            (256, 2001, vec![], "event 7 of px4 has 2001 bytes of message, 2000 at most"),
        ] {
            let refusal = file(entries, message, &arguments).unwrap_err();
            assert_eq!(refusal, format!("metadata of PX4's events: {why} are expected"));
        }
    }

    /// However many arguments are of one enum, its entries are there once.
    #[test]
    fn arguments_of_one_enum_share_its_entries() {
        let texts = EventTexts::parse(JSON.as_bytes()).unwrap();
        assert_eq!(texts.len(), 4);
        let twice = JSON.replace(
            r#""type": "navigation_mode_group_t" },"#,
            r#""type": "navigation_mode_group_t" }, { "name": "too", "type": "navigation_mode_group_t" },"#,
        );
        let texts = EventTexts::parse(twice.as_bytes()).unwrap();
        let Argument::Named { names, .. } = &texts.0[&(1 << 24 | 9)].arguments[1] else { panic!() };
        assert_eq!(Arc::strong_count(names), 2);
    }
}
