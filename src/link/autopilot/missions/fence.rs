//! From the items of a fence plan to areas: each corner of a polygon is an item that tells how many there
//! are, each circle one item.

use nalgebra::Vector2;

use super::plan::Item;
use crate::autopilot::fence::{Area, Outline, Rule};
use crate::model::Environment;
use crate::model::environment::GeoPoint;

/// `MAV_CMD_NAV_FENCE_*`. A return point is kept and, as in PX4, not flown to.
pub(super) const RETURN_POINT: u16 = 5000;
const POLYGON_IN: u16 = 5001;
const POLYGON_OUT: u16 = 5002;
const CIRCLE_IN: u16 = 5003;
const CIRCLE_OUT: u16 = 5004;

/// Most corners of a polygon: more than a plan holds.
const MOST_CORNERS: f32 = 1000.0;

/// The items of one area after the other; return points belong to none.
///
/// # Errors
/// The number of the item with which a polygon begins whose corners do not follow each other, or are too few.
pub(super) fn areas_of(items: &[Item]) -> Result<Vec<&[Item]>, usize> {
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

/// The areas of a plan that was accepted, in the local frame.
pub(in crate::link::autopilot) fn areas(items: &[Item], environment: &Environment) -> Vec<Area> {
    let place = |item: &Item| -> Vector2<f64> {
        let (latitude_deg, longitude_deg) = (item.x / 1e7, item.y / 1e7);
        environment.local_ned(&GeoPoint { latitude_deg, longitude_deg, altitude_m: 0.0 }).xy()
    };
    let area = |items: &[Item]| {
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
    };
    // A plan is kept only if it falls into areas.
    areas_of(items).unwrap_or_default().into_iter().filter_map(area).collect()
}
