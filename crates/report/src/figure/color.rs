//! Colours: one map for J_state, one small palette for lines; both work for colour-blind eyes and in grey.
//!
//! The map is viridis (van der Walt and Smith, CC0), nine of its colours with straight lines in between, in
//! steps fine enough to look even and coarse enough that neighbouring points of a path share one. A cost
//! above 1 is outside the map: red.

/// A colour as red, green and blue.
pub type Rgb = (u8, u8, u8);

/// Colour of text and of what is drawn like text.
pub const INK: Rgb = (0x22, 0x22, 0x22);
/// Colour of secondary text: ticks, remarks.
pub const SOFT_INK: Rgb = (0x55, 0x55, 0x55);
/// Colour of grid lines.
pub const GRID: Rgb = (0xE4, 0xE4, 0xE4);
/// Colour of the time between release and t = 0.
pub const BAND: Rgb = (0xEE, 0xEE, 0xEE);
/// Colour of the background.
pub const WHITE: Rgb = (0xFF, 0xFF, 0xFF);
/// Colour of limits, and of what is beyond them.
pub const LIMIT: Rgb = (0xC0, 0x1F, 0x2E);
/// Colour of the first line of a panel: north, front (Okabe and Ito's blue).
pub const FIRST: Rgb = (0x00, 0x72, 0xB2);
/// Colour of the second line of a panel: down, rear (Okabe and Ito's vermilion, a little darker for white
/// ground).
pub const SECOND: Rgb = (0xCC, 0x55, 0x00);

/// Colour of the third line of a panel: east (Okabe and Ito's bluish green, darker for white ground).
pub const THIRD: Rgb = (0x00, 0x7A, 0x5A);
/// Colours of the lines of a panel that may have one for each rotor.
pub const LINES: [Rgb; 8] = [
    FIRST,
    SECOND,
    THIRD,
    (0xB0, 0x45, 0x86),
    (0x9A, 0x6B, 0x00),
    (0x3A, 0x97, 0xD0),
    (0x7D, 0x66, 0x08),
    SOFT_INK,
];

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

/// Number of colours between no cost and the limit.
const STEPS: usize = 40;

/// Number of the colour of a cost, from 0 at no cost to the limit at 1 in every figure; `STEPS` stands for
/// red.
pub fn cost_step(cost: f64) -> usize {
    if !(cost <= 1.0) {
        return STEPS;
    }
    ((cost.max(0.0) * STEPS as f64) as usize).min(STEPS - 1)
}

/// The colour with a number.
pub fn color_of_step(step: usize) -> Rgb {
    if step >= STEPS {
        return LIMIT;
    }
    let x = step as f64 / (STEPS - 1) as f64 * (VIRIDIS.len() - 1) as f64;
    let i = (x as usize).min(VIRIDIS.len() - 2);
    let mix = |a: u8, b: u8| (f64::from(a) + (x - i as f64) * (f64::from(b) - f64::from(a))).round() as u8;
    let (a, b) = (VIRIDIS[i], VIRIDIS[i + 1]);
    (mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

/// The colour of a cost.
pub fn cost_color(cost: f64) -> Rgb {
    color_of_step(cost_step(cost))
}

/// All colours in order, each with the cost at which it begins.
pub fn cost_colors() -> impl Iterator<Item = (f64, Rgb)> {
    (0..STEPS).map(|i| (i as f64 / STEPS as f64, color_of_step(i)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_have_the_ends_colours_and_beyond_the_limit_is_red() {
        assert_eq!((cost_color(0.0), cost_color(1.0)), (VIRIDIS[0], VIRIDIS[8]));
        assert_eq!(
            (cost_color(1.001), cost_color(f64::NAN), cost_color(f64::INFINITY)),
            (LIMIT, LIMIT, LIMIT)
        );
        assert_eq!(cost_color(-1.0), VIRIDIS[0]);
    }
}
