//! Texts of others - peers, files, paths - made fit to be printed.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Whether a character would act on a terminal instead of being shown: controls, breaks of lines, and marks
/// that turn the direction of writing.
fn acts(character: char) -> bool {
    character.is_control()
        || matches!(
            character,
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
        )
}

/// A text of others on one line, with each character that would act on a terminal written as a word: `\x1b`
/// for the controls below U+0100 (line breaks and tabulators among them), `\u{202e}` for line separators and
/// marks of direction. What is shown as it is stays as it is.
///
/// ```
/// # use samara_core::printable::printable;
/// assert_eq!(printable("good\r\u{1b}[2Kevil"), r"good\x0d\x1b[2Kevil");
/// assert_eq!(printable("file\u{202e}nosj.txt"), r"file\u{202e}nosj.txt");
/// assert_eq!(printable("Fallschirm über 5 km²"), "Fallschirm über 5 km²");
/// ```
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        let code = u32::from(character);
        // Writing to a string does not fail.
        let _ = match (acts(character), code < 0x100) {
            (false, _) => shown.write_char(character),
            (true, true) => write!(shown, "\\x{code:02x}"),
            (true, false) => write!(shown, "\\u{{{code:x}}}"),
        };
    }
    Cow::Owned(shown)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The whole of C0, DEL, C1, the line separators and the marks of direction of Unicode 16 (UAX #9), and
    /// their neighbours, which are shown.
    #[test]
    fn closed_form_exactly_what_acts_is_written_as_a_word() {
        let acting =
            [0..=0x1f, 0x7f..=0x9f, 0x61c..=0x61c, 0x200e..=0x200f, 0x2028..=0x202e, 0x2066..=0x2069];
        for code in 0..=0x2100_u32 {
            let text = char::from_u32(code).unwrap().to_string();
            let word = if code < 0x100 { format!("\\x{code:02x}") } else { format!("\\u{{{code:x}}}") };
            let expected = if acting.iter().any(|range| range.contains(&code)) { word } else { text.clone() };
            assert_eq!(printable(&text), expected, "U+{code:04X}");
        }
        assert!(matches!(printable("J_TPF 0.461, \u{1f681}"), Cow::Borrowed(_)));
    }
}
