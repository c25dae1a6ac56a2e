//! A column of panels over time: velocities, pitch, pitch rate, thrusts and J_state, each with its limit;
//! with what is out of the plane (east, roll, roll rate) where there is any, and the bus where the battery
//! has a voltage.

use super::axis::{Axis, Panel, SMALL, TITLE, range, short};
use super::canvas::{Anchor, Font, Pen, Point, Stroke, sub, text_width};
use super::color::{BAND, FIRST, INK, LIMIT, LINES, Rgb, SECOND, SOFT_INK, THIRD, cost_color, cost_step};
use super::flight_path::rimmed;
use super::label::{LabelPlace, Room};
use super::rotors::rotor_groups;
use super::sheet::Sheet;
use super::track::{Track, TrackPoint};
use samara_core::units::DEG_PER_RAD;

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

/// A line of a panel: a quantity over time.
struct Line {
    name: String,
    color: Rgb,
    of: Box<dyn Fn(&TrackPoint) -> f64>,
    target: Option<f64>,
}

impl Line {
    fn new(name: &str, color: Rgb, of: impl Fn(&TrackPoint) -> f64 + 'static) -> Self {
        Self { name: name.to_owned(), color, of: Box::new(of), target: None }
    }

    fn stroke(&self) -> Stroke {
        // The first line shows at both sides of a second one that covers it.
        Stroke::solid(self.color, if self.color == FIRST { 2.2 } else { 1.6 })
    }
}

/// A panel that has no place yet.
struct Quantity {
    title: &'static str,
    lines: Vec<Line>,
    limit: Option<f64>,
    limit_name: &'static str,
    both_ways: bool,
}

fn quantities(sheet: &Sheet<'_>) -> Vec<Quantity> {
    let (mission, limits) = (sheet.mission, &sheet.mission.limits.safety);
    // What is out of the plane is shown where there is any.
    let rolls = sheet.track.rolls();
    let target_v_ned = mission.target_v_ned;
    let target = |line: Line, v: f64| Line { target: Some(v), ..line };
    let mut velocities = vec![
        target(Line::new("north", FIRST, |i| i.v_ned.x), target_v_ned.x),
        target(Line::new("down", SECOND, |i| i.v_ned.z), target_v_ned.z),
    ];
    if target_v_ned.y != 0.0 || sheet.track.reaches(EAST_SHOWN_M_S, |i| i.v_ned.y) {
        velocities.push(target(Line::new("east", THIRD, |i| i.v_ned.y), target_v_ned.y));
    }
    type Angle = fn(&TrackPoint) -> f64;
    let turn = |[title, with_roll]: [&'static str; 2], pitch: Angle, roll: Angle, limit_rad: f64| Quantity {
        title: if rolls { with_roll } else { title },
        lines: if rolls {
            vec![Line::new("pitch", FIRST, pitch), Line::new("roll", SECOND, roll)]
        } else {
            vec![Line::new("", FIRST, pitch)]
        },
        limit: Some(limit_rad * DEG_PER_RAD),
        limit_name: "limit",
        both_ways: true,
    };
    let mut all = vec![
        Quantity {
            title: "velocity [m/s]",
            lines: velocities,
            limit: None,
            limit_name: "limit",
            both_ways: false,
        },
        turn(
            ["pitch [deg]", "pitch and roll [deg]"],
            |i| i.pitch_rad * DEG_PER_RAD,
            |i| i.roll_rad * DEG_PER_RAD,
            limits.pitch_rad,
        ),
        turn(
            ["pitch rate [deg/s]", "pitch and roll rate [deg/s]"],
            |i| i.pitch_rate_rad_s * DEG_PER_RAD,
            |i| i.roll_rate_rad_s * DEG_PER_RAD,
            limits.pitch_rate_rad_s,
        ),
        Quantity {
            title: "thrust per rotor [N]",
            lines: thrusts(sheet),
            limit: Some(mission.plan.thrust_max_n),
            limit_name: "plan's limit",
            both_ways: false,
        },
    ];
    let pack = mission.electric.as_ref().map(|battery| battery.pack().limits());
    if let Some(pack) = pack.filter(|_| sheet.track.instants.iter().any(|i| i.bus.is_some())) {
        all.push(Quantity {
            title: "pack current [A], bus voltage [V]",
            lines: vec![
                Line::new("current", FIRST, |i| i.bus.map_or(f64::NAN, |bus| bus.1)),
                Line::new("voltage", SECOND, |i| i.bus.map_or(f64::NAN, |bus| bus.0)),
            ],
            limit: Some(pack.current_max_a).filter(|limit_a| limit_a.is_finite()),
            limit_name: "limit of the current",
            both_ways: false,
        });
    }
    all
}

