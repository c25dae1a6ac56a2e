//! A column of panels over time: velocities, pitch, pitch rate, thrusts and J_state, each with its limit;
//! with what is out of the plane (east, roll, roll rate) where there is any.

use nalgebra::Vector3;

use super::axis::{Axis, Panel, SMALL, TITLE, range, short};
use super::canvas::{Anchor, Font, Pen, Point, Stroke, sub, text_width};
use super::color::{BAND, ColorScale, FIRST, INK, Rgb, SECOND, SOFT_INK, THIRD};
use super::flight_path::colored;
use super::label::{Place, Room};
use super::panel_names::{limit_line, name_line};
use super::track::{Track, TrackPoint};
use crate::assess::SafetyLimits;
use crate::units::DEG_PER_RAD;

/// Least east velocity that is shown [m/s].
const EAST_SHOWN_M_S: f64 = 0.005;
const PANEL_GAP_PX: f64 = 27.0;
/// Distance of a panel's title from its left edge [px].
const TITLE_LEFT_PX: f64 = 34.0;
const TITLE_ABOVE_PX: f64 = 12.0;
/// A limit is drawn when the flight comes within this fraction of it; else it is only named.
const NEAR_LIMIT: f64 = 0.3;
const PLAN: Stroke = Stroke { color: INK, width: 1.0, dash: Some((5.0, 4.0)) };
const PLAN_END: Rgb = (0xA8, 0xA8, 0xA8);
const TARGET: Stroke = Stroke { color: SOFT_INK, width: 1.0, dash: Some((1.0, 3.0)) };

/// A column of panels over time.
pub(crate) struct TimePanels<'a> {
    pub(crate) track: &'a Track,
    pub(crate) plan: Option<&'a Track>,
    /// Steady velocity to reach, NED [m/s].
    pub(crate) target_v_ned: Vector3<f64>,
    pub(crate) limits: &'a SafetyLimits,
    /// The plan's limit on a rotor's thrust [N].
    pub(crate) thrust_max_n: f64,
    pub(crate) scale: ColorScale,
    /// Highest J_state; `None` for a flight that is not judged.
    pub(crate) j_tpf: Option<f64>,
}

/// A line of a panel: a quantity over time.
struct Line {
    name: &'static str,
    color: Rgb,
    width: f64,
    of: Box<dyn Fn(&TrackPoint) -> f64>,
    target: Option<f64>,
}

impl Line {
    fn new(name: &'static str, color: Rgb, of: impl Fn(&TrackPoint) -> f64 + 'static) -> Self {
        // The first line shows at both sides of a second one that covers it.
        let width = if color == FIRST { 2.2 } else { 1.6 };
        Self { name, color, width, of: Box::new(of), target: None }
    }
}

/// A panel that has no place yet.
struct Quantity {
    title: &'static str,
    unit: &'static str,
    lines: Vec<Line>,
    limit: Option<f64>,
    limit_name: &'static str,
    both_ways: bool,
}

