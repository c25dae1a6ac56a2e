//! Where work is cut into parts, each with a file of its own: shards of a campaign, candidates of a search.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Most parts of a whole: their numbers have five digits in the names of files.
pub const PARTS_MOST: u64 = 100_000;

/// Part number `part` of `of` parts, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Number of the part.
    pub part: u64,
    /// Number of parts.
    pub of: u64,
}

impl Cut {
    /// The whole, as one part.
    pub const WHOLE: Self = Self { part: 0, of: 1 };

    /// A part of 1 to [`PARTS_MOST`], or nothing.
    fn checked(self) -> Option<Self> {
        ((1..=PARTS_MOST).contains(&self.of) && self.part < self.of).then_some(self)
    }

    /// The places of this part's of so many things: `[floor(part count/of), floor((part+1) count/of))`.
    pub fn range(&self, count: u64) -> Range<u64> {
        let of = u128::from(self.of.max(1));
        let cut = |part: u64| u64::try_from(u128::from(part) * u128::from(count) / of).unwrap_or(count);
        cut(self.part)..cut(self.part + 1)
    }

    /// How the name of the part's file tells it, `00017-of-01000`.
    pub fn name(&self) -> String {
        format!("{:05}-of-{:05}", self.part, self.of)
    }

    /// The part of a [`Cut::name`]; `None` for any other text.
    pub fn of_name(name: &str) -> Option<Self> {
        let (part, of) = name.split_once("-of-")?;
        let cut = Self { part: part.parse().ok()?, of: of.parse().ok()? }.checked()?;
        (cut.name() == name).then_some(cut)
    }
}

impl fmt::Display for Cut {
    /// Part I of N, as `I/N`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.part, self.of)
    }
}

impl FromStr for Cut {
    type Err = String;

    /// Part I of N, as `I/N`.
    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        parts
            .and_then(|(part, of)| Self { part, of }.checked())
            .ok_or_else(|| format!("I/N is expected, N from 1 to {PARTS_MOST}, I from 0 to N-1, such as 0/4"))
    }
}

/// Ascending numbers as `0-3,17`.
pub fn ranges(numbers: &[u64]) -> String {
    let mut ranges: Vec<(u64, u64)> = Vec::new();
    for &number in numbers {
        match ranges.last_mut() {
            Some((_, last)) if *last + 1 == number => *last = number,
            _ => ranges.push((number, number)),
        }
    }
    let words =
        ranges.iter().map(|(from, to)| if from == to { from.to_string() } else { format!("{from}-{to}") });
    words.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: ten things in three parts are 3, 3 and 4; whatever the numbers, parts follow each other from
    /// the first thing to the last.
    #[test]
    fn closed_form_parts_are_each_thing_once() {
        let parts = |of: u64, count: u64| (0..of).map(move |part| Cut { part, of }.range(count));
        assert_eq!(parts(3, 10).collect::<Vec<_>>(), [0..3, 3..6, 6..10]);
        assert_eq!(parts(4, 2).collect::<Vec<_>>(), [0..0, 0..1, 1..1, 1..2]);
        for (of, count) in [(1, 0), (7, 530), (1000, 100_000_000), (99_991, 1_000_000_000), (3, u64::MAX)] {
            let end = parts(of, count).fold(0, |next, part| {
                assert_eq!(part.start, next);
                part.end
            });
            assert_eq!(end, count);
        }
    }

    #[test]
    fn a_name_tells_the_part_and_nothing_else_does() {
        let cut = Cut { part: 17, of: 1000 };
        assert_eq!(cut.name(), "00017-of-01000");
        assert_eq!(Cut::of_name("00017-of-01000"), Some(cut));
        for bad in
            ["17-of-1000", "01000-of-01000", "+0017-of-01000", "00000-of-00000", "00000-of-100001", "x"]
        {
            assert_eq!(Cut::of_name(bad), None, "{bad}");
        }
    }

    #[test]
    fn what_is_typed_is_a_part_or_refused() {
        assert_eq!("17/1000".parse(), Ok(Cut { part: 17, of: 1000 }));
        for bad in ["", "1", "4/4", "0/0", "-1/4", "0/100001", "1/x"] {
            assert!(bad.parse::<Cut>().is_err_and(|why| why.starts_with("I/N is expected")), "{bad}");
        }
    }

    #[test]
    fn closed_form_numbers_as_an_array() {
        for (numbers, text) in [(&[][..], ""), (&[3], "3"), (&[0, 1, 2, 5, 7, 8], "0-2,5,7-8")] {
            assert_eq!(ranges(numbers), text);
        }
    }
}
