//! A command that wants an answer: sent, answered or sent again, given up.

use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd, MavResult};
use num_traits::FromPrimitive as _;

use super::patience::{Sent, Wire};
use crate::link::frame::CommandAck;
use crate::params::file::AUTOPILOT_COMPONENT;
use crate::time::TimeUs;

/// An unanswered or refused command is repeated after this simulated time. A refusal is reported only then,
/// so that the STATUSTEXT that explains it, which may come after it, is reported with it.
const RETRY_US: TimeUs = 1_000_000;

const ACCEPTED: u8 = MavResult::MAV_RESULT_ACCEPTED as u8;
const UNSUPPORTED: u8 = MavResult::MAV_RESULT_UNSUPPORTED as u8;
const IN_PROGRESS: u8 = MavResult::MAV_RESULT_IN_PROGRESS as u8;

/// One command on its way.
#[derive(Clone, Debug)]
pub(super) struct Request {
    message: COMMAND_LONG_DATA,
    what: &'static str,
    by: &'static str,
    attempts_left: u32,
    retry_us: TimeUs,
    sent: Option<Sent>,
    result: Option<u8>,
}

/// A command that was refused or not answered.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Failure {
    /// The command, in words.
    pub what: &'static str,
    /// The component that was to answer, in words.
    pub by: &'static str,
    /// When it was last sent.
    pub sent_at: TimeUs,
    /// The name of the refusal.
    pub result: Option<String>,
}

/// What is to be done about a request.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum RequestStep {
    /// Wait.
    Pending,
    /// Send this.
    Send(COMMAND_LONG_DATA),
    /// It has been accepted.
    Accepted,
    /// It has failed, and is worth another try.
    Again(Failure),
    /// It has failed, and is not to be tried again.
    GaveUp(Failure),
}

impl Request {
    pub(super) fn new(
        message: COMMAND_LONG_DATA,
        what: &'static str,
        by: &'static str,
        attempts: u32,
    ) -> Self {
        Self { message, what, by, attempts_left: attempts, retry_us: RETRY_US, sent: None, result: None }
    }

    /// This request repeated five times as often: there is no time to wait for what explains a refusal.
    pub(super) fn hurried(self) -> Self {
        Self { retry_us: self.retry_us / 5, attempts_left: self.attempts_left.saturating_mul(5), ..self }
    }

    /// Whether it was sent and may still be answered.
    pub(super) fn is_under_way(&self, now: TimeUs, wire: &Wire) -> bool {
        self.result.is_none() && self.sent.is_some_and(|sent| !wire.has_waited(sent, now, self.retry_us))
    }

    /// A command to the autopilot of a system.
    pub(super) fn to_autopilot(
        system_id: u8,
        command: MavCmd,
        params: [f32; 3],
        what: &'static str,
        attempts: u32,
    ) -> Self {
        let message = COMMAND_LONG_DATA {
            command,
            param1: params[0],
            param2: params[1],
            param3: params[2],
            target_system: system_id,
            target_component: AUTOPILOT_COMPONENT,
            ..COMMAND_LONG_DATA::default()
        };
        Self::new(message, what, "autopilot", attempts)
    }

    /// Takes an acknowledgement that came from `from`, if it is one for this request and for `us`.
    pub(super) fn take_ack(&mut self, ack: &CommandAck, from: (u8, u8), us: (u8, u8)) {
        let m = &self.message;
        // An old autopilot leaves the target empty.
        let for_us = [(0, 0), us].contains(&(ack.target_system, ack.target_component));
        if for_us && from == (m.target_system, m.target_component) && ack.command == m.command as u16 {
            self.result = (ack.result != IN_PROGRESS).then_some(ack.result);
        }
    }

    /// When it was last sent.
    pub(super) fn sent_at(&self) -> Option<TimeUs> {
        self.sent.map(|sent| sent.at)
    }

    /// What is to be done about it at `now`.
    pub(super) fn poll(&mut self, now: TimeUs, wire: &Wire) -> RequestStep {
        if self.result == Some(ACCEPTED) {
            return RequestStep::Accepted;
        }
        let Some(sent) = self.sent else {
            self.sent = Some(wire.send(now));
            self.attempts_left = self.attempts_left.saturating_sub(1);
            return RequestStep::Send(self.message.clone());
        };
        // A refusal waits for what explains it, in simulated time alone.
        let waited = match self.result {
            Some(_) => now >= sent.at + self.retry_us,
            None => wire.has_waited(sent, now, self.retry_us),
        };
        if !waited {
            return RequestStep::Pending;
        }
        let result = self.result.take();
        let (what, by, sent_at) = (self.what, self.by, sent.at);
        let failure = Failure { what, by, sent_at, result: result.map(result_name) };
        if self.attempts_left == 0 || result == Some(UNSUPPORTED) {
            return RequestStep::GaveUp(failure);
        }
        self.sent = None;
        self.message.confirmation = self.message.confirmation.wrapping_add(1);
        RequestStep::Again(failure)
    }
}

/// The name of a `MAV_RESULT`.
fn result_name(result: u8) -> String {
    MavResult::from_u8(result).map_or_else(
        || format!("result {result}"),
        |known| format!("{known:?}").trim_start_matches("MAV_RESULT_").to_owned(),
    )
}
