//! The vertical plane that a flight path is seen in: that of its motion.

use super::track::{Track, TrackPoint};
use samara_core::math;
use samara_core::units::DEG_PER_RAD;

/// Part of a path's extent by which it may leave a plane and still be seen whole in it.
const FLAT: f64 = 0.02;
/// Bearings this close to one of the four main ones bear its name [deg].
const NAMED_WITHIN_DEG: f64 = 0.5;

/// A vertical plane through the release.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Heading {
    /// The direction to the right on the sheet: north and east part of a unit vector.
    ahead: (f64, f64),
    /// Name of that direction, for an axis.
    pub(crate) name: String,
    /// Whether the path leaves the plane.
    pub(crate) leaves: bool,
}

impl Heading {
    /// The plane of a track's motion: north to the right where it has next to no part to the east.
    pub(crate) fn of(track: &Track) -> Self {
        let from_s = track.release_s.unwrap_or(f64::NEG_INFINITY);
        let place = |i: &TrackPoint| (i.north_m, i.east_m, i.down_m);
        let finite = |p: &(f64, f64, f64)| p.0.is_finite() && p.1.is_finite() && p.2.is_finite();
        let places = || track.instants.iter().filter(|i| i.t_s >= from_s).map(place).filter(finite);
        let (Some(first), Some(last)) = (places().next(), places().next_back()) else { return Self::north() };
        let away = places().map(|p| (p.0 - first.0, p.1 - first.1, p.2 - first.2));
        let extent = away.clone().fold(0.0, |far: f64, p| far.max(p.0.abs()).max(p.1.abs()).max(p.2.abs()));
        if away.clone().all(|p| p.1.abs() <= FLAT * extent) {
            return Self::north();
        }
        let length = |p: (f64, f64)| math::hypot(p.0, p.1);
        let farthest = away
            .clone()
            .map(|p| (p.0, p.1))
            .fold((0.0, 0.0), |far, p| if length(p) > length(far) { p } else { far });
        // A path that comes back has its farthest point for a direction.
        let end = (last.0 - first.0, last.1 - first.1);
        let along = if length(end) > 0.2 * length(farthest) { end } else { farthest };
        let ahead = (along.0 / length(along), along.1 / length(along));
        let leaves = away.clone().any(|p| (p.1 * ahead.0 - p.0 * ahead.1).abs() > FLAT * extent);
        Self { ahead, name: name(ahead), leaves }
    }

    fn north() -> Self {
        Self { ahead: (1.0, 0.0), name: "north [m]".to_owned(), leaves: false }
    }

    /// Distance of a point along the plane [m].
    pub(crate) fn along(&self, i: &TrackPoint) -> f64 {
        i.north_m * self.ahead.0 + i.east_m * self.ahead.1
    }

    /// Angle by which a vehicle is turned in the plane, nose up from the right [rad].
    pub(crate) fn tilt_rad(&self, i: &TrackPoint) -> f64 {
        math::atan2(i.z_ned.x * self.ahead.0 + i.z_ned.y * self.ahead.1, i.z_ned.z)
    }
}

fn name((north, east): (f64, f64)) -> String {
    let bearing_deg = (math::atan2(east, north) * DEG_PER_RAD).rem_euclid(360.0);
    let main = ["north", "east", "south", "west"];
    let quarter = (bearing_deg / 90.0).round();
    if (bearing_deg - 90.0 * quarter).abs() <= NAMED_WITHIN_DEG {
        return format!("{} [m]", main[quarter as usize % 4]);
    }
    format!("distance towards {bearing_deg:.0} deg [m]")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_bearings_count_from_north_over_east() {
        assert_eq!(name((1.0, 0.0)), "north [m]");
        assert_eq!(name((0.0, -1.0)), "west [m]");
        assert_eq!(name((1.0, 1.0)), "distance towards 45 deg [m]");
        assert_eq!(name((1.0, -1e-6)), "north [m]");
    }
}
