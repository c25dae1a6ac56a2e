//! The flight path as in the paper's figure 7: north to the right, down downwards, both to the same scale,
//! coloured by J_state, marks every 1.56 s; the vehicle in its attitude every few seconds.

use super::axis::{Axis, Panel, SMALL, TITLE, number, range, round_step};
use super::canvas::{Anchor, Font, Pen, Point, Stroke, sub, text_width};
use super::color::{ColorScale, INK, WHITE};
use super::glyph;
use super::label::{Place, Room};
use super::track::Track;

/// Time between marks on a path [s], as in the paper's figure 7.
pub(crate) const MARK_INTERVAL_S: f64 = 1.56;
const PATH_PX: f64 = 4.5;

/// A point of the path with a name.
pub(crate) struct Event {
    pub(crate) t_s: f64,
    pub(crate) text: String,
    pub(crate) strong: bool,
}

/// The panel of a flight path.
pub(crate) struct FlightPath<'a> {
    pub(crate) track: &'a Track,
    pub(crate) plan: Option<&'a Track>,
    pub(crate) scale: ColorScale,
    pub(crate) events: Vec<Event>,
    /// Whether the flight begins under a parachute.
    pub(crate) parachute: bool,
}

impl FlightPath<'_> {
    /// Draws the panel between two corners.
    pub(crate) fn draw(&self, pen: &mut Pen<'_>, upper_left: Point, lower_right: Point) {
        let panel = self.panel(upper_left, lower_right);
        panel.grid(pen, 5, 7, true);
        let (_, (x1, y1)) = panel.corners();
        pen.text("altitude lost [m]", (upper_left.0 - 40.0, upper_left.1 - 14.0), Anchor::Start, TITLE);
        pen.text("north [m]", (0.5 * (upper_left.0 + x1), y1 + 32.0), Anchor::Middle, TITLE);
        let mut room = Room::new(upper_left, (x1, y1));
        let px = |track: &Track| -> Vec<Point> {
            track.instants.iter().map(|i| panel.px(i.north_m, i.down_m)).collect()
        };
        room.take_line(&px(self.track));
        self.path(pen, &panel);
        if let Some(plan) = self.plan {
            pen.line(&px(plan), Stroke::dashed(INK, 1.0, 5.0, 4.0));
        }
        self.marks(pen, &panel);
        self.vehicles(pen, &panel, &mut room);
        self.label_events(pen, &panel, &mut room);
        if let Some(plan) = self.plan {
            label_plan(pen, &px(plan), &mut room);
        }
    }

    /// A panel with both axes to the same scale, the path in the middle and room for the parachute at the
    /// top.
    fn panel(&self, (x0, y0): Point, (x1, y1): Point) -> Panel {
        let tracks = || std::iter::once(self.track).chain(self.plan);
        let all = |f: fn(&super::track::TrackPoint) -> f64| {
            range(tracks().flat_map(|t| t.instants.iter().map(f))).unwrap_or((0.0, 1.0))
        };
        let (north, down) = (all(|i| i.north_m), all(|i| i.down_m));
        let margin = 0.5 * glyph::VEHICLE_PX + 6.0;
        let top = if self.parachute { glyph::PARACHUTE_PX + 8.0 } else { margin };
        let (width, height) = (x1 - x0 - 2.0 * margin, y1 - y0 - top - margin);
        let m_per_px = ((north.1 - north.0) / width).max((down.1 - down.0) / height).max(1e-3);
        let left = 0.5 * (north.0 + north.1) - 0.5 * (x1 - x0) * m_per_px;
        let upper = down.0 - (top + 0.5 * (height - (down.1 - down.0) / m_per_px)) * m_per_px;
        Panel {
            x: Axis { low: left, high: left + (x1 - x0) * m_per_px, low_px: x0, high_px: x1 },
            y: Axis { low: upper, high: upper + (y1 - y0) * m_per_px, low_px: y0, high_px: y1 },
        }
    }

    /// Draws the path, a line for each run of one colour.
    fn path(&self, pen: &mut Pen<'_>, panel: &Panel) {
        let released_s = self.track.release_s.unwrap_or(f64::NEG_INFINITY);
        let hang: Vec<Point> = (self.track.instants.iter())
            .filter(|i| i.t_s <= released_s)
            .map(|i| panel.px(i.north_m, i.down_m))
            .collect();
        pen.line(&hang, Stroke::dashed(SMALL.color, 1.2, 2.0, 3.0));
        let points: Vec<(Point, usize)> = (self.track.instants.iter())
            .filter(|i| i.t_s >= released_s)
            .map(|i| (panel.px(i.north_m, i.down_m), self.scale.step(i.j_state)))
            .collect();
        let all: Vec<Point> = points.iter().map(|p| p.0).collect();
        // A dark rim makes the bright end of the map stand out from the paper.
        pen.line(&all, Stroke::solid((0x66, 0x66, 0x66), PATH_PX + 1.2));
        colored(pen, &points, PATH_PX);
    }

    fn marks(&self, pen: &mut Pen<'_>, panel: &Panel) {
        let end_s = self.track.span_s().map_or(0.0, |s| s.1);
        for k in 0..1000 {
            let t_s = f64::from(k) * MARK_INTERVAL_S;
            let Some(i) = self.track.at(t_s).filter(|_| t_s <= end_s) else { break };
            pen.disc(panel.px(i.north_m, i.down_m), 2.6, INK);
            pen.disc(panel.px(i.north_m, i.down_m), 1.7, WHITE);
        }
    }

    /// Draws the vehicle every few seconds, with the time beside it.
    fn vehicles(&self, pen: &mut Pen<'_>, panel: &Panel, room: &mut Room) {
        let Some((start_s, end_s)) = self.track.span_s() else { return };
        if self.parachute
            && let Some(first) = self.track.instants.first()
        {
            let at = panel.px(first.north_m, first.down_m);
            glyph::parachute(pen, at);
            glyph::vehicle(pen, at, first.pitch_rad);
            room.take(Place::around((at.0, at.1 - 16.0), glyph::VEHICLE_PX, 64.0));
        }
        let interval_s = vehicle_interval_s(end_s - start_s.max(0.0));
        let chosen = (1..100).map(|k| f64::from(k) * interval_s).take_while(|t| *t <= end_s);
        let chosen: Vec<_> = chosen.filter_map(|t| self.track.at(t).map(|i| (t, i))).collect();
        for (_, i) in &chosen {
            let at = panel.px(i.north_m, i.down_m);
            glyph::vehicle(pen, at, i.pitch_rad);
            room.take(Place::around(at, 36.0, 20.0));
        }
        for (t_s, i) in &chosen {
            let text = format!("{} s", number(*t_s, if interval_s < 1.0 { 1 } else { 0 }));
            let size = (text_width(&text, SMALL.size), 14.0);
            let (x, y) = panel.px(i.north_m, i.down_m);
            let beside = [(-1.0, 0.0), (1.0, 0.0), (-1.0, 10.0), (1.0, -10.0), (-1.0, 20.0), (1.0, -20.0)]
                .map(|(side, dy)| Place::around((x + side * (27.0 + 0.5 * size.0), y + dy), size.0, size.1));
            if let Some(place) = room.best(beside) {
                pen.text(&text, place.centre(), Anchor::Middle, SMALL);
            }
        }
    }

    fn label_events(&self, pen: &mut Pen<'_>, panel: &Panel, room: &mut Room) {
        for event in &self.events {
            let Some(i) = self.track.at(event.t_s) else { continue };
            let at = panel.px(i.north_m, i.down_m);
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
            let right = place.x0 > at.0;
            let edge = (if right { place.x0 - 3.0 } else { place.x1 + 3.0 }, place.centre().1);
            pen.line(&[at, edge], Stroke::solid(INK, 0.8));
            pen.disc(at, if event.strong { 5.0 } else { 3.6 }, INK);
            pen.disc(at, if event.strong { 3.4 } else { 2.4 }, self.scale.color(i.j_state));
            let start = (if right { place.x0 } else { place.x1 }, place.centre().1);
            let anchor = if right { Anchor::Start } else { Anchor::End };
            pen.text(&event.text, start, anchor, font);
        }
    }
}

