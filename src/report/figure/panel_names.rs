//! Names of limits and lines in a panel, where there is room.

use super::axis::{Panel, SMALL, TITLE, short};
use super::canvas::{Anchor, Font, Pen, Point, Stroke, text_width};
use super::color::{LIMIT, Rgb};
use super::label::{Place, Room};

/// Draws a limit across the panel and names it where there is room, rather at the right.
pub(crate) fn limit_line(pen: &mut Pen<'_>, panel: &Panel, limit: f64, name: &str, room: &mut Room) {
    let line = [panel.px(panel.x.low, limit), panel.px(panel.x.high, limit)];
    pen.line(&line, Stroke::dashed(LIMIT, 1.2, 8.0, 3.0));
    room.take_line(&line);
    let text = format!("{name} {}", short(limit));
    let w = text_width(&text, SMALL.size);
    let (left, right) = (panel.x.low_px + 0.5 * w + 2.0, panel.x.high_px - 0.5 * w - 2.0);
    let candidates = (0..=12).map(|k| right + (left - right) * f64::from(k) / 12.0).flat_map(|x| {
        // On the inner side of the limit first.
        let inwards = if limit < 0.0 { -9.0 } else { 9.0 };
        [inwards, -inwards].map(|dy| Place::around((x, line[0].1 + dy), w, 13.0))
    });
    if let Some(place) = room.best(candidates) {
        pen.text(&text, place.centre(), Anchor::Middle, Font { color: LIMIT, ..SMALL });
    }
}

/// Writes a line's name beside it, where there is room.
pub(crate) fn name_line(pen: &mut Pen<'_>, curve: &[Point], (name, color): (&str, Rgb), room: &mut Room) {
    let (w, h) = (text_width(name, TITLE.size), 14.0);
    let n = curve.len();
    if name.is_empty() || n == 0 {
        return;
    }
    let stations = (3..32).map(|k| curve[k * (n - 1) / 32]);
    let candidates = stations.filter(|p| p.0.is_finite() && p.1.is_finite()).flat_map(|(x, y)| {
        let aside = 0.5 * w + 7.0;
        [(0.0, -11.0), (0.0, 11.0), (aside, 3.0), (-aside, -3.0)]
            .map(|(dx, dy)| Place::around((x + dx, y + dy), w, h))
    });
    if let Some(place) = room.best(candidates) {
        pen.text(name, place.centre(), Anchor::Middle, Font { color, bold: true, ..TITLE });
    }
}
