//! An event's message with its arguments in their places: `{1}`, `{2:.1}`, `{3:.1m}`.

use super::argument::Argument;

/// A text is cut when it is longer than this [bytes]: PX4's have some hundred.
const LONGEST: usize = 1000;

/// The message with the arguments put in. Tags go, what they enclose stays; a backslash takes the meaning
/// from what follows it. A place that is none is left as it is.
pub(super) fn filled(message: &str, kinds: &[Argument], packed: &[u8]) -> String {
    let mut text = String::new();
    let mut rest = message;
    while let Some(at) = rest.find(['\\', '<', '{'])
        && text.len() <= LONGEST
    {
        text.push_str(&rest[..at]);
        let (mark, after) = rest[at..].split_at(1);
        let end = |close: char| after.find(close);
        rest = match (mark, end('>'), end('}')) {
            ("\\", ..) => {
                let mut chars = after.chars();
                text.extend(chars.next());
                chars.as_str()
            }
            ("<", Some(close), _) => &after[close + 1..],
            ("{", _, Some(close)) => {
                match placed(&after[..close], kinds, packed) {
                    Some(value) => text.push_str(&value),
                    None => text.push_str(&rest[at..at + close + 2]),
                }
                &after[close + 1..]
            }
            _ => {
                text.push_str(mark);
                after
            }
        };
    }
    text.push_str(rest);
    let end = (0..=LONGEST.min(text.len())).rev().find(|at| text.is_char_boundary(*at));
    text.truncate(end.unwrap_or(0));
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What stands for a place: its number from 1, digits after the point, unit.
fn placed(place: &str, kinds: &[Argument], packed: &[u8]) -> Option<String> {
    let (number, format) = place.split_once(':').unwrap_or((place, ""));
    let index = number.parse::<usize>().ok()?.checked_sub(1)?;
    let (kind, at) = (kinds.get(index)?, kinds[..index].iter().map(Argument::bytes).sum::<usize>());
    let bytes = packed.get(at..at + kind.bytes())?;
    let (digits, unit) = match format.strip_prefix('.') {
        Some(format) => {
            let end = format.find(|c: char| !c.is_ascii_digit()).unwrap_or(format.len());
            (format[..end].parse::<usize>().ok().map(|digits| digits.min(9)), &format[end..])
        }
        None => (None, format),
    };
    let unit = match unit {
        "" => "",
        "C" => " deg C",
        "m" | "m_v" => " m",
        "m^2" => " m^2",
        "m/s" => " m/s",
        _ => return None,
    };
    let mut whole = [0; 8];
    whole[..bytes.len()].copy_from_slice(bytes);
    let unsigned = u64::from_le_bytes(whole);
    let value = match kind {
        Argument::Unsigned(_) => unsigned.to_string(),
        Argument::Signed(width) => {
            let shift = 64 - 8 * u32::from(*width);
            ((unsigned << shift) as i64 >> shift).to_string()
        }
        Argument::Float => {
            let value = f32::from_le_bytes(bytes.try_into().ok()?);
            digits.map_or_else(|| value.to_string(), |digits| format!("{value:.digits$}"))
        }
        Argument::Named { bits: false, names, .. } => {
            names.get(&unsigned).cloned().unwrap_or_else(|| unsigned.to_string())
        }
        Argument::Named { bits: true, names, .. } => {
            let set = |(bit, name): (&u64, &String)| (unsigned & bit != 0).then(|| name.clone());
            let all: Vec<String> = names.iter().filter_map(set).collect();
            all.join(", ")
        }
    };
    Some(value + unit)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::sync::Arc;

    use super::*;

    /// A long name in many places would make gigabytes of one event.
    #[test]
    fn regress_a_text_is_cut_where_it_is_longer_than_a_thousand_bytes() {
        let names = Arc::new(BTreeMap::from([(0, "\u{e9}".repeat(100_000))]));
        let kinds = [Argument::Named { bytes: 1, bits: false, names }];
        let text = filled(&"{1}".repeat(100_000), &kinds, &[0]);
        assert_eq!(text, "\u{e9}".repeat(LONGEST / 2));
    }

    /// The forms that libevents' documentation lists, and what PX4's metadata have.
    #[test]
    fn places_take_their_arguments_digits_and_units() {
        let names = Arc::new(BTreeMap::from([(1, "x".to_owned()), (2, "y".to_owned())]));
        let kinds = [
            Argument::Unsigned(2),
            Argument::Signed(1),
            Argument::Float,
            Argument::Named { bytes: 1, bits: false, names: names.clone() },
            Argument::Named { bytes: 1, bits: true, names },
        ];
        let mut packed = vec![0x34, 0x12, 0xFE];
        packed.extend(2.26_f32.to_le_bytes());
        packed.extend([2, 3]);
        let text = |message: &str| filled(message, &kinds, &packed);
        assert_eq!(text("{1}, {2} and {3:.1m/s}"), "4660, -2 and 2.3 m/s");
        assert_eq!(text("axis {4} of {5}"), "axis y of x, y");
        assert_eq!(text("see <param>SYS_HAS_GPS</param> \\<1\\> \\{1\\}"), "see SYS_HAS_GPS <1> {1}");
        assert_eq!(text("{9} {0} {x} {3:.1furlong} {"), "{9} {0} {x} {3:.1furlong} {");
    }
}
