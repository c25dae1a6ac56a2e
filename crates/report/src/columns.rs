//! Numbers for people.

/// With that many decimals; no "-0.00".
pub fn fixed(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        _ => text,
    }
}

/// With up to that many decimals, none of the last ones zero, so that a given number shows as it was given.
pub fn short(x: f64, digits: usize) -> String {
    let text = fixed(x, digits);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// An upper end with that many decimals: not below `x`.
pub fn upper_end(x: f64, digits: usize) -> String {
    let nearest = format!("{x:.digits$}");
    if nearest.parse().is_ok_and(|shown: f64| shown < x) {
        // Half a unit of the last place more is nearest to the next one.
        return fixed(x + 0.5 * f64::powi(0.1, digits as i32), digits);
    }
    fixed(x, digits)
}

/// A probability in three figures, `1.30e-4`; `0` for none.
pub fn probability(p: f64) -> String {
    if p == 0.0 { "0".to_owned() } else { format!("{p:.2e}") }
}

/// The upper end of a probability's interval in three figures: not below it.
pub fn probability_at_most(p: f64) -> String {
    beside(p, |shown| shown < p, 1)
}

/// The lower end of a probability's interval in three figures: not above it.
pub fn probability_at_least(p: f64) -> String {
    beside(p, |shown| shown > p, -1)
}

/// A probability in three figures, the last one more by `more` where the nearest number is on the wrong side.
fn beside(p: f64, wrong: impl Fn(f64) -> bool, more: i32) -> String {
    let nearest = probability(p);
    let Some((figures, power)) = nearest.split_once('e').filter(|_| nearest.parse().is_ok_and(wrong)) else {
        return nearest;
    };
    let (figures, power): (i32, i32) =
        (figures.replace('.', "").parse().unwrap_or(0), power.parse().unwrap_or(0));
    let (figures, power) = match figures + more {
        1000 => (100, power + 1),
        99 => (999, power - 1),
        figures => (figures, power),
    };
    format!("{}.{:02}e{power}", figures / 100, figures % 100)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: ends go outwards, what is exact stays, and a figure is carried.
    #[test]
    fn closed_form_ends_of_intervals() {
        let both = |p: f64| [probability_at_least(p), probability(p), probability_at_most(p)];
        assert_eq!(both(2.9912e-3), ["2.99e-3", "2.99e-3", "3.00e-3"]);
        assert_eq!(both(1.996e-4), ["1.99e-4", "2.00e-4", "2.00e-4"]);
        assert_eq!(both(9.991e-5), ["9.99e-5", "9.99e-5", "1.00e-4"]);
        assert_eq!(both(9.996e-5), ["9.99e-5", "1.00e-4", "1.00e-4"]);
        assert_eq!(both(1.25e-2), ["1.25e-2"; 3]);
        assert_eq!((both(0.0), both(1.0)), (["0"; 3].map(str::to_owned), ["1.00e0"; 3].map(str::to_owned)));
        let upper = |x: f64| upper_end(x, 4);
        assert_eq!([0.12341, 0.12346, 0.1234, 2.0].map(upper), ["0.1235", "0.1235", "0.1234", "2.0000"]);
        assert_eq!([-0.00003, -0.12346, 0.99999].map(upper), ["0.0000", "-0.1234", "1.0000"]);
    }

    /// Whatever the number, the shown ends hold it and are a unit of the last figure apart at most.
    #[test]
    fn prop_shown_ends_hold_the_number() {
        let mut dice = samara_core::random::Stream::new(1, samara_core::random::Purpose::Dice, 2);
        for _ in 0..2000 {
            let p = samara_core::math::exp(-30.0 * dice.uniform());
            let shown = [probability_at_least(p), probability_at_most(p)].map(|s| s.parse::<f64>().unwrap());
            assert!(shown[0] <= p && p <= shown[1] && shown[1] < 1.0101 * shown[0], "{p} {shown:?}");
            let x = 1e3 * dice.normal();
            let end: f64 = upper_end(x, 4).parse().unwrap();
            assert!(x <= end && end < x + 1.01e-4, "{x} {end}");
        }
    }
}
