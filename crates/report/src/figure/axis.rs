//! Axes: from numbers to pixels, round ticks, numbers as text.

use super::canvas::{Anchor, Font, Pen, Point, Stroke};
use super::color::{GRID, INK, SOFT_INK};
use crate::columns;
use samara_core::math;

/// Text of ticks and labels at lines.
pub const SMALL: Font = Font { size: 12.0, color: SOFT_INK, bold: false };
/// Font of titles of panels and axes, and of names beside lines.
pub const TITLE: Font = Font { size: 12.5, color: INK, bold: false };

/// Fewest ticks that make a scale.
const FEWEST: usize = 3;

/// A linear scale: `low` is drawn at `low_px`, `high` at `high_px`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
    /// Place of the least value [px].
    pub low_px: f64,
    /// Place of the greatest value [px].
    pub high_px: f64,
}

impl Axis {
    /// The scale from the lower to the higher of two numbers, between the pixels at which they are drawn.
    pub fn new((low, high): (f64, f64), (low_px, high_px): (f64, f64)) -> Self {
        Self { low, high, low_px, high_px }
    }

    /// Pixel at which a number is drawn.
    pub fn px(&self, x: f64) -> f64 {
        self.low_px + (x - self.low) / (self.high - self.low) * (self.high_px - self.low_px)
    }

    /// About `count` round numbers within the scale, as numbers and as text; at least `FEWEST` where the
    /// scale allows.
    pub fn ticks(&self, count: usize) -> Vec<(f64, String)> {
        let finer = (0..3).map(|k| self.about(count << k));
        finer.reduce(|found, finer| if found.len() < FEWEST { finer } else { found }).unwrap_or_default()
    }

    fn about(&self, count: usize) -> Vec<(f64, String)> {
        let step = round_step((self.high - self.low) / count as f64);
        if !(step > 0.0 && step.is_finite()) {
            return Vec::new();
        }
        let decimals = (-(math::log10(step) + 1e-9).floor()).clamp(0.0, 12.0) as usize;
        let first = (self.low / step - 1e-6).ceil();
        // At most 10 count ticks fit, whatever the numbers are.
        (0..10 * count)
            .map(|i| (first + i as f64) * step)
            .take_while(|x| *x <= self.high + 1e-6 * step)
            .map(|x| (x, number(x, decimals)))
            .collect()
    }
}

/// The round number - 1, 2 or 5 times a power of ten - at or above `x`.
pub fn round_step(x: f64) -> f64 {
    let power = math::powf(10f64, (math::log10(x) + 1e-9).floor());
    [1.0, 2.0, 5.0].into_iter().map(|m| m * power).find(|s| *s >= x * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

/// A number with a minus sign proper, and none before zero.
pub fn number(x: f64, decimals: usize) -> String {
    columns::fixed(x, decimals).replace('-', "\u{2212}")
}

/// A number with as many decimals (two at most) as it has.
pub fn short(x: f64) -> String {
    columns::short(x, 2).replace('-', "\u{2212}")
}

/// Range of the finite values; `None` when there are none.
pub fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|x| x.is_finite()).fold(None, |r, x| match r {
        None => Some((x, x)),
        Some((low, high)) => Some((low.min(x), high.max(x))),
    })
}

/// A rectangle for curves: one axis to the right, one up or down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panel {
    /// Axis to the right.
    pub x: Axis,
    /// Axis upwards.
    pub y: Axis,
}

impl Panel {
    /// Point at which a pair of numbers is drawn.
    pub fn px(&self, x: f64, y: f64) -> Point {
        (self.x.px(x), self.y.px(y))
    }

    /// Upper left and lower right corner.
    pub fn corners(&self) -> (Point, Point) {
        let (y0, y1) = (self.y.low_px.min(self.y.high_px), self.y.low_px.max(self.y.high_px));
        ((self.x.low_px, y0), (self.x.high_px, y1))
    }

    /// Grid lines with numbers at the left, and below if `below`.
    pub fn grid(&self, pen: &mut Pen<'_>, columns: usize, rows: usize, below: bool) {
        let ((x0, y0), (x1, y1)) = self.corners();
        let line = Stroke::solid(GRID, 1.0);
        for (x, text) in self.x.ticks(columns) {
            let px = self.x.px(x);
            pen.line(&[(px, y0), (px, y1)], line);
            if below {
                pen.text(&text, (px, y1 + 13.0), Anchor::Center, SMALL);
            }
        }
        for (y, text) in self.y.ticks(rows) {
            let px = self.y.px(y);
            pen.line(&[(x0, px), (x1, px)], line);
            pen.text(&text, (x0 - 7.0, px), Anchor::Right, SMALL);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(low: f64, high: f64, count: usize) -> Vec<String> {
        let axis = Axis::new((low, high), (0.0, 100.0));
        axis.ticks(count).into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn ticks_are_round_and_have_the_decimals_they_need() {
        assert_eq!(texts(-2.5, 34.5, 8), ["0", "5", "10", "15", "20", "25", "30"]);
        assert_eq!(texts(-0.31, 0.2, 5), ["\u{2212}0.2", "0.0", "0.2"]);
        assert_eq!(texts(0.0, 300.0, 3), ["0", "100", "200", "300"]);
        // By twenties there would be one.
        assert_eq!(texts(-17.0, 32.0, 3), ["\u{2212}10", "0", "10", "20", "30"]);
        assert_eq!(texts(1.0, 1.0, 5), [""; 0]);
        assert_eq!(texts(f64::NAN, 1.0, 5), [""; 0]);
    }

    #[test]
    fn numbers_lose_what_says_nothing() {
        assert_eq!(
            (number(-0.001, 2).as_str(), short(12.0).as_str(), short(-0.25).as_str()),
            ("0.00", "12", "\u{2212}0.25")
        );
    }
}
