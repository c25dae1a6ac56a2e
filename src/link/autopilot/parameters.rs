//! The parameter protocol: listed, read, set, checked for change by `_HASH_CHECK`, saved.
//!
//! As PX4 does it: integers travel as their bytes; a list begins with the checksum, by which a ground station that knows all values
//! stops it (PARAM_SET `_HASH_CHECK`), and goes out a few values at a time. Better than PX4: what is refused is said, with the
//! reason (STATUSTEXT, PARAM_ERROR), and the value in effect; an accepted change is told on both links, and so are the parameters
//! that follow from it.

use std::collections::VecDeque;

use mavlink::dialects::common::*;

use super::super::{Frame, Link};
use super::{AutopilotSession, Peer};
use crate::autopilot::Severity;
use crate::autopilot::parameters::{Parameters, Refusal};
use crate::params::export::GRAVITY_KEY;
use crate::params::{ParameterFile, Purpose, Value, file};

/// PX4's name for the checksum.
const HASH: &str = "_HASH_CHECK";
/// Values of a list that go out at a time.
const AT_A_TIME: usize = 5;
/// Index of what is no parameter.
const NO_INDEX: u16 = u16::MAX;
const TYPE_INT32: u8 = 6;
const TYPE_REAL32: u8 = 9;
/// Highest `MAV_PARAM_TYPE`.
const TYPE_LAST: u8 = 10;

/// Most lists that go out on a link at the same time.
const MAX_LISTS: usize = 32;

/// What comes next of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    Hash,
    Index(usize),
}

/// The lists that go out on a link, each to the peer that asked for it. They take turns.
#[derive(Clone, Debug, Default)]
pub(super) struct Listings(VecDeque<(Peer, Next)>);

impl Listings {
    /// One list at a time for a peer; asked for again, it starts over, without the checksum.
    fn begin(&mut self, peer: Peer) {
        if let Some((_, next)) = self.0.iter_mut().find(|(p, _)| p.id == peer.id) {
            *next = Next::Index(0);
        } else if self.0.len() < MAX_LISTS {
            self.0.push_back((peer, Next::Hash));
        }
    }

    fn stop(&mut self, peer: Peer) {
        self.0.retain(|(p, _)| p.id != peer.id);
    }
}

impl AutopilotSession {
    /// What is in effect, under PX4's names.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Puts in what a parameter file holds beyond gains and limits; gives remarks on the file.
    pub fn load_parameters(&mut self, file: &ParameterFile) -> Vec<String> {
        let remarks = self.parameters.load(file, &mut self.autopilot);
        if !self.running {
            self.restart_sensing();
        }
        remarks
    }

    /// The text of a parameter file that a ground station wants kept.
    pub fn take_saved_parameters(&mut self) -> Option<String> {
        self.saved_parameters.take()
    }

    /// PARAM_REQUEST_LIST.
    pub(super) fn begin_listing(&mut self, peer: Peer) {
        self.port(peer.link).listings.begin(peer);
    }

    /// Sends the next few values of the lists that are under way.
    pub(super) fn list_on(&mut self) {
        for link in super::LINKS {
            let Some((peer, mut next)) = self.port(link).listings.0.pop_front() else { continue };
            for _ in 0..AT_A_TIME {
                next = match next {
                    Next::Hash => {
                        self.send_hash(peer);
                        Next::Index(0)
                    }
                    Next::Index(index) => {
                        self.send_parameter(peer, index);
                        Next::Index(index + 1)
                    }
                };
            }
            if matches!(next, Next::Index(index) if index < self.parameters.len()) {
                self.port(link).listings.0.push_back((peer, next));
            }
        }
    }

    fn send_hash(&mut self, peer: Peer) {
        let message = PARAM_VALUE_DATA {
            param_value: f32::from_bits(self.parameters.hash()),
            param_count: self.parameters.len() as u16,
            param_index: NO_INDEX,
            param_id: HASH.into(),
            param_type: MavParamType::MAV_PARAM_TYPE_UINT32,
        };
        self.reply(peer, &MavMessage::PARAM_VALUE(message));
    }

    fn send_parameter(&mut self, peer: Peer, index: usize) {
        if let Some(message) = self.parameter_message(index) {
            self.reply(peer, &message);
        }
    }

    fn parameter_message(&self, index: usize) -> Option<MavMessage> {
        let entry = self.parameters.at(index)?;
        let (param_value, param_type) = match entry.value {
            // Integers travel as their bytes.
            Value::Int(x) => (f32::from_bits(x as u32), MavParamType::MAV_PARAM_TYPE_INT32),
            Value::Real(x) => (x, MavParamType::MAV_PARAM_TYPE_REAL32),
        };
        Some(MavMessage::PARAM_VALUE(PARAM_VALUE_DATA {
            param_value,
            param_count: self.parameters.len() as u16,
            param_index: index as u16,
            param_id: entry.name.as_str().into(),
            param_type,
        }))
    }

