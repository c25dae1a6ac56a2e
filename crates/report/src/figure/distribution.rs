//! Distributions of a campaign's quantities: for each the share of the trials that stay at or below a value,
//! a line per controller, beside the limit.

use super::axis::{Axis, Panel, SMALL, TITLE, range};
use super::canvas::{self, Anchor, FigureError, Font, Pen, Point, Stroke, text_width};
use super::color::{FIRST, INK, LIMIT, Rgb, SECOND, SOFT_INK, THIRD};
use super::label::{LabelPlace, Room};

const WIDTH_PX: u32 = 960;
const LEFT_PX: [f64; 2] = [62.0, 540.0];
const PANEL_PX: (f64, f64) = (404.0, 200.0);
const TOP_PX: f64 = 104.0;
/// Distance from one row of panels to the next [px].
const ROW_PX: f64 = 288.0;
const HEADLINE: Font = Font { size: 18.0, color: INK, bold: true };
/// Colours of the controllers; the judged one has the first.
const COLORS: [Rgb; 4] = [FIRST, SECOND, THIRD, SOFT_INK];
/// Dashes of the controllers [px]; none for the judged one.
const DASHES: [Option<(f64, f64)>; 4] = [None, Some((6.0, 3.0)), Some((2.0, 3.0)), Some((9.0, 3.0))];
/// A limit farther than this share of the values' range beyond them is left out of the panel.
const LIMIT_AIR: f64 = 1.5;

/// The distribution of one quantity.
#[derive(Clone, Debug)]
pub struct Distribution {
    /// Name with unit.
    pub name: String,
    /// The limit, where there is one.
    pub limit: Option<f64>,
    /// For each controller its name, the values of its trials, and the number of trials; one without a value
    /// (never steady) counts as beyond every value.
    pub controllers: Vec<(String, Vec<f64>, usize)>,
}

/// Draws the distributions in panels, two to a row.
///
/// # Errors
/// [`FigureError`] when no value is finite or the backend fails.
pub fn distribution_figure(
    origin: &str,
    title: &str,
    remark: &str,
    distributions: &[Distribution],
) -> Result<String, FigureError> {
    let shown: Vec<(&Distribution, (f64, f64))> =
        distributions.iter().filter_map(|d| Some((d, span(d)?))).collect();
    if shown.is_empty() {
        return Err(FigureError::Empty);
    }
    let rows = shown.len().div_ceil(2);
    let height = (TOP_PX + ROW_PX * rows as f64).ceil() as u32 - 20;
    canvas::sheet((WIDTH_PX, height), (title, origin), |pen| {
        pen.text(title, (16.0, 26.0), Anchor::Left, HEADLINE);
        pen.text(remark, (16.0, 51.0), Anchor::Left, SMALL);
        for (place, (distribution, span)) in shown.iter().enumerate() {
            panel(pen, distribution, *span, place);
        }
    })
}

/// The range of values that a panel shows, with its limit where that is near.
fn span(distribution: &Distribution) -> Option<(f64, f64)> {
    let (low, high) = range(distribution.controllers.iter().flat_map(|(_, x, _)| x.iter().copied()))?;
    let width = (high - low).max(1e-3 * high.abs()).max(1e-9);
    let near = distribution.limit.filter(|limit| *limit <= high + LIMIT_AIR * width && *limit >= low);
    let high = near.map_or(high, |limit| high.max(limit));
    let air = 0.04 * (high - low).max(width);
    Some((low - air, high + air))
}

