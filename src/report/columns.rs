//! Numbers and tables for the terminal.

use std::fmt::Display;

/// A line of a table in columns of these widths, a space apart: the first cell to the left, the others to the
/// right. Ends with a line's end.
pub(super) fn columns(widths: &[usize], cells: impl IntoIterator<Item = impl Display>) -> String {
    let mut line = String::new();
    for (i, (cell, &width)) in cells.into_iter().zip(widths).enumerate() {
        line += &if i == 0 { format!("{cell:<width$}") } else { format!(" {cell:>width$}") };
    }
    line + "\n"
}

/// With that many decimals; no "-0.00".
pub(super) fn fixed(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        _ => text,
    }
}

/// With up to that many decimals, none of the last ones zero, so that a given number shows as it was given.
pub(super) fn short(x: f64, digits: usize) -> String {
    let text = fixed(x, digits);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
