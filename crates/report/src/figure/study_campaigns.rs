//! Figures 9 to 14, two for each campaign: the velocity of each trial, over ground on the left, in body axes
//! on the right, coloured by J_state (9, 11, 13); J_TPF of each trial by pitch and pitch rate at the release,
//! as colour on the left, against each on the right (10, 12, 14).

use nalgebra::Vector3;

use super::axis::{Axis, Panel, SMALL};
use super::canvas::FigureError;
use super::canvas::{Anchor, Pen, Point, Stroke, sub, text_width};
use super::color::{INK, LIMIT, SOFT_INK, WHITE, cost_color, cost_step};
use super::flight_path::{color_bar, colored};
use super::label::{LabelPlace, Room};
use super::study::{LEFT_PX, PANEL_PX, StudyStyle, TrialPoint, column, grid, with_margin};
use samara_core::assess::TraceInstant;
use samara_core::frames::rotate_body_from_ned;
use samara_core::math;
use samara_core::trajectory::Trajectory;
use samara_core::units::DEG_PER_RAD;

const HEIGHT_PX: u32 = 560;
const TOP_PX: f64 = 112.0;
const BOTTOM_PX: f64 = 506.0;
const SPARSE_PX: f64 = 1.5;
const PLAN_POINTS: u32 = 600;
/// Distance of the two panels of costs on the right [px].
const GAP_PX: f64 = 66.0;
const RADIUS_PX: f64 = 3.2;
const PITCH: &str = "pitch at release [deg]";
const RATE: &str = "pitch rate at release [deg/s]";

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
        color_bar(pen, "state", (LEFT_PX[1] + PANEL_PX, 40.0));
        for side in 0..SIDES.len() {
            draw_side(pen, style, side, flights, plan);
        }
    })
}

/// A panel of velocities: its name, its axes, and the velocity that it shows.
type Side = (&'static str, [&'static str; 2], fn(&TraceInstant) -> Vector3<f64>);

const SIDES: [Side; 2] = [
    ("over ground, north and down", ["north velocity [m/s]", "down velocity [m/s]"], |i| i.v_ned),
    ("in body axes", ["forward velocity, body x [m/s]", "downward velocity, body z [m/s]"], |i| i.v_body),
];

fn draw_side(
    pen: &mut Pen<'_>,
    style: &StudyStyle,
    side: usize,
    flights: &[Vec<TraceInstant>],
    plan: Option<&Trajectory>,
) {
    let (name, axes, velocity) = SIDES[side];
    let [x, y] = [2 * side, 2 * side + 1].map(|i| with_margin(style.velocities[i], 0.05));
    let panel = Panel { x: column(x, side), y: Axis::new(y, (TOP_PX, BOTTOM_PX)) };
    pen.text(name, (LEFT_PX[side] + PANEL_PX, TOP_PX - 12.0), Anchor::Right, SMALL);
    grid(pen, &panel, axes, 6, 12.0);
    let mut room = Room::new(panel.corners());
    let px = |i: &TraceInstant| {
        let v = velocity(i);
        panel.px(v.x, v.z)
    };
    for flight in flights {
        let points = flight.iter().map(|i| (px(i), even(cost_step(i.j_state))));
        let points = sparse(&points.collect::<Vec<_>>());
        room.take_points(&points);
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
        let far = |q: &(Point, usize)| math::hypot(p.0.0 - q.0.0, p.0.1 - q.0.1) >= SPARSE_PX;
        if i + 1 == points.len() || kept.last().is_none_or(far) {
            kept.push(*p);
        }
    }
    kept
}

fn plan_line(plan: &Trajectory, panel: &Panel, in_body_axes: bool) -> Vec<Point> {
    (0..=PLAN_POINTS)
        .map(|k| plan.end_s() * f64::from(k) / f64::from(PLAN_POINTS))
        .map(|t_s| {
            let v_ned = plan.velocity_ned(t_s);
            let v = if in_body_axes { rotate_body_from_ned(plan.attitude(t_s), v_ned) } else { v_ned };
            panel.px(v.x, v.z)
        })
        .collect()
}

