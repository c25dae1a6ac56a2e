//! Which numbers of a search stand at an end of their range, as a sentence and as JSON.

use samara_core::hints::No;
use samara_core::tune::range_ends::{NEAR_AN_END, RangeEnds, SearchedNumber};
use samara_report::columns::short;
use samara_report::json::result_objects;

/// A number in four figures.
fn figures(x: f64) -> String {
    let digits = match x.abs() {
        s if s >= 100.0 => 1,
        s if s >= 10.0 => 2,
        s if s >= 1.0 => 3,
        s if s >= 0.01 => 4,
        _ => 7,
    };
    short(x, digits)
}

/// The no that is said of numbers at an end of their range; `None` where there are none.
pub fn wall(ends: &RangeEnds) -> Option<No> {
    (!ends.at_end.is_empty()).then_some(No::AtAWall)
}

/// Which numbers stand at an end of their range, a sentence without a full stop; `None` where none does.
pub fn range_ends_words(ends: &RangeEnds) -> Option<String> {
    let named = |number: &SearchedNumber| {
        let end = number.at_end().unwrap_or(number.most);
        let to = if end == number.most { "to" } else { "from" };
        format!("{} {} ({to} {})", number.name, figures(number.value), figures(end))
    };
    let named: Vec<String> = ends.at_end.iter().map(named).collect();
    (!named.is_empty()).then(|| {
        format!(
            "{} of {} numbers stand within {:.0} % of an end of their range: {}",
            named.len(),
            ends.searched,
            100.0 * NEAR_AN_END,
            named.join(", ")
        )
    })
}

result_objects! {
    /// Numbers of a search that stand at an end of their range.
    RangeEndsObject(ends: &RangeEnds) {
        /// How many numbers were searched.
        of: usize = ends.searched,
        /// How near an end counts, as a share of it.
        within: f64 = NEAR_AN_END,
        /// The numbers that stand there.
        numbers: Vec<NumberObject> = ends.at_end.iter().map(NumberObject::of).collect(),
    }

    /// A number that was searched, with its range.
    NumberObject(number: &SearchedNumber) {
        /// Name of the number.
        name: String = number.name.to_string(),
        /// The value that was found.
        value: f64 = number.value,
        /// Least value of the range.
        least: f64 = number.least,
        /// Greatest value of the range.
        most: f64 = number.most,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentence_names_each_number_and_its_end() {
        let number =
            |name: &'static str, value| SearchedNumber { name: name.into(), value, least: 1e-4, most: 5.0 };
        let numbers = [number("K_pq", 4.8123), number("K_iq", 1e-4), number("K_pvx", 1.0)];
        let words = range_ends_words(&RangeEnds::of(numbers)).unwrap();
        let expected = "2 of 3 numbers stand within 6 % of an end of their range: K_pq 4.812 (to 5), K_iq 0.0001 (from 0.0001)";
        assert_eq!(words, expected);
        assert_eq!(range_ends_words(&RangeEnds::of([number("K_pvx", 1.0)])), None);
    }
}
