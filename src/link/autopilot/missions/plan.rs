//! What is kept: three plans of items (mission, fence, rally points), and which items may stand in which.

use std::sync::Arc;

use super::wire::MissionResult;
use crate::autopilot::parameters::hash::crc32;

/// `MAV_FRAME` of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::link::autopilot) struct Frame(pub u8);

impl Frame {
    /// MISSION: the item is at no place, x and y are its parameters 5 and 6.
    const MISSION: Self = Self(2);

    /// Latitude and longitude, height above sea level or home (GLOBAL, GLOBAL_RELATIVE_ALT and their old
    /// twins `_INT`).
    pub(super) fn is_global(self) -> bool {
        matches!(self.0, 0 | 3 | 5 | 6)
    }
}

/// An item as a ground station gave it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::link::autopilot) struct Item {
    pub params: [f32; 4],
    /// Latitude [degE7] in a global frame, else parameter 5.
    pub x: f64,
    /// Longitude [degE7] in a global frame, else parameter 6.
    pub y: f64,
    /// Height [m] in a global frame, else parameter 7.
    pub z: f32,
    /// `MAV_CMD`.
    pub command: u16,
    pub frame: Frame,
    pub current: u8,
    pub autocontinue: u8,
}

/// Fence vertices and circles (`MAV_CMD_NAV_FENCE_*`): return point, polygons, circles.
const FENCE: std::ops::RangeInclusive<u16> = 5000..=5004;
const POLYGON: std::ops::RangeInclusive<u16> = 5001..=5002;
const CIRCLE: std::ops::RangeInclusive<u16> = 5003..=5004;
const RALLY_POINT: u16 = 5100;
/// Commands at a place that PX4 takes in a mission.
const AT_A_PLACE: [u16; 14] = [16, 17, 18, 19, 20, 21, 22, 31, 80, 84, 85, 195, 201, 4501];
/// Commands at no place that PX4 takes in a mission.
const AT_NO_PLACE: [u16; 37] = [
    20, 21, 80, 93, 112, 114, 115, 177, 178, 179, 183, 187, 189, 195, 196, 197, 200, 201, 203, 204, 205, 206,
    211, 212, 214, 260, 530, 531, 532, 1000, 1001, 2000, 2001, 2003, 2500, 2501, 3000,
];

/// Which plan: mission, fence, rally points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(in crate::link::autopilot) enum Kind {
    Mission = 0,
    Fence = 1,
    Rally = 2,
}

impl Kind {
    pub(in crate::link::autopilot) const ALL: [Self; 3] = [Self::Mission, Self::Fence, Self::Rally];

    /// The plan of a `MAV_MISSION_TYPE`.
    pub(super) fn from_number(kind: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|k| *k as u8 == kind)
    }

    /// Most items, as many as PX4 takes.
    pub(super) fn capacity(self) -> usize {
        match self {
            Self::Mission => 2000,
            Self::Fence => 64,
            Self::Rally => 32,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Mission => "mission",
            Self::Fence => "fence",
            Self::Rally => "rally points",
        }
    }
}

impl Item {
    /// Whether it may stand in a plan.
    pub(super) fn check(&self, kind: Kind) -> Result<(), MissionResult> {
        let fits = match kind {
            Kind::Mission => AT_A_PLACE.contains(&self.command) || AT_NO_PLACE.contains(&self.command),
            Kind::Fence => FENCE.contains(&self.command),
            Kind::Rally => self.command == RALLY_POINT,
        };
        if !fits {
            return Err(MissionResult::Unsupported);
        }
        let at_a_place = kind != Kind::Mission || AT_A_PLACE.contains(&self.command);
        let at_none = kind == Kind::Mission && AT_NO_PLACE.contains(&self.command);
        if self.frame.is_global() && (at_a_place || at_none) {
            self.check_place()?;
        } else if !(self.frame == Frame::MISSION && at_none) {
            return Err(MissionResult::UnsupportedFrame);
        }
        let size = self.params[0];
        let is_sized = match self.command {
            command if POLYGON.contains(&command) => size >= 3.0,
            command if CIRCLE.contains(&command) => size > 0.0 && size.is_finite(),
            _ => true,
        };
        if kind == Kind::Fence && !is_sized {
            return Err(MissionResult::InvalidParam1);
        }
        Ok(())
    }

    fn check_place(&self) -> Result<(), MissionResult> {
        if !(self.x.abs() <= 90e7) {
            return Err(MissionResult::InvalidLatitude);
        }
        if !(self.y.abs() <= 180e7) {
            return Err(MissionResult::InvalidLongitude);
        }
        if self.z.is_infinite() { Err(MissionResult::InvalidAltitude) } else { Ok(()) }
    }

    fn checksum(&self, start: u32) -> u32 {
        let [low, high] = self.command.to_le_bytes();
        let head = [self.frame.0, low, high, self.autocontinue];
        let numbers = self.params.iter().chain([&self.z]).flat_map(|x| x.to_le_bytes());
        let places = [self.x, self.y].into_iter().flat_map(f64::to_le_bytes);
        let bytes: Vec<u8> = head.into_iter().chain(numbers).chain(places).collect();
        crc32(start, &bytes)
    }
}

/// A plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::link::autopilot) struct Plan {
    pub items: Arc<Vec<Item>>,
    /// By which peers know the plan again: a checksum of its items, 0 for none.
    pub opaque_id: u32,
}

impl Plan {
    pub(super) fn new(items: Vec<Item>) -> Self {
        let opaque_id = match items.iter().fold(0, |crc, item| item.checksum(crc)) {
            0 if !items.is_empty() => 1,
            crc => crc,
        };
        Self { items: Arc::new(items), opaque_id }
    }

    /// Number of items; no plan has more than [`Kind::capacity`].
    pub(in crate::link::autopilot) fn len(&self) -> u16 {
        self.items.len() as u16
    }
}
