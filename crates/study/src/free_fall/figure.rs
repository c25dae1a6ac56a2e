//! Operating curves of rules that find a fall: the median time until it is found over false alarms an hour, a
//! line for each level, a panel for each kind of rule.

use crate::free_fall::report::{FreeFallReport, OperatingPoint};
use samara_core::assess::free_fall::rules::{LEVELS, RuleKind};
use samara_core::math;
use samara_report::figure::axis::{Axis, Panel, SMALL, TITLE, number};
use samara_report::figure::canvas::{self, Anchor, FigureError, Font, Pen, Point, Stroke};
use samara_report::figure::color::{GRID, INK, LIMIT, LINES};

const WIDTH_PX: u32 = 960;
const HEIGHT_PX: u32 = 470;
const TOP_PX: f64 = 110.0;
const BOTTOM_PX: f64 = 400.0;
/// Left and right edge of the panels [px].
const SIDES_PX: [(f64, f64); 2] = [(64.0, 440.0), (510.0, 886.0)];
/// Highest median that is shown [ms].
const MOST_MS: f64 = 350.0;
/// Latency that was asked for [ms].
const ASKED_MS: f64 = 150.0;

/// Draws the operating curves. A rule without false alarms stands at the upper bound of its rate, as a ring.
///
/// # Errors
/// [`FigureError::Empty`] without releases or descents; [`FigureError`] when the backend fails.
pub fn free_fall_figure(report: &FreeFallReport<'_>) -> Result<String, FigureError> {
    if report.releases.is_empty() || report.descents.is_empty() {
        return Err(FigureError::Empty);
    }
    let points = report.operating_points();
    let rate = |point: &OperatingPoint| math::log10(shown_rate(point));
    let low = points.iter().map(rate).fold(f64::INFINITY, f64::min).floor();
    let high = points.iter().map(rate).fold(f64::NEG_INFINITY, f64::max).ceil().max(low + 1.0);
    let title = format!("{}: a fall found by the accelerometer, rules and settings", report.mission.name);
    canvas::sheet((WIDTH_PX, HEIGHT_PX), (&title, &report.mission.stamp().csv_comment()), |pen| {
        pen.text(&title, (16.0, 26.0), Anchor::Left, Font { size: 18.0, color: INK, bold: true });
        let remark = "A point is a time, 50 to 300 ms; a ring is a rule without a false alarm, at the bound of its rate (95 %). \
                      Taut riser only. Level as a share of g beside each line.";
        pen.text(remark, (16.0, 51.0), Anchor::Left, SMALL);
        for (kind, (left, right)) in RuleKind::ALL.into_iter().zip(SIDES_PX) {
            let panel = Panel {
                x: Axis::new((low, high), (left, right)),
                y: Axis::new((0.0, MOST_MS), (BOTTOM_PX, TOP_PX)),
            };
            let of_kind: Vec<&OperatingPoint> = points.iter().filter(|p| p.rule.kind == kind).collect();
            draw(pen, &panel, kind, &of_kind);
        }
    })
}

/// The rate at which a rule is shown, each hour.
fn shown_rate(point: &OperatingPoint) -> f64 {
    if point.alarms_per_h > 0.0 { point.alarms_per_h } else { point.alarms_per_h_high }
}

fn draw(pen: &mut Pen<'_>, panel: &Panel, kind: RuleKind, points: &[&OperatingPoint]) {
    let ((x0, y0), (x1, y1)) = panel.corners();
    for power in panel.x.low as i32..=panel.x.high as i32 {
        let x = panel.x.px(f64::from(power));
        pen.line(&[(x, y0), (x, y1)], Stroke::solid(GRID, 1.0));
        let text = if power < -3 { format!("1e{}", number(f64::from(power), 0)) } else { decade(power) };
        pen.text(&text, (x, y1 + 14.0), Anchor::Center, SMALL);
    }
    for (ms, text) in panel.y.ticks(7) {
        let y = panel.y.px(ms);
        pen.line(&[(x0, y), (x1, y)], Stroke::solid(GRID, 1.0));
        pen.text(&text, (x0 - 7.0, y), Anchor::Right, SMALL);
    }
    let asked = panel.y.px(ASKED_MS);
    pen.line(&[(x0, asked), (x1, asked)], Stroke::dashed(LIMIT, 1.0, 4.0, 3.0));
    let name = match kind {
        RuleKind::Lack => "lack of specific force, summed",
        RuleKind::Hold => "below the level all the time",
    };
    pen.text(name, (x0, y0 - 32.0), Anchor::Left, Font { bold: true, ..TITLE });
    pen.text("median until found [ms]", (x0 - 40.0, y0 - 14.0), Anchor::Left, TITLE);
    pen.text("false alarms an hour", (0.5 * (x0 + x1), y1 + 38.0), Anchor::Center, TITLE);
    for (color, level) in LINES.into_iter().zip(LEVELS) {
        let shown = points.iter().filter(|p| p.rule.level == level && 1e3 * p.median_s <= MOST_MS);
        let places: Vec<(Point, bool)> = shown
            .map(|p| (panel.px(math::log10(shown_rate(p)), 1e3 * p.median_s), p.alarms_per_h > 0.0))
            .collect();
        let line: Vec<Point> = places.iter().map(|(at, _)| *at).collect();
        pen.line(&line, Stroke::solid(color, 1.6));
        for (at, counted) in &places {
            if *counted {
                pen.disc(*at, 3.0, color);
            } else {
                pen.dot(*at, (3.5, 2.0), color);
            }
        }
        if let Some((x, y)) = line.first() {
            let font = Font { color, ..SMALL };
            pen.text(&number(level, 2), (x + 6.0, y + 9.0), Anchor::Left, font);
        }
    }
}

/// A power of ten from 0.001 on.
fn decade(power: i32) -> String {
    number(10f64.powi(power), (-power).max(0) as usize)
}
