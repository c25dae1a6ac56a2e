//! Parameters given to the vehicle and asked of it.
//!
//! Each is read first (PARAM_REQUEST_READ) and then, if it is to be set, written (PARAM_SET) in the type that
//! the vehicle's PARAM_VALUE named, and the echo is compared. PX4 takes no value of another type than the
//! parameter's, and types change between its versions: v1.12 says so by STATUSTEXT, v1.13 to v1.17 by nothing
//! at all, later ones by PARAM_ERROR, which tells one kind of refusal from another
//! (`mavlink_parameters.cpp`).

use std::collections::BTreeMap;
use std::fmt;

use mavlink::dialects::common::*;

use super::patience::{Sent, Wire};
use crate::link::wire::param_value;
use crate::params::Value;
use crate::params::file::AUTOPILOT_COMPONENT;
use crate::params::px4_required::other_name;
use crate::time::TimeUs;

/// What is not answered is sent again after this, on the autopilot's clock.
pub(in crate::link) const RETRY_US: TimeUs = 300_000;
/// What has been asked for so often is not there, what has been written so often is not taken: PX4 answers in
/// a hundredth of that time.
const TRIES: u32 = 4;
/// How many go out at a time: a burst must fit into the receiver's socket.
const AT_A_TIME: usize = 16;
/// By name, not by index.
const BY_NAME: i16 = -1;

/// Why a value is not in the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::link) enum Refusal {
    /// The vehicle says why (PARAM_ERROR).
    Told(MavParamError),
    /// The parameter's type has no such value; this is the value that it has.
    Unfit(Value),
    /// The vehicle keeps, or echoes, this value.
    Keeps(Value),
    /// PARAM_SET was not answered.
    Unanswered,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = match self {
            Self::Told(error) => *error,
            Self::Unfit(Value::Int(_)) => return f.write_str("a whole number there"),
            Self::Unfit(Value::Real(_)) => return f.write_str("in single precision there"),
            Self::Keeps(value) => return write!(f, "reads back as {value}"),
            Self::Unanswered => return write!(f, "no answer to {TRIES} PARAM_SET"),
        };
        f.write_str(match kind {
            MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST => "unknown there",
            MavParamError::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE => "out of range there",
            MavParamError::MAV_PARAM_ERROR_PERMISSION_DENIED => "not permitted",
            MavParamError::MAV_PARAM_ERROR_COMPONENT_NOT_FOUND => "of a component that is not there",
            MavParamError::MAV_PARAM_ERROR_READ_ONLY => "read-only there",
            MavParamError::MAV_PARAM_ERROR_TYPE_UNSUPPORTED => "of a type that is not taken there",
            MavParamError::MAV_PARAM_ERROR_TYPE_MISMATCH => "of another type there",
            MavParamError::MAV_PARAM_ERROR_READ_FAIL => "cannot be read there",
            _ => "refused, and no reason told",
        })
    }
}

/// How far a parameter is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// Asked for.
    Reading,
    /// Written in the vehicle's type; the last echo, if there was one.
    Writing(Value, Option<Value>),
    /// The vehicle has this value.
    Has(Value),
    /// The vehicle does not have the parameter: it says so, or has it by another name.
    Absent,
    /// It was asked for as often as it is, and nothing came.
    Silent,
    /// The vehicle does not take the value, or cannot read its own.
    Refused(Refusal),
}

#[derive(Clone, Debug)]
struct Item {
    name: String,
    set: Option<Value>,
    sent: Option<Sent>,
    tries: u32,
    stage: Stage,
}

impl Item {
    fn is_over(&self) -> bool {
        !matches!(self.stage, Stage::Reading | Stage::Writing(..))
    }

