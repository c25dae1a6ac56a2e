//! What is remembered of a flight besides its log: what happened when, in simulated time, and whether a failsafe flew.

use super::super::TimeUs;
use super::{SimulatorEvent, SimulatorSession};
use crate::sim::Phase;

/// Something that happened in a flight.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlightEvent {
    /// Simulated time.
    pub at: TimeUs,
    /// What.
    pub text: String,
}

/// A flight in words: the same for the same flight, however long one had to wait for its parties.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FlightRecord {
    /// What happened, in its order: arming, release, rotors free, failsafes.
    pub events: Vec<FlightEvent>,
    /// Whether the autopilot was in a failsafe, armed, at any time after the release: then it was not the plan that was flown.
    pub failsafe: bool,
}

impl SimulatorSession {
    /// What is remembered of the flight.
    pub fn record(&self) -> &FlightRecord {
        &self.record
    }

    /// Tells an event, and remembers it if it belongs to the flight.
    pub(super) fn tell(&mut self, event: SimulatorEvent) {
        if let Some((at, text)) = event.of_flight() {
            self.record.events.push(FlightEvent { at, text });
        }
        self.events.push_back(event);
    }

    /// The failsafe as the autopilot's HEARTBEAT shows it.
    pub(super) fn set_failsafe(&mut self, active: bool) {
        if active != self.peer.failsafe {
            self.peer.failsafe = active;
            self.tell(SimulatorEvent::Failsafe { at: self.now, active });
        }
        self.record.failsafe |= active && self.sim.phase() != Phase::Hanging;
    }
}
