//! The probability of reaching a cost: the mean of the populations with its interval, each population, the
//! bound, and the smallest probability of interest.

use crate::rare::report::RareReport;
use samara_core::math;
use samara_report::figure::axis::{Axis, Panel, SMALL, TITLE};
use samara_report::figure::canvas::{self, Anchor, FigureError, Font, Pen, Point, Stroke, sub};
use samara_report::figure::color::{FIRST, GRID, INK, LIMIT, Rgb, SOFT_INK};

const WIDTH_PX: u32 = 760;
const HEIGHT_PX: u32 = 520;
const X_PX: (f64, f64) = (76.0, 724.0);
const Y_PX: (f64, f64) = (456.0, 92.0);
/// Inside of the interval.
const INSIDE: Rgb = (0xDC, 0xEA, 0xF5);
/// Lines of the populations.
const POPULATION: Rgb = (0x9F, 0xC4, 0xE2);

/// Draws the probability over J_TPF.
///
/// # Errors
/// [`FigureError::Empty`] where no cost has a probability to show; [`FigureError`] when the backend fails.
pub fn rare_figure(report: &RareReport<'_>) -> Result<String, FigureError> {
    let curve: Vec<_> = report.curve().into_iter().filter(|(_, at)| at.probability > 0.0).collect();
    let (Some((from, _)), Some((to, last))) = (curve.first(), curve.last()) else {
        return Err(FigureError::Empty);
    };
    let search = &report.found.search;
    let decades = math::log10(search.least.min(last.low.max(1e-15)).min(last.probability)).floor();
    let panel =
        Panel { x: Axis::new((*from, search.bound.max(*to)), X_PX), y: Axis::new((decades, 0.0), Y_PX) };
    let title = format!("{}: how often {} reaches a cost", report.mission.name, sub("J", "TPF"));
    let plain = title.replace(&sub("J", "TPF"), "J_TPF");
    canvas::sheet((WIDTH_PX, HEIGHT_PX), (&plain, &report.mission.stamp().csv_comment()), |pen| {
        pen.text(&title, (16.0, 26.0), Anchor::Left, Font { size: 18.0, color: INK, bold: true });
        let sentence = report.sentence().replace("J_TPF", &sub("J", "TPF"));
        pen.text(&sentence, (16.0, 50.0), Anchor::Left, SMALL);
        grid(pen, &panel, decades);
        let place = |x: f64, p: f64| panel.px(x, math::log10(p.max(1e-300)).max(decades));
        let high: Vec<Point> = curve.iter().map(|(x, at)| place(*x, at.high)).collect();
        let low = curve.iter().rev().map(|(x, at)| place(*x, at.low));
        pen.polygon(&high.iter().copied().chain(low).collect::<Vec<_>>(), INSIDE);
        for ascent in &report.found.ascents {
            let of = curve.iter().map(|(x, _)| (*x, ascent.exceedance(*x)));
            let line: Vec<Point> = of.take_while(|(_, p)| *p > 0.0).map(|(x, p)| place(x, p)).collect();
            pen.line(&line, Stroke::solid(POPULATION, 0.8));
        }
        let mean: Vec<Point> = curve.iter().map(|(x, at)| place(*x, at.probability)).collect();
        pen.line(&mean, Stroke::solid(FIRST, 2.0));
        lines(pen, &panel, (search.bound, search.least));
    })
}

fn grid(pen: &mut Pen<'_>, panel: &Panel, decades: f64) {
    let ((x0, y0), (x1, y1)) = panel.corners();
    let every = ((-decades / 12.0).ceil() as i32).max(1);
    for power in (0..=-(decades as i32)).step_by(every as usize) {
        let y = panel.y.px(f64::from(-power));
        pen.line(&[(x0, y), (x1, y)], Stroke::solid(GRID, 1.0));
        let text = if power == 0 { "1".to_owned() } else { format!("1e\u{2212}{power}") };
        pen.text(&text, (x0 - 7.0, y), Anchor::Right, SMALL);
    }
    for (x, text) in panel.x.ticks(8) {
        let px = panel.x.px(x);
        pen.line(&[(px, y0), (px, y1)], Stroke::solid(GRID, 1.0));
        pen.text(&text, (px, y1 + 14.0), Anchor::Center, SMALL);
    }
    pen.text(&sub("J", "TPF"), (0.5 * (x0 + x1), y1 + 38.0), Anchor::Center, TITLE);
    pen.text("probability of reaching it", (x0 - 60.0, y0 - 16.0), Anchor::Left, TITLE);
}

/// The bound and the smallest probability of interest.
fn lines(pen: &mut Pen<'_>, panel: &Panel, (bound, least): (f64, f64)) {
    let ((x0, y0), (x1, y1)) = panel.corners();
    let x = panel.x.px(bound);
    pen.line(&[(x, y0), (x, y1)], Stroke::solid(LIMIT, 1.2));
    pen.text("failure", (x - 6.0, y0 + 10.0), Anchor::Right, Font { color: LIMIT, ..SMALL });
    let y = panel.y.px(math::log10(least));
    pen.line(&[(x0, y), (x1, y)], Stroke::dashed(SOFT_INK, 1.0, 4.0, 3.0));
    pen.text("of interest down to here", (x0 + 6.0, y - 9.0), Anchor::Left, SMALL);
}