    /// Takes the vehicle's value, read or echoed.
    fn take(&mut self, value: Value) {
        match (self.stage, self.set) {
            (Stage::Writing(wanted, _), _) if value == wanted => self.stage = Stage::Has(value),
            (Stage::Writing(wanted, _), _) => self.stage = Stage::Writing(wanted, Some(value)),
            (Stage::Reading | Stage::Absent | Stage::Silent, Some(set)) => match set.in_type_of(value) {
                Some(wanted) => {
                    (self.stage, self.sent, self.tries) = (Stage::Writing(wanted, None), None, 0);
                }
                None => self.stage = Stage::Refused(Refusal::Unfit(value)),
            },
            (Stage::Reading | Stage::Absent | Stage::Silent, None) => self.stage = Stage::Has(value),
            _ => {}
        }
    }

    /// The tries are over, and so is the time for an answer to the last one.
    fn give_up(&mut self) {
        self.stage = match self.stage {
            Stage::Reading => Stage::Silent,
            Stage::Writing(_, Some(other)) => Stage::Refused(Refusal::Keeps(other)),
            Stage::Writing(_, None) => Stage::Refused(Refusal::Unanswered),
            over => over,
        };
    }
}

/// Parameters under way.
#[derive(Clone, Debug, Default)]
pub(in crate::link) struct Exchange(Vec<Item>);

/// Result of an exchange.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::link) struct Exchanged {
    /// What the vehicle has.
    pub(in crate::link) values: BTreeMap<String, Value>,
    /// How many were set.
    pub(in crate::link) set: usize,
    /// Were to be set and do not exist there.
    pub(in crate::link) absent: Vec<String>,
    /// Were to be set or read, and no value has come.
    pub(in crate::link) silent: Vec<String>,
    /// Were to be set to a value and were not.
    pub(in crate::link) refused: Vec<(String, Value, Refusal)>,
}

impl Exchange {
    /// Sets some parameters and reads others.
    pub(in crate::link) fn new<'a>(
        set: &BTreeMap<String, Value>,
        read: impl Iterator<Item = &'a str>,
    ) -> Self {
        let item = |name: &str, set| {
            let name = name.to_owned();
            Item { name, set, sent: None, tries: 0, stage: Stage::Reading }
        };
        let reads = read.filter(|name| !set.contains_key(*name)).map(|name| item(name, None));
        Self(set.iter().map(|(name, value)| item(name, Some(*value))).chain(reads).collect())
    }

    /// What is to be sent now to the autopilot of a system; what is not answered is sent again after
    /// `retry_us`.
    pub(in crate::link) fn poll(
        &mut self,
        now: TimeUs,
        retry_us: TimeUs,
        wire: &Wire,
        system_id: u8,
    ) -> Vec<MavMessage> {
        let waited = |sent: Sent| wire.has_waited(sent, now, retry_us);
        for item in &mut self.0 {
            if item.tries >= TRIES && item.sent.is_some_and(waited) {
                item.give_up();
            }
        }
        let due = |item: &&mut Item| !item.is_over() && item.tries < TRIES && item.sent.is_none_or(waited);
        let send = |item: &mut Item| {
            item.sent = Some(wire.send(now));
            item.tries += 1;
            message(item, system_id)
        };
        self.0.iter_mut().filter(due).take(AT_A_TIME).map(send).collect()
    }

    /// Takes the vehicle's value of a parameter.
    pub(in crate::link) fn take(&mut self, m: &PARAM_VALUE_DATA) {
        let value = match m.param_type {
            MavParamType::MAV_PARAM_TYPE_INT32 => Value::Int(m.param_value.to_bits() as i32),
            MavParamType::MAV_PARAM_TYPE_REAL32 => Value::Real(m.param_value),
            _ => return,
        };
        let Ok(name) = m.param_id.to_str() else { return };
        if let Some(item) = self.0.iter_mut().find(|item| item.name == name) {
            item.take(value);
            // Which it has by one of two names it does not have by the other: nothing to be waited for.
            let other = other_name(name);
            if let Some(other) = self.0.iter_mut().find(|item| other == Some(item.name.as_str())) {
                other.stage = Stage::Absent;
            }
        }
    }

    /// The vehicle does not do what it was asked for about a parameter.
    pub(in crate::link) fn take_error(&mut self, name: &str, error: MavParamError) {
        let asked = |item: &&mut Item| item.name == name && item.tries > 0 && !item.is_over();
        if let Some(item) = self.0.iter_mut().find(asked) {
            item.stage = match error {
                MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST => Stage::Absent,
                other => Stage::Refused(Refusal::Told(other)),
            };
        }
    }

    /// Whether each has been answered or given up.
    pub(in crate::link) fn is_over(&self) -> bool {
        self.0.iter().all(Item::is_over)
    }

    /// Result of the exchange so far.
    pub(in crate::link) fn outcome(&self) -> Exchanged {
        let mut outcome = Exchanged::default();
        for item in &self.0 {
            match (item.stage, item.set) {
                (Stage::Has(value), set) => {
                    outcome.values.insert(item.name.clone(), value);
                    outcome.set += usize::from(set.is_some());
                }
                (Stage::Refused(why), Some(set)) => outcome.refused.push((item.name.clone(), set, why)),
                (Stage::Absent, Some(_)) => outcome.absent.push(item.name.clone()),
                (Stage::Absent, None) => {}
                (Stage::Refused(_), None) | (Stage::Reading | Stage::Writing(..) | Stage::Silent, _) => {
                    outcome.silent.push(item.name.clone());
                }
            }
        }
        outcome
    }
}

