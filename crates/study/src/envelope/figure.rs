//! The safe-release envelope: a panel for each two quantities, with the confirmed edges of both limits and
//! the nominal release.

use crate::envelope::ENVELOPE_LIMITS;
use crate::envelope::report::{EnvelopePair, EnvelopeReport};
use samara_core::assess::envelope::AxisRange;
use samara_report::figure::axis::{Axis, Panel, SMALL, TITLE, range};
use samara_report::figure::canvas::{self, Anchor, FigureError, Font, Pen, Point, Stroke, sub};
use samara_report::figure::color::{FIRST, GRID, INK, Rgb, THIRD};

const WIDTH_PX: u32 = 1100;
const COLUMNS: usize = 3;
const LEFT_PX: f64 = 62.0;
const COLUMN_PX: f64 = 354.0;
const PANEL_PX: (f64, f64) = (276.0, 210.0);
const TOP_PX: f64 = 118.0;
/// Distance from one row of panels to the next [px].
const ROW_PX: f64 = 296.0;
const HEADLINE: Font = Font { size: 18.0, color: INK, bold: true };
/// Lines and insides of the limits, in the order of [`ENVELOPE_LIMITS`].
const LINES: [Rgb; 2] = [THIRD, FIRST];
const INSIDES: [Rgb; 2] = [(0xC4, 0xE3, 0xD8), (0xE2, 0xEE, 0xF7)];
/// Air about the edges in a panel, as a share of their range.
const MARGIN: f64 = 0.08;

/// Draws the fans of an envelope.
///
/// # Errors
/// [`FigureError::Empty`] without fans; [`FigureError`] when the backend fails.
pub fn envelope_figure(report: &EnvelopeReport<'_>) -> Result<String, FigureError> {
    if report.fans.is_empty() {
        return Err(FigureError::Empty);
    }
    let mission = report.mission;
    let title = format!("Safe-release envelope: {}, gains {}", mission.name, mission.control.gains_name);
    let rows = report.fans.len().div_ceil(COLUMNS);
    let height = (TOP_PX + ROW_PX * rows as f64).ceil() as u32 - 20;
    canvas::sheet((WIDTH_PX, height), (&title, &mission.stamp().csv_comment()), |pen| {
        pen.text(&title, (16.0, 26.0), Anchor::Left, HEADLINE);
        let remark = "Inside the solid lines 99 % of the flights stay below the limit, with 95 % confidence at each corner; dashed: \
                      the last point at which the search lost no flight; cross: nominal release.";
        pen.text(remark, (16.0, 51.0), Anchor::Left, SMALL);
        legend(pen);
        for (place, fan) in report.fans.iter().enumerate() {
            let (column, row) = ((place % COLUMNS) as f64, (place / COLUMNS) as f64);
            let corner = (LEFT_PX + COLUMN_PX * column, TOP_PX + ROW_PX * row);
            panel(pen, &fan.pair(&report.ranges), corner, PANEL_PX);
        }
    })
}

/// Draws up to [`STRIP_PANELS`] pairs of an envelope in a row, without a headline: for a page that says what
/// they are. `title` and `origin` go into the document's head.
///
/// # Errors
/// [`FigureError::Empty`] without pairs; [`FigureError`] when the backend fails.
pub fn envelope_strip(head: (&str, &str), pairs: &[EnvelopePair]) -> Result<String, FigureError> {
    let pairs = &pairs[..pairs.len().min(STRIP_PANELS)];
    if pairs.is_empty() {
        return Err(FigureError::Empty);
    }
    let width = STRIP_COLUMN_PX * pairs.len() as f64;
    let height = STRIP_TOP_PX + STRIP_PANEL_PX.1 + 48.0;
    canvas::sheet((width as u32, height as u32), head, |pen| {
        for (place, pair) in pairs.iter().enumerate() {
            let corner = (STRIP_LEFT_PX + STRIP_COLUMN_PX * place as f64, STRIP_TOP_PX);
            panel(pen, pair, corner, STRIP_PANEL_PX);
        }
    })
}

/// Most panels of a strip.
pub const STRIP_PANELS: usize = 2;
/// A strip's panels are small, for a page where there is little room.
const STRIP_PANEL_PX: (f64, f64) = (190.0, 120.0);
const STRIP_COLUMN_PX: f64 = 262.0;
const STRIP_LEFT_PX: f64 = 50.0;
const STRIP_TOP_PX: f64 = 26.0;

