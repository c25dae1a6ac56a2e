//! One campaign by two ways to fly it: the value of each trial by the one over that by the other, a panel for
//! each quantity, with the bound from the one to the other.

use crate::fidelity::{FidelityReport, QuantityFound};
use samara_report::figure::axis::{Axis, Panel, SMALL, TITLE, range};
use samara_report::figure::canvas::{self, Anchor, FigureError, Font, Pen, Stroke};
use samara_report::figure::color::{FIRST, INK, LIMIT, SOFT_INK};

const WIDTH_PX: u32 = 960;
const HEIGHT_PX: u32 = 420;
const TOP_PX: f64 = 96.0;
const BOTTOM_PX: f64 = 346.0;
/// Left and right edges of the panels [px].
const SIDES_PX: [(f64, f64); 3] = [(64.0, 300.0), (384.0, 620.0), (704.0, 940.0)];
/// Most trials that are drawn: more are a blot.
const MOST_DRAWN: usize = 2000;

/// Draws the first quantities of a report, as many as there are panels.
///
/// # Errors
/// [`FigureError::Empty`] where no trial was flown both ways; [`FigureError`] when the backend fails.
pub fn fidelity_figure(report: &FidelityReport<'_>) -> Result<String, FigureError> {
    let pairs: Vec<Vec<(f64, f64)>> = (0..SIDES_PX.len()).map(|i| report.pairs(i)).collect();
    if pairs.iter().all(Vec::is_empty) {
        return Err(FigureError::Empty);
    }
    let mission = report.mission();
    let title = format!("{}: the same trials, flown two ways", mission.name);
    canvas::sheet((WIDTH_PX, HEIGHT_PX), (&title, &mission.stamp().csv_comment()), |pen| {
        pen.text(&title, (16.0, 26.0), Anchor::Left, Font { size: 18.0, color: INK, bold: true });
        let remark = "A point is a trial. Grey: equal in both. Red: 95 % of the next trials lie below, whatever the distribution.";
        pen.text(remark, (16.0, 51.0), Anchor::Left, SMALL);
        for ((found, pairs), sides) in report.quantities().iter().zip(&pairs).zip(SIDES_PX) {
            draw(pen, found, pairs, sides);
        }
    })
}

fn draw(pen: &mut Pen<'_>, found: &QuantityFound, pairs: &[(f64, f64)], sides_px: (f64, f64)) {
    let Some((low, high)) = range(pairs.iter().flat_map(|(model, faithful)| [*model, *faithful])) else {
        return;
    };
    let room = 0.05 * (high - low).max(1e-9 * high.abs()).max(f64::MIN_POSITIVE);
    let scale = (low - room, high + room);
    let panel = Panel { x: Axis::new(scale, sides_px), y: Axis::new(scale, (BOTTOM_PX, TOP_PX)) };
    panel.grid(pen, 4, 5, true);
    let ((x0, y0), (x1, y1)) = panel.corners();
    let line = |above: f64| {
        let (from, to) = (scale.0.max(scale.0 - above), scale.1.min(scale.1 - above));
        [panel.px(from, from + above), panel.px(to, to + above)]
    };
    pen.line(&line(0.0), Stroke::solid(SOFT_INK, 1.0));
    for (model, faithful) in pairs.iter().take(MOST_DRAWN) {
        pen.disc(panel.px(*model, *faithful), 1.6, FIRST);
    }
    let margin = found.bound.map(|bound| bound.margin).filter(|m| m.abs() < scale.1 - scale.0);
    if let Some(margin) = margin {
        pen.line(&line(margin), Stroke::dashed(LIMIT, 1.4, 5.0, 3.0));
    }
    pen.text(&found.words, (x0, y0 - 26.0), Anchor::Left, Font { bold: true, ..TITLE });
    pen.text("by 1, the most faithful", (x0, y0 - 11.0), Anchor::Left, SMALL);
    pen.text("by 2", (0.5 * (x0 + x1), y1 + 36.0), Anchor::Center, SMALL);
}
