//! What one peer says and others should hear, by PX4's rules (`Mavlink::forward_message`).
//!
//! A frame for a component goes to the peers by whom that component was heard; a frame for everybody goes to
//! all peers that have spoken. What is for us alone is not passed on, nothing goes back to where it came
//! from, nor to a peer by whom its sender is heard as well (two ways to the same network would make a loop).
//! Frames pass unchanged, sequence number and signature included.
//!
//! Differs from PX4: there a link has one peer, here each peer counts as a link.

use mavlink::MessageData as _;
use mavlink::dialects::common::*;

use super::super::frame::Frame;

/// Messages that never leave the link they came by: those of a simulator, of the link itself, and secrets.
#[expect(deprecated, reason = "HIL_STATE is, and is still a simulator's message")]
const STAYS: [u32; 11] = [
    AUTH_KEY_DATA::ID,
    HIL_STATE_DATA::ID,
    HIL_CONTROLS_DATA::ID,
    HIL_RC_INPUTS_RAW_DATA::ID,
    HIL_ACTUATOR_CONTROLS_DATA::ID,
    HIL_SENSOR_DATA::ID,
    RADIO_STATUS_DATA::ID,
    HIL_GPS_DATA::ID,
    HIL_OPTICAL_FLOW_DATA::ID,
    HIL_STATE_QUATERNION_DATA::ID,
    SETUP_SIGNING_DATA::ID,
];

/// Whom a frame is for, as its target fields say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// Us and nobody else.
    Us,
    /// Everybody.
    Everybody,
    /// A system, and if it is not 0, one component of it; our own system's other components among them.
    Others { system: u8, component: u8 },
}

impl Target {
    /// Of a frame, where `own` is our system and component.
    pub(super) fn of(frame: &Frame, own: (u8, u8)) -> Self {
        match frame.target() {
            (0, _) => Self::Everybody,
            target if target == own => Self::Us,
            (system, component) => Self::Others { system, component },
        }
    }

    /// Whether we are among those meant.
    pub(super) fn includes(self, own: (u8, u8)) -> bool {
        match self {
            Self::Us | Self::Everybody => true,
            Self::Others { system, component } => system == own.0 && component == 0,
        }
    }

    /// Whether a peer by whom `heard` (systems and components) have spoken gets the frame.
    pub(super) fn reaches(self, heard: impl IntoIterator<Item = (u8, u8)>) -> bool {
        let mut heard = heard.into_iter();
        match self {
            Self::Us => false,
            Self::Everybody => heard.next().is_some(),
            Self::Others { system, component } => {
                heard.any(|(s, c)| s == system && (component == 0 || c == component))
            }
        }
    }
}

/// Whether a message may leave its link.
pub(super) fn may_leave(message_id: u32) -> bool {
    !STAYS.contains(&message_id)
}
