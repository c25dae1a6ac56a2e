//! The flight path as in the paper's figure 7: the plane of motion, down downwards, both to the same scale,
//! coloured by J_state, marks at round times; the vehicle in its attitude every few seconds. A path that
//! leaves the plane is seen from above, too.

use super::axis::{Axis, Panel, SMALL, TITLE, number, range, round_step, short};
use super::canvas::{Anchor, Font, Pen, Point, Stroke, sub, text_width};
use super::color::{INK, LIMIT, Rgb, WHITE, color_of_step, cost_color, cost_colors, cost_step};
use super::glyph;
use super::label::{LabelPlace, Room};
use super::polyline::runs;
use super::sheet::Sheet;
use super::track::{Track, TrackPoint};
use samara_core::math;

const PATH_PX: f64 = 4.5;
/// Vehicles that are nearer to each other, to the right and down, are not drawn [px].
const APART_PX: (f64, f64) = (42.0, 24.0);

/// Height of the view from above, with its axis, where there is one [px].
const ABOVE_PX: f64 = 246.0;
const WIND: Rgb = (0x6A, 0x4C, 0x9C);

/// Draws the panel between two corners, and below it the view from above where the path leaves the plane.
pub(crate) fn draw(pen: &mut Pen<'_>, sheet: &Sheet<'_>, (upper_left, lower_right): (Point, Point)) {
    let leaves = sheet.heading.leaves;
    let y1 = if leaves { lower_right.1 - ABOVE_PX } else { lower_right.1 };
    from_the_side(pen, sheet, (upper_left, (lower_right.0, y1)));
    if leaves {
        from_above(pen, sheet, ((upper_left.0, y1 + 64.0), lower_right));
    }
}

fn from_the_side(pen: &mut Pen<'_>, sheet: &Sheet<'_>, corners: (Point, Point)) {
    let panel = panel(sheet, corners);
    panel.grid(pen, 5, 7, true);
    let (upper_left, (x1, y1)) = corners;
    pen.text("altitude lost [m]", (upper_left.0 - 40.0, upper_left.1 - 14.0), Anchor::Left, TITLE);
    pen.text(&sheet.heading.name, (0.5 * (upper_left.0 + x1), y1 + 30.0), Anchor::Center, TITLE);
    let mut room = Room::new(corners);
    let px =
        |track: &Track| -> Vec<Point> { track.instants.iter().map(|i| place(sheet, &panel, i)).collect() };
    room.take_line(&px(sheet.track));
    path(pen, sheet, |i| place(sheet, &panel, i));
    if let Some(plan) = sheet.plan {
        pen.line(&px(plan), Stroke::dashed(INK, 1.0, 5.0, 4.0));
    }
    let end_s = sheet.track.span_s().map_or(0.0, |s| s.1);
    let mark_s = mark_interval_s(end_s);
    let marked = |t_s: f64| sheet.track.at(t_s).filter(|_| t_s <= end_s);
    marks(pen, mark_s, (2.6, 1.7), |t_s| marked(t_s).map(|i| place(sheet, &panel, i)));
    vehicles(pen, sheet, &panel, &mut room);
    label_events(pen, sheet, &panel, &mut room);
    if let Some(plan) = sheet.plan {
        label_plan(pen, &px(plan), &mut room);
    }
}

/// Point of the sheet at which an instant is drawn.
fn place(sheet: &Sheet<'_>, panel: &Panel, i: &TrackPoint) -> Point {
    panel.px(sheet.heading.along(i), i.down_m)
}

