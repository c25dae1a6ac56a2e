//! An [`Outcome`] in files: the cells of a row, the keys of an object. A number is a column or a key by
//! itself, named by its [`Quantity`]; what is none is an empty cell, and `null`.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::ser::SerializeMap as _;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value, json};
use std::borrow::Cow;

use samara_core::assess::outcome::{QUANTITIES, Quantity};
use samara_core::assess::{Limits, Outcome};
use samara_mission::Mission;

/// An outcome as keys of an object: every quantity. It reads those that are there, and has no number for the
/// others; keys that are no quantities are left to others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutcomeObject(pub Outcome);

impl Serialize for OutcomeObject {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(QUANTITIES.len()))?;
        for quantity in &QUANTITIES {
            map.serialize_entry(quantity.key, &quantity.of(&self.0))?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for OutcomeObject {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let object = Map::deserialize(deserializer)?;
        let mut outcome = Outcome::lost();
        for quantity in &QUANTITIES {
            quantity.put(&mut outcome, object.get(quantity.key).and_then(Value::as_f64));
        }
        Ok(Self(outcome))
    }
}

impl JsonSchema for OutcomeObject {
    fn schema_name() -> Cow<'static, str> {
        "Outcome".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let key = |quantity: &Quantity| {
            let words = format!("The {}; null where the flight has none.", quantity.head());
            let schema = json!({ "description": words, "type": ["number", "null"] });
            (quantity.key.to_owned(), schema)
        };
        let keys: Map<String, Value> = QUANTITIES.iter().map(key).collect();
        let required = QUANTITIES.map(|quantity| quantity.key);
        json_schema!({ "type": "object", "properties": keys, "required": required })
    }
}

/// An outcome as an object of its own, which has each quantity, a number or `null`, and nothing else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutcomeRecord(pub Outcome);

impl Serialize for OutcomeRecord {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        OutcomeObject(self.0).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for OutcomeRecord {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let object = Map::deserialize(deserializer)?;
        let is_told = |value: &Value| value.is_null() || value.as_f64().is_some();
        let there = |quantity: &Quantity| object.get(quantity.key).is_some_and(is_told);
        if object.len() != QUANTITIES.len() || !QUANTITIES.iter().all(there) {
            let expected = "each quantity of a flight, a number or null, is expected";
            return Err(serde::de::Error::custom(expected));
        }
        OutcomeObject::deserialize(Value::Object(object))
            .map_err(serde::de::Error::custom)
            .map(|of| Self(of.0))
    }
}

/// The limits of a mission beside those of J_state as an object: each under its key, and how close to the
/// target steady flight is where that must be reached, in the mean over which time where it is told by that.
/// A mission without ground has none of a touch.
pub fn limits_object(mission: &Mission, limits: &Limits) -> Map<String, Value> {
    let there = |quantity: &Quantity| mission.site.ground.is_some() || !quantity.is_of_a_touch();
    let limit = |quantity: &Quantity| (quantity.limit)(limits).filter(|_| there(quantity));
    let judged = QUANTITIES.iter().filter_map(|quantity| Some((quantity.judged?.key, limit(quantity))));
    let within = limits.must_be_steady.then_some(limits.steady_within_m_s);
    let mean = limits.steady_mean_over_s.filter(|_| limits.must_be_steady);
    let mean = mean.map(|over_s| ("steady_mean_over_s", Some(over_s)));
    let all = judged.chain([("steady_within_m_s", within)]).chain(mean);
    all.map(|(key, limit)| (key.to_owned(), limit.into())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::Columns;

    /// Each quantity with a number of its own.
    fn distinct() -> Outcome {
        let mut outcome = Outcome::default();
        (1u32..)
            .zip(&QUANTITIES)
            .for_each(|(n, quantity)| quantity.put(&mut outcome, Some(f64::from(n) / 8.0)));
        outcome
    }

    /// A property: cells stand under their columns, and an object is read as it was written; one that lacks a
    /// quantity, has another key or no number is refused.
    #[test]
    fn prop_cells_and_keys_are_those_of_their_quantities() {
        let outcome = distinct();
        let columns = Columns::<Outcome>::none().quantities(&QUANTITIES, |of| Some(of));
        let (names, line) = (columns.names(), columns.line(&outcome));
        let cells: Vec<f64> = line.trim_end().split(',').map(|cell| cell.parse().unwrap()).collect();
        for ((name, cell), quantity) in names.split(',').zip(&cells).zip(&QUANTITIES) {
            assert_eq!((name, Some(*cell)), (quantity.key, quantity.of(&outcome)));
        }
        for outcome in [outcome, Outcome::lost()] {
            let text = serde_json::to_string(&OutcomeRecord(outcome)).unwrap();
            assert_eq!(serde_json::from_str::<OutcomeRecord>(&text).unwrap().0, outcome);
            for spoilt in [
                text.replace("\"peak_tilt_deg\"", "\"peak_tilt_rad\""),
                text.replacen('{', "{\"more\":1.0,", 1),
                text.replacen("\"j_tpf\":", "\"j_tpf\":\"x\",\"y\":", 1),
            ] {
                assert!(serde_json::from_str::<OutcomeRecord>(&spoilt).is_err(), "{spoilt}");
            }
        }
    }
}
