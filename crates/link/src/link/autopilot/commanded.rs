//! What others command the armed vehicle to do otherwise than by setpoints, as the simulator is told: whose
//! command ended a drop then stands in its verdict.
//!
//! Told by STATUSTEXT on the simulator's link alone, behind [`COMMANDED`]: modes other than OFFBOARD,
//! disarming, parameters, sticks that are lost. A link on which nobody does any of this stays as PX4's is.

use mavlink::dialects::common::MavMessage;

use super::outbox::{Outbox, Peer};
use crate::autopilot::{Autopilot, FlightMode};
use crate::link::Link;

/// What such a text begins with.
pub const COMMANDED: &str = "commanded: ";
/// What the words of a parameter begin with ([`crate::sim::PARAMETER`]).
pub(super) const PARAMETER: &str = crate::sim::PARAMETER;

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
    pub(super) fn changed_to(self, now: Self) -> Option<String> {
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

/// Tells the simulator what is a peer's doing: words that lead up to who it is.
pub(super) fn tell(outbox: &mut Outbox, what: &str, peer: Peer) {
    let text = format!("{COMMANDED}{what} system {}, component {}", peer.system, peer.component);
    for message in outbox.notices(&text) {
        outbox.send(Link::Simulator, &MavMessage::STATUSTEXT(message));
    }
}