/// Names the dashed line of the plan, somewhere along it.
fn label_plan(pen: &mut Pen<'_>, line: &[Point], room: &mut Room) {
    let (w, n) = (text_width("planned path", SMALL.size), line.len());
    let stations = [12, 10, 8, 14, 6, 16].map(|k| line.get(k * n / 20)).into_iter().flatten();
    let candidates = stations.flat_map(|p| [10.0, 22.0].map(|dx| (p, dx))).map(|((x, y), dx)| {
        let place = Place::around((x + dx + 0.5 * w, y - dx), w, 14.0);
        (place, (*x, *y))
    });
    let candidates: Vec<_> = candidates.collect();
    if let Some(place) = room.best(candidates.iter().map(|c| c.0))
        && let Some((_, from)) = candidates.iter().find(|c| c.0 == place)
    {
        let (x, y) = (place.x0 - 2.0, place.centre().1);
        pen.line(&[*from, (x, y)], Stroke::solid(SMALL.color, 0.6));
        pen.text("planned path", (place.x0, y), Anchor::Start, SMALL);
    }
}

/// Time between two drawn vehicles [s], for about seven in all.
pub(crate) fn vehicle_interval_s(duration_s: f64) -> f64 {
    round_step((duration_s / 9.0).max(0.1))
}

/// Draws a line for each run of points of one colour.
pub(crate) fn colored(pen: &mut Pen<'_>, points: &[(Point, usize)], width: f64) {
    let mut start = 0;
    while start + 1 < points.len() {
        let step = points[start].1;
        let run = points[start..].iter().take_while(|p| p.1 == step).count();
        // A run ends where the next one begins.
        let end = (start + run + 1).min(points.len());
        let line: Vec<Point> = points[start..end].iter().map(|p| p.0).collect();
        pen.line(&line, Stroke::solid(ColorScale::color_of_step(step), width));
        start += run;
    }
}

/// Draws the bar that explains the colours of J with that subscript, its right end at `right`.
pub(crate) fn color_bar(pen: &mut Pen<'_>, scale: &ColorScale, subscript: &str, (right, y): Point) {
    const WIDTH_PX: f64 = 150.0;
    let axis = Axis { low: scale.low, high: scale.high, low_px: right - WIDTH_PX, high_px: right };
    let mut colors = scale.colors().peekable();
    while let Some((from, color)) = colors.next() {
        let to = colors.peek().map_or(scale.high, |c| c.0);
        // A little too wide, so that no seam shows between colours.
        pen.rectangle((axis.px(from), y), ((axis.px(to) + 0.6).min(right), y + 9.0), color);
    }
    for (tick, text) in axis.ticks(4) {
        pen.line(&[(axis.px(tick), y + 9.0), (axis.px(tick), y + 12.0)], Stroke::solid(SMALL.color, 1.0));
        pen.text(&text, (axis.px(tick), y + 20.0), Anchor::Middle, SMALL);
    }
    pen.text(&sub("J", subscript), (axis.low_px - 8.0, y + 4.5), Anchor::End, TITLE);
}
