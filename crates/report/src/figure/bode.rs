//! Gain and phase of a design's loops over the frequency: pitch on the left, velocities on the right, at each
//! state in a colour of its own.

use super::WIDTH_PX;
use super::axis::{Axis, Panel, SMALL, TITLE, number};
use super::canvas::{self, Anchor, FigureError, Font, Pen, Point, Stroke};
use super::color::{FIRST, GRID, INK, LIMIT, Rgb, SECOND, THIRD};
use samara_core::design::linear_loop::size;
use samara_core::design::{LOOPS, LinearLoop, LoopsAt};
use samara_core::math;
use samara_core::units::DEG_PER_RAD;
use samara_mission::{Mission, Stamp};

const HEIGHT_PX: u32 = 640;
/// Colours of the states.
const COLORS: [Rgb; 3] = [SECOND, THIRD, FIRST];
/// Loops that are drawn, by place in [`LOOPS`]: to the left, to the right.
const SHOWN: [[usize; 2]; 2] = [[0, 1], [2, 3]];
/// Left and right edges of the two columns.
const COLUMNS: [(f64, f64); 2] = [(64.0, 464.0), (548.0, 944.0)];
/// Upper and lower edges of gain and phase.
const GAIN_PX: (f64, f64) = (112.0, 330.0);
const PHASE_PX: (f64, f64) = (372.0, 588.0);
/// Ranges of gain [dB] and phase [deg].
const GAIN_DB: (f64, f64) = (-40.0, 60.0);
const PHASE_DEG: (f64, f64) = (-360.0, 0.0);

/// Draws the loops at each state. Gains and phases beyond the panels are left out.
///
/// # Errors
/// [`FigureError`] when there are no loops or the backend fails.
pub fn bode_figure(mission: &Mission, name: &str, states: &[LoopsAt]) -> Result<String, FigureError> {
    let any = states.iter().flat_map(|at| &at.loops).next().ok_or(FigureError::Empty)?;
    let highest = std::f64::consts::PI / any.0.period_s;
    let headline = format!("{}: open loops of {name}", mission.name);
    let stamp = Stamp { seed: mission.seed, input_hash: mission.hash_without_gains() };
    canvas::sheet((WIDTH_PX, HEIGHT_PX), (&headline, &stamp.csv_comment()), |pen| {
        pen.text(&headline, (16.0, 28.0), Anchor::Left, Font { size: 19.0, color: INK, bold: true });
        let below = "Each loop is broken at its command while the others are closed; the second loop of a panel is dashed.";
        pen.text(below, (16.0, 54.0), Anchor::Left, SMALL);
        let mut x = 16.0;
        for (at, color) in states.iter().zip(COLORS) {
            pen.line(&[(x, 76.0), (x + 22.0, 76.0)], Stroke::solid(color, 2.2));
            pen.text(at.name, (x + 28.0, 76.0), Anchor::Left, Font { color, bold: true, ..TITLE });
            x += 150.0;
        }
        for (shown, edges) in SHOWN.iter().zip(COLUMNS) {
            column(pen, states, *shown, edges, highest);
        }
    })
}

fn column(pen: &mut Pen<'_>, states: &[LoopsAt], shown: [usize; 2], edges: (f64, f64), highest: f64) {
    let decades = (-2.0, math::log10(highest));
    let x = Axis::new(decades, edges);
    let gain = Panel { x, y: Axis::new(GAIN_DB, (GAIN_PX.1, GAIN_PX.0)) };
    let phase = Panel { x, y: Axis::new(PHASE_DEG, (PHASE_PX.1, PHASE_PX.0)) };
    for (panel, (y0, y1)) in [(&gain, GAIN_PX), (&phase, PHASE_PX)] {
        for power in decades.0 as i32..=decades.1.floor() as i32 {
            let px = x.px(f64::from(power));
            pen.line(&[(px, y0), (px, y1)], Stroke::solid(GRID, 1.0));
            let text = number(10f64.powi(power), (-power).max(0) as usize);
            pen.text(&text, (px, y1 + 13.0), Anchor::Center, SMALL);
        }
        let step = if panel.y.high > 0.0 { 20.0 } else { 90.0 };
        let rows = ((panel.y.high - panel.y.low) / step).round() as u32;
        for row in 0..=rows {
            let value = panel.y.low + step * f64::from(row);
            let px = panel.y.px(value);
            pen.line(&[(edges.0, px), (edges.1, px)], Stroke::solid(GRID, 1.0));
            pen.text(&number(value, 0), (edges.0 - 7.0, px), Anchor::Right, SMALL);
        }
    }
    // Where stability ends: a gain of 1 with a phase of -180 deg.
    for (panel, value) in [(&gain, 0.0), (&phase, -180.0)] {
        let px = panel.y.px(value);
        pen.line(&[(edges.0, px), (edges.1, px)], Stroke::dashed(LIMIT, 1.0, 4.0, 3.0));
    }
    let [first, second] = shown.map(|i| LOOPS[i].0);
    let title = format!("{first}, {second}: gain [dB]");
    pen.text(&title, (edges.0, GAIN_PX.0 - 14.0), Anchor::Left, TITLE);
    pen.text("phase [deg]", (edges.0, PHASE_PX.0 - 14.0), Anchor::Left, TITLE);
    pen.text("rad/s", (0.5 * (edges.0 + edges.1), PHASE_PX.1 + 34.0), Anchor::Center, TITLE);
    for (at, color) in states.iter().zip(COLORS) {
        for (place, index) in shown.into_iter().enumerate() {
            let Some((open, _)) = at.loops.get(index) else { continue };
            let stroke =
                if place == 0 { Stroke::solid(color, 1.8) } else { Stroke::dashed(color, 1.8, 6.0, 4.0) };
            for line in curves(open, &gain, &phase) {
                pen.line(&line, stroke);
            }
        }
    }
}

/// Gain and phase in pieces that lie within their panels; the phase lies between -360 deg and 0, and a line
/// that leaves on one side goes on at the other.
fn curves(open: &LinearLoop, gain: &Panel, phase: &Panel) -> Vec<Vec<Point>> {
    let (mut gains, mut phases) = (vec![Vec::new()], vec![Vec::new()]);
    let mut before = f64::NAN;
    for omega in open.frequencies() {
        let l = open.response(omega);
        if !(l.re.is_finite() && l.im.is_finite()) {
            continue;
        }
        let turned = (math::atan2(l.im, l.re) * DEG_PER_RAD).rem_euclid(360.0);
        let angle_deg = if turned > 0.0 { turned - 360.0 } else { turned };
        if (angle_deg - before).abs() > 180.0 {
            phases.push(Vec::new());
        }
        before = angle_deg;
        let decade = math::log10(omega);
        place(gain, decade, 20.0 * math::log10(size(l).max(f64::MIN_POSITIVE)), &mut gains);
        place(phase, decade, angle_deg, &mut phases);
    }
    gains.into_iter().chain(phases).filter(|line| line.len() > 1).collect()
}

fn place(panel: &Panel, x: f64, y: f64, pieces: &mut Vec<Vec<Point>>) {
    let inside = (panel.x.low..=panel.x.high).contains(&x) && (panel.y.low..=panel.y.high).contains(&y);
    match (inside, pieces.last_mut()) {
        (true, Some(piece)) => piece.push(panel.px(x, y)),
        (false, Some(piece)) if !piece.is_empty() => pieces.push(Vec::new()),
        _ => {}
    }
}
