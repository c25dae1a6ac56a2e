//! Commands as they are typed into a POSIX shell.

use std::borrow::Cow;

use samara_core::printable::printable;

/// A word as a shell reads it back: as it is where no character of it means anything to a shell, else in
/// single quotes; in those of POSIX.1-2024's `$'..'` where a character would act on a terminal.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./=:,+@%".contains(c);
    // A shell takes `~` for a folder and a leading `=` for a path in some; what is empty would be no word.
    if !word.is_empty() && !word.starts_with('=') && word.chars().all(plain) {
        return word.to_owned();
    }
    if matches!(printable(word), Cow::Borrowed(_)) {
        return format!("'{}'", word.replace('\'', "'\\''"));
    }
    let mut escaped = String::from("$'");
    for character in word.chars() {
        let text = character.to_string();
        match (character, printable(&text)) {
            ('\'' | '\\', _) => escaped.extend(['\\', character]),
            (_, Cow::Borrowed(_)) => escaped.push(character),
            // A third digit would be taken for one of the code.
            _ => text.bytes().for_each(|byte| escaped += &format!("\\{byte:03o}")),
        }
    }
    escaped + "'"
}

/// A command of these words, quoted, with a space between.
pub fn command_line(words: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    words.into_iter().map(|word| quoted(word.as_ref())).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// POSIX.1-2024, XCU 2.2.4: `\ddd` is the byte of that octal code, also where digits follow.
    #[test]
    fn closed_form_what_would_act_on_a_terminal_is_quoted_by_its_bytes() {
        assert_eq!(quoted("a\n1"), "$'a\\0121'");
        assert_eq!(quoted("it's\u{1b}[2J\\\u{202e}"), "$'it\\'s\\033[2J\\\\\\342\\200\\256'");
    }

    /// POSIX.1-2017, XCU 2.2.2: within single quotes every character stands for itself but the quote.
    #[test]
    fn closed_form_words_are_quoted_where_they_must_be() {
        let line =
            command_line(["samara", "drop", "a b.json", "--gains", "it's", "$(rm)", "~/x", "", "px4=/b"]);
        assert_eq!(line, "samara drop 'a b.json' --gains 'it'\\''s' '$(rm)' '~/x' '' px4=/b");
    }
}
