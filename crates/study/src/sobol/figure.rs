//! What decides a drop: a panel for each output, a bar for each group of what is drawn: alone, and with
//! interactions.

use crate::sobol::report::{OUTPUTS, SobolReport};
use samara_core::assess::Quantity;
use samara_core::assess::sobol::{Index, Sensitivity};
use samara_report::figure::axis::{SMALL, TITLE};
use samara_report::figure::canvas::{self, Anchor, FigureError, Font, Pen, Stroke, sub};
use samara_report::figure::color::{FIRST, GRID, INK, Rgb};

const WIDTH_PX: u32 = 1060;
const TOP_PX: f64 = 118.0;
const ROW_PX: f64 = 26.0;
/// Left end of the names' column, and of each panel.
const LEFT_PX: f64 = 190.0;
const PANEL_PX: f64 = 250.0;
const STRIDE_PX: f64 = 286.0;
/// What interactions add.
const TOTAL: Rgb = (0xA9, 0xCD, 0xE6);

/// Draws the indices, the groups in the order of their drawing.
///
/// # Errors
/// [`FigureError::Empty`] without groups; [`FigureError`] when the backend fails.
pub fn sobol_figure(report: &SobolReport<'_>) -> Result<String, FigureError> {
    if report.groups.is_empty() {
        return Err(FigureError::Empty);
    }
    let title =
        format!("What decides a drop: {}, gains {}", report.mission.name, report.mission.control.gains_name);
    let bottom = TOP_PX + ROW_PX * report.groups.len() as f64;
    let size = (WIDTH_PX, bottom as u32 + 44);
    canvas::sheet(size, (&title, &report.mission.stamp().csv_comment()), |pen| {
        pen.text(&title, (16.0, 26.0), Anchor::Left, Font { size: 18.0, color: INK, bold: true });
        let remark = "Share of the variance: dark, that of the quantity alone; light, with its interactions. Lines: 95 % intervals.";
        pen.text(remark, (16.0, 50.0), Anchor::Left, SMALL);
        for (k, group) in report.groups.iter().enumerate() {
            let y = TOP_PX + ROW_PX * (k as f64 + 0.5);
            pen.text(&group.words, (LEFT_PX - 10.0, y), Anchor::Right, SMALL);
        }
        for (k, (output, found)) in OUTPUTS.iter().zip(&report.found).enumerate() {
            panel(pen, LEFT_PX + STRIDE_PX * k as f64, bottom, (output, found));
        }
    })
}

fn panel(pen: &mut Pen<'_>, left: f64, bottom: f64, (output, found): (&Quantity, &Sensitivity)) {
    let words = output.words.replace("J_TPF", &sub("J", "TPF"));
    pen.text(&words, (left, TOP_PX - 34.0), Anchor::Left, Font { bold: true, ..TITLE });
    let unit = if output.unit.is_empty() { String::new() } else { format!(" {}", output.unit) };
    let spread = format!("{:.3}{unit}, standard deviation {:.3}{unit}", found.mean, found.deviation);
    pen.text(&spread, (left, TOP_PX - 15.0), Anchor::Left, SMALL);
    let px = |share: f64| left + PANEL_PX * share.clamp(0.0, 1.0);
    for tenth in [0, 2, 4, 6, 8, 10] {
        let x = px(f64::from(tenth) / 10.0);
        pen.line(&[(x, TOP_PX), (x, bottom)], Stroke::solid(GRID, 1.0));
        let text = if tenth == 10 { "1".to_owned() } else { format!("0.{tenth}") };
        pen.text(&text, (x, bottom + 14.0), Anchor::Center, SMALL);
    }
    for (k, (first, total)) in found.first.iter().zip(&found.total).enumerate() {
        let y = TOP_PX + ROW_PX * (k as f64 + 0.5);
        pen.rectangle((left, y - 8.0), (px(total.value), y + 8.0), TOTAL);
        pen.rectangle((left, y - 8.0), (px(first.value), y + 8.0), FIRST);
        for (index, at) in [(total, y + 4.0), (first, y - 4.0)] {
            let Index { value, half } = *index;
            pen.line(&[(px(value - half), at), (px(value + half), at)], Stroke::solid(INK, 1.0));
        }
    }
}
