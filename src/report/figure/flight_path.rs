//! The flight path as in the paper's figure 7: north to the right, down downwards, both to the same scale,
//! coloured by J_state, marks every 1.56 s; the vehicle in its attitude every few seconds.

use super::axis::{Axis, Panel, SMALL, TITLE, number, range, round_step};
use super::canvas::{Anchor, Font, Pen, Point, Stroke, sub, text_width};
use super::color::{ColorScale, INK, WHITE};
use super::glyph;
use super::label::{Place, Room};
use super::polyline::runs;
use super::sheet::Sheet;
use super::track::{Track, TrackPoint};

/// Time between marks on a path [s], as in the paper's figure 7.
pub(crate) const MARK_INTERVAL_S: f64 = 1.56;
const PATH_PX: f64 = 4.5;

/// Draws the panel between two corners.
pub(crate) fn draw(pen: &mut Pen<'_>, sheet: &Sheet<'_>, corners: (Point, Point)) {
    let panel = panel(sheet, corners);
    panel.grid(pen, 5, 7, true);
    let (upper_left, (x1, y1)) = corners;
    pen.text("altitude lost [m]", (upper_left.0 - 40.0, upper_left.1 - 14.0), Anchor::Left, TITLE);
    pen.text("north [m]", (0.5 * (upper_left.0 + x1), y1 + 32.0), Anchor::Center, TITLE);
    let mut room = Room::new(corners);
    let px = |track: &Track| -> Vec<Point> { track.instants.iter().map(|i| place(&panel, i)).collect() };
    room.take_line(&px(sheet.track));
    path(pen, sheet, &panel);
    if let Some(plan) = sheet.plan {
        pen.line(&px(plan), Stroke::dashed(INK, 1.0, 5.0, 4.0));
    }
    let end_s = sheet.track.span_s().map_or(0.0, |s| s.1);
    marks(pen, (2.6, 1.7), |t_s| sheet.track.at(t_s).filter(|_| t_s <= end_s).map(|i| place(&panel, i)));
    vehicles(pen, sheet, &panel, &mut room);
    label_events(pen, sheet, &panel, &mut room);
    if let Some(plan) = sheet.plan {
        label_plan(pen, &px(plan), &mut room);
    }
}

/// Point of the sheet at which an instant is drawn.
fn place(panel: &Panel, i: &TrackPoint) -> Point {
    panel.px(i.north_m, i.down_m)
}

/// A panel with both axes to the same scale, the path in the middle and room for the parachute at the top.
fn panel(sheet: &Sheet<'_>, ((x0, y0), (x1, y1)): (Point, Point)) -> Panel {
    let instants = || sheet.track.instants.iter().chain(sheet.plan.iter().flat_map(|plan| &plan.instants));
    let all = |f: fn(&TrackPoint) -> f64| range(instants().map(f)).unwrap_or((0.0, 1.0));
    let (north, down) = (all(|i| i.north_m), all(|i| i.down_m));
    let margin = 0.5 * glyph::VEHICLE_PX + 6.0;
    let top = if sheet.parachute() { glyph::PARACHUTE_PX + 8.0 } else { margin };
    let (width, height) = (x1 - x0 - 2.0 * margin, y1 - y0 - top - margin);
    let m_per_px = ((north.1 - north.0) / width).max((down.1 - down.0) / height).max(1e-3);
    let left = 0.5 * (north.0 + north.1) - 0.5 * (x1 - x0) * m_per_px;
    let upper = down.0 - (top + 0.5 * (height - (down.1 - down.0) / m_per_px)) * m_per_px;
    Panel {
        x: Axis::new((left, left + (x1 - x0) * m_per_px), (x0, x1)),
        y: Axis::new((upper, upper + (y1 - y0) * m_per_px), (y0, y1)),
    }
}

/// Draws the path, a line for each run of one colour.
fn path(pen: &mut Pen<'_>, sheet: &Sheet<'_>, panel: &Panel) {
    let instants = sheet.track.instants.iter();
    let released_s = sheet.track.release_s.unwrap_or(f64::NEG_INFINITY);
    let hang = instants.clone().filter(|i| i.t_s <= released_s).map(|i| place(panel, i));
    pen.line(&hang.collect::<Vec<_>>(), Stroke::dashed(SMALL.color, 1.2, 2.0, 3.0));
    let fall = instants.filter(|i| i.t_s >= released_s);
    let points = fall.map(|i| (place(panel, i), sheet.scale.step(i.j_state)));
    rimmed(pen, &points.collect::<Vec<_>>(), (PATH_PX + 1.2, PATH_PX));
}

/// Draws discs every [`MARK_INTERVAL_S`] as long as there is a point at that time.
pub(crate) fn marks(pen: &mut Pen<'_>, radii: (f64, f64), at: impl Fn(f64) -> Option<Point>) {
    let times = (0..1000).map(|k| f64::from(k) * MARK_INTERVAL_S);
    times.map_while(at).for_each(|point| pen.dot(point, radii, WHITE));
}