/// A line for each group of rotors whose thrusts run together: their mean.
fn thrusts(sheet: &Sheet<'_>) -> Vec<Line> {
    let groups = rotor_groups(sheet.mission, sheet.track);
    let line = |(color, group): (&Rgb, super::rotors::RotorGroup)| {
        let rotors = group.rotors;
        Line::new(&group.name, *color, move |i| {
            rotors.iter().map(|k| i.thrust_n[*k]).sum::<f64>() / rotors.len() as f64
        })
    };
    LINES.iter().cycle().zip(groups).map(line).collect()
}

/// Draws the panels between two corners.
pub(crate) fn draw(pen: &mut Pen<'_>, sheet: &Sheet<'_>, ((x0, y0), (x1, y1)): (Point, Point)) {
    // A flight that was broken off is shorter than its plan.
    let spans = [Some(sheet.track), sheet.plan].into_iter().flatten().filter_map(Track::span_s);
    let Some((from_s, to_s)) = spans.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else { return };
    let time = Axis::new((from_s, to_s.max(from_s + 1e-3)), (x0, x1));
    let quantities = quantities(sheet);
    let n = quantities.len();
    let height = (y1 - y0 - n as f64 * PANEL_GAP_PX) / (n + 1) as f64;
    let top = |row: usize| y0 + row as f64 * (height + PANEL_GAP_PX);
    for (row, quantity) in quantities.iter().enumerate() {
        draw_quantity(pen, sheet, time, (top(row), top(row) + height), quantity);
    }
    draw_cost(pen, sheet, time, (top(n), top(n) + height));
    let label = if sheet.track.since_free { "time since the rotors were freed [s]" } else { "time [s]" };
    pen.text(label, (0.5 * (x0 + x1), y1 + 32.0), Anchor::Center, TITLE);
    draw_key(pen, sheet, (x1, y0 - 14.0));
}

/// Explains the kinds of line, ending at `right`.
fn draw_key(pen: &mut Pen<'_>, sheet: &Sheet<'_>, (right, y): (f64, f64)) {
    let flown = sheet.plan.is_some() || sheet.track.release_s.is_some() || !sheet.track.since_free;
    let main = if flown { "flown" } else { "planned" };
    let kinds = [(main, Stroke::solid(SOFT_INK, 2.0)), ("plan", PLAN), ("target", TARGET)];
    let mut x = right;
    for (name, stroke) in kinds.iter().rev().filter(|k| k.0 != "plan" || sheet.plan.is_some()) {
        pen.text(name, (x, y), Anchor::Right, SMALL);
        x -= text_width(name, SMALL.size) + 5.0;
        pen.line(&[(x - 24.0, y), (x, y)], *stroke);
        x -= 24.0 + 14.0;
    }
}

/// The upright line at the plan's end.
fn plan_end(sheet: &Sheet<'_>, panel: &Panel) -> Option<[Point; 2]> {
    let end_s = sheet.plan_end_s.filter(|end_s| *end_s <= panel.x.high)?;
    let ((_, y0), (_, y1)) = panel.corners();
    Some([(panel.x.px(end_s), y0), (panel.x.px(end_s), y1)])
}

