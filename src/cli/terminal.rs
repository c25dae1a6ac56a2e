//! The terminal: results on stdout, everything else on stderr, and the exit code.

use std::borrow::Cow;
use std::cell::RefCell;
use std::fmt::Display;
use std::io::{self, Write as _};

use super::answer::{Answer, BadInput, Failure};
use samara::printable::printable;

thread_local! {
    /// What a verb prints that another one runs, until that takes it.
    static HELD: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Runs something whose results on stdout, printed by this thread, are held back and given to the caller.
pub fn held<T>(run: impl FnOnce() -> T) -> (T, String) {
    HELD.set(Some(String::new()));
    let result = run();
    (result, HELD.take().unwrap_or_default())
}

/// Prints to stdout; a reader that has gone away (`samara plan | head`) is no error. A device that cannot be
/// written to is one: results that nobody gets are no success.
pub fn print(text: &str) -> Result<(), Failure> {
    let is_held = HELD.with_borrow_mut(|held| held.as_mut().map(|held| held.push_str(text)).is_some());
    if is_held {
        return Ok(());
    }
    let mut out = io::stdout().lock();
    let text = if text.starts_with('{') { Cow::Borrowed(text) } else { fit(text) };
    let painted = (!text.starts_with('{') && colored(&out)).then(|| painted(&text));
    match out.write_all(painted.as_deref().unwrap_or(&text).as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(anyhow::Error::from(e).context("cannot write to stdout")).bad_input()
        }
        _ => Ok(()),
    }
}

/// A text for the terminal: lines, in which nothing that others have named - a path, a vehicle, a peer - acts
/// on the terminal.
fn fit(text: &str) -> Cow<'_, str> {
    let lines = text.split_inclusive(['\n', '\t']).map(|line| {
        let shown = line.trim_end_matches(['\n', '\t']);
        (printable(shown), &line[shown.len()..])
    });
    if lines.clone().all(|(shown, _)| matches!(shown, Cow::Borrowed(_))) {
        return Cow::Borrowed(text);
    }
    Cow::Owned(lines.flat_map(|(shown, end)| [shown, Cow::Borrowed(end)]).collect())
}

/// Whether words of a verdict are coloured: on a terminal alone, and not where NO_COLOR is set
/// (<https://no-color.org>).
fn colored(out: &impl io::IsTerminal) -> bool {
    out.is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

/// Words that say no.
const BAD: [&str; 7] =
    ["EXCEEDED", "NOT STEADY", "NOT safe", "NOT OK", "NOT reproduced", "FAILED", "THE BOUNDS DO NOT HOLD"];
/// Words that say yes.
const GOOD: [&str; 2] = ["ok", "safe"];

/// The text with the words of a verdict in green and red.
fn painted(text: &str) -> String {
    let whole = |line: &str, at: usize, word: &str| {
        let letter = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
        !line[..at].ends_with(letter) && !line[at + word.len()..].starts_with(letter)
    };
    let mut out = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let found = |words: &[&'static str]| {
            words.iter().find_map(|word| {
                let at = line.match_indices(word).find(|(at, _)| whole(line, *at, word))?.0;
                Some((at, *word))
            })
        };
        match found(&BAD).map(|found| (found, 31)).or_else(|| found(&GOOD).map(|found| (found, 32))) {
            Some(((at, word), color)) => {
                let (before, after) = (&line[..at], &line[at + word.len()..]);
                out += &format!("{before}\u{1b}[{color}m{word}\u{1b}[0m{after}");
            }
            None => out += line,
        }
    }
    out
}

/// Prints to stderr. When that is gone or full nobody is left to read, and there is no reason to end.
pub fn print_err(text: &str) {
    let _ = io::stderr().lock().write_all(fit(text).as_bytes());
}

/// Prints remarks to stderr, each behind what it is of: a parameter file, gains or a mission.
pub fn print_remarks(of: impl Display, remarks: &[impl Display]) {
    for remark in remarks {
        print_err(&format!("samara: {of}: {remark}\n"));
    }
}

/// Prints a failure and gives the exit code.
pub fn exit_code(result: Result<Answer, Failure>) -> u8 {
    let (code, whose) = match &result {
        Ok(Answer::Yes) => return 0,
        Ok(Answer::No) => return 1,
        Ok(Answer::Asks) => return 4,
        Err(Failure::BadInput(_)) => (2, ""),
        Err(Failure::Internal(_)) => (3, "internal error: "),
    };
    if let Err(failure) = result {
        print_err(&format!("samara: {whose}{}\n", failure.text()));
    }
    code
}

#[cfg(test)]
mod tests {
    use super::{fit, painted};

    /// Lines and tabulators stay; what would act on a terminal within them is written as a word.
    #[test]
    fn closed_form_nothing_that_others_have_named_acts_on_the_terminal() {
        assert_eq!(fit("a\tb\n\nc\n"), "a\tb\n\nc\n");
        let text = "cannot read x\u{1b}]0;own\u{7}.json\r\n\tfile\u{202e}\u{9b}\n";
        assert_eq!(fit(text), "cannot read x\\x1b]0;own\\x07.json\\x0d\n\tfile\\u{202e}\\x9b\n");
    }

    /// Whole words alone, one a line, and no before yes.
    #[test]
    fn closed_form_words_of_a_verdict_are_painted() {
        let text = "J_TPF 0.5  ok, decided by speed\npitch  EXCEEDED\ngains safety, unsafe\nours: NOT safe\n";
        let expected = "J_TPF 0.5  \u{1b}[32mok\u{1b}[0m, decided by speed\npitch  \u{1b}[31mEXCEEDED\u{1b}[0m\n\
                        gains safety, unsafe\nours: \u{1b}[31mNOT safe\u{1b}[0m\n";
        assert_eq!(painted(text), expected);
    }
}
