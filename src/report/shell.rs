//! Commands as they are typed into a POSIX shell.

use std::borrow::Cow;

use crate::printable::printable;

/// A word as a shell reads it back: as it is where no character of it means anything to a shell, else in
/// single quotes; in `$'..'`, byte by byte, where a character would act on a terminal.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./=:,+@%".contains(c);
    // A shell takes `~` for a folder and a leading `=` for a path in some; what is empty would be no word.
    if !word.is_empty() && !word.starts_with('=') && word.chars().all(plain) {
        return word.to_owned();
    }
    if let Cow::Owned(_) = printable(word) {
        return format!("$'{}'", word.chars().map(in_bytes).collect::<String>());
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// A character within `$'..'`.
fn in_bytes(character: char) -> String {
    let text = character.to_string();
    match (character, printable(&text)) {
        ('\'' | '\\', _) => format!("\\{character}"),
        (_, Cow::Borrowed(_)) => text,
        (_, Cow::Owned(_)) => text.bytes().map(|byte| format!("\\x{byte:02x}")).collect(),
    }
}

/// A command of these words, quoted, with a space between.
pub fn command_line(words: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    words.into_iter().map(|word| quoted(word.as_ref())).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// POSIX.1-2017, XCU 2.2.2: within single quotes every character stands for itself but the quote.
    /// POSIX.1-2024, XCU 2.2.4: within `$'..'` `\xXX` is a byte.
    #[test]
    fn closed_form_words_are_quoted_where_they_must_be() {
        let line =
            command_line(["samara", "drop", "a b.json", "--gains", "it's", "$(rm)", "~/x", "", "px4=/b"]);
        assert_eq!(command_line(["x\n=cmd|\u{1b}]0;o'\\\u{202e}"]), r"$'x\x0a=cmd|\x1b]0;o\'\\\xe2\x80\xae'");
        assert_eq!(line, "samara drop 'a b.json' --gains 'it'\\''s' '$(rm)' '~/x' '' px4=/b");
    }
}
