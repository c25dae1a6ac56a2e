//! The parameter protocol: listed, read, set, checked for change by `_HASH_CHECK`, saved.
//!
//! As PX4 does it: integers travel as their bytes; a list begins with the checksum, by which a ground station
//! that knows all values stops it (PARAM_SET `_HASH_CHECK`), and goes out a few values at a time. Better than
//! PX4: a refusal comes with its reason (STATUSTEXT, PARAM_ERROR) and the value in effect; an accepted change
//! goes out on both links, and so do the parameters that follow from it.

use std::collections::VecDeque;

use mavlink::MessageData as _;
use mavlink::dialects::common::*;
use num_traits::FromPrimitive as _;

use super::command_result::CommandResult;
use super::outbox::{LINKS, Outbox, Peer};
use crate::autopilot::flight_log::LogEntry;
use crate::autopilot::parameters::{Parameters, Refusal, legible};
use crate::autopilot::{Autopilot, Severity};
use crate::link::frame::{Command, Frame};
use crate::link::wire::param_value;
use crate::params::purpose::GRAVITY_KEY;
use crate::params::{Purpose, Value, file};

/// PX4's name for the checksum.
const HASH: &str = "_HASH_CHECK";
/// Values of a list that go out at a time.
const AT_A_TIME: usize = 5;
/// Index of what is no parameter.
const NO_INDEX: u16 = u16::MAX;
/// Most lists that go out on a link at the same time.
const MAX_LISTS: usize = 32;

/// A request of the parameter protocol, whatever type a value is said to have.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Request {
    List,
    /// By index or, where that is negative, by name.
    Read {
        index: i16,
        name: String,
    },
    Set {
        name: String,
        kind: u8,
        bits: u32,
    },
}

impl Request {
    /// The request in a frame, with the system and component that it is addressed to; `None` for any other
    /// message.
    pub(super) fn read(frame: &Frame) -> Option<((u8, u8), Self)> {
        let p = frame.payload();
        let at = |i: usize| (p.u8(i), p.u8(i + 1));
        Some(match frame.message_id {
            PARAM_REQUEST_LIST_DATA::ID => (at(0), Self::List),
            PARAM_REQUEST_READ_DATA::ID => {
                (at(2), Self::Read { index: p.u16(0) as i16, name: p.text::<16>(4) })
            }
            PARAM_SET_DATA::ID => {
                (at(4), Self::Set { name: p.text::<16>(6), kind: p.u8(22), bits: p.u32(0) })
            }
            _ => return None,
        })
    }
}

/// What comes next of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    Hash,
    Index(usize),
}

/// The parameters, and the lists of them that go out, each to the peer that asked for it. On each link they
/// take turns.
#[derive(Clone, Debug)]
pub(super) struct ParameterServer {
    pub parameters: Parameters,
    lists: VecDeque<(Peer, Next)>,
    /// Whether somebody keeps the file that PREFLIGHT_STORAGE asks for.
    keeps_file: bool,
    /// The text of a parameter file that a ground station wants kept.
    pub saved: Option<String>,
}

impl ParameterServer {
    /// A server of parameters that nobody has asked for yet.
    pub(super) fn new(parameters: Parameters, keeps_file: bool) -> Self {
        Self { parameters, lists: VecDeque::new(), keeps_file, saved: None }
    }

    /// Takes a request of a peer; the index of the parameter that has another value by it.
    pub(super) fn handle(
        &mut self,
        peer: Peer,
        request: Request,
        autopilot: &mut Autopilot,
        outbox: &mut Outbox,
    ) -> Option<usize> {
        match request {
            Request::List => self.begin_list(peer),
            Request::Read { index, name } => self.answer_read(peer, index, &name, outbox),
            // The ground station knows all values.
            Request::Set { name, .. } if name == HASH => {
                self.lists.retain(|(p, _)| (p.link, p.id) != (peer.link, peer.id));
            }
            Request::Set { name, kind, bits } => {
                return self.set(peer, &name, (kind, bits), autopilot, outbox);
            }
        }
        None
    }

