//! What was measured in a flight and what a vehicle that was identified predicts, one channel above another.

use samara_core::identify::{CHANNELS, Shown};

use super::WIDTH_PX;
use super::axis::{Axis, Panel, TITLE, range};
use super::canvas::{self, Anchor, FigureError, Font, Point, Stroke};
use super::color::{FIRST, INK, SECOND};

/// Channels that are shown: rates, specific force along the thrust and along x.
const DRAWN: [usize; 5] = [3, 4, 5, 2, 0];
/// Times that are shown [s]: what is more is too fine to be seen.
const SHOWN_S: f64 = 24.0;
const EDGES_PX: (f64, f64) = (64.0, 944.0);
const TOP_PX: f64 = 64.0;
const PANEL_PX: f64 = 130.0;
const GAP_PX: f64 = 34.0;
/// A longer time between instants parts a line [s].
const PARTED_S: f64 = 0.1;

/// Draws instants that were predicted.
///
/// # Errors
/// [`FigureError`] when there are none or the backend fails.
pub fn identified_figure(title: &str, shown: &[Shown]) -> Result<String, FigureError> {
    let from_s = shown.first().ok_or(FigureError::Empty)?.t_s;
    let shown: Vec<&Shown> = shown.iter().take_while(|instant| instant.t_s <= from_s + SHOWN_S).collect();
    let to_s = shown.last().map_or(from_s, |instant| instant.t_s).max(from_s + 1.0);
    let height = TOP_PX + DRAWN.len() as f64 * (PANEL_PX + GAP_PX);
    canvas::sheet((WIDTH_PX, height as u32), (title, ""), |pen| {
        pen.text(title, (16.0, 24.0), Anchor::Left, Font { size: 17.0, color: INK, bold: true });
        for (place, channel) in DRAWN.into_iter().enumerate() {
            let top = TOP_PX + place as f64 * (PANEL_PX + GAP_PX);
            let values = || shown.iter().flat_map(|one| [one.measured[channel], one.predicted[channel]]);
            let Some((low, high)) = range(values()) else { continue };
            let room = (0.05 * (high - low)).max(1e-6);
            let panel = Panel {
                x: Axis::new((from_s, to_s), EDGES_PX),
                y: Axis::new((low - room, high + room), (top + PANEL_PX, top)),
            };
            panel.grid(pen, 12, 3, place + 1 == DRAWN.len());
            let (name, unit) = CHANNELS[channel];
            pen.text(&format!("{name} [{unit}]"), (EDGES_PX.0 - 30.0, top - 12.0), Anchor::Left, TITLE);
            for (color, width, of) in [
                (FIRST, 1.4, (|one: &Shown, i: usize| one.measured[i]) as fn(&Shown, usize) -> f64),
                (SECOND, 1.1, |one, i| one.predicted[i]),
            ] {
                let mut points: Vec<Point> = Vec::new();
                let mut newest_s = f64::NAN;
                for one in &shown {
                    if one.t_s - newest_s > PARTED_S {
                        points.push((f64::NAN, f64::NAN));
                    }
                    newest_s = one.t_s;
                    points.push(panel.px(one.t_s, of(one, channel)));
                }
                pen.line(&points, Stroke::solid(color, width));
            }
        }
    })
}
