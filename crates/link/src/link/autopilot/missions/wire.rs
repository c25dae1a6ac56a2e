//! The messages of the mission protocol by wire offset: an item with a command or a plan of a type that no
//! enum knows is owed an answer too.
#![expect(deprecated, reason = "deprecated in MAVLink, still sent by ground stations")]

use mavlink::MessageData as _;
use mavlink::dialects::common::*;

use super::super::outbox::Peer;
use crate::autopilot::missions::{Item, ItemFault, ItemFrame};
use crate::link::frame::Frame;

/// The answer to an upload with this fault.
impl From<ItemFault> for MavMissionResult {
    fn from(fault: ItemFault) -> Self {
        match fault {
            ItemFault::Command => Self::MAV_MISSION_UNSUPPORTED,
            ItemFault::Frame => Self::MAV_MISSION_UNSUPPORTED_FRAME,
            ItemFault::Size => Self::MAV_MISSION_INVALID_PARAM1,
            ItemFault::Latitude => Self::MAV_MISSION_INVALID_PARAM5_X,
            ItemFault::Longitude => Self::MAV_MISSION_INVALID_PARAM6_Y,
            ItemFault::Altitude => Self::MAV_MISSION_INVALID_PARAM7,
        }
    }
}

/// A ground station's request. `kind` is a `MAV_MISSION_TYPE`, whatever its number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Request {
    List { kind: u8 },
    Item { kind: u8, seq: u16, int: bool },
    Count { kind: u8, count: u16 },
    Upload { kind: u8, seq: u16, int: bool, item: Item },
    Ack { kind: u8, result: u8 },
    Clear { kind: u8 },
    SetCurrent { seq: u16 },
    Partial { kind: u8 },
}

impl Request {
    /// The request in a frame, with the system and component that it is addressed to; `None` for any other
    /// message.
    pub(crate) fn read(frame: &Frame) -> Option<((u8, u8), Self)> {
        let p = frame.payload();
        let at = |i: usize| (p.u8(i), p.u8(i + 1));
        Some(match frame.message_id {
            MISSION_ITEM_DATA::ID | MISSION_ITEM_INT_DATA::ID => {
                let int = frame.message_id == MISSION_ITEM_INT_DATA::ID;
                let item_frame = ItemFrame(p.u8(34));
                let per_unit = if item_frame.is_global() { 1e7 } else { 1.0 };
                let place = |i: usize| if int { f64::from(p.i32(i)) } else { f64::from(p.f32(i)) * per_unit };
                let item = Item {
                    params: std::array::from_fn(|i| p.f32(4 * i)),
                    x: place(16),
                    y: place(20),
                    z: p.f32(24),
                    command: p.u16(30),
                    frame: item_frame,
                    current: p.u8(35),
                    autocontinue: p.u8(36),
                };
                (at(32), Self::Upload { kind: p.u8(37), seq: p.u16(28), int, item })
            }
            MISSION_REQUEST_DATA::ID => (at(2), Self::Item { kind: p.u8(4), seq: p.u16(0), int: false }),
            MISSION_REQUEST_INT_DATA::ID => (at(2), Self::Item { kind: p.u8(4), seq: p.u16(0), int: true }),
            MISSION_SET_CURRENT_DATA::ID => (at(2), Self::SetCurrent { seq: p.u16(0) }),
            MISSION_REQUEST_LIST_DATA::ID => (at(0), Self::List { kind: p.u8(2) }),
            MISSION_COUNT_DATA::ID => (at(2), Self::Count { kind: p.u8(4), count: p.u16(0) }),
            MISSION_CLEAR_ALL_DATA::ID => (at(0), Self::Clear { kind: p.u8(2) }),
            MISSION_ACK_DATA::ID => (at(0), Self::Ack { kind: p.u8(3), result: p.u8(2) }),
            MISSION_REQUEST_PARTIAL_LIST_DATA::ID | MISSION_WRITE_PARTIAL_LIST_DATA::ID => {
                (at(4), Self::Partial { kind: p.u8(6) })
            }
            _ => return None,
        })
    }
}

/// A message to a peer: its number and its payload in wire order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Answer {
    pub to: Peer,
    pub message_id: u32,
    pub payload: Vec<u8>,
}

impl Answer {
    pub(super) fn ack(to: Peer, kind: u8, result: MavMissionResult, opaque_id: u32) -> Self {
        let mut payload = vec![to.system, to.component, result as u8, kind];
        payload.extend(opaque_id.to_le_bytes());
        Self { to, message_id: MISSION_ACK_DATA::ID, payload }
    }

    pub(super) fn count(to: Peer, kind: u8, count: u16, opaque_id: u32) -> Self {
        let mut payload = count.to_le_bytes().to_vec();
        payload.extend([to.system, to.component, kind]);
        payload.extend(opaque_id.to_le_bytes());
        Self { to, message_id: MISSION_COUNT_DATA::ID, payload }
    }

    /// The vehicle's request for an item.
    pub(super) fn request(to: Peer, kind: u8, seq: u16, int: bool) -> Self {
        let [low, high] = seq.to_le_bytes();
        let message_id = if int { MISSION_REQUEST_INT_DATA::ID } else { MISSION_REQUEST_DATA::ID };
        Self { to, message_id, payload: vec![low, high, to.system, to.component, kind] }
    }

    /// An item as it was uploaded; `current` says whether it is the one that is next.
    pub(super) fn item(to: Peer, kind: u8, seq: u16, int: bool, item: &Item, current: bool) -> Self {
        let per_unit = if item.frame.is_global() { 1e7 } else { 1.0 };
        let place =
            |x: f64| if int { (x as i32).to_le_bytes() } else { ((x / per_unit) as f32).to_le_bytes() };
        let mut payload: Vec<u8> = item.params.iter().flat_map(|x| x.to_le_bytes()).collect();
        payload.extend(place(item.x));
        payload.extend(place(item.y));
        payload.extend(item.z.to_le_bytes());
        payload.extend(seq.to_le_bytes());
        payload.extend(item.command.to_le_bytes());
        payload.extend([to.system, to.component, item.frame.0, u8::from(current), item.autocontinue, kind]);
        let message_id = if int { MISSION_ITEM_INT_DATA::ID } else { MISSION_ITEM_DATA::ID };
        Self { to, message_id, payload }
    }
}
