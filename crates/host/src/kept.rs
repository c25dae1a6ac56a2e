//! The rows of a study, kept as lines of numbers: one for each job, in the order in which the study has them
//! flown. What was being written when a run was killed is no whole line and is flown again. Where another
//! stage of the study begins stands a line that says what that hangs on.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, Seek as _, SeekFrom, Write};

use samara_core::printable::printable;
use samara_study::jobs::Numbers;
use samara_study::kind::differences;

/// A file that grows row by row, and is cut where what it holds is not gone on with.
pub trait RowsFile: Write {
    /// Cuts it to its first bytes, behind which it goes on.
    ///
    /// # Errors
    /// Of writing it.
    fn cut(&mut self, bytes: u64) -> io::Result<()>;
}

impl RowsFile for File {
    fn cut(&mut self, bytes: u64) -> io::Result<()> {
        self.set_len(bytes)?;
        self.seek(SeekFrom::End(0)).map(|_| ())
    }
}

/// A line behind the first one.
#[derive(Clone, Debug, PartialEq)]
enum Line {
    Row(Numbers),
    /// What follows is another stage of the study, which hangs on this.
    Stage(String),
}

/// What an earlier run has left in a file of rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Earlier {
    /// Each whole line behind the first one, and its bytes.
    lines: VecDeque<(Line, u64)>,
    /// Bytes of whole lines, the first one among them; 0 where that is not whole.
    whole: u64,
}

impl Earlier {
    /// How many bytes are whole lines.
    pub fn whole(&self) -> u64 {
        self.whole
    }
}

/// Where rows go, and those that an earlier run has left.
#[derive(Default)]
pub struct KeptRows {
    earlier: VecDeque<(Line, u64)>,
    file: Option<Box<dyn RowsFile>>,
    line: String,
    /// Bytes of the lines that were taken or written.
    at: u64,
    /// Bytes of the first line.
    head: u64,
    /// Bytes of the first stage, behind which there is another one.
    first_stage: Option<u64>,
}

impl KeptRows {
    /// Keeps rows nowhere.
    pub fn nowhere() -> Self {
        Self::default()
    }

    /// Goes on from an earlier run ([`going_on`]) and keeps the rows that follow in its file, of which so
    /// many bytes are there as are whole; a file without its first line, `head`, is given that.
    ///
    /// # Errors
    /// Of writing it.
    pub fn going_on(head: &str, earlier: Earlier, mut file: Box<dyn RowsFile>) -> io::Result<Self> {
        if earlier.whole == 0 {
            file.write_all(head.as_bytes())?;
        }
        let head = head.len() as u64;
        Ok(Self { earlier: earlier.lines, file: Some(file), at: head, head, ..Self::default() })
    }

    /// How many bytes of the file are of the study's first stage, where another one follows and it has rows:
    /// it may go on for longer.
    pub(crate) fn first_stage(&self) -> Option<u64> {
        self.first_stage.filter(|bytes| *bytes > self.head)
    }

    /// The numbers of the next row of an earlier run, if there is one in this stage of the study. What
    /// follows a stage that now goes on for longer is dropped.
    pub(crate) fn earlier(&mut self) -> io::Result<Option<Numbers>> {
        match self.earlier.pop_front() {
            Some((Line::Row(row), bytes)) => {
                self.at += bytes;
                Ok(Some(row))
            }
            Some((Line::Stage(_), _)) => self.drop_rest().map(|()| None),
            None => Ok(None),
        }
    }

    /// Another stage of the study begins.
    pub(crate) fn stage(&mut self, hangs_on: &str) -> io::Result<()> {
        let ends = self.at;
        match self.earlier.front() {
            Some((Line::Stage(kept), bytes)) if kept == hangs_on => {
                self.at += bytes;
                self.earlier.pop_front();
            }
            // The stage before went on for longer in the earlier run: that is the better one to keep.
            Some((Line::Row(_), _)) => {
                let rows = self.earlier.iter().take_while(|(line, _)| matches!(line, Line::Row(_)));
                let ends = self.at + rows.map(|(_, bytes)| bytes).sum::<u64>();
                let first_stage = self.first_stage.or(Some(ends));
                *self = Self { head: self.head, first_stage, ..Self::nowhere() };
                return Ok(());
            }
            _ => {
                self.drop_rest()?;
                self.line = format!("# {hangs_on}\n");
                self.write()?;
            }
        }
        self.first_stage.get_or_insert(ends);
        Ok(())
    }

    /// Keeps a row of these numbers.
    pub(crate) fn keep(&mut self, numbers: &[f64]) -> io::Result<()> {
        if self.file.is_none() {
            return Ok(());
        }
        self.line.clear();
        push_line(&mut self.line, numbers);
        self.write()
    }

    fn write(&mut self) -> io::Result<()> {
        self.at += self.line.len() as u64;
        self.file.as_mut().map_or(Ok(()), |file| file.write_all(self.line.as_bytes()))
    }

    /// Drops what the earlier run has left from here on.
    fn drop_rest(&mut self) -> io::Result<()> {
        self.earlier.clear();
        self.file.as_mut().map_or(Ok(()), |file| file.cut(self.at))
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

/// What an earlier run has left in a file of rows, whose first line is to be `head`; nothing where it was
/// ended within that.
///
/// # Errors
/// In what the first line differs, where it does.
pub fn going_on(text: &str, head: &str) -> Result<Earlier, String> {
    match text.strip_prefix(head) {
        Some(rest) => {
            let lines = lines(rest);
            let whole = head.len() as u64 + lines.iter().map(|(_, bytes)| bytes).sum::<u64>();
            Ok(Earlier { lines, whole })
        }
        None if head.starts_with(text) => Ok(Earlier::default()),
        None => {
            let found = text.lines().next().unwrap_or_default();
            Err(match differences(found, head) {
                Some(words) => format!("these rows are of another study: {words}"),
                None => format!(
                    "these rows are of another study; expected `{}`, found `{}`",
                    head.trim_end(),
                    printable(found)
                ),
            })
        }
    }
}

/// The whole lines of a text that was kept, up to the first that is neither a row nor begins a stage.
fn lines(text: &str) -> VecDeque<(Line, u64)> {
    let mut lines = VecDeque::new();
    for line in text.split_inclusive('\n') {
        let Some(text) = line.strip_suffix('\n') else { break };
        let row = || text.split(',').map(str::parse).collect::<Result<Numbers, _>>().ok().map(Line::Row);
        let stage = text.strip_prefix("# ").map(|hangs_on| Line::Stage(hangs_on.to_owned()));
        let Some(read) = stage.or_else(row) else { break };
        lines.push_back((read, line.len() as u64));
    }
    lines
}

/// The rows of a text, up to the first line that is none.
pub(crate) fn rows(text: &str) -> Vec<Numbers> {
    let rows = lines(text).into_iter().map_while(|(line, _)| match line {
        Line::Row(row) => Some(row),
        Line::Stage(_) => None,
    });
    rows.collect()
}
