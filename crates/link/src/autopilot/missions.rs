//! Missions, fences and rally points as they are kept: three plans of items, which items may stand in which,
//! and the areas of a fence. The areas are watched by [`super::fence`], missions are flown by
//! [`super::mission_flight`].

use std::sync::Arc;

use nalgebra::Vector2;

use super::fence::{Area, Fence, Outline, Rule};
use crate::checksum::crc32;
use crate::model::Environment;
use crate::model::environment::GeoPoint;

/// What is wrong with an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ItemFault {
    /// The item's command may not stand in such a plan.
    Command,
    /// The item's frame does not fit its command.
    Frame,
    /// Parameter 1 is no size of an area.
    Size,
    /// Latitude beyond the poles.
    Latitude,
    /// Longitude beyond 180 deg.
    Longitude,
    /// An infinite altitude.
    Altitude,
}

/// `MAV_FRAME` of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ItemFrame(pub u8);

impl ItemFrame {
    /// MISSION: the item is at no place, x and y are its parameters 5 and 6.
    const MISSION: Self = Self(2);

    /// Latitude and longitude, height above sea level or home (GLOBAL, GLOBAL_RELATIVE_ALT and their old
    /// twins `_INT`).
    pub fn is_global(self) -> bool {
        matches!(self.0, 0 | 3 | 5 | 6)
    }
}

/// An item as a ground station gave it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item {
    /// Parameters 1 to 4.
    pub params: [f32; 4],
    /// Latitude [degE7] in a global frame, else parameter 5.
    pub x: f64,
    /// Longitude [degE7] in a global frame, else parameter 6.
    pub y: f64,
    /// Height [m] in a global frame, else parameter 7.
    pub z: f32,
    /// `MAV_CMD`.
    pub command: u16,
    /// What x, y and z mean.
    pub frame: ItemFrame,
    /// Kept as it came.
    pub current: u8,
    /// Kept as it came.
    pub autocontinue: u8,
}

/// `MAV_CMD_NAV_FENCE_*`. A return point is kept and, as in PX4, not flown to.
const RETURN_POINT: u16 = 5000;
const POLYGON_IN: u16 = 5001;
const POLYGON_OUT: u16 = 5002;
const CIRCLE_IN: u16 = 5003;
const CIRCLE_OUT: u16 = 5004;

/// Most corners of a polygon: more than a plan holds.
const MOST_CORNERS: f32 = 1000.0;
const RALLY_POINT: u16 = 5100;
/// Commands at a place that PX4 takes in a mission.
const AT_A_PLACE: [u16; 13] = [16, 17, 19, 20, 21, 22, 31, 80, 84, 85, 195, 201, 4501];
/// Commands at no place that PX4 takes in a mission.
const AT_NO_PLACE: [u16; 37] = [
    20, 21, 80, 93, 112, 114, 115, 177, 178, 179, 183, 187, 189, 195, 196, 197, 200, 201, 203, 204, 205, 206,
    211, 212, 214, 260, 530, 531, 532, 1000, 1001, 2000, 2001, 2003, 2500, 2501, 3000,
];

/// NAV_ROI, DO_SET_ROI_LOCATION, DO_SET_ROI_WPNEXT_OFFSET and DO_SET_ROI.
pub const REGIONS_OF_INTEREST: [u16; 4] = [80, 195, 196, 201];

/// The kinds of plans, by their `MAV_MISSION_TYPE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Items to be flown one after the other.
    Mission = 0,
    /// Areas to stay in or keep out of.
    Fence = 1,
    /// Places to return to.
    Rally = 2,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Mission, Self::Fence, Self::Rally];

    /// The plan of a `MAV_MISSION_TYPE`.
    pub fn from_number(kind: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|k| *k as u8 == kind)
    }

    /// Most items, as many as PX4 takes.
    pub fn capacity(self) -> usize {
        match self {
            Self::Mission => 2000,
            Self::Fence => 64,
            Self::Rally => 32,
        }
    }

    /// Name for the crew.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mission => "mission",
            Self::Fence => "fence",
            Self::Rally => "rally points",
        }
    }
}

impl Item {
    /// Checks that the item may stand in a plan.
    ///
    /// # Errors
    /// [`ItemFault`]: the first thing that is wrong with it.
    pub fn check(&self, kind: Kind) -> Result<(), ItemFault> {
        let fits = match kind {
            Kind::Mission => AT_A_PLACE.contains(&self.command) || AT_NO_PLACE.contains(&self.command),
            Kind::Fence => (RETURN_POINT..=CIRCLE_OUT).contains(&self.command),
            Kind::Rally => self.command == RALLY_POINT,
        };
        if !fits {
            return Err(ItemFault::Command);
        }
        let at_a_place = kind != Kind::Mission || AT_A_PLACE.contains(&self.command);
        let at_none = kind == Kind::Mission && AT_NO_PLACE.contains(&self.command);
        if self.frame.is_global() && (at_a_place || at_none) {
            self.check_place()?;
        } else if !(self.frame == ItemFrame::MISSION && at_none) {
            return Err(ItemFault::Frame);
        }
        let size = self.params[0];
        let is_sized = match self.command {
            POLYGON_IN | POLYGON_OUT => size >= 3.0,
            // One of no radius holds no place.
            CIRCLE_IN | CIRCLE_OUT => size >= 0.0 && size.is_finite(),
            _ => true,
        };
        if kind == Kind::Fence && !is_sized {
            return Err(ItemFault::Size);
        }
        Ok(())
    }