    /// One list at a time for a peer; asked for again, it starts over, without the checksum.
    fn begin_list(&mut self, peer: Peer) {
        if let Some((_, next)) = self.lists.iter_mut().find(|(p, _)| (p.link, p.id) == (peer.link, peer.id)) {
            *next = Next::Index(0);
        } else if self.lists.iter().filter(|(p, _)| p.link == peer.link).count() < MAX_LISTS {
            self.lists.push_back((peer, Next::Hash));
        }
    }

    /// Sends the next few values of the lists that are under way.
    pub(super) fn list_on(&mut self, outbox: &mut Outbox) {
        for link in LINKS {
            let first = self.lists.iter().position(|(peer, _)| peer.link == link);
            let Some((peer, mut next)) = first.and_then(|i| self.lists.remove(i)) else { continue };
            for _ in 0..AT_A_TIME {
                next = match next {
                    Next::Hash => {
                        outbox.reply(peer, &self.hash_message());
                        Next::Index(0)
                    }
                    Next::Index(index) => {
                        self.send_value(peer, index, outbox);
                        Next::Index(index + 1)
                    }
                };
            }
            if matches!(next, Next::Index(index) if index < self.parameters.len()) {
                self.lists.push_back((peer, next));
            }
        }
    }

    fn answer_read(&mut self, peer: Peer, asked: i16, name: &str, outbox: &mut Outbox) {
        let index = match usize::try_from(asked) {
            Ok(index) => Some(index).filter(|&i| i < self.parameters.len()),
            Err(_) if name == HASH => return outbox.reply(peer, &self.hash_message()),
            Err(_) => self.parameters.index_of(name),
        };
        match index {
            Some(index) => self.send_value(peer, index, outbox),
            None => {
                let error = MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST;
                outbox.reply(peer, &param_error(peer, name, asked, error));
            }
        }
    }

    fn set(
        &mut self,
        peer: Peer,
        name: &str,
        (kind, bits): (u8, u32),
        autopilot: &mut Autopilot,
        outbox: &mut Outbox,
    ) -> Option<usize> {
        let value = match MavParamType::from_u8(kind) {
            Some(MavParamType::MAV_PARAM_TYPE_INT32) => Ok(Value::Int(bits as i32)),
            Some(MavParamType::MAV_PARAM_TYPE_REAL32) => Ok(Value::Real(f32::from_bits(bits))),
            _ if self.parameters.index_of(name).is_none() => {
                Err(MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST)
            }
            Some(_) => Err(MavParamError::MAV_PARAM_ERROR_TYPE_MISMATCH),
            None => Err(MavParamError::MAV_PARAM_ERROR_TYPE_UNSUPPORTED),
        };
        let value_of = |parameters: &Parameters| parameters.at(parameters.index_of(name)?).map(|e| e.value);
        let before = value_of(&self.parameters);
        let (reason, error) = match value.map(|value| self.parameters.set(name, value, autopilot)) {
            Ok(Ok(changed)) => {
                self.publish(&changed, outbox);
                return changed.first().copied().filter(|_| value_of(&self.parameters) != before);
            }
            Ok(Err(refusal)) => (refusal.to_string(), error_of(&refusal)),
            Err(error) => {
                let known = "only 6 (INT32) and 9 (REAL32) are known";
                let name = legible(name);
                (format!("{name} refused: type {kind}, {known}"), error)
            }
        };
        autopilot.say(Severity::Error, reason);
        if let Some(index) = self.parameters.index_of(name) {
            self.send_value(peer, index, outbox);
        }
        outbox.reply(peer, &param_error(peer, name, -1, error));
        None
    }

    /// PREFLIGHT_STORAGE, parameter 1: 1 keep the parameters, 2 back to those of the start. Not in flight, as
    /// in PX4.
    pub(super) fn store(
        &mut self,
        command: &Command,
        gravity_m_s2: f64,
        autopilot: &mut Autopilot,
        outbox: &mut Outbox,
    ) -> CommandResult {
        if autopilot.is_armed() {
            let reason = "parameters are stored and reset only while disarmed";
            return CommandResult::TemporarilyRejected.because(autopilot, reason);
        }
        match command.param(1) {
            Some(1.0) if self.keeps_file => self.saved = Some(self.file_text(gravity_m_s2)),
            Some(1.0) => {
                let reason = "parameters are not stored: there is no folder for results";
                return CommandResult::Denied.because(autopilot, reason);
            }
            Some(2.0) => {
                let changed = self.parameters.reset(autopilot);
                self.publish(&changed, outbox);
            }
            _ => return CommandResult::Unsupported,
        }
        CommandResult::Accepted
    }

