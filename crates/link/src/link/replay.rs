//! A drop flown again from its recorded actuators, without an autopilot.
//!
//! The simulator of the mission is given what reached it in the flight, at the simulated times at which it
//! did: from `hil.tlog` what the autopilot sent, from `companion.tlog` what came to the parachute's socket,
//! the release command with it. What the simulator says on the HIL link is held against what is recorded
//! there: equal messages show that mission and program are those that flew.
//!
//! Setpoints went on another link and decide nothing here: the log of a replay holds none. A simulator that
//! was released from outside the wire, and a flight of which the companion's frames were not recorded, are
//! flown as far as the record goes; the difference says where that is.

use std::collections::VecDeque;

use super::hil::{HilSession, Pace, SIMULATOR_COMPONENT};
use super::session::{Link, Session};
use super::tlog::TlogRecord;
use crate::sim::DropRun;
use crate::time::{TimeUs, seconds};

/// A recording that cannot be flown again.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReplayError {
    /// The recording has no HIL_ACTUATOR_CONTROLS.
    #[error("no HIL_ACTUATOR_CONTROLS in the recording: it is not one of a simulator's link")]
    NoActuators,
    /// The recording goes on, but lacks an answer that the simulator needs.
    #[error(
        "no HIL_ACTUATOR_CONTROLS of {:.3} s in the recording, which goes on with record {next}",
        seconds(*at)
    )]
    Unanswered {
        /// Simulated time of the step that was not answered.
        at: TimeUs,
        /// Number of the next record, from 1.
        next: usize,
    },
}

/// The first message of the simulator that is not as recorded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "at {:.3} s: message {} was recorded{}, and {} replayed",
    seconds(*at),
    name(*recorded),
    record.map_or(String::new(), |number| format!(" (record {number})")),
    if recorded == replayed { "another of that kind".to_owned() } else { name(*replayed) }
)]
pub struct Difference {
    /// Simulated time: that of the record, or that of the message where there is no record.
    pub at: TimeUs,
    /// Number of the record, from 1; `None` where the recording has ended.
    pub record: Option<usize>,
    /// MAVLink id of the recorded message, `None` where the recording has ended.
    pub recorded: Option<u32>,
    /// MAVLink id of the message that the replay sent, `None` where it had ended.
    pub replayed: Option<u32>,
}

/// A message's number, if there is a message.
fn name(id: Option<u32>) -> String {
    id.map_or_else(|| "none".to_owned(), |id| id.to_string())
}

/// A drop that was flown again.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// The drop, with its log and record.
    pub run: DropRun,
    /// Messages of the simulator that are as recorded, before the first that is not.
    pub equal_messages: usize,
    /// The first message that is not.
    pub difference: Option<Difference>,
}

/// A message of the simulator: when, which record, id and payload.
struct Said {
    at: TimeUs,
    record: Option<usize>,
    id: u32,
    payload: Vec<u8>,
}