    fn check_place(&self) -> Result<(), ItemFault> {
        if !(self.x.abs() <= 90e7) {
            return Err(ItemFault::Latitude);
        }
        if !(self.y.abs() <= 180e7) {
            return Err(ItemFault::Longitude);
        }
        if self.z.is_infinite() { Err(ItemFault::Altitude) } else { Ok(()) }
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

/// A plan as it was uploaded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// Items in order.
    pub items: Arc<Vec<Item>>,
    /// By which peers know the plan again: a checksum of its items, 0 for none.
    pub opaque_id: u32,
}

impl Plan {
    /// A plan of these items.
    pub fn new(items: Vec<Item>) -> Self {
        let opaque_id = match items.iter().fold(0, |crc, item| item.checksum(crc)) {
            0 if !items.is_empty() => 1,
            crc => crc,
        };
        Self { items: Arc::new(items), opaque_id }
    }

    /// Number of items; no plan has more than [`Kind::capacity`].
    pub fn count(&self) -> u16 {
        self.items.len() as u16
    }

    /// The areas of a fence that was accepted, in the local frame.
    pub fn fence(&self, environment: &Environment) -> Fence {
        // A plan is kept only if it falls into areas.
        let areas = areas_of(&self.items).unwrap_or_default();
        Fence::new(areas.into_iter().filter_map(|items| area(items, environment)).collect())
    }

    /// What of the plan is kept but not flown as a crew might think, in words.
    pub fn remarks(&self, kind: Kind) -> Vec<&'static str> {
        let any = |test: fn(&Item) -> bool| self.items.iter().any(test);
        let is_empty = |item: &Item| matches!(item.command, CIRCLE_IN | CIRCLE_OUT) && item.params[0] == 0.0;
        let remarks = match kind {
            Kind::Mission => vec![(
                any(|item| REGIONS_OF_INTEREST.contains(&item.command)),
                "mission: regions of interest are passed over, the nose does not turn to them",
            )],
            Kind::Fence => vec![
                (any(|item| item.command == RETURN_POINT), "fence: the return point is kept, not flown to"),
                (any(is_empty), "fence: a circle of radius 0 holds no place"),
            ],
            Kind::Rally => Vec::new(),
        };
        remarks.into_iter().filter_map(|(holds, text)| holds.then_some(text)).collect()
    }
}

/// The items of one area after the other; return points belong to none.
///
/// # Errors
/// The number of the item with which a polygon begins whose corners do not follow each other, or are too few.
pub fn areas_of(items: &[Item]) -> Result<Vec<&[Item]>, usize> {
    let mut areas = Vec::new();
    let mut rest = items;
    while let Some(first) = rest.first() {
        let length = match first.command {
            POLYGON_IN | POLYGON_OUT => first.params[0].clamp(1.0, MOST_CORNERS) as usize,
            _ => 1,
        };
        let alike = |item: &&Item| item.command == first.command && item.params[0] == first.params[0];
        if rest.iter().take(length).take_while(alike).count() < length {
            return Err(items.len() - rest.len());
        }
        let (area, others) = rest.split_at(length);
        if first.command != RETURN_POINT {
            areas.push(area);
        }
        rest = others;
    }
    Ok(areas)
}

fn area(items: &[Item], environment: &Environment) -> Option<Area> {
    let place = |item: &Item| -> Vector2<f64> {
        let (latitude_deg, longitude_deg) = (item.x / 1e7, item.y / 1e7);
        environment.local_ned(&GeoPoint { latitude_deg, longitude_deg, altitude_m: 0.0 }).xy()
    };
    let first = items.first()?;
    let rule = match first.command {
        POLYGON_IN | CIRCLE_IN => Rule::StayIn,
        POLYGON_OUT | CIRCLE_OUT => Rule::KeepOut,
        _ => return None,
    };
    let outline = match first.command {
        CIRCLE_IN | CIRCLE_OUT => {
            Outline::Circle { centre_ne: place(first), radius_m: f64::from(first.params[0]) }
        }
        _ => Outline::Polygon(items.iter().map(place).collect()),
    };
    Some(Area { rule, outline })
}
