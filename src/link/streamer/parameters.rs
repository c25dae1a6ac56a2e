//! Parameters given to the vehicle (PARAM_SET, its echo compared) and asked of it (PARAM_REQUEST_READ).

use std::collections::BTreeMap;

use mavlink::dialects::common::*;

use super::patience::{Sent, Wire};
use crate::link::wire::param_value;
use crate::params::Value;
use crate::params::file::AUTOPILOT_COMPONENT;
use crate::params::px4_required::other_name;
use crate::time::TimeUs;

/// What is not answered is sent again after this, on the autopilot's clock.
pub(super) const RETRY_US: TimeUs = 300_000;
/// What has been sent so often is not there: PX4 answers in a hundredth of that time.
pub(super) const TRIES: u32 = 4;
/// How many go out at a time: a burst must fit into the receiver's socket.
const AT_A_TIME: usize = 16;
/// By name, not by index.
const BY_NAME: i16 = -1;

/// What is known of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Known {
    /// No answer yet.
    Nothing,
    /// The vehicle has this value.
    Has(Value),
    /// The vehicle does not have the parameter.
    Absent,
}

#[derive(Clone, Debug)]
struct Item {
    name: String,
    set: Option<Value>,
    sent: Option<Sent>,
    tries: u32,
    known: Known,
}

impl Item {
    fn is_over(&self) -> bool {
        match (self.known, self.set) {
            (Known::Nothing, _) => false,
            // An echo with another value: it is tried again.
            (Known::Has(value), Some(set)) => value == set || self.tries >= TRIES,
            _ => true,
        }
    }
}

/// Parameters under way.
#[derive(Clone, Debug, Default)]
pub(super) struct Exchange(Vec<Item>);

/// Result of an exchange.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Outcome {
    /// What the vehicle has.
    pub(super) values: BTreeMap<String, Value>,
    /// How many were set.
    pub(super) set: usize,
    /// Were to be set and do not exist there.
    pub(super) absent: Vec<String>,
    /// Were to be set to the first value and are the second.
    pub(super) refused: Vec<(String, Value, Value)>,
}

impl Exchange {
    /// Sets some parameters and reads others.
    pub(super) fn new<'a>(set: &BTreeMap<String, Value>, read: impl Iterator<Item = &'a str>) -> Self {
        let item = |name: &str, set| {
            let name = name.to_owned();
            Item { name, set, sent: None, tries: 0, known: Known::Nothing }
        };
        let reads = read.filter(|name| !set.contains_key(*name)).map(|name| item(name, None));
        Self(set.iter().map(|(name, value)| item(name, Some(*value))).chain(reads).collect())
    }

    /// What is to be sent now to the autopilot of a system; what is not answered is sent again after
    /// `retry_us`.
    pub(super) fn poll(
        &mut self,
        now: TimeUs,
        retry_us: TimeUs,
        wire: &Wire,
        system_id: u8,
    ) -> Vec<MavMessage> {
        let waited = |sent: Sent| wire.has_waited(sent, now, retry_us);
        for item in &mut self.0 {
            let unanswered = item.sent.is_some_and(waited) && item.tries >= TRIES;
            if unanswered && item.known == Known::Nothing {
                item.known = Known::Absent;
            }
        }
        let due = |item: &&mut Item| !item.is_over() && item.tries < TRIES && item.sent.is_none_or(waited);
        let send = |item: &mut Item| {
            item.sent = Some(wire.send(now));
            item.tries += 1;
            message(&item.name, item.set, system_id)
        };
        self.0.iter_mut().filter(due).take(AT_A_TIME).map(send).collect()
    }

    /// Takes the vehicle's value of a parameter.
    pub(super) fn take(&mut self, m: &PARAM_VALUE_DATA) {
        let value = match m.param_type {
            MavParamType::MAV_PARAM_TYPE_INT32 => Value::Int(m.param_value.to_bits() as i32),
            MavParamType::MAV_PARAM_TYPE_REAL32 => Value::Real(m.param_value),
            _ => return,
        };
        let of_that_name = |item: &&mut Item| m.param_id.to_str() == Ok(item.name.as_str());
        if let Some(item) = self.0.iter_mut().find(of_that_name) {
            item.known = Known::Has(value);
            // Which it has by one of two names it does not have by the other: nothing to be waited for.
            let other = other_name(&item.name);
            if let Some(other) = self.0.iter_mut().find(|item| other == Some(item.name.as_str())) {
                other.known = Known::Absent;
            }
        }
    }

    /// The vehicle does not have a parameter.
    pub(super) fn take_absence(&mut self, name: &str) {
        if let Some(item) = self.0.iter_mut().find(|item| item.name == name && item.tries > 0) {
            item.known = Known::Absent;
        }
    }

    /// Whether each has been answered or given up.
    pub(super) fn is_over(&self) -> bool {
        self.0.iter().all(Item::is_over)
    }

    /// Result of the exchange so far.
    pub(super) fn outcome(&self) -> Outcome {
        let mut outcome = Outcome::default();
        for item in &self.0 {
            match (item.known, item.set) {
                (Known::Has(value), set) => {
                    outcome.values.insert(item.name.clone(), value);
                    match set {
                        Some(set) if set != value => outcome.refused.push((item.name.clone(), set, value)),
                        Some(_) => outcome.set += 1,
                        None => {}
                    }
                }
                (_, Some(_)) => outcome.absent.push(item.name.clone()),
                (_, None) => {}
            }
        }
        outcome
    }
}

fn message(name: &str, set: Option<Value>, system_id: u8) -> MavMessage {
    let (target_system, target_component) = (system_id, AUTOPILOT_COMPONENT);
    let Some(value) = set else {
        return MavMessage::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
            param_index: BY_NAME,
            target_system,
            target_component,
            param_id: name.into(),
        });
    };
    let ((param_value, param_type), param_id) = (param_value(value), name.into());
    let data = PARAM_SET_DATA { param_value, target_system, target_component, param_id, param_type };
    MavMessage::PARAM_SET(data)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// PX4 v1.16 has EKF2_GPS_DELAY, says so, and says nothing of SENS_GPS0_DELAY, by its source: that is not
    /// waited for.
    #[test]
    fn what_goes_by_another_name_is_not_waited_for() {
        let names = ["EKF2_GPS_DELAY", "SENS_GPS0_DELAY"];
        let set = names.map(|name| (name.to_owned(), Value::Real(110.0))).into();
        let (mut exchange, wire) = (Exchange::new(&set, std::iter::empty()), Wire::default());
        assert_eq!(exchange.poll(0, RETRY_US, &wire, 1).len(), 2);
        let (param_id, param_type) = ("EKF2_GPS_DELAY".into(), MavParamType::MAV_PARAM_TYPE_REAL32);
        exchange.take(&PARAM_VALUE_DATA { param_id, param_value: 110.0, param_type, ..Default::default() });
        assert!(exchange.is_over());
        assert_eq!((exchange.outcome().set, exchange.outcome().absent), (1, vec![names[1].to_owned()]));
    }
}