/// Draws the path from above: north up, east to the right, to one scale; with the wind.
fn from_above(pen: &mut Pen<'_>, sheet: &Sheet<'_>, corners: (Point, Point)) {
    let ((x0, y0), (x1, y1)) = corners;
    let north = over(sheet, |i| i.north_m);
    let east = over(sheet, |i| i.east_m);
    const MARGIN_PX: f64 = 14.0;
    let (width, height) = (x1 - x0 - 2.0 * MARGIN_PX, y1 - y0 - 2.0 * MARGIN_PX);
    let m_per_px = ((east.1 - east.0) / width).max((north.1 - north.0) / height).max(1e-3);
    let around = |(low, high): (f64, f64), px: f64| {
        let (middle, half) = (0.5 * (low + high), 0.5 * px * m_per_px);
        (middle - half, middle + half)
    };
    let panel = Panel {
        x: Axis::new(around(east, x1 - x0), (x0, x1)),
        y: Axis::new(around(north, y1 - y0), (y1, y0)),
    };
    panel.grid(pen, 5, 4, true);
    pen.text("from above: north [m]", (x0 - 40.0, y0 - 12.0), Anchor::Left, TITLE);
    pen.text("east [m]", (0.5 * (x0 + x1), y1 + 30.0), Anchor::Center, TITLE);
    let px = |i: &TrackPoint| panel.px(i.east_m, i.north_m);
    let mut room = Room::new(corners);
    room.take_line(&sheet.track.instants.iter().map(px).collect::<Vec<_>>());
    path(pen, sheet, px);
    if let Some(plan) = sheet.plan {
        let plan: Vec<Point> = plan.instants.iter().map(px).collect();
        pen.line(&plan, Stroke::dashed(INK, 1.0, 5.0, 4.0));
        room.take_line(&plan);
    }
    let end_s = sheet.track.span_s().map_or(0.0, |s| s.1);
    let marked = |t_s: f64| sheet.track.at(t_s).filter(|_| t_s <= end_s);
    marks(pen, mark_interval_s(end_s), (2.2, 1.4), |t_s| marked(t_s).map(px));
    wind(pen, sheet, corners, &mut room);
}

/// Draws an arrow along the wind in the corner with most room, and its speed.
fn wind(pen: &mut Pen<'_>, sheet: &Sheet<'_>, ((x0, y0), (x1, y1)): (Point, Point), room: &mut Room) {
    let wind = sheet.mission.site.environment.wind_ned_m_s;
    let speed = math::hypot(wind.x, wind.y);
    if !(speed > 0.0) {
        return;
    }
    let text = format!("wind {} m/s", short(speed));
    let (w, h) = (text_width(&text, SMALL.size), 54.0);
    let corners = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)];
    let inwards = |(x, y): Point| {
        let aside = 0.5 * w + 8.0;
        (if x == x0 { x + aside } else { x - aside }, if y == y0 { y + 34.0 } else { y - 34.0 })
    };
    let Some(place) = room.best(corners.map(|corner| LabelPlace::around(inwards(corner), w, h))) else {
        return;
    };
    let (x, y) = (place.centre().0, place.y0 + 18.0);
    let (east, up) = (wind.y / speed, wind.x / speed);
    let at = |ahead: f64, aside: f64| (x + ahead * east - aside * up, y - ahead * up - aside * east);
    pen.line(&[at(-17.0, 0.0), at(10.0, 0.0)], Stroke::solid(WIND, 2.0));
    pen.polygon(&[at(18.0, 0.0), at(8.0, 4.5), at(8.0, -4.5)], WIND);
    pen.text(&text, (x, place.y1 - 7.0), Anchor::Center, Font { color: WIND, ..SMALL });
}

/// Range of a quantity over what is drawn: the flight from the release on, and the plan.
fn over(sheet: &Sheet<'_>, quantity: impl Fn(&TrackPoint) -> f64) -> (f64, f64) {
    let released_s = sheet.track.release_s.unwrap_or(f64::NEG_INFINITY);
    let flown = sheet.track.instants.iter().filter(|i| i.t_s >= released_s);
    let all = flown.chain(sheet.plan.iter().flat_map(|plan| &plan.instants));
    range(all.map(quantity)).unwrap_or((0.0, 1.0))
}