fn panel(pen: &mut Pen<'_>, distribution: &Distribution, span: (f64, f64), place: usize) {
    let (left, top) = (LEFT_PX[place % 2], TOP_PX + ROW_PX * (place / 2) as f64);
    let panel = Panel {
        x: Axis::new(span, (left, left + PANEL_PX.0)),
        y: Axis::new((0.0, 100.0), (top + PANEL_PX.1, top)),
    };
    pen.text("share of the trials [%]", (left - 44.0, top - 14.0), Anchor::Left, SMALL);
    let beneath = (left + 0.5 * PANEL_PX.0, top + PANEL_PX.1 + 34.0);
    pen.text(&distribution.name, beneath, Anchor::Center, TITLE);
    panel.grid(pen, 6, 5, true);
    let mut room = Room::new(panel.corners());
    if let Some(limit) = distribution.limit {
        if limit <= span.1 {
            let line = [panel.px(limit, 0.0), panel.px(limit, 100.0)];
            room.line(pen, &line, Stroke::dashed(LIMIT, 1.4, 8.0, 3.0));
            let text = format!("limit {limit:.2}");
            name(pen, &mut room, &text, line[0], LIMIT);
        } else {
            let text = format!("limit {limit:.2}, beyond the right edge");
            pen.text(&text, (left + PANEL_PX.0, top - 14.0), Anchor::Right, Font { color: LIMIT, ..SMALL });
        }
    }
    let lines: Vec<Vec<Point>> =
        distribution.controllers.iter().map(|(_, values, trials)| steps(&panel, values, *trials)).collect();
    for (i, line) in lines.iter().enumerate() {
        let color = COLORS[i % COLORS.len()];
        let stroke = match DASHES[i % DASHES.len()] {
            None => Stroke::solid(color, 2.0),
            Some((dash, gap)) => Stroke::dashed(color, 1.8, dash, gap),
        };
        room.line(pen, line, stroke);
    }
    for (i, (line, (label, ..))) in lines.iter().zip(&distribution.controllers).enumerate() {
        let Some(middle) = line.get(line.len() / 2) else { continue };
        name(pen, &mut room, label, *middle, COLORS[i % COLORS.len()]);
    }
}

/// Writes a name where there is room near a point.
fn name(pen: &mut Pen<'_>, room: &mut Room, text: &str, (x, y): Point, color: Rgb) {
    let font = Font { color, ..SMALL };
    let half = 0.5 * text_width(text, font.size) + 8.0;
    let heights = [-14.0, 14.0, -34.0, 34.0, -58.0, 58.0, -84.0, 84.0, -110.0, 110.0, -140.0, 140.0];
    let places = heights
        .iter()
        .flat_map(|dy| [half, -half].map(|dx| LabelPlace::around((x + dx, y + dy), 2.0 * half - 12.0, 14.0)));
    room.write(pen, (text, font), places);
}

/// The share of the trials at or below each value, as a line of steps.
fn steps(panel: &Panel, values: &[f64], trials: usize) -> Vec<Point> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let share = |count: usize| 100.0 * count as f64 / trials.max(1) as f64;
    let mut line = Vec::with_capacity(2 * sorted.len());
    for (i, x) in sorted.iter().enumerate() {
        line.extend([panel.px(*x, share(i)), panel.px(*x, share(i + 1))]);
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three of four trials have a value: the line ends at three quarters, each step a quarter high.
    #[test]
    fn closed_form_steps() {
        let panel =
            Panel { x: Axis::new((0.0, 4.0), (0.0, 400.0)), y: Axis::new((0.0, 100.0), (100.0, 0.0)) };
        let line = steps(&panel, &[3.0, 1.0, 2.0, f64::INFINITY], 4);
        let expected =
            [(100.0, 100.0), (100.0, 75.0), (200.0, 75.0), (200.0, 50.0), (300.0, 50.0), (300.0, 25.0)];
        assert_eq!(line.len(), expected.len());
        for (a, b) in line.iter().zip(expected) {
            assert!((a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-9, "{line:?}");
        }
    }

    /// A limit that is near is in the panel, one far away is not; without values there is no figure.
    #[test]
    fn a_limit_is_shown_where_it_is_near() {
        let of = |limit| Distribution {
            name: "x".to_owned(),
            limit: Some(limit),
            controllers: vec![("a".to_owned(), vec![1.0, 2.0], 2)],
        };
        assert!(span(&of(2.5)).unwrap().1 > 2.5 && span(&of(100.0)).unwrap().1 < 3.0);
        assert!(distribution_figure("", "t", "r", &[of(2.5), of(100.0)]).unwrap().contains("limit 2.50"));
        let empty = Distribution { controllers: vec![("a".to_owned(), vec![], 3)], ..of(1.0) };
        assert!(matches!(distribution_figure("", "t", "r", &[empty]), Err(FigureError::Empty)));
    }
}
