//! The rows of a study, kept as lines of numbers: one for each job, in the order in which the study has them
//! flown. What was being written when a run was killed is no whole line and is flown again.

use std::io::{self, Write};

use samara_core::printable::printable;
use samara_study::jobs::Numbers;

/// Where rows go, and those that an earlier run has left.
#[derive(Default)]
pub struct KeptRows {
    earlier: std::vec::IntoIter<Numbers>,
    sink: Option<Box<dyn Write>>,
    line: String,
}

impl KeptRows {
    /// Keeps rows nowhere.
    pub fn nowhere() -> Self {
        Self::default()
    }

    /// Goes on from earlier rows ([`read`]) and keeps those that follow them.
    pub fn going_on(earlier: Vec<Numbers>, sink: Box<dyn Write>) -> Self {
        Self { earlier: earlier.into_iter(), sink: Some(sink), ..Self::default() }
    }

    /// The numbers of the next row of an earlier run, if there is one.
    pub(crate) fn earlier(&mut self) -> Option<Numbers> {
        self.earlier.next()
    }

    /// Keeps a row of these numbers.
    pub(crate) fn keep(&mut self, numbers: &[f64]) -> io::Result<()> {
        let Some(sink) = &mut self.sink else { return Ok(()) };
        self.line.clear();
        push_line(&mut self.line, numbers);
        sink.write_all(self.line.as_bytes())
    }
}

/// Puts the line of a row's numbers behind a text.
pub fn push_line(text: &mut String, numbers: &[f64]) {
    for (i, number) in numbers.iter().enumerate() {
        if i > 0 {
            text.push(',');
        }
        // The shortest digits that mean this number.
        *text += &format!("{number:?}");
    }
    text.push('\n');
}

pub(crate) fn not_a_row() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, "a row that was kept is not one of this study")
}

/// The rows of a file that an earlier run has left, and how many of its bytes are whole lines: none where it
/// was ended within its first one, which is to be `head`.
///
/// # Errors
/// What is expected and what was found, where the file begins otherwise.
pub fn going_on(text: &str, head: &str) -> Result<(Vec<Numbers>, usize), String> {
    match text.strip_prefix(head) {
        Some(rows) => {
            let (rows, whole) = read(rows);
            Ok((rows, head.len() + whole))
        }
        None if head.starts_with(text) => Ok((Vec::new(), 0)),
        None => Err(format!(
            "these rows are of other inputs; expected `{}`, found `{}`",
            head.trim_end(),
            printable(text.lines().next().unwrap_or_default())
        )),
    }
}

/// The rows of a text that was kept, and how many bytes of it are whole lines of numbers.
pub fn read(text: &str) -> (Vec<Numbers>, usize) {
    let (mut rows, mut whole) = (Vec::new(), 0);
    for line in text.split_inclusive('\n') {
        let Some(numbers) = line.strip_suffix('\n') else { break };
        let row: Result<Numbers, _> = numbers.split(',').map(str::parse).collect();
        let Ok(row) = row else { break };
        rows.push(row);
        whole += line.len();
    }
    (rows, whole)
}
