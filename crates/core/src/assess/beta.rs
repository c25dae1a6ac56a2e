//! The beta distribution, which Student's t and the exact binomial interval are made of.
//!
//! `I_x(a, b)`, the regularised incomplete beta function, by its continued fraction (Lentz's method); its
//! inverse by bisection, to the last bit that the function resolves. `ln Gamma` by Lanczos' sum (g = 7, nine
//! terms).

use crate::math;

/// `ln Gamma(x)` for x > 0.
fn ln_gamma(x: f64) -> f64 {
    const G: f64 = 7.0;
    const FIRST: f64 = 0.999_999_999_999_809_9;
    const COEFFICIENTS: [f64; 8] = [
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    let x = x - 1.0;
    let sum = (1..).zip(COEFFICIENTS).fold(FIRST, |sum, (i, c)| sum + c / (x + f64::from(i)));
    let t = x + G + 0.5;
    0.5 * math::ln(2.0 * std::f64::consts::PI) + (x + 0.5) * math::ln(t) - t + math::ln(sum)
}

/// `I_x(a, b)`: the probability that a beta variable is below `x`; a, b > 0.
pub fn beta_cdf(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    let front =
        math::exp(ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * math::ln(x) + b * math::ln_1p(-x));
    // The fraction converges quickly on one side of the mean; the other is its mirror image.
    if x < (a + 1.0) / (a + b + 2.0) {
        front * continued_fraction(x, a, b) / a
    } else {
        1.0 - front * continued_fraction(1.0 - x, b, a) / b
    }
}

fn continued_fraction(x: f64, a: f64, b: f64) -> f64 {
    const TINY: f64 = 1e-300;
    const TERMS: u32 = 100_000;
    let away_from_zero = |x: f64| if x.abs() < TINY { TINY } else { x };
    let mut c = 1.0;
    let mut d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
    let mut fraction = d;
    for m in (1..TERMS).map(f64::from) {
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let before = fraction;
        for term in [even, odd] {
            d = 1.0 / away_from_zero(1.0 + term * d);
            c = away_from_zero(1.0 + term / c);
            fraction *= d * c;
        }
        if (fraction - before).abs() <= 1e-16 * fraction.abs() {
            break;
        }
    }
    fraction
}

/// The `x` with `I_x(a, b) = p`.
pub fn beta_quantile(p: f64, a: f64, b: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if beta_cdf(middle, a, b) < p {
            low = middle;
        } else {
            high = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_gamma() {
        for (x, wanted) in
            [(0.5, math::ln(std::f64::consts::PI.sqrt())), (1.0, 0.0), (11.0, math::ln(3_628_800f64))]
        {
            assert!((ln_gamma(x) - wanted).abs() < 1e-13, "{x}: {}", ln_gamma(x));
        }
    }

    /// Shapes from 0.5 to 1000, two standard deviations about the mean, by mpmath at 50 digits.
    #[test]
    fn reference_beta_distribution_is_that_of_another_library() {
        let rows: Vec<&str> = include_str!("../../../../tests/data/beta.csv").lines().skip(2).collect();
        assert_eq!(rows.len(), 108);
        for row in rows {
            let numbers: Vec<f64> = row.split(',').map(|number| number.parse().unwrap()).collect();
            let [x, a, b, wanted] = numbers[..] else { panic!("{row}") };
            let value = beta_cdf(x, a, b);
            assert!((value - wanted).abs() < 1e-12, "{row}: {value}");
        }
    }

    /// `I_x(1, b) = 1 - (1 - x)^b`, `I_x(a, 1) = x^a`, `I_x(1/2, 1/2) = 2/pi asin(sqrt x)`.
    #[test]
    fn closed_form_beta_distribution() {
        for x in [1e-6f64, 0.03, 0.5, 0.97] {
            for k in [1.0f64, 3.5, 100.0] {
                assert!((beta_cdf(x, 1.0, k) - (1.0 - math::powf(1.0 - x, k))).abs() < 1e-13);
                assert!((beta_cdf(x, k, 1.0) - math::powf(x, k)).abs() < 1e-13);
            }
            let arcsine = math::asin(x.sqrt()) * std::f64::consts::FRAC_2_PI;
            assert!((beta_cdf(x, 0.5, 0.5) - arcsine).abs() < 1e-13);
        }
    }

    #[test]
    fn closed_form_quantile_undoes_the_distribution() {
        for (a, b) in [(0.5, 49.5), (3.0, 98.0), (99_990.0, 11.0)] {
            for p in [0.025, 0.5, 0.975] {
                assert!((beta_cdf(beta_quantile(p, a, b), a, b) - p).abs() < 1e-9, "{a} {b} {p}");
            }
        }
    }
}