    /// PARAM_REQUEST_READ, by index or, with a negative one, by name.
    pub(super) fn answer_param_read(&mut self, peer: Peer, frame: &Frame) {
        let p = frame.payload();
        let asked = p.u16(0) as i16;
        let name = p.text::<16>(4);
        let index = match usize::try_from(asked) {
            Ok(index) => Some(index).filter(|&i| i < self.parameters.len()),
            Err(_) if name == HASH => return self.send_hash(peer),
            Err(_) => self.parameters.index_of(&name),
        };
        match index {
            Some(index) => self.send_parameter(peer, index),
            None => {
                let error = MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST;
                self.send_param_error(peer, &name, asked, error);
            }
        }
    }

    /// PARAM_SET, whatever its type.
    pub(super) fn set_parameter(&mut self, peer: Peer, frame: &Frame) {
        let p = frame.payload();
        let (name, kind) = (p.text::<16>(6), p.u8(22));
        if name == HASH {
            // The ground station knows all values.
            self.port(peer.link).listings.stop(peer);
            return;
        }
        let value = match kind {
            TYPE_INT32 => Value::Int(p.i32(0)),
            TYPE_REAL32 => Value::Real(p.f32(0)),
            _ => return self.refuse_type(peer, &name, kind),
        };
        match self.parameters.set(&name, value, &mut self.autopilot) {
            Ok(changed) => self.tell_parameters(&changed),
            Err(refusal) => {
                let error = match &refusal {
                    Refusal::Unknown(_) => MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST,
                    Refusal::WrongType { .. } => MavParamError::MAV_PARAM_ERROR_TYPE_MISMATCH,
                    Refusal::OutOfRange { .. } => MavParamError::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
                    Refusal::ReadOnly { .. } => MavParamError::MAV_PARAM_ERROR_READ_ONLY,
                };
                self.refuse_parameter(peer, &name, refusal.to_string(), error);
            }
        }
    }

    fn refuse_type(&mut self, peer: Peer, name: &str, kind: u8) {
        let error = if self.parameters.index_of(name).is_none() {
            MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST
        } else if (1..=TYPE_LAST).contains(&kind) {
            MavParamError::MAV_PARAM_ERROR_TYPE_MISMATCH
        } else {
            MavParamError::MAV_PARAM_ERROR_TYPE_UNSUPPORTED
        };
        let text = format!("{name} refused: type {kind}, only 6 (INT32) and 9 (REAL32) are known");
        self.refuse_parameter(peer, name, text, error);
    }

    fn refuse_parameter(&mut self, peer: Peer, name: &str, text: String, error: MavParamError) {
        self.autopilot.say(Severity::Error, text);
        if let Some(index) = self.parameters.index_of(name) {
            self.send_parameter(peer, index);
        }
        self.send_param_error(peer, name, -1, error);
    }

    fn send_param_error(&mut self, peer: Peer, name: &str, param_index: i16, error: MavParamError) {
        let message = PARAM_ERROR_DATA {
            param_index,
            target_system: peer.system,
            target_component: peer.component,
            param_id: name.into(),
            error,
        };
        self.reply(peer, &MavMessage::PARAM_ERROR(message));
    }

    /// Values that have changed, to everybody.
    fn tell_parameters(&mut self, changed: &[usize]) {
        for &index in changed {
            if let Some((name, value)) = self.parameters.at(index).map(|e| (e.name.clone(), e.value)) {
                self.log_parameter(&name, value);
            }
            if let Some(message) = self.parameter_message(index) {
                self.send(Link::GroundStation, &message);
                self.send(Link::Api, &message);
            }
        }
    }

    /// The values as a file for `--params`; for the caller to keep when one is asked for by PREFLIGHT_STORAGE.
    pub(super) fn parameter_file(&self) -> String {
        let notes = [
            format!("{}: {}", Purpose::KEY, Purpose::Samara.name()),
            Purpose::Samara.words().to_owned(),
            format!("{GRAVITY_KEY}: {} m/s^2", self.environment.gravity_m_s2),
        ];
        let version = concat!("samara ", env!("CARGO_PKG_VERSION"));
        file::write(version, &notes, &self.parameters.values())
    }

    /// PREFLIGHT_STORAGE 2: the values of the start.
    pub(super) fn reset_parameters(&mut self) {
        let changed = self.parameters.reset(&mut self.autopilot);
        self.tell_parameters(&changed);
    }
}