/// A panel with both axes to the same scale, the path in the middle and room for the parachute at the top.
fn panel(sheet: &Sheet<'_>, ((x0, y0), (x1, y1)): (Point, Point)) -> Panel {
    let (along, down) = (over(sheet, |i| sheet.heading.along(i)), over(sheet, |i| i.down_m));
    let margin = 0.5 * glyph::VEHICLE_PX + 6.0;
    let top = if sheet.parachute() { glyph::PARACHUTE_PX + 8.0 } else { margin };
    let (width, height) = (x1 - x0 - 2.0 * margin, y1 - y0 - top - margin);
    let m_per_px = ((along.1 - along.0) / width).max((down.1 - down.0) / height).max(1e-3);
    let left = 0.5 * (along.0 + along.1) - 0.5 * (x1 - x0) * m_per_px;
    let upper = down.0 - (top + 0.5 * (height - (down.1 - down.0) / m_per_px)) * m_per_px;
    Panel {
        x: Axis::new((left, left + (x1 - x0) * m_per_px), (x0, x1)),
        y: Axis::new((upper, upper + (y1 - y0) * m_per_px), (y0, y1)),
    }
}

/// Draws the path from the release on, a line for each run of one colour.
fn path(pen: &mut Pen<'_>, sheet: &Sheet<'_>, px: impl Fn(&TrackPoint) -> Point) {
    let released_s = sheet.track.release_s.unwrap_or(f64::NEG_INFINITY);
    let fall = sheet.track.instants.iter().filter(|i| i.t_s >= released_s);
    let points = fall.map(|i| (px(i), cost_step(i.j_state)));
    rimmed(pen, &points.collect::<Vec<_>>(), (PATH_PX + 1.2, PATH_PX));
}

/// Time between marks on a path of that length [s]: round, a dozen marks or so.
pub(crate) fn mark_interval_s(duration_s: f64) -> f64 {
    round_step((duration_s / 18.0).max(0.01))
}

/// Draws discs at that interval as long as there is a point at that time.
pub(crate) fn marks(
    pen: &mut Pen<'_>,
    interval_s: f64,
    radii: (f64, f64),
    at: impl Fn(f64) -> Option<Point>,
) {
    let times = (0..1000).map(|k| f64::from(k) * interval_s);
    times.map_while(at).for_each(|point| pen.dot(point, radii, WHITE));
}

/// Draws the vehicle every few seconds, with the time beside it.
fn vehicles(pen: &mut Pen<'_>, sheet: &Sheet<'_>, panel: &Panel, room: &mut Room) {
    let track = sheet.track;
    let Some((start_s, end_s)) = track.span_s() else { return };
    let mut drawn: Vec<Point> = Vec::new();
    let first = track.release_s.map_or(track.instants.first(), |t_s| track.at(t_s));
    if sheet.parachute()
        && let Some(first) = first
    {
        let at = place(sheet, panel, first);
        glyph::parachute(pen, at);
        glyph::vehicle(pen, at, sheet.heading.tilt_rad(first));
        drawn.push(at);
        room.take(LabelPlace::around((at.0, at.1 - 16.0), glyph::VEHICLE_PX, 64.0));
    }
    let interval_s = vehicle_interval_s(end_s - start_s.max(0.0));
    let chosen = (1..100).map(|k| f64::from(k) * interval_s).take_while(|t| *t <= end_s);
    let mut times = Vec::new();
    for (t_s, i) in chosen.filter_map(|t| track.at(t).map(|i| (t, i))) {
        let at = place(sheet, panel, i);
        // A vehicle that hovers is drawn once.
        let apart = |d: &Point| (d.0 - at.0).abs() > APART_PX.0 || (d.1 - at.1).abs() > APART_PX.1;
        if drawn.iter().all(apart) {
            glyph::vehicle(pen, at, sheet.heading.tilt_rad(i));
            room.take(LabelPlace::around(at, 36.0, 20.0));
            drawn.push(at);
            times.push((t_s, at));
        }
    }
    let decimals = if interval_s < 0.1 {
        2
    } else if interval_s < 1.0 {
        1
    } else {
        0
    };
    for (t_s, (x, y)) in times {
        let text = format!("{} s", number(t_s, decimals));
        let w = text_width(&text, SMALL.size);
        let beside = [(-1.0, 0.0), (1.0, 0.0), (-1.0, 10.0), (1.0, -10.0), (-1.0, 20.0), (1.0, -20.0)]
            .map(|(side, dy)| LabelPlace::around((x + side * (27.0 + 0.5 * w), y + dy), w, 14.0));
        if let Some(place) = room.free(beside) {
            pen.text(&text, place.centre(), Anchor::Center, SMALL);
        }
    }
}