/// Flies the drop of a fresh `simulator`, which waits for no companion, from what was recorded of its link
/// (`hil`) and of the parachute's (`companion`, empty where nothing came there), both in order of time.
///
/// # Errors
/// [`ReplayError`] for a recording without actuators, or with a gap in them.
pub fn replay(
    mut simulator: HilSession,
    hil: &[TlogRecord],
    companion: &[TlogRecord],
) -> Result<Replayed, ReplayError> {
    use mavlink::dialects::common::MavMessage::{HEARTBEAT, HIL_ACTUATOR_CONTROLS};
    /// MAV_COMP_ID_AUTOPILOT1.
    const AUTOPILOT: u8 = 1;
    if !hil.iter().any(|r| matches!(r.frame.known(), Some(HIL_ACTUATOR_CONTROLS(_)))) {
        return Err(ReplayError::NoActuators);
    }
    let system_id = simulator.config().system_id;
    let of_simulator = |record: &TlogRecord| {
        (record.frame.system_id, record.frame.component_id) == (system_id, SIMULATOR_COMPONENT)
    };
    let (said, heard): (Vec<&TlogRecord>, Vec<&TlogRecord>) = hil.iter().partition(|r| of_simulator(r));
    let mut comparison = Comparison::of(&said);
    let mut heard = heard.into_iter().peekable();
    // What the vehicle itself says to companions did not come to the parachute, but for the HEARTBEAT of an
    // autopilot that sends none to its simulator (PX4): the host passes that on.
    let is_beat = |r: &TlogRecord| matches!(r.frame.known(), Some(HEARTBEAT(_)));
    let passed_on = !hil.iter().any(|r| !of_simulator(r) && is_beat(r));
    let is_autopilots_beat =
        |r: &TlogRecord| is_beat(r) && r.frame.system_id == system_id && r.frame.component_id == AUTOPILOT;
    let mut outside = companion
        .iter()
        .filter(|r| r.frame.system_id != system_id || (passed_on && is_autopilots_beat(r)))
        .peekable();
    simulator.peer_connected();
    loop {
        let now = simulator.now();
        while let Some(record) = heard.next_if(|r| r.at <= now) {
            simulator.handle_input(Link::Simulator, &record.frame);
        }
        while let Some(record) = outside.next_if(|r| r.at <= now) {
            simulator.handle_input(Link::Parachute, &record.frame);
        }
        comparison.take(&mut simulator);
        match simulator.next_wake() {
            Some(next) => simulator.handle_time(next),
            None if simulator.pace() == Pace::Done => break,
            None => match heard.peek() {
                Some(record) => return Err(ReplayError::Unanswered { at: now, next: record.number }),
                // The flight was stopped here.
                None => break,
            },
        }
    }
    let (equal_messages, difference) = comparison.finish();
    Ok(Replayed { run: simulator.into_run(), equal_messages, difference })
}

/// The messages of the simulator, recorded and sent again.
struct Comparison {
    recorded: VecDeque<Said>,
    equal: usize,
    difference: Option<Difference>,
}

impl Comparison {
    fn of(recorded: &[&TlogRecord]) -> Self {
        let said = |r: &&TlogRecord| Said {
            at: r.at,
            record: Some(r.number),
            id: r.frame.message_id,
            payload: r.frame.payload().as_slice().to_vec(),
        };
        Self { recorded: recorded.iter().map(said).collect(), equal: 0, difference: None }
    }

    /// Takes what the simulator sends. Numbers of frames and signatures are the host's: messages count.
    fn take(&mut self, simulator: &mut HilSession) {
        let at = simulator.now();
        while let Some(sent) = simulator.poll_output() {
            if sent.link != Link::Simulator {
                continue;
            }
            super::decoder::Decoder::new().datagram(&sent.bytes, |frame| {
                let payload = frame.payload().as_slice().to_vec();
                self.hold(&Said { at, record: None, id: frame.message_id, payload });
            });
        }
    }

    fn hold(&mut self, sent: &Said) {
        if self.difference.is_some() {
            return;
        }
        match self.recorded.pop_front() {
            Some(recorded) if (recorded.id, &recorded.payload) == (sent.id, &sent.payload) => self.equal += 1,
            recorded => {
                self.difference = Some(Difference {
                    at: recorded.as_ref().map_or(sent.at, |r| r.at),
                    record: recorded.as_ref().and_then(|r| r.record),
                    recorded: recorded.map(|r| r.id),
                    replayed: Some(sent.id),
                });
            }
        }
    }

    /// How many were equal, and the first that was not; what is left of the recording was not sent again.
    fn finish(self) -> (usize, Option<Difference>) {
        let left = self.recorded.front().map(|r| Difference {
            at: r.at,
            record: r.record,
            recorded: Some(r.id),
            replayed: None,
        });
        (self.equal, self.difference.or(left))
    }
}
