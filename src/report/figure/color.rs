//! Colours: one map for J_state, one small palette for lines; both work for colour-blind eyes and in grey.
//!
//! The map is viridis (van der Walt and Smith, CC0), nine of its colours with straight lines in between, in
//! steps fine enough to look even and coarse enough that neighbouring points of a path share one. A cost
//! above 1 is outside the map: red.

/// A colour as red, green and blue.
pub(crate) type Rgb = (u8, u8, u8);

/// Colour of text and of what is drawn like text.
pub(crate) const INK: Rgb = (0x22, 0x22, 0x22);
/// Colour of secondary text: ticks, remarks.
pub(crate) const SOFT_INK: Rgb = (0x55, 0x55, 0x55);
/// Colour of grid lines.
pub(crate) const GRID: Rgb = (0xE4, 0xE4, 0xE4);
/// Colour of the time between release and t = 0.
pub(crate) const BAND: Rgb = (0xEE, 0xEE, 0xEE);
/// Colour of the background.
pub(crate) const WHITE: Rgb = (0xFF, 0xFF, 0xFF);
/// Colour of limits, and of what is beyond them.
pub(crate) const LIMIT: Rgb = (0xC0, 0x1F, 0x2E);
/// Colour of the first line of a panel: north, front (Okabe and Ito's blue).
pub(crate) const FIRST: Rgb = (0x00, 0x72, 0xB2);
/// Colour of the second line of a panel: down, rear (Okabe and Ito's vermilion, a little darker for white
/// ground).
pub(crate) const SECOND: Rgb = (0xCC, 0x55, 0x00);

/// Colour of the third line of a panel: east (Okabe and Ito's bluish green, darker for white ground).
pub(crate) const THIRD: Rgb = (0x00, 0x7A, 0x5A);

const VIRIDIS: [Rgb; 9] = [
    (0x44, 0x01, 0x54),
    (0x47, 0x2D, 0x7B),
    (0x3B, 0x52, 0x8B),
    (0x2C, 0x72, 0x8E),
    (0x21, 0x90, 0x8C),
    (0x27, 0xAD, 0x81),
    (0x5D, 0xC8, 0x63),
    (0xAA, 0xDC, 0x32),
    (0xFD, 0xE7, 0x25),
];

/// Number of colours that a scale shows.
const STEPS: usize = 40;

/// A scale of J_state: from `low` to `high` through the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ColorScale {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl ColorScale {
    /// The scale for these costs, rounded to tenths; 1, the limit, is its highest end.
    pub(crate) fn around(costs: impl Iterator<Item = f64>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for c in costs.filter(|c| c.is_finite()) {
            (low, high) = (low.min(c), high.max(c));
        }
        let low = (low.clamp(0.0, 0.9) * 10.0 + 1e-9).floor() / 10.0;
        let high = ((high.clamp(0.0, 1.0) * 10.0 - 1e-9).ceil() / 10.0).max(low + 0.1);
        Self { low, high }
    }

    /// Number of the colour of a cost; [`STEPS`] stands for red.
    pub(crate) fn step(&self, cost: f64) -> usize {
        if !(cost <= 1.0) {
            return STEPS;
        }
        let fraction = ((cost - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        ((fraction * STEPS as f64) as usize).min(STEPS - 1)
    }

    /// The colour with a number.
    pub(crate) fn color_of_step(step: usize) -> Rgb {
        if step >= STEPS {
            return LIMIT;
        }
        let x = step as f64 / (STEPS - 1) as f64 * (VIRIDIS.len() - 1) as f64;
        let i = (x as usize).min(VIRIDIS.len() - 2);
        let mix =
            |a: u8, b: u8| (f64::from(a) + (x - i as f64) * (f64::from(b) - f64::from(a))).round() as u8;
        let (a, b) = (VIRIDIS[i], VIRIDIS[i + 1]);
        (mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
    }

    /// The colour of a cost.
    pub(crate) fn color(&self, cost: f64) -> Rgb {
        Self::color_of_step(self.step(cost))
    }

    /// All colours in order, each with the cost at which it begins.
    pub(crate) fn colors(&self) -> impl Iterator<Item = (f64, Rgb)> {
        let Self { low, high } = *self;
        (0..STEPS).map(move |i| (low + (high - low) * i as f64 / STEPS as f64, Self::color_of_step(i)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_spans_the_costs_in_tenths_and_ends_at_the_limit() {
        assert_eq!(ColorScale::around([0.25, 0.555].into_iter()), ColorScale { low: 0.2, high: 0.6 });
        assert_eq!(ColorScale::around([0.33, 7.0].into_iter()).high, 1.0);
        let nothing = ColorScale::around([f64::INFINITY].into_iter());
        assert!(nothing.high > nothing.low);
    }

    #[test]
    fn ends_have_the_ends_colours_and_beyond_the_limit_is_red() {
        let scale = ColorScale { low: 0.2, high: 0.6 };
        assert_eq!((scale.color(0.2), scale.color(0.6)), (VIRIDIS[0], VIRIDIS[8]));
        assert_eq!((scale.color(1.0), scale.color(1.001)), (VIRIDIS[8], LIMIT));
        assert_eq!(scale.color(f64::NAN), LIMIT);
    }
}
