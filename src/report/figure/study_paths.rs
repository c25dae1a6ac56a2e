//! Figures 7 and 8: flight paths from the releases under study, two controllers beside each other in a panel,
//! coloured by J_state, marks every 1.56 s. The point of release is at (0, 0).

use super::axis::{Axis, Panel, SMALL, range};
use super::canvas::FigureError;
use super::canvas::{Anchor, Font, Pen, Point, Stroke, sub, text_width};
use super::color::{ColorScale, INK, SOFT_INK, WHITE};
use super::flight_path::{MARK_INTERVAL_S, color_bar};
use super::label::{Place, Room};
use super::study::{AXIS, StudyStyle, with_margin};
use crate::assess::TraceInstant;

const HEIGHT_PX: u32 = 640;
const TOP_PX: f64 = 118.0;
const BOTTOM_PX: f64 = 588.0;
/// Left edges of the panels [px].
const LEFT_PX: [f64; 2] = [62.0, 540.0];
const PANEL_PX: f64 = 404.0;
/// Dash, gap, dash, gap of the paths of a panel's two controllers [px].
const PATTERNS: [[f64; 4]; 2] = [[9.0, 4.0, 9.0, 4.0], [9.0, 3.0, 2.0, 3.0]];

/// The flights of one controller.
#[derive(Clone, Copy, Debug)]
pub struct PathGroup<'a> {
    /// Name of the controller.
    pub name: &'a str,
    /// One flight for each release.
    pub flights: &'a [Vec<TraceInstant>],
    /// J_TPF of each flight, over the whole flight.
    pub j_tpf: &'a [f64],
}

