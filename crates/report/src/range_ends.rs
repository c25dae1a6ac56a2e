//! Which numbers of a search stand at an end of their range, as a sentence and as JSON.

use serde::Serialize;

use super::columns::short;
use super::json::object;
use samara_core::tune::range_ends::{NEAR_AN_END, RangeEnds, SearchedNumber};

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

/// The value of the key `at_range_ends`.
pub(super) fn range_ends_json(ends: &RangeEnds) -> impl Serialize + use<> {
    let number = |number: &SearchedNumber| {
        object! { name: number.name.clone(), value: number.value, least: number.least, most: number.most }
    };
    object! {
        of: ends.searched,
        within: NEAR_AN_END,
        numbers: ends.at_end.iter().map(number).collect::<Vec<_>>(),
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