/// Draws what is behind the curves; returns the room for labels in the panel and a little above it.
fn frame(pen: &mut Pen<'_>, sheet: &Sheet<'_>, panel: &Panel, title: &str, last: bool) -> Room {
    let ((x0, y0), (x1, y1)) = panel.corners();
    if let Some(release_s) = sheet.track.release_s {
        let zero = panel.x.px(0.0_f64.min(panel.x.high));
        pen.rectangle((panel.x.px(release_s.max(panel.x.low)), y0), (zero, y1), BAND);
    }
    panel.grid(pen, 8, 4, last);
    let mut room = Room::new(((x0, y0 - 9.0), (x1, y1)));
    if let Some(line) = plan_end(sheet, panel) {
        room.line(pen, &line, Stroke::solid(PLAN_END, 1.0));
    }
    pen.text(title, (x0 - TITLE_LEFT_PX, y0 - TITLE_ABOVE_PX), Anchor::Left, TITLE);
    room
}

fn draw_quantity(pen: &mut Pen<'_>, sheet: &Sheet<'_>, time: Axis, (y0, y1): (f64, f64), q: &Quantity) {
    let curves =
        |track: &Track| -> Vec<Vec<(f64, f64)>> { q.lines.iter().map(|l| track.curve(&l.of)).collect() };
    // A plan knows no bus.
    let planned = |track: &Track| -> Vec<Vec<(f64, f64)>> {
        curves(track).into_iter().filter(|curve| curve.iter().any(|p| !p.1.is_nan())).collect()
    };
    let (flown, planned) = (curves(sheet.track), sheet.plan.map(planned).unwrap_or_default());
    let values = flown.iter().chain(&planned).flatten().map(|p| p.1);
    let (low, high) = range(values.chain(q.lines.iter().filter_map(|l| l.target))).unwrap_or((0.0, 1.0));
    let above = q.limit.filter(|limit| high >= NEAR_LIMIT * limit);
    let below = q.limit.filter(|limit| q.both_ways && low <= -NEAR_LIMIT * limit).map(|limit| -limit);
    let (low, high) = (below.map_or(low, |l| low.min(l)), above.map_or(high, |l| high.max(l)));
    // What rests is drawn as resting: its rounding is not blown up.
    let least = 0.02 * q.limit.unwrap_or(10.0);
    let margin = (0.08 * (high - low)).max(0.5 * (least - (high - low)));
    let panel = Panel { x: time, y: Axis::new((low - margin, high + margin), (y1, y0)) };
    let mut title = q.title.to_owned();
    if let (Some(limit), None, None) = (q.limit, above, below) {
        let sign = if q.both_ways { "\u{b1}" } else { "" };
        title += &format!(", {} {sign}{}", q.limit_name, short(limit));
    }
    let mut room = frame(pen, sheet, &panel, &title, false);
    let width = text_width(&title, TITLE.size);
    let title_left = panel.x.low_px - TITLE_LEFT_PX;
    room.take(LabelPlace::around((title_left + 0.5 * width, y0 - TITLE_ABOVE_PX), width, 16.0));
    let px = |curve: &[(f64, f64)]| -> Vec<Point> { curve.iter().map(|p| panel.px(p.0, p.1)).collect() };
    for (line, curve) in q.lines.iter().zip(&flown) {
        if let Some(target) = line.target {
            let steady = [panel.px(time.low.max(0.0), target), panel.px(time.high, target)];
            room.line(pen, &steady, TARGET);
        }
        room.line(pen, &px(curve), line.stroke());
    }
    for curve in &planned {
        room.line(pen, &px(curve), PLAN);
    }
    for limit in above.iter().chain(&below) {
        limit_line(pen, &panel, *limit, q.limit_name, &mut room);
    }
    for (line, curve) in q.lines.iter().zip(&flown) {
        name_line(pen, &px(curve), (&line.name, line.color), &mut room);
    }
    // The plan's end is named once, in the panel without a limit.
    if q.limit.is_none()
        && let Some([(x, _), _]) = plan_end(sheet, &panel)
    {
        let w = text_width("plan ends", SMALL.size);
        let aside = 0.5 * w + 5.0;
        let candidates = [0.12, 0.3, 0.5, 0.7, 0.88].into_iter().flat_map(|share| {
            [-aside, aside].map(|dx| LabelPlace::around((x + dx, y0 + share * (y1 - y0)), w, 13.0))
        });
        room.write(pen, ("plan ends", SMALL), candidates);
    }
}

