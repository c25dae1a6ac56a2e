//! Numbers of a search's result that stand at an end of their range: beyond it something better may be.

use std::borrow::Cow;

/// So near to an end of its range, as a part of that end's value, a number stands at it; of an end at zero,
/// as a part of the range's width.
pub const NEAR_AN_END: f64 = 0.06;

/// A number that was searched, with the range that it was searched in.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchedNumber {
    /// Name in files.
    pub name: Cow<'static, str>,
    /// The number that was found.
    pub value: f64,
    /// Least value of the range.
    pub least: f64,
    /// Greatest value of the range.
    pub most: f64,
}

impl SearchedNumber {
    /// The end of the range that the number stands at, or lies beyond, if it does: so a ratio decides,
    /// whatever scale the search has. The nearer one, where it stands at both.
    pub fn at_end(&self) -> Option<f64> {
        let Self { value, least, most, .. } = *self;
        let within = |end: f64| NEAR_AN_END * if end == 0.0 { most - least } else { end.abs() };
        let ends = [(value - least, least), (most - value, most)];
        let (_, end) = ends
            .into_iter()
            .filter(|(inside, end)| *inside <= within(*end))
            .min_by(|(a, _), (b, _)| a.total_cmp(b))?;
        Some(end)
    }
}

/// How many numbers were searched, and those that stand at an end of their range.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RangeEnds {
    /// How many were searched.
    pub searched: usize,
    /// Those at an end of their range, in the order of the search.
    pub at_end: Vec<SearchedNumber>,
}

impl RangeEnds {
    /// Of the numbers of a result; one whose range has no width was not searched.
    pub fn of(numbers: impl IntoIterator<Item = SearchedNumber>) -> Self {
        let mut ends = Self::default();
        for number in numbers.into_iter().filter(|number| number.least < number.most) {
            ends.searched += 1;
            ends.at_end.extend(number.at_end().is_some().then_some(number));
        }
        ends
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: 94 % of 5 is 4.7; 106 % of 0.0001 is 0.000106; at zero 6 % of a width of 3 are 0.18.
    #[test]
    fn closed_form_ends_by_a_ratio() {
        let end = |value, least, most| SearchedNumber { name: "k".into(), value, least, most }.at_end();
        for (value, least, most, expected) in [
            (4.73, 1e-4, 5.0, Some(5.0)),
            (4.70, 1e-4, 5.0, Some(5.0)),
            (4.69, 1e-4, 5.0, None),
            (26.9, 1e-4, 5.0, Some(5.0)),
            (1.05e-4, 1e-4, 5.0, Some(1e-4)),
            (1.07e-4, 1e-4, 5.0, None),
            (0.17, 0.0, 3.0, Some(0.0)),
            (0.19, 0.0, 3.0, None),
            (-0.95, -1.0, 1.0, Some(-1.0)),
        ] {
            assert_eq!(end(value, least, most), expected, "{value} of [{least}, {most}]");
        }
    }

    /// The shipped x500's gains in the range that they were found in: three of seven stand at its end.
    #[test]
    fn closed_form_the_x500s_gains_stand_at_the_end_of_their_range() {
        let found = [4.81, 1.2, 4.73, 4.97, 1.1, 2.0, 0.1];
        let number = |value| SearchedNumber { name: "k".into(), value, least: 1e-4, most: 5.0 };
        let fixed = SearchedNumber { name: "k".into(), value: 1.0, least: 1.0, most: 1.0 };
        let ends = RangeEnds::of(found.map(number).into_iter().chain([fixed]));
        assert_eq!(ends.searched, 7);
        assert_eq!(ends.at_end.iter().map(|n| n.value).collect::<Vec<_>>(), [4.81, 4.73, 4.97]);
    }
}
