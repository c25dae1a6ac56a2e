//! Small pictures on the flight path: the vehicle in its attitude, seen from the east, and the parachute.

use super::canvas::{Pen, Point, Stroke};
use super::color::{INK, WHITE};
use samara_core::math;

/// Half the vehicle's arm [px].
pub(crate) const ARM_PX: f64 = 15.0;

/// Draws a vehicle with a rotor ahead and one behind; nose up is nose up.
pub(crate) fn vehicle(pen: &mut Pen<'_>, centre: Point, pitch_rad: f64) {
    let (s, c) = math::sin_cos(pitch_rad);
    // Nose (cos, -sin) in (north, down); -z of the body is (-sin, -cos). Down is down on the sheet.
    let at = |(ahead, up): Point| (centre.0 + ahead * c + up * -s, centre.1 + ahead * -s + up * -c);
    // A white rim keeps it apart from the path.
    for (color, rim) in [(WHITE, 3.0), (INK, 0.0)] {
        let mut line = |from: Point, to: Point, width: f64| {
            pen.line(&[at(from), at(to)], Stroke::solid(color, width + rim));
        };
        line((-ARM_PX, 0.0), (ARM_PX, 0.0), 2.0);
        for x in [-ARM_PX, ARM_PX] {
            line((x, 0.0), (x, 4.5), 1.4);
            line((x - 7.0, 4.5), (x + 7.0, 4.5), 1.6);
        }
        line((-3.5, -1.8), (3.5, -1.8), 4.2);
    }
}

/// Draws a canopy with its lines, above a vehicle at `load`.
pub(crate) fn parachute(pen: &mut Pen<'_>, load: Point) {
    const RADIUS_PX: f64 = 20.0;
    const LINES_PX: f64 = 26.0;
    let (x, y) = (load.0, load.1 - LINES_PX);
    let arc = |from: f64, to: f64, rx: f64, ry: f64| -> Vec<Point> {
        (0..=24)
            .map(|i| from + (to - from) * f64::from(i) / 24.0)
            .map(|a: f64| (x - rx * math::cos(a), y - ry * math::sin(a)))
            .collect()
    };
    let half_turn = std::f64::consts::PI;
    let dome = arc(0.0, half_turn, RADIUS_PX, RADIUS_PX * 0.8);
    pen.polygon(&dome, (0xE9, 0xEE, 0xF3));
    for side in [-1.0, -0.4, 0.4, 1.0] {
        pen.line(&[(x + side * RADIUS_PX, y), load], Stroke::solid(INK, 0.7));
    }
    pen.line(&dome, Stroke::solid(INK, 1.4));
    pen.line(&[(x - RADIUS_PX, y), (x + RADIUS_PX, y)], Stroke::solid(INK, 1.0));
}

/// Width and height that a vehicle takes, whatever its pitch [px].
pub(crate) const VEHICLE_PX: f64 = 2.0 * ARM_PX + 14.0;
/// Height above the load that the parachute takes [px].
pub(crate) const PARACHUTE_PX: f64 = 44.0;