fn draw_cost(pen: &mut Pen<'_>, sheet: &Sheet<'_>, time: Axis, (y0, y1): (f64, f64)) {
    let costs = sheet.track.curve(|i| i.j_state);
    let highest = range(costs.iter().map(|p| p.1)).map_or(1.0, |r| r.1.max(1.0));
    let panel = Panel { x: time, y: Axis::new((0.0, 1.08 * highest), (y1, y0)) };
    let mut room = frame(pen, sheet, &panel, &sub("J", "state"), true);
    let points: Vec<_> = costs.iter().map(|p| (panel.px(p.0, p.1), cost_step(p.1))).collect();
    rimmed(pen, &points, (3.4, 2.4));
    room.take_points(&points);
    limit_line(pen, &panel, 1.0, "limit", &mut room);
    if let Some(plan) = sheet.plan {
        let line: Vec<Point> = plan.curve(|i| i.j_state).iter().map(|p| panel.px(p.0, p.1)).collect();
        room.line(pen, &line, PLAN);
    }
    if let (Some(worst), Some(j_tpf)) = (sheet.track.riskiest(), sheet.j_tpf) {
        let at = panel.px(worst.t_s, worst.j_state);
        pen.dot(at, (4.4, 2.8), cost_color(worst.j_state));
        let text = format!("{} {:.3}", sub("J", "TPF"), j_tpf);
        let w = text_width(&text, TITLE.size);
        let aside = 0.5 * w + 9.0;
        let around =
            [(aside, -11.0), (aside, 12.0), (aside, 0.0), (-aside, -11.0), (0.0, -16.0), (0.0, 18.0)]
                .into_iter()
                .chain((1..6).map(|k| (aside + 8.0 * f64::from(k), 0.0)))
                .map(|(dx, dy)| LabelPlace::around((at.0 + dx, at.1 + dy), w, 15.0));
        room.write(pen, (&text, Font { bold: true, ..TITLE }), around);
    }
}

/// Draws a limit across the panel and names it where there is room, rather at the right.
fn limit_line(pen: &mut Pen<'_>, panel: &Panel, limit: f64, name: &str, room: &mut Room) {
    let line = [panel.px(panel.x.low, limit), panel.px(panel.x.high, limit)];
    room.line(pen, &line, Stroke::dashed(LIMIT, 1.2, 8.0, 3.0));
    let text = format!("{name} {}", short(limit));
    let w = text_width(&text, SMALL.size);
    let (left, right) = (panel.x.low_px + 0.5 * w + 2.0, panel.x.high_px - 0.5 * w - 2.0);
    let candidates = (0..=12).map(|k| right + (left - right) * f64::from(k) / 12.0).flat_map(|x| {
        // On the inner side of the limit first.
        let inwards = if limit < 0.0 { -9.0 } else { 9.0 };
        [inwards, -inwards].map(|dy| LabelPlace::around((x, line[0].1 + dy), w, 13.0))
    });
    room.write(pen, (&text, Font { color: LIMIT, ..SMALL }), candidates);
}

/// Writes a line's name beside it, where there is room.
fn name_line(pen: &mut Pen<'_>, curve: &[Point], (name, color): (&str, Rgb), room: &mut Room) {
    let (w, h) = (text_width(name, TITLE.size), 14.0);
    let n = curve.len();
    if name.is_empty() || n == 0 {
        return;
    }
    let stations = (3..32).map(|k| curve[k * (n - 1) / 32]);
    let candidates = stations.filter(|p| p.0.is_finite() && p.1.is_finite()).flat_map(|(x, y)| {
        let aside = 0.5 * w + 7.0;
        [(0.0, -11.0), (0.0, 11.0), (aside, 3.0), (-aside, -3.0)]
            .map(|(dx, dy)| LabelPlace::around((x + dx, y + dy), w, h))
    });
    room.write(pen, (name, Font { color, bold: true, ..TITLE }), candidates);
}
