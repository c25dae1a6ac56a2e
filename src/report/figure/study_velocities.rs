//! Figures 9, 11 and 13: the velocity of each trial, over ground on the left, in body axes on the right,
//! coloured by J_state.

use nalgebra::Vector3;

use super::axis::{Axis, Panel, SMALL};
use super::canvas::FigureError;
use super::canvas::{Anchor, Pen, Point, Stroke, text_width};
use super::color::INK;
use super::flight_path::{color_bar, colored};
use super::label::{Place, Room};
use super::study::{AXIS, StudyStyle, with_margin};
use crate::assess::TraceInstant;
use crate::trajectory::Trajectory;

const HEIGHT_PX: u32 = 560;
const TOP_PX: f64 = 112.0;
const BOTTOM_PX: f64 = 506.0;
const LEFT_PX: [f64; 2] = [62.0, 540.0];
const PANEL_PX: f64 = 404.0;
const SPARSE_PX: f64 = 1.5;
const PLAN_POINTS: u32 = 600;

/// Draws the velocities of `flights`; the plan, if it was followed, as a dashed line.
///
/// # Errors
/// [`FigureError`] when the backend fails.
pub fn velocities_figure(
    style: &StudyStyle,
    title: &str,
    flights: &[Vec<TraceInstant>],
    plan: Option<&Trajectory>,
) -> Result<String, FigureError> {
    let followed = if plan.is_some() { "dashed: the optimal trajectory; " } else { "" };
    let remark = format!("{} trials; {followed}dots: where they begin; cross: the target.", flights.len());
    style.sheet(HEIGHT_PX, title, &remark, |pen| {
        color_bar(pen, &style.j_state, "state", (LEFT_PX[1] + PANEL_PX, 40.0));
        for (side, axes) in [OVER_GROUND, IN_BODY_AXES].iter().enumerate() {
            draw_side(pen, style, (side, axes), flights, plan);
        }
    })
}

/// Ranges and titles of a panel.
struct Axes {
    name: &'static str,
    x: &'static str,
    y: &'static str,
    velocity: fn(&TraceInstant) -> Vector3<f64>,
}

const OVER_GROUND: Axes = Axes {
    name: "over ground, north and down",
    x: "north velocity [m/s]",
    y: "down velocity [m/s]",
    velocity: |i| i.v_ned,
};
const IN_BODY_AXES: Axes = Axes {
    name: "in body axes",
    x: "forward velocity, body x [m/s]",
    y: "downward velocity, body z [m/s]",
    velocity: |i| i.v_body,
};

fn draw_side(
    pen: &mut Pen<'_>,
    style: &StudyStyle,
    (side, axes): (usize, &Axes),
    flights: &[Vec<TraceInstant>],
    plan: Option<&Trajectory>,
) {
    let (panel, left) = (panel(style, side), LEFT_PX[side]);
    pen.text(axes.name, (left + PANEL_PX, TOP_PX - 12.0), Anchor::End, SMALL);
    pen.text(axes.y, (left - 44.0, TOP_PX - 12.0), Anchor::Start, AXIS);
    pen.text(axes.x, (left + 0.5 * PANEL_PX, BOTTOM_PX + 34.0), Anchor::Middle, AXIS);
    panel.grid(pen, 6, 6, true);
    let mut room = Room::new(panel.corners().0, panel.corners().1);
    let px = |i: &TraceInstant| {
        let v = (axes.velocity)(i);
        panel.px(v.x, v.z)
    };
    for flight in flights {
        let points: Vec<(Point, usize)> =
            flight.iter().map(|i| (px(i), even(style.j_state.step(i.j_state)))).collect();
        let points = sparse(&points);
        let line: Vec<Point> = points.iter().map(|p| p.0).collect();
        room.take_line(&line);
        colored(pen, &points, 0.9);
    }
    for first in flights.iter().filter_map(|f| f.first()) {
        pen.disc(px(first), 1.8, INK);
    }
    if let Some(plan) = plan {
        pen.line(&plan_line(plan, &panel, side == 1), Stroke::dashed(INK, 1.2, 5.0, 4.0));
    }
    if side == 0 {
        target(pen, &panel, style, &mut room);
    }
}

/// Number of the colour, rounded down to an even one: half the colours are enough for a line among a hundred.
fn even(step: usize) -> usize {
    step - step % 2
}

/// The points that are a pixel and more from the one before, and the last.
fn sparse(points: &[(Point, usize)]) -> Vec<(Point, usize)> {
    let mut kept: Vec<(Point, usize)> = Vec::new();
    for (i, p) in points.iter().enumerate() {
        let far = |q: &(Point, usize)| (p.0.0 - q.0.0).hypot(p.0.1 - q.0.1) >= SPARSE_PX;
        if i + 1 == points.len() || kept.last().is_none_or(far) {
            kept.push(*p);
        }
    }
    kept
}

fn panel(style: &StudyStyle, side: usize) -> Panel {
    let x = with_margin(style.velocities[2 * side], 0.05);
    let y = with_margin(style.velocities[2 * side + 1], 0.05);
    Panel {
        x: Axis { low: x.0, high: x.1, low_px: LEFT_PX[side], high_px: LEFT_PX[side] + PANEL_PX },
        y: Axis { low: y.0, high: y.1, low_px: TOP_PX, high_px: BOTTOM_PX },
    }
}

fn plan_line(plan: &Trajectory, panel: &Panel, in_body_axes: bool) -> Vec<Point> {
    (0..=PLAN_POINTS)
        .map(|k| plan.end_s() * f64::from(k) / f64::from(PLAN_POINTS))
        .map(|t_s| {
            let v_ned = plan.velocity_ned(t_s);
            let v = if in_body_axes {
                crate::frames::rotate_body_from_ned(plan.attitude(t_s), v_ned)
            } else {
                v_ned
            };
            panel.px(v.x, v.z)
        })
        .collect()
}

fn target(pen: &mut Pen<'_>, panel: &Panel, style: &StudyStyle, room: &mut Room) {
    let [north, _, down] = style.target_v_ned;
    let (x, y) = panel.px(north, down);
    for (dx, dy) in [(8.0, 0.0), (0.0, 8.0)] {
        pen.line(&[(x - dx, y - dy), (x + dx, y + dy)], Stroke::solid((0xFF, 0xFF, 0xFF), 4.0));
    }
    for (dx, dy) in [(8.0, 0.0), (0.0, 8.0)] {
        pen.line(&[(x - dx, y - dy), (x + dx, y + dy)], Stroke::solid(INK, 1.6));
    }
    let w = text_width("target", SMALL.size);
    let around = [(0.0, -18.0), (0.0, 20.0), (w, 0.0), (-w, 0.0), (w, 22.0), (-w, 22.0), (w, -22.0)];
    if let Some(place) = room.best(around.map(|(dx, dy)| Place::around((x + dx, y + dy), w, 14.0))) {
        pen.text("target", place.centre(), Anchor::Middle, SMALL);
    }
}
