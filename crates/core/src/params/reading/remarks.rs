//! Remarks on lines, by what there is to say of them: few, however many lines there are.

use std::collections::BTreeMap;

/// Most lines that are named in a remark; the others are counted.
const LINES_NAMED: usize = 4;
/// Most remarks; what else there is to say is counted.
const MOST: usize = 24;

/// What there is to say, with the lines that it is about.
#[derive(Default)]
pub(super) struct Remarks(BTreeMap<String, Vec<usize>>);

impl Remarks {
    /// Notes something about a line.
    pub(super) fn note(&mut self, line: usize, words: impl Into<String>) {
        self.0.entry(words.into()).or_default().push(line);
    }

    /// The remarks in the order of their first lines.
    pub(super) fn said(self) -> Vec<String> {
        let mut all: Vec<(String, Vec<usize>)> = self.0.into_iter().collect();
        all.sort_by_key(|(_, lines)| lines.first().copied());
        let more = all.len().saturating_sub(MOST);
        let mut said: Vec<String> =
            all.iter().take(MOST).map(|(words, lines)| remark(words, lines)).collect();
        if more > 0 {
            said.push(format!("{more} more remarks of other kinds"));
        }
        said
    }
}

fn remark(words: &str, lines: &[usize]) -> String {
    let named: Vec<String> = lines.iter().take(LINES_NAMED).map(usize::to_string).collect();
    let more = match lines.len().saturating_sub(LINES_NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let s = if lines.len() == 1 { "" } else { "s" };
    format!("line{s} {}{more}: {words}", named.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_told_together_by_what_there_is_to_say() {
        let mut remarks = Remarks::default();
        remarks.note(9, "odd");
        (2..=7).for_each(|line| remarks.note(line, "strange"));
        assert_eq!(remarks.said(), ["lines 2, 3, 4, 5 and 2 more: strange", "line 9: odd"]);
        let mut many = Remarks::default();
        (0..30).for_each(|i| many.note(i, format!("{i:02}")));
        assert_eq!(many.said().last().unwrap(), "6 more remarks of other kinds");
    }
}