fn legend(pen: &mut Pen<'_>) {
    let mut x = 16.0;
    for (i, limit) in ENVELOPE_LIMITS.iter().enumerate() {
        pen.rectangle((x, 66.0), (x + 22.0, 80.0), INSIDES[i]);
        pen.line(&[(x, 66.0), (x + 22.0, 66.0)], Stroke::solid(LINES[i], 2.0));
        let text = format!("{} < {limit}", sub("J", "state"));
        pen.text(&text, (x + 30.0, 73.0), Anchor::Left, Font { color: LINES[i], ..SMALL });
        x += 120.0;
    }
}

fn panel(pen: &mut Pen<'_>, pair: &EnvelopePair, (left, top): Point, (width, height): (f64, f64)) {
    let [x, y] = pair.axes;
    let panel = Panel {
        x: Axis::new(span(pair, 0), (left, left + width)),
        y: Axis::new(span(pair, 1), (top + height, top)),
    };
    pen.text(y.words(), (left - 44.0, top - 14.0), Anchor::Left, TITLE);
    pen.text(x.words(), (left + 0.5 * width, top + height + 34.0), Anchor::Center, TITLE);
    let at = |points: &[[f64; 2]]| -> Vec<Point> { points.iter().map(|[x, y]| panel.px(*x, *y)).collect() };
    let confirmed = pair.outlines.each_ref().map(|outline| at(&outline.confirmed));
    // The larger region first, the grid over both.
    for (points, inside) in confirmed.iter().zip(INSIDES).rev().filter(|(points, _)| points.len() > 2) {
        pen.polygon(points, inside);
    }
    panel.grid(pen, 6, 5, true);
    frame(pen, &panel);
    for ((points, outline), color) in confirmed.iter().zip(&pair.outlines).zip(LINES).rev() {
        pen.line(&closed(&at(&outline.safe)), Stroke::dashed(color, 1.0, 4.0, 3.0));
        pen.line(&closed(points), Stroke::solid(color, 2.0));
    }
    let [nominal_x, nominal_y] = pair.ranges.map(|range| range.nominal);
    let (px, py) = panel.px(nominal_x, nominal_y);
    for (dx, dy) in [(5.0, 0.0), (0.0, 5.0)] {
        pen.line(&[(px - dx, py - dy), (px + dx, py + dy)], Stroke::solid(INK, 1.6));
    }
}

/// The range of a panel along the first or the second quantity: about the edges, or what was looked at.
fn span(pair: &EnvelopePair, along: usize) -> (f64, f64) {
    let safe = pair.outlines.iter().flat_map(|outline| &outline.safe);
    let found = range(safe.map(|point| point[along]));
    let AxisRange { low, nominal, high } = pair.ranges[along];
    let (low, high) = found.filter(|(low, high)| high > low).unwrap_or((low, high));
    let (low, high) = (low.min(nominal), high.max(nominal));
    let air = MARGIN * (high - low).max(1e-9);
    (low - air, high + air)
}

fn frame(pen: &mut Pen<'_>, panel: &Panel) {
    let ((x0, y0), (x1, y1)) = panel.corners();
    pen.line(&[(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)], Stroke::solid(GRID, 1.0));
}

/// The line through the points and back to the first.
fn closed(points: &[Point]) -> Vec<Point> {
    points.iter().chain(points.first()).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::search::SearchedFan;
    use samara_core::assess::envelope::{Edge, EdgeSearch, EnvelopeAxis, Fan, reaches_of};
    use samara_mission::Mission;

    /// Every panel has its axes' names, every limit its outline; without fans there is no figure.
    #[test]
    fn a_panel_for_each_pair() {
        let mission = Mission::shipped("titan_drop").unwrap();
        let range = AxisRange { low: -2.0, nominal: 0.0, high: 2.0 };
        let fan = |axes| {
            let fan = Fan::new(axes, &[range; 6], &reaches_of(&[range; 6]), 8);
            let edge =
                |limit: f64| Edge { limit, safe: limit, beyond: None, tried: vec![limit], holds: true };
            let edges = vec![ENVELOPE_LIMITS.map(edge).to_vec(); fan.rays.len()];
            SearchedFan { fan, nominal: [true; 2], edges }
        };
        let fans = EnvelopeAxis::pairs().into_iter().take(4).map(fan).collect();
        let search = EdgeSearch::default();
        let mut report =
            EnvelopeReport { mission: &mission, search, ranges: [range; 6], plan_j_tpf: 0.5, fans };
        let svg = envelope_figure(&report).unwrap();
        for (_, axis) in EnvelopeAxis::pairs().into_iter().take(4).map(|[x, y]| (x, y)) {
            assert!(svg.contains(axis.words()), "{axis:?}");
        }
        assert_eq!(svg.matches("<polygon").count(), 1 + 2 + 2 * 4, "sheet, legend, two regions a panel");
        report.fans.clear();
        assert!(matches!(envelope_figure(&report), Err(FigureError::Empty)));
    }
}
