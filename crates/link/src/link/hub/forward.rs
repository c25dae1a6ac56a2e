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

/// What a companion streams for an autopilot to fly.
const SETPOINTS: [u32; 3] = [
    SET_POSITION_TARGET_LOCAL_NED_DATA::ID,
    SET_POSITION_TARGET_GLOBAL_INT_DATA::ID,
    SET_ATTITUDE_TARGET_DATA::ID,
];

/// Whether we, system and component `own`, are among those whom a frame is for.
pub(super) fn includes(target: (u8, u8), own: (u8, u8)) -> bool {
    target.0 == 0 || target == own || target == (own.0, 0)
}

/// Whether a peer by whom `heard` (systems and components) have spoken gets a frame: one for everybody, for a
/// component among them that is not us, or for any component of a system among them.
pub(super) fn reaches(target: (u8, u8), own: (u8, u8), mut heard: impl Iterator<Item = (u8, u8)>) -> bool {
    match target {
        (0, _) => heard.next().is_some(),
        (system, component) => {
            target != own && heard.any(|(s, c)| s == system && (component == 0 || c == component))
        }
    }
}

/// Whether a message may leave its link.
pub(super) fn may_leave(message_id: u32) -> bool {
    !STAYS.contains(&message_id)
}

/// Whether a message is a setpoint of a companion's stream.
pub(super) fn is_setpoint(message_id: u32) -> bool {
    SETPOINTS.contains(&message_id)
}