    /// The values as a file for `--params`.
    fn file_text(&self, gravity_m_s2: f64) -> String {
        let notes = [
            format!("{}: {}", Purpose::KEY, Purpose::Samara.name()),
            Purpose::Samara.words().to_owned(),
            format!("{GRAVITY_KEY}: {gravity_m_s2} m/s^2"),
        ];
        let version = concat!("samara ", env!("CARGO_PKG_VERSION"));
        file::write(version, &notes, &self.parameters.values())
    }

    /// Logs values that have changed, and sends them to everybody.
    fn publish(&self, changed: &[usize], outbox: &mut Outbox) {
        for &index in changed {
            if let Some(entry) = self.parameters.at(index) {
                outbox.log.push(LogEntry::Parameter(entry.name.clone(), entry.value));
            }
            if let Some(message) = self.value_message(index) {
                outbox.broadcast(&message);
            }
        }
    }

    fn send_value(&self, peer: Peer, index: usize, outbox: &mut Outbox) {
        if let Some(message) = self.value_message(index) {
            outbox.reply(peer, &message);
        }
    }

    fn value_message(&self, index: usize) -> Option<MavMessage> {
        let entry = self.parameters.at(index)?;
        Some(self.message(&entry.name, index as u16, param_value(entry.value)))
    }

    fn hash_message(&self) -> MavMessage {
        let hash = f32::from_bits(self.parameters.hash());
        self.message(HASH, NO_INDEX, (hash, MavParamType::MAV_PARAM_TYPE_UINT32))
    }

    fn message(&self, name: &str, param_index: u16, value: (f32, MavParamType)) -> MavMessage {
        let ((param_value, param_type), param_id) = (value, name.into());
        let param_count = self.parameters.len() as u16;
        let data = PARAM_VALUE_DATA { param_value, param_count, param_index, param_id, param_type };
        MavMessage::PARAM_VALUE(data)
    }
}

fn error_of(refusal: &Refusal) -> MavParamError {
    match refusal {
        Refusal::Unknown(_) => MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST,
        Refusal::WrongType { .. } => MavParamError::MAV_PARAM_ERROR_TYPE_MISMATCH,
        Refusal::OutOfRange { .. } => MavParamError::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
        Refusal::ReadOnly { .. } => MavParamError::MAV_PARAM_ERROR_READ_ONLY,
    }
}

fn param_error(peer: Peer, name: &str, param_index: i16, error: MavParamError) -> MavMessage {
    let (target_system, target_component, param_id) = (peer.system, peer.component, name.into());
    let data = PARAM_ERROR_DATA { param_index, target_system, target_component, param_id, error };
    MavMessage::PARAM_ERROR(data)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{ControlLimits, Gains};
    use crate::link::{Link, PeerId};
    use crate::params::Subject;
    use crate::test_site;

    /// Peers are renewed for nothing: a list that nobody hears has no end of its own.
    #[test]
    fn more_lists_than_there_is_room_for_are_not_begun() {
        let subject = Subject {
            vehicle: &test_site::vehicle(),
            environment: &test_site::environment(),
            gains: &Gains::longitudinal([8.0, 2.0, 4.0, 3.0, 1.0, 1.5, 0.2]),
            limits: &ControlLimits::default(),
            speed_m_s: 9.0,
            tilt_from: None,
            pack: None,
        };
        let mut server = ParameterServer::new(Parameters::of(&subject, 1).unwrap(), false);
        for link in [Link::GroundStation, Link::Api] {
            for id in 0..3 * MAX_LISTS as u32 {
                server.begin_list(Peer { link, id: PeerId(id), system: 66, component: 190 });
            }
        }
        assert_eq!(server.lists.len(), 2 * MAX_LISTS);
    }
}