impl TimePanels<'_> {
    fn quantities(&self) -> [Quantity; 4] {
        let limits = self.limits;
        let target = |line: Line, v: f64| Line { target: Some(v), ..line };
        // What is out of the plane is shown where there is any.
        let rolls = self.track.rolls();
        let drifts = self.target_v_ned.y != 0.0 || self.track.reaches(EAST_SHOWN_M_S, |i| i.v_ned.y);
        let east = drifts.then(|| target(Line::new("east", THIRD, |i| i.v_ned.y), self.target_v_ned.y));
        let name = |name: &'static str| if rolls { name } else { "" };
        let also = |line: Line| rolls.then_some(line).into_iter();
        let roll = also(Line::new("roll", SECOND, |i| i.roll_rad * DEG_PER_RAD));
        let roll_rate = also(Line::new("roll", SECOND, |i| i.roll_rate_rad_s * DEG_PER_RAD));
        [
            Quantity {
                title: "velocity",
                unit: "m/s",
                lines: [
                    target(Line::new("north", FIRST, |i| i.v_ned.x), self.target_v_ned.x),
                    target(Line::new("down", SECOND, |i| i.v_ned.z), self.target_v_ned.z),
                ]
                .into_iter()
                .chain(east)
                .collect(),
                limit: None,
                limit_name: "limit",
                both_ways: false,
            },
            Quantity {
                title: if rolls { "pitch and roll" } else { "pitch" },
                unit: "deg",
                lines: std::iter::once(Line::new(name("pitch"), FIRST, |i| i.pitch_rad * DEG_PER_RAD))
                    .chain(roll)
                    .collect(),
                limit: Some(limits.pitch_rad * DEG_PER_RAD),
                limit_name: "limit",
                both_ways: true,
            },
            Quantity {
                title: if rolls { "pitch and roll rate" } else { "pitch rate" },
                unit: "deg/s",
                lines: std::iter::once(Line::new(name("pitch"), FIRST, |i| i.pitch_rate_rad_s * DEG_PER_RAD))
                    .chain(roll_rate)
                    .collect(),
                limit: Some(limits.pitch_rate_rad_s * DEG_PER_RAD),
                limit_name: "limit",
                both_ways: true,
            },
            Quantity {
                title: "thrust per rotor",
                unit: "N",
                lines: vec![
                    Line::new("front", FIRST, |i| i.front_n),
                    Line::new("rear", SECOND, |i| i.rear_n),
                ],
                limit: Some(self.thrust_max_n),
                limit_name: "plan's limit",
                both_ways: false,
            },
        ]
    }

    /// Draws the panels between two corners.
    pub(crate) fn draw(&self, pen: &mut Pen<'_>, (x0, y0): Point, (x1, y1): Point) {
        // A flight that was broken off is shorter than its plan.
        let spans = [Some(self.track), self.plan].into_iter().flatten().filter_map(Track::span_s);
        let Some((from_s, to_s)) = spans.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else { return };
        let time = Axis { low: from_s, high: to_s.max(from_s + 1e-3), low_px: x0, high_px: x1 };
        let height = (y1 - y0 - 4.0 * PANEL_GAP_PX) / 5.0;
        let top = |row: usize| y0 + row as f64 * (height + PANEL_GAP_PX);
        for (row, quantity) in self.quantities().iter().enumerate() {
            self.quantity(pen, time, (top(row), top(row) + height), quantity);
        }
        self.cost(pen, time, (top(4), top(4) + height));
        let label = if self.track.since_free { "time since the rotors were freed [s]" } else { "time [s]" };
        pen.text(label, (0.5 * (x0 + x1), y1 + 32.0), Anchor::Middle, TITLE);
        self.key(pen, (x1, y0 - 14.0));
    }

    /// Explains the kinds of line, ending at `right`.
    fn key(&self, pen: &mut Pen<'_>, (right, y): Point) {
        let flown = self.plan.is_some() || self.track.release_s.is_some() || !self.track.since_free;
        let main = if flown { "flown" } else { "planned" };
        let kinds = [(main, Stroke::solid(SOFT_INK, 2.0)), ("plan", PLAN), ("target", TARGET)];
        let mut x = right;
        for (name, stroke) in kinds.iter().rev().filter(|k| k.0 != "plan" || self.plan.is_some()) {
            pen.text(name, (x, y), Anchor::End, SMALL);
            x -= text_width(name, SMALL.size) + 5.0;
            pen.line(&[(x - 24.0, y), (x, y)], *stroke);
            x -= 24.0 + 14.0;
        }
    }

    fn frame(&self, pen: &mut Pen<'_>, panel: &Panel, title: &str, last: bool) {
        let ((x0, y0), (_, y1)) = panel.corners();
        if let Some(release_s) = self.track.release_s {
            let zero = panel.x.px(0.0_f64.min(panel.x.high));
            pen.rectangle((panel.x.px(release_s.max(panel.x.low)), y0), (zero, y1), BAND);
        }
        panel.grid(pen, 8, 4, last);
        if let Some((_, end_s)) = self.plan.and_then(Track::span_s) {
            let x = panel.x.px(end_s);
            pen.line(&[(x, y0), (x, y1)], Stroke::solid(PLAN_END, 1.0));
        }
        pen.text(title, (x0 - TITLE_LEFT_PX, y0 - TITLE_ABOVE_PX), Anchor::Start, TITLE);
    }

    fn quantity(&self, pen: &mut Pen<'_>, time: Axis, (y0, y1): (f64, f64), q: &Quantity) {
        let curves =
            |track: &Track| -> Vec<Vec<(f64, f64)>> { q.lines.iter().map(|l| track.curve(&l.of)).collect() };
        let (flown, planned) = (curves(self.track), self.plan.map(curves).unwrap_or_default());
        let values = flown.iter().chain(&planned).flatten().map(|p| p.1);
        let (low, high) = range(values.chain(q.lines.iter().filter_map(|l| l.target))).unwrap_or((0.0, 1.0));
        let above = q.limit.filter(|limit| high >= NEAR_LIMIT * limit);
        let below = q.limit.filter(|limit| q.both_ways && low <= -NEAR_LIMIT * limit).map(|limit| -limit);
        let (low, high) = (below.map_or(low, |l| low.min(l)), above.map_or(high, |l| high.max(l)));
        // What rests is drawn as resting: its rounding is not blown up.
        let least = 0.02 * q.limit.unwrap_or(10.0);
        let margin = (0.08 * (high - low)).max(0.5 * (least - (high - low)));
        let y = Axis { low: low - margin, high: high + margin, low_px: y1, high_px: y0 };
        let panel = Panel { x: time, y };
        let title = match q.limit {
            Some(limit) if above.is_none() && below.is_none() => {
                let sign = if q.both_ways { "\u{b1}" } else { "" };
                format!("{} [{}], {} {sign}{}", q.title, q.unit, q.limit_name, short(limit))
            }
            _ => format!("{} [{}]", q.title, q.unit),
        };
        self.frame(pen, &panel, &title, false);
        let mut room = self.room(&panel);
        let ((x0, _), _) = panel.corners();
        let width = text_width(&title, TITLE.size);
        room.take(Place::around((x0 - TITLE_LEFT_PX + 0.5 * width, y0 - TITLE_ABOVE_PX), width, 16.0));
        let px = |curve: &[(f64, f64)]| -> Vec<Point> { curve.iter().map(|p| panel.px(p.0, p.1)).collect() };
        for (line, curve) in q.lines.iter().zip(&flown) {
            if let Some(target) = line.target {
                let steady = [panel.px(time.low.max(0.0), target), panel.px(time.high, target)];
                pen.line(&steady, TARGET);
                room.take_line(&steady);
            }
            pen.line(&px(curve), Stroke::solid(line.color, line.width));
            room.take_line(&px(curve));
        }
        for curve in &planned {
            pen.line(&px(curve), PLAN);
            room.take_line(&px(curve));
        }
        for limit in above.iter().chain(&below) {
            limit_line(pen, &panel, *limit, q.limit_name, &mut room);
        }
        for (line, curve) in q.lines.iter().zip(&flown) {
            name_line(pen, &px(curve), (line.name, line.color), &mut room);
        }
        if q.limit.is_none() {
            self.name_plan_end(pen, &panel, &mut room);
        }
    }

    /// Room for labels in a panel, and a little above it.
    fn room(&self, panel: &Panel) -> Room {
        let ((x0, y0), corner) = panel.corners();
        let mut room = Room::new((x0, y0 - 9.0), corner);
        if let Some((_, end_s)) = self.plan.and_then(Track::span_s) {
            room.take_line(&[(panel.x.px(end_s), y0), (panel.x.px(end_s), corner.1)]);
        }
        room
    }

    /// Names the upright line once, in the panel without a limit.
    fn name_plan_end(&self, pen: &mut Pen<'_>, panel: &Panel, room: &mut Room) {
        let Some((_, end_s)) = self.plan.and_then(Track::span_s) else { return };
        let ((_, y0), (_, y1)) = panel.corners();
        let (x, w) = (panel.x.px(end_s), text_width("plan ends", SMALL.size));
        let aside = 0.5 * w + 5.0;
        let candidates = [0.12, 0.3, 0.5, 0.7, 0.88].map(|f| y0 + f * (y1 - y0));
        let candidates = candidates
            .into_iter()
            .flat_map(|y| [-aside, aside].map(|dx| Place::around((x + dx, y), w, 13.0)));
        if let Some(place) = room.best(candidates) {
            pen.text("plan ends", place.centre(), Anchor::Middle, SMALL);
        }
    }

    fn cost(&self, pen: &mut Pen<'_>, time: Axis, (y0, y1): (f64, f64)) {
        let costs = self.track.curve(|i| i.j_state);
        let highest = range(costs.iter().map(|p| p.1)).map_or(1.0, |r| r.1.max(1.0));
        let panel = Panel { x: time, y: Axis { low: 0.0, high: 1.08 * highest, low_px: y1, high_px: y0 } };
        self.frame(pen, &panel, &sub("J", "state"), true);
        let points: Vec<(Point, usize)> =
            costs.iter().map(|p| (panel.px(p.0, p.1), self.scale.step(p.1))).collect();
        let line: Vec<Point> = points.iter().map(|p| p.0).collect();
        pen.line(&line, Stroke::solid((0x66, 0x66, 0x66), 3.4));
        colored(pen, &points, 2.4);
        let mut room = self.room(&panel);
        room.take_line(&line);
        limit_line(pen, &panel, 1.0, "limit", &mut room);
        if let Some(plan) = self.plan {
            let line: Vec<Point> = plan.curve(|i| i.j_state).iter().map(|p| panel.px(p.0, p.1)).collect();
            pen.line(&line, PLAN);
            room.take_line(&line);
        }
        if let (Some(worst), Some(j_tpf)) = (self.track.riskiest(), self.j_tpf) {
            let at = panel.px(worst.t_s, worst.j_state);
            pen.disc(at, 4.4, INK);
            pen.disc(at, 2.8, self.scale.color(worst.j_state));
            let text = format!("{} {:.3}", sub("J", "TPF"), j_tpf);
            let w = text_width(&text, TITLE.size);
            let aside = 0.5 * w + 9.0;
            let around =
                [(aside, -11.0), (aside, 12.0), (aside, 0.0), (-aside, -11.0), (0.0, -16.0), (0.0, 18.0)]
                    .into_iter()
                    .chain((1..6).map(|k| (aside + 8.0 * f64::from(k), 0.0)))
                    .map(|(dx, dy)| Place::around((at.0 + dx, at.1 + dy), w, 15.0));
            if let Some(place) = room.best(around) {
                pen.text(&text, place.centre(), Anchor::Middle, Font { bold: true, ..TITLE });
            }
        }
    }
}
