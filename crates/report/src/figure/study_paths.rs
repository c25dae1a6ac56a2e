//! Figures 7 and 8: flight paths from the releases under study, two controllers beside each other in a panel,
//! coloured by J_state, marks at round times. The point of release is at (0, 0).

use super::axis::{Axis, Panel, SMALL, range};
use super::canvas::FigureError;
use super::canvas::{Anchor, Font, Pen, Point, Stroke, sub, text_width};
use super::color::{SOFT_INK, color_of_step, cost_step};
use super::flight_path::{color_bar, mark_interval_s, marks};
use super::label::{LabelPlace, Room};
use super::polyline::runs;
use super::study::{AXIS, LEFT_PX, PANEL_PX, StudyStyle, column, grid, with_margin};
use samara_core::assess::TraceInstant;
use samara_core::math;

const HEIGHT_PX: u32 = 640;
const TOP_PX: f64 = 118.0;
const BOTTOM_PX: f64 = 588.0;
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

impl PathGroup<'_> {
    /// The flights up to a time.
    fn shown(&self, until_s: f64) -> impl Iterator<Item = &[TraceInstant]> {
        self.flights.iter().map(move |f| &f[..f.partition_point(|i| i.t_s <= until_s + 1e-9)])
    }
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
    let mark_s = mark_interval_s(until_s.min(style.end_s));
    let remark = format!(
        "One path per release case, marks every {mark_s} s.{}",
        if until_s < style.end_s - 1e-9 { " The axis to the north is stretched." } else { "" }
    );
    let all = || panels.iter().flatten().flat_map(|group| group.shown(until_s)).flatten();
    let over = |of: fn(&TraceInstant) -> f64| range(all().map(of)).ok_or(FigureError::Empty);
    let (north, down) = (over(|i| i.north_down_m.0)?, over(|i| i.north_down_m.1)?);
    style.sheet(HEIGHT_PX, title, &remark, |pen| {
        color_bar(pen, "state", (LEFT_PX[1] + PANEL_PX, 40.0));
        for (side, groups) in panels.iter().enumerate() {
            let panel = panel(side, north, down);
            grid(pen, &panel, ["north [m]", "altitude lost [m]"], 8, 14.0);
            let mut room = Room::new(panel.corners());
            for (group, pattern) in groups.iter().zip(PATTERNS) {
                for flight in group.shown(until_s) {
                    path(pen, &panel, flight, mark_s, pattern, &mut room);
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
fn panel(side: usize, north: (f64, f64), down: (f64, f64)) -> Panel {
    let (mut n, mut d) = (with_margin(north, 0.06), with_margin(down, 0.06));
    d.1 += 0.10 * (d.1 - d.0);
    let (width, height) = (PANEL_PX, BOTTOM_PX - TOP_PX);
    let (per_px_n, per_px_d) = ((n.1 - n.0) / width, (d.1 - d.0) / height);
    if (0.5..2.0).contains(&(per_px_n / per_px_d)) {
        let per_px = per_px_n.max(per_px_d);
        n.1 = n.0 + per_px * width;
        d.1 = d.0 + per_px * height;
    }
    Panel { x: column(n, side), y: Axis::new(d, (TOP_PX, BOTTOM_PX)) }
}

fn point(panel: &Panel, i: &TraceInstant) -> Point {
    panel.px(i.north_down_m.0, i.north_down_m.1)
}

fn path(
    pen: &mut Pen<'_>,
    panel: &Panel,
    flight: &[TraceInstant],
    mark_s: f64,
    pattern: [f64; 4],
    room: &mut Room,
) {
    let at = |i: &TraceInstant| point(panel, i);
    let points: Vec<(Point, usize)> = flight.iter().map(|i| (at(i), cost_step(i.j_state))).collect();
    room.take_points(&points);
    broken(pen, &points, pattern, 2.0);
    let end_s = flight.last().map_or(0.0, |i| i.t_s);
    marks(pen, mark_s, (2.4, 1.5), |t_s| {
        flight.iter().find(|i| i.t_s >= t_s - 1e-9).filter(|_| t_s <= end_s + 1e-9).map(at)
    });
}

/// Draws a broken line with a colour for each point.
fn broken(pen: &mut Pen<'_>, points: &[(Point, usize)], pattern: [f64; 4], width: f64) {
    let period: f64 = pattern.iter().sum();
    let (mut length, mut before) = (0.0, None);
    let drawn = points.iter().map(|&(p, step)| {
        let piece = before.replace(p).map_or(0.0, |q: Point| math::hypot(p.0 - q.0, p.1 - q.1));
        length += if piece.is_finite() { piece } else { 0.0 };
        let place = length % period;
        let drawn = place < pattern[0]
            || (pattern[0] + pattern[1]..pattern[0] + pattern[1] + pattern[2]).contains(&place);
        (p, drawn.then_some(step))
    });
    for (step, line) in runs(&drawn.collect::<Vec<_>>()) {
        if let Some(step) = step {
            pen.line(&line, Stroke::solid(color_of_step(step), width));
        }
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
    let ends = group.shown(until_s).filter_map(|flight| flight.last()).map(|i| point(panel, i));
    let Some((x, y)) = ends.reduce(|a, b| if b.1 > a.1 { b } else { a }) else { return };
    let bold = Font { bold: true, ..AXIS };
    let costs = range(group.j_tpf.iter().copied())
        .map_or(String::new(), |(low, high)| format!("{} {low:.3} to {high:.3}", sub("J", "TPF")));
    let w = text_width(group.name, bold.size).max(text_width(&costs, SMALL.size)) + 40.0;
    let (low_x, high_x) = (panel.x.low_px + 0.5 * w + 4.0, panel.x.high_px - 0.5 * w - 4.0);
    let candidates = [0.0, 0.8, -0.8, 1.2, -1.2].into_iter().flat_map(|side| {
        [26.0, 0.0, -40.0, -80.0, -120.0].map(|dy| {
            LabelPlace::around(((x + side * 0.6 * w).clamp(low_x, high_x.max(low_x)), y + dy), w, 36.0)
        })
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
    pen.text(group.name, (left + 40.0, centre.1 - 8.0), Anchor::Left, bold);
    pen.text(&costs, (left + 40.0, centre.1 + 9.0), Anchor::Left, SMALL);
}
