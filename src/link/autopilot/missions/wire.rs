//! The messages of the mission protocol by wire offset: an item with a command or a plan of a type that no enum knows is owed an
//! answer too.

use super::plan::{Frame as ItemFrame, Item};
use crate::link::Frame;

/// Message numbers.
mod id {
    pub const REQUEST_PARTIAL_LIST: u32 = 37;
    pub const WRITE_PARTIAL_LIST: u32 = 38;
    pub const ITEM: u32 = 39;
    pub const REQUEST: u32 = 40;
    pub const SET_CURRENT: u32 = 41;
    pub const REQUEST_LIST: u32 = 43;
    pub const COUNT: u32 = 44;
    pub const CLEAR_ALL: u32 = 45;
    pub const ACK: u32 = 47;
    pub const REQUEST_INT: u32 = 51;
    pub const ITEM_INT: u32 = 73;
}

/// `MAV_MISSION_RESULT`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(in crate::link::autopilot) enum MissionResult {
    Accepted = 0,
    Error = 1,
    UnsupportedFrame = 2,
    Unsupported = 3,
    NoSpace = 4,
    InvalidParam1 = 6,
    InvalidLatitude = 10,
    InvalidLongitude = 11,
    InvalidAltitude = 12,
    InvalidSequence = 13,
}

/// MISSION_ACK's result by which a ground station gives up: `MAV_MISSION_OPERATION_CANCELLED`.
pub(super) const CANCELLED: u8 = 15;

/// What a ground station asks. `kind` is a `MAV_MISSION_TYPE`, whatever its number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::link::autopilot) enum Request {
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
    /// The request in a frame with the system and component that it is addressed to; `None` when it is no such message.
    pub(in crate::link::autopilot) fn read(frame: &Frame) -> Option<(u8, u8, Self)> {
        let p = frame.payload();
        let at = |i: usize| (p.u8(i), p.u8(i + 1));
        let ((system, component), request) = match frame.message_id {
            id::ITEM | id::ITEM_INT => {
                let int = frame.message_id == id::ITEM_INT;
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
            id::REQUEST => (at(2), Self::Item { kind: p.u8(4), seq: p.u16(0), int: false }),
            id::REQUEST_INT => (at(2), Self::Item { kind: p.u8(4), seq: p.u16(0), int: true }),
            id::SET_CURRENT => (at(2), Self::SetCurrent { seq: p.u16(0) }),
            id::REQUEST_LIST => (at(0), Self::List { kind: p.u8(2) }),
            id::COUNT => (at(2), Self::Count { kind: p.u8(4), count: p.u16(0) }),
            id::CLEAR_ALL => (at(0), Self::Clear { kind: p.u8(2) }),
            id::ACK => (at(0), Self::Ack { kind: p.u8(3), result: p.u8(2) }),
            id::REQUEST_PARTIAL_LIST | id::WRITE_PARTIAL_LIST => (at(4), Self::Partial { kind: p.u8(6) }),
            _ => return None,
        };
        Some((system, component, request))
    }
}

/// A message to a peer: its number and its payload in wire order.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::link::autopilot) struct Answer {
    pub message_id: u32,
    pub payload: Vec<u8>,
}

/// Who is answered: system and component.
pub(super) type Address = (u8, u8);

impl Answer {
    pub(super) fn ack((system, component): Address, kind: u8, result: MissionResult, opaque_id: u32) -> Self {
        let mut payload = vec![system, component, result as u8, kind];
        payload.extend(opaque_id.to_le_bytes());
        Self { message_id: id::ACK, payload }
    }

    pub(super) fn count((system, component): Address, kind: u8, count: u16, opaque_id: u32) -> Self {
        let mut payload = count.to_le_bytes().to_vec();
        payload.extend([system, component, kind]);
        payload.extend(opaque_id.to_le_bytes());
        Self { message_id: id::COUNT, payload }
    }

    /// The vehicle's request for an item.
    pub(super) fn request((system, component): Address, kind: u8, seq: u16, int: bool) -> Self {
        let [low, high] = seq.to_le_bytes();
        let message_id = if int { id::REQUEST_INT } else { id::REQUEST };
        Self { message_id, payload: vec![low, high, system, component, kind] }
    }

    /// An item as it was uploaded; `current`: whether it is the one that is next.
    pub(super) fn item(
        (system, component): Address,
        kind: u8,
        seq: u16,
        int: bool,
        item: &Item,
        current: bool,
    ) -> Self {
        let per_unit = if item.frame.is_global() { 1e7 } else { 1.0 };
        let place =
            |x: f64| if int { (x as i32).to_le_bytes() } else { ((x / per_unit) as f32).to_le_bytes() };
        let mut payload: Vec<u8> = item.params.iter().flat_map(|x| x.to_le_bytes()).collect();
        payload.extend(place(item.x));
        payload.extend(place(item.y));
        payload.extend(item.z.to_le_bytes());
        payload.extend(seq.to_le_bytes());
        payload.extend(item.command.to_le_bytes());
        payload.extend([system, component, item.frame.0, u8::from(current), item.autocontinue, kind]);
        let message_id = if int { id::ITEM_INT } else { id::ITEM };
        Self { message_id, payload }
    }
}
