//! What others command the armed vehicle to do otherwise than by setpoints, as the simulator is told: whose
//! command ended a drop then stands in its verdict.
//!
//! Told by STATUSTEXT on the simulator's link alone, behind [`COMMANDED`]: modes other than OFFBOARD,
//! disarming, parameters, sticks that are lost. A link on which nobody does any of this stays as PX4's is.

use mavlink::dialects::common::MavMessage;

use super::AutopilotSession;
use super::outbox::Peer;
use crate::autopilot::{Autopilot, FlightMode};
use crate::link::Link;

/// What such a text begins with.
pub const COMMANDED: &str = "commanded: ";

/// What a command may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Standing {
    armed: bool,
    mode: FlightMode,
}

impl Standing {
    pub(super) fn of(autopilot: &Autopilot) -> Self {
        Self { armed: autopilot.is_armed(), mode: autopilot.mode() }
    }

    /// What has been commanded since, in words, if it was armed.
    fn changed_to(self, now: Self) -> Option<String> {
        match now {
            _ if !self.armed => None,
            Self { armed: false, .. } => Some("disarmed".to_owned()),
            Self { mode, .. } if mode != self.mode && mode != FlightMode::Offboard => {
                Some(format!("mode {}", mode.name()))
            }
            _ => None,
        }
    }
}

impl AutopilotSession {
    /// Tells the simulator what a frame of a peer has changed of an autopilot that stood so.
    pub(super) fn tell_change(&mut self, before: Standing, peer: Peer) {
        if peer.link != Link::Simulator
            && let Some(what) = before.changed_to(Standing::of(&self.vehicle.autopilot))
        {
            self.tell_simulator(&format!("{what} by {}", who(peer)));
        }
    }

    /// Tells the simulator that a peer has set the parameter of an index, if the vehicle is armed.
    pub(super) fn tell_parameter(&mut self, index: usize, peer: Peer) {
        if self.vehicle.autopilot.is_armed()
            && let Some(entry) = self.parameters.parameters.at(index)
        {
            let what = format!("parameter {} set to {} by {}", entry.name, entry.value, who(peer));
            self.tell_simulator(&what);
        }
    }

    /// Tells the simulator whose sticks are lost, if the vehicle is armed.
    pub(super) fn tell_lost_sticks(&mut self) {
        if let Some(peer) = self.pilot.filter(|_| self.vehicle.autopilot.is_armed()) {
            self.tell_simulator(&format!("manual control lost: sticks of {}", who(peer)));
        }
    }

    fn tell_simulator(&mut self, what: &str) {
        for text in self.outbox.notices(&format!("{COMMANDED}{what}")) {
            self.outbox.send(Link::Simulator, &MavMessage::STATUSTEXT(text));
        }
    }
}

fn who(peer: Peer) -> String {
    format!("system {}, component {}", peer.system, peer.component)
}