fn target(pen: &mut Pen<'_>, panel: &Panel, style: &StudyStyle, room: &mut Room) {
    let [north, _, down] = style.target_v_ned;
    let (x, y) = panel.px(north, down);
    for stroke in [Stroke::solid(WHITE, 4.0), Stroke::solid(INK, 1.6)] {
        for (dx, dy) in [(8.0, 0.0), (0.0, 8.0)] {
            pen.line(&[(x - dx, y - dy), (x + dx, y + dy)], stroke);
        }
    }
    let w = text_width("target", SMALL.size);
    let around = [(0.0, -18.0), (0.0, 20.0), (w, 0.0), (-w, 0.0), (w, 22.0), (-w, 22.0), (w, -22.0)];
    room.write(pen, ("target", SMALL), around.map(|(dx, dy)| LabelPlace::around((x + dx, y + dy), w, 14.0)));
}

/// Draws the costs of the first trials of `flown`. The origin is the nominal release.
///
/// # Errors
/// [`FigureError`] when the backend fails.
pub fn costs_figure(
    style: &StudyStyle,
    title: &str,
    trials: &[TrialPoint],
    flown: u64,
) -> Result<String, FigureError> {
    let shown = match trials.len() as u64 {
        n if n < flown => format!("The first {n} of {flown} trials"),
        n => format!("{n} trials"),
    };
    let remark = format!("{shown}, each a point; the origin is the nominal release.");
    let [pitch, rate] = style.release.map(|r| with_margin((r.0 * DEG_PER_RAD, r.1 * DEG_PER_RAD), 0.05));
    style.sheet(HEIGHT_PX, title, &remark, |pen| {
        color_bar(pen, "TPF", (LEFT_PX[1] + PANEL_PX, 40.0));
        map(pen, trials, pitch, rate);
        against(pen, style, trials, 0, (PITCH, pitch, |t| t.pitch_rad));
        against(pen, style, trials, 1, (RATE, rate, |t| t.pitch_rate_rad_s));
    })
}

/// Draws pitch rate over pitch, the cost as colour.
fn map(pen: &mut Pen<'_>, trials: &[TrialPoint], pitch: (f64, f64), rate: (f64, f64)) {
    let map = Panel { x: column(pitch, 0), y: Axis::new(rate, (BOTTOM_PX, TOP_PX)) };
    grid(pen, &map, [PITCH, RATE], 6, 12.0);
    for (from, to) in
        [(map.px(0.0, rate.0), map.px(0.0, rate.1)), (map.px(pitch.0, 0.0), map.px(pitch.1, 0.0))]
    {
        pen.line(&[from, to], Stroke::solid(SOFT_INK, 0.8));
    }
    for t in trials {
        let at = map.px(t.pitch_rad * DEG_PER_RAD, t.pitch_rate_rad_s * DEG_PER_RAD);
        pen.dot(at, (RADIUS_PX + 1.3, RADIUS_PX + 0.6), cost_color(t.j_tpf));
    }
}

/// Name, range [deg] and value [rad] of a quantity.
type Quantity = (&'static str, (f64, f64), fn(&TrialPoint) -> f64);

/// Draws the cost against one quantity.
fn against(pen: &mut Pen<'_>, style: &StudyStyle, trials: &[TrialPoint], row: u8, (name, x, of): Quantity) {
    let height = 0.5 * (BOTTOM_PX - TOP_PX - GAP_PX);
    let top = TOP_PX + f64::from(row) * (height + GAP_PX);
    let j = with_margin(style.j_tpf_range, 0.08);
    let panel = Panel { x: column(x, 1), y: Axis::new(j, (top + height, top)) };
    grid(pen, &panel, [name, &sub("J", "TPF")], 4, 12.0);
    if style.j_tpf_range.1 > 0.95 {
        pen.line(&[panel.px(x.0, 1.0), panel.px(x.1, 1.0)], Stroke::dashed(LIMIT, 1.2, 8.0, 3.0));
    }
    for t in trials.iter().filter(|t| t.j_tpf.is_finite()) {
        let at = panel.px(of(t) * DEG_PER_RAD, t.j_tpf);
        pen.dot(at, (RADIUS_PX + 0.6, RADIUS_PX), cost_color(t.j_tpf));
    }
}