/// Draws the vehicle every few seconds, with the time beside it.
fn vehicles(pen: &mut Pen<'_>, sheet: &Sheet<'_>, panel: &Panel, room: &mut Room) {
    let track = sheet.track;
    let Some((start_s, end_s)) = track.span_s() else { return };
    if sheet.parachute()
        && let Some(first) = track.instants.first()
    {
        let at = place(panel, first);
        glyph::parachute(pen, at);
        glyph::vehicle(pen, at, first.pitch_rad);
        room.take(Place::around((at.0, at.1 - 16.0), glyph::VEHICLE_PX, 64.0));
    }
    let interval_s = vehicle_interval_s(end_s - start_s.max(0.0));
    let chosen = (1..100).map(|k| f64::from(k) * interval_s).take_while(|t| *t <= end_s);
    let chosen: Vec<_> = chosen.filter_map(|t| track.at(t).map(|i| (t, i))).collect();
    for (_, i) in &chosen {
        let at = place(panel, i);
        glyph::vehicle(pen, at, i.pitch_rad);
        room.take(Place::around(at, 36.0, 20.0));
    }
    for (t_s, i) in &chosen {
        let text = format!("{} s", number(*t_s, if interval_s < 1.0 { 1 } else { 0 }));
        let (w, (x, y)) = (text_width(&text, SMALL.size), place(panel, i));
        let beside = [(-1.0, 0.0), (1.0, 0.0), (-1.0, 10.0), (1.0, -10.0), (-1.0, 20.0), (1.0, -20.0)]
            .map(|(side, dy)| Place::around((x + side * (27.0 + 0.5 * w), y + dy), w, 14.0));
        room.write(pen, (&text, SMALL), beside);
    }
}

fn label_events(pen: &mut Pen<'_>, sheet: &Sheet<'_>, panel: &Panel, room: &mut Room) {
    for event in &sheet.events {
        let Some(i) = sheet.track.at(event.t_s) else { continue };
        let at = place(panel, i);
        let font = Font { bold: event.strong, ..TITLE };
        let (w, h) = (text_width(&event.text, font.size), 15.0);
        let mut candidates = Vec::new();
        for reach in [26.0, 40.0, 60.0] {
            for dy in [0.0, -14.0, 14.0, -28.0, 28.0, -44.0, 44.0] {
                for side in [1.0, -1.0] {
                    candidates.push(Place::around((at.0 + side * (reach + 0.5 * w), at.1 + dy), w, h));
                }
            }
        }
        let Some(place) = room.best(candidates) else { continue };
        let (x, anchor, gap) =
            if place.x0 > at.0 { (place.x0, Anchor::Left, -3.0) } else { (place.x1, Anchor::Right, 3.0) };
        let y = place.centre().1;
        pen.line(&[at, (x + gap, y)], Stroke::solid(INK, 0.8));
        pen.dot(at, if event.strong { (5.0, 3.4) } else { (3.6, 2.4) }, sheet.scale.color(i.j_state));
        pen.text(&event.text, (x, y), anchor, font);
    }
}

/// Names the dashed line of the plan, somewhere along it.
fn label_plan(pen: &mut Pen<'_>, line: &[Point], room: &mut Room) {
    let (w, n) = (text_width("planned path", SMALL.size), line.len());
    let stations = [12, 10, 8, 14, 6, 16].map(|k| line.get(k * n / 20)).into_iter().flatten();
    let candidates: Vec<_> = stations
        .flat_map(|p| [10.0, 22.0].map(|dx| (Place::around((p.0 + dx + 0.5 * w, p.1 - dx), w, 14.0), *p)))
        .collect();
    if let Some(place) = room.best(candidates.iter().map(|c| c.0))
        && let Some((_, from)) = candidates.iter().find(|c| c.0 == place)
    {
        let (x, y) = (place.x0 - 2.0, place.centre().1);
        pen.line(&[*from, (x, y)], Stroke::solid(SMALL.color, 0.6));
        pen.text("planned path", (place.x0, y), Anchor::Left, SMALL);
    }
}

/// Time between two drawn vehicles [s], for about seven in all.
pub(crate) fn vehicle_interval_s(duration_s: f64) -> f64 {
    round_step((duration_s / 9.0).max(0.1))
}

/// Draws such a line on a wider dark one, which makes the bright end of the map stand out from the paper.
pub(crate) fn rimmed(pen: &mut Pen<'_>, points: &[(Point, usize)], (rim, width): (f64, f64)) {
    let all: Vec<Point> = points.iter().map(|p| p.0).collect();
    pen.line(&all, Stroke::solid((0x66, 0x66, 0x66), rim));
    colored(pen, points, width);
}

/// Draws a line for each run of points of one colour.
pub(crate) fn colored(pen: &mut Pen<'_>, points: &[(Point, usize)], width: f64) {
    for (step, line) in runs(points) {
        pen.line(&line, Stroke::solid(ColorScale::color_of_step(step), width));
    }
}

/// Draws the bar that explains the colours of J with that subscript, its right end at `right`.
pub(crate) fn color_bar(pen: &mut Pen<'_>, scale: &ColorScale, subscript: &str, (right, y): Point) {
    const WIDTH_PX: f64 = 150.0;
    let axis = Axis::new((scale.low, scale.high), (right - WIDTH_PX, right));
    let mut colors = scale.colors().peekable();
    while let Some((from, color)) = colors.next() {
        let to = colors.peek().map_or(scale.high, |c| c.0);
        // A little too wide, so that no seam shows between colours.
        pen.rectangle((axis.px(from), y), ((axis.px(to) + 0.6).min(right), y + 9.0), color);
    }
    for (tick, text) in axis.ticks(4) {
        pen.line(&[(axis.px(tick), y + 9.0), (axis.px(tick), y + 12.0)], Stroke::solid(SMALL.color, 1.0));
        pen.text(&text, (axis.px(tick), y + 20.0), Anchor::Center, SMALL);
    }
    pen.text(&sub("J", subscript), (axis.low_px - 8.0, y + 4.5), Anchor::Right, TITLE);
}