fn message(item: &Item, system_id: u8) -> MavMessage {
    let (target_system, target_component) = (system_id, AUTOPILOT_COMPONENT);
    let param_id = item.name.as_str().into();
    let Stage::Writing(value, _) = item.stage else {
        return MavMessage::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
            param_index: BY_NAME,
            target_system,
            target_component,
            param_id,
        });
    };
    let (param_value, param_type) = param_value(value);
    let data = PARAM_SET_DATA { param_value, target_system, target_component, param_id, param_type };
    MavMessage::PARAM_SET(data)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(name: &str, value: Value) -> PARAM_VALUE_DATA {
        let (param_value, param_type) = param_value(value);
        PARAM_VALUE_DATA { param_id: name.into(), param_value, param_type, ..Default::default() }
    }

    fn written(messages: &[MavMessage]) -> Vec<(String, u32, MavParamType)> {
        let of = |m: &MavMessage| match m {
            MavMessage::PARAM_SET(m) => {
                Some((m.param_id.to_str().unwrap().to_owned(), m.param_value.to_bits(), m.param_type))
            }
            _ => None,
        };
        messages.iter().filter_map(of).collect()
    }

    /// PX4 v1.16 has EKF2_GPS_DELAY, says so, and says nothing of SENS_GPS0_DELAY, by its source: that is not
    /// waited for.
    #[test]
    fn what_goes_by_another_name_is_not_waited_for() {
        let names = ["EKF2_GPS_DELAY", "SENS_GPS0_DELAY"];
        let set = names.map(|name| (name.to_owned(), Value::Real(110.0))).into();
        let (mut exchange, wire) = (Exchange::new(&set, std::iter::empty()), Wire::default());
        assert_eq!(exchange.poll(0, RETRY_US, &wire, 1).len(), 2);
        exchange.take(&told(names[0], Value::Real(10.0)));
        assert_eq!(written(&exchange.poll(0, RETRY_US, &wire, 1)).len(), 1);
        exchange.take(&told(names[0], Value::Real(110.0)));
        assert!(exchange.is_over());
        assert_eq!((exchange.outcome().set, exchange.outcome().absent), (1, vec![names[1].to_owned()]));
    }

    /// PX4 after v1.17 has SENS_GPS0_DELAY as an INT32 and refuses a REAL32 (`module.yaml`,
    /// `mavlink_parameters.cpp`); an INT32 travels as the float of the same bits.
    #[test]
    fn regress_a_parameter_is_written_in_the_type_that_it_was_read_in() {
        let set = [("A".to_owned(), Value::Real(110.0)), ("B".to_owned(), Value::Int(3))].into();
        let (mut exchange, wire) = (Exchange::new(&set, std::iter::empty()), Wire::default());
        assert!(written(&exchange.poll(0, RETRY_US, &wire, 1)).is_empty(), "read before it is written");
        exchange.take(&told("A", Value::Int(0)));
        exchange.take(&told("B", Value::Real(0.5)));
        let sent = written(&exchange.poll(0, RETRY_US, &wire, 1));
        let expected = [
            ("A".to_owned(), 110, MavParamType::MAV_PARAM_TYPE_INT32),
            ("B".to_owned(), 3f32.to_bits(), MavParamType::MAV_PARAM_TYPE_REAL32),
        ];
        assert_eq!(sent, expected);
        exchange.take(&told("A", Value::Int(110)));
        exchange.take(&told("B", Value::Real(3.0)));
        assert!(exchange.is_over() && exchange.outcome().set == 2);
    }

    /// A gain of 0.15 is no whole number, and 0 in its place would be another flight.
    #[test]
    fn a_value_that_the_type_has_not_is_refused_and_never_written() {
        let set = [("A".to_owned(), Value::Real(0.15))].into();
        let (mut exchange, wire) = (Exchange::new(&set, std::iter::empty()), Wire::default());
        exchange.poll(0, RETRY_US, &wire, 1);
        exchange.take(&told("A", Value::Int(0)));
        assert!(exchange.poll(0, RETRY_US, &wire, 1).is_empty() && exchange.is_over());
        let [(name, value, why)] = &exchange.outcome().refused[..] else { panic!() };
        assert_eq!(format!("{name} = {value} ({why})"), "A = 0.15 (a whole number there)");
    }

    /// An echo with another value is written again; four of them, or none, and it was not taken.
    #[test]
    fn what_reads_back_otherwise_is_written_four_times() {
        for (echo, words) in [(Some(Value::Real(2.0)), "reads back as 2"), (None, "no answer to 4 PARAM_SET")]
        {
            let set = [("A".to_owned(), Value::Real(1.0))].into();
            let (mut exchange, wire) = (Exchange::new(&set, std::iter::empty()), Wire::default());
            exchange.poll(0, RETRY_US, &wire, 1);
            exchange.take(&told("A", Value::Real(2.0)));
            let mut count = 0;
            for i in 0..40 {
                count += written(&exchange.poll(i * RETRY_US / 4, RETRY_US, &wire, 1)).len();
                if let Some(echo) = echo {
                    exchange.take(&told("A", echo));
                }
            }
            assert_eq!(count, 4);
            let [(_, _, why)] = exchange.outcome().refused[..] else { panic!() };
            assert_eq!(why.to_string(), words);
        }
    }

    /// Of MAVLink's kinds one says that the parameter is not there; all others are of one that is.
    #[test]
    fn an_error_is_told_by_its_kind() {
        use MavParamError::*;
        for (error, words) in [
            (MAV_PARAM_ERROR_DOES_NOT_EXIST, None),
            (MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE, Some("out of range there")),
            (MAV_PARAM_ERROR_PERMISSION_DENIED, Some("not permitted")),
            (MAV_PARAM_ERROR_READ_ONLY, Some("read-only there")),
            (MAV_PARAM_ERROR_TYPE_UNSUPPORTED, Some("of a type that is not taken there")),
            (MAV_PARAM_ERROR_TYPE_MISMATCH, Some("of another type there")),
            (MAV_PARAM_ERROR_READ_FAIL, Some("cannot be read there")),
        ] {
            let set = [("A".to_owned(), Value::Real(1.0))].into();
            let (mut exchange, wire) = (Exchange::new(&set, std::iter::empty()), Wire::default());
            exchange.take_error("A", error);
            assert!(!exchange.is_over(), "nothing was asked");
            exchange.poll(0, RETRY_US, &wire, 1);
            exchange.take_error("A", error);
            assert!(exchange.is_over());
            let Exchanged { absent, refused, .. } = exchange.outcome();
            assert_eq!(absent.is_empty(), words.is_some());
            assert_eq!(refused.first().map(|(_, _, why)| why.to_string()).as_deref(), words);
        }
    }
}