fn label_events(pen: &mut Pen<'_>, sheet: &Sheet<'_>, panel: &Panel, room: &mut Room) {
    for event in &sheet.events {
        let Some(i) = sheet.track.at(event.t_s) else { continue };
        let at = place(sheet, panel, i);
        let font = Font { bold: event.strong, ..TITLE };
        let (w, h) = (text_width(&event.text, font.size), 15.0);
        let mut candidates = Vec::new();
        for reach in [26.0, 40.0, 60.0, 90.0] {
            for dy in [0.0, -14.0, 14.0, -28.0, 28.0, -44.0, 44.0, -62.0, 62.0, -84.0, 84.0] {
                for side in [1.0, -1.0] {
                    candidates.push(LabelPlace::around((at.0 + side * (reach + 0.5 * w), at.1 + dy), w, h));
                }
            }
        }
        let Some(place) = room.best(candidates) else { continue };
        let (x, anchor, gap) =
            if place.x0 > at.0 { (place.x0, Anchor::Left, -3.0) } else { (place.x1, Anchor::Right, 3.0) };
        let y = place.centre().1;
        pen.line(&[at, (x + gap, y)], Stroke::solid(INK, 0.8));
        pen.dot(at, if event.strong { (5.0, 3.4) } else { (3.6, 2.4) }, cost_color(i.j_state));
        pen.text(&event.text, (x, y), anchor, font);
    }
}

/// Names the dashed line of the plan, somewhere along it.
fn label_plan(pen: &mut Pen<'_>, line: &[Point], room: &mut Room) {
    let (w, n) = (text_width("planned path", SMALL.size), line.len());
    let stations = [12, 10, 8, 14, 6, 16].map(|k| line.get(k * n / 20)).into_iter().flatten();
    let candidates: Vec<_> = stations
        .flat_map(|p| {
            [10.0, 22.0].map(|dx| (LabelPlace::around((p.0 + dx + 0.5 * w, p.1 - dx), w, 14.0), *p))
        })
        .collect();
    if let Some(place) = room.free(candidates.iter().map(|c| c.0))
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
        pen.line(&line, Stroke::solid(color_of_step(step), width));
    }
}

/// Draws the bar that explains the colours of J with that subscript, its right end, the limit, at `right`.
pub(crate) fn color_bar(pen: &mut Pen<'_>, subscript: &str, (right, y): Point) {
    const WIDTH_PX: f64 = 150.0;
    let axis = Axis::new((0.0, 1.0), (right - WIDTH_PX, right));
    let mut colors = cost_colors().peekable();
    while let Some((from, color)) = colors.next() {
        let to = colors.peek().map_or(1.0, |c| c.0);
        // A little too wide, so that no seam shows between colours.
        pen.rectangle((axis.px(from), y), ((axis.px(to) + 0.6).min(right), y + 9.0), color);
    }
    for (tick, text) in [(0.0, "0"), (0.5, "0.5")] {
        pen.line(&[(axis.px(tick), y + 9.0), (axis.px(tick), y + 12.0)], Stroke::solid(SMALL.color, 1.0));
        pen.text(text, (axis.px(tick), y + 20.0), Anchor::Center, SMALL);
    }
    pen.line(&[(right, y - 3.0), (right, y + 12.0)], Stroke::solid(LIMIT, 2.0));
    pen.text("1, the limit", (right + 2.0, y + 20.0), Anchor::Right, Font { color: LIMIT, ..SMALL });
    pen.text(&sub("J", subscript), (axis.low_px - 8.0, y + 4.5), Anchor::Right, TITLE);
}