/// Draws two panels of two groups each; the first group of a panel is dashed, the second dash-dotted.
/// `until_s` cuts the flights off.
///
/// # Errors
/// [`FigureError`] when no position is finite or the backend fails.
pub fn paths_figure(
    style: &StudyStyle,
    title: &str,
    panels: [[PathGroup<'_>; 2]; 2],
    until_s: f64,
) -> Result<String, FigureError> {
    let remark = format!(
        "One path per release case, marks every {MARK_INTERVAL_S} s.{}",
        if until_s < style.end_s - 1e-9 { " The axis to the north is stretched." } else { "" }
    );
    let shown = |flight: &'_ [TraceInstant]| -> Vec<TraceInstant> {
        flight.iter().filter(|i| i.t_s <= until_s + 1e-9).copied().collect()
    };
    let all: Vec<Vec<TraceInstant>> =
        panels.iter().flatten().flat_map(|g| g.flights).map(|f| shown(f)).collect();
    let over = |of: fn(&TraceInstant) -> f64| range(all.iter().flatten().map(of)).ok_or(FigureError::Empty);
    let (north, down) = (over(|i| i.north_down_m.0)?, over(|i| i.north_down_m.1)?);
    style.sheet(HEIGHT_PX, title, &remark, |pen| {
        color_bar(pen, &style.j_state, "state", (LEFT_PX[1] + PANEL_PX, 40.0));
        for (groups, left) in panels.iter().zip(LEFT_PX) {
            let panel = panel(left, north, down);
            pen.text("altitude lost [m]", (left - 44.0, TOP_PX - 14.0), Anchor::Start, AXIS);
            pen.text("north [m]", (left + 0.5 * PANEL_PX, BOTTOM_PX + 34.0), Anchor::Middle, AXIS);
            panel.grid(pen, 6, 8, true);
            let mut room = Room::new(panel.corners().0, panel.corners().1);
            for (group, pattern) in groups.iter().zip(PATTERNS) {
                for flight in group.flights.iter().map(|f| shown(f)) {
                    path(pen, &panel, &flight, &style.j_state, pattern, &mut room);
                }
            }
            for (group, pattern) in groups.iter().zip(PATTERNS) {
                name(pen, &panel, group, until_s, pattern, &mut room);
            }
        }
    })
}

/// A panel with both axes to the same scale when the paths leave room for that; a figure of the first seconds
/// stretches north.
fn panel(left: f64, north: (f64, f64), down: (f64, f64)) -> Panel {
    let (mut n, mut d) = (with_margin(north, 0.06), with_margin(down, 0.06));
    d.1 += 0.10 * (d.1 - d.0);
    let (width, height) = (PANEL_PX, BOTTOM_PX - TOP_PX);
    let (per_px_n, per_px_d) = ((n.1 - n.0) / width, (d.1 - d.0) / height);
    if (0.5..2.0).contains(&(per_px_n / per_px_d)) {
        let per_px = per_px_n.max(per_px_d);
        n.1 = n.0 + per_px * width;
        d.1 = d.0 + per_px * height;
    }
    Panel {
        x: Axis { low: n.0, high: n.1, low_px: left, high_px: left + width },
        y: Axis { low: d.0, high: d.1, low_px: TOP_PX, high_px: BOTTOM_PX },
    }
}

fn path(
    pen: &mut Pen<'_>,
    panel: &Panel,
    flight: &[TraceInstant],
    scale: &ColorScale,
    pattern: [f64; 4],
    room: &mut Room,
) {
    let at = |i: &TraceInstant| panel.px(i.north_down_m.0, i.north_down_m.1);
    let points: Vec<(Point, usize)> = flight.iter().map(|i| (at(i), scale.step(i.j_state))).collect();
    let line: Vec<Point> = points.iter().map(|p| p.0).collect();
    room.take_line(&line);
    broken(pen, &points, pattern, 2.0);
    let end_s = flight.last().map_or(0.0, |i| i.t_s);
    for k in 0..1000 {
        let t_s = f64::from(k) * MARK_INTERVAL_S;
        let Some(i) = flight.iter().find(|i| i.t_s >= t_s - 1e-9).filter(|_| t_s <= end_s + 1e-9) else {
            break;
        };
        pen.disc(at(i), 2.4, INK);
        pen.disc(at(i), 1.5, WHITE);
    }
}

/// Draws a broken line with a colour for each point.
fn broken(pen: &mut Pen<'_>, points: &[(Point, usize)], pattern: [f64; 4], width: f64) {
    let period: f64 = pattern.iter().sum();
    let mut length = 0.0;
    let mut run: Vec<Point> = Vec::new();
    let mut color = None;
    for pair in points.windows(2) {
        let ((a, step), (b, _)) = (pair[0], pair[1]);
        let place = length % period;
        let drawn = place < pattern[0]
            || (pattern[0] + pattern[1]..pattern[0] + pattern[1] + pattern[2]).contains(&place);
        if color != drawn.then_some(step) {
            if let Some(step) = color {
                pen.line(&run, Stroke::solid(ColorScale::color_of_step(step), width));
            }
            run.clear();
            run.push(a);
            color = drawn.then_some(step);
        }
        run.push(b);
        let piece = (b.0 - a.0).hypot(b.1 - a.1);
        length += if piece.is_finite() { piece } else { 0.0 };
    }
    if let Some(step) = color {
        pen.line(&run, Stroke::solid(ColorScale::color_of_step(step), width));
    }
}

/// Names a group at the lower end of its paths, with the lowest and highest J_TPF.
fn name(
    pen: &mut Pen<'_>,
    panel: &Panel,
    group: &PathGroup<'_>,
    until_s: f64,
    pattern: [f64; 4],
    room: &mut Room,
) {
    let ends = group.flights.iter().filter_map(|f| f.iter().rfind(|i| i.t_s <= until_s + 1e-9));
    let Some((x, y)) = ends
        .map(|i| panel.px(i.north_down_m.0, i.north_down_m.1))
        .reduce(|a, b| if b.1 > a.1 { b } else { a })
    else {
        return;
    };
    let bold = Font { bold: true, ..AXIS };
    let costs = range(group.j_tpf.iter().copied())
        .map_or(String::new(), |(low, high)| format!("{} {low:.3} to {high:.3}", sub("J", "TPF")));
    let w = text_width(group.name, bold.size).max(text_width(&costs, SMALL.size)) + 40.0;
    let (low_x, high_x) = (panel.x.low_px + 0.5 * w + 4.0, panel.x.high_px - 0.5 * w - 4.0);
    let candidates = [0.0, 0.8, -0.8, 1.2, -1.2].into_iter().flat_map(|side| {
        [26.0, 0.0, -40.0, -80.0, -120.0]
            .map(|dy| Place::around(((x + side * 0.6 * w).clamp(low_x, high_x.max(low_x)), y + dy), w, 36.0))
    });
    let Some(place) = room.best(candidates) else { return };
    let (left, centre) = (place.x0, place.centre());
    let mut x = left;
    for (i, length) in pattern.iter().chain(&pattern).enumerate() {
        let end = (x + length).min(left + 34.0);
        if i % 2 == 0 && end > x {
            pen.line(&[(x, centre.1 - 8.0), (end, centre.1 - 8.0)], Stroke::solid(SOFT_INK, 2.0));
        }
        x = end;
    }
    pen.text(group.name, (left + 40.0, centre.1 - 8.0), Anchor::Start, bold);
    pen.text(&costs, (left + 40.0, centre.1 + 9.0), Anchor::Start, SMALL);
}
