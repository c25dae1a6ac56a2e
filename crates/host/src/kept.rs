//! The rows of a study, kept as lines of numbers: one for each job, in the order in which the study has them
//! flown. What was being written when a run was killed is no whole line and is flown again.

use std::io::{self, Write};

use samara_study::jobs::Row;

/// Where rows go, and those that an earlier run has left.
#[derive(Default)]
pub struct KeptRows {
    earlier: std::vec::IntoIter<Vec<f64>>,
    sink: Option<Box<dyn Write>>,
    line: String,
    numbers: Vec<f64>,
}

impl KeptRows {
    /// Keeps rows nowhere.
    pub fn nowhere() -> Self {
        Self::default()
    }

    /// Goes on from earlier rows ([`read`]) and keeps those that follow them.
    pub fn going_on(earlier: Vec<Vec<f64>>, sink: Box<dyn Write>) -> Self {
        Self { earlier: earlier.into_iter(), sink: Some(sink), ..Self::default() }
    }

    /// The next row of an earlier run, if there is one; an error where its numbers are not those of such a
    /// row.
    pub(crate) fn earlier<R: Row>(&mut self) -> io::Result<Option<R>> {
        let Some(numbers) = self.earlier.next() else { return Ok(None) };
        let mut numbers = numbers.into_iter();
        let row = R::from_numbers(&mut numbers).filter(|_| numbers.next().is_none());
        row.map(Some).ok_or_else(|| {
            io::Error::new(io::ErrorKind::InvalidData, "a row that was kept is not one of this study")
        })
    }

    /// Keeps a row.
    pub(crate) fn keep(&mut self, row: &impl Row) -> io::Result<()> {
        let Some(sink) = &mut self.sink else { return Ok(()) };
        self.numbers.clear();
        row.put_numbers(&mut self.numbers);
        self.line.clear();
        for (i, number) in self.numbers.iter().enumerate() {
            if i > 0 {
                self.line.push(',');
            }
            // The shortest digits that mean this number.
            self.line += &format!("{number:?}");
        }
        self.line.push('\n');
        sink.write_all(self.line.as_bytes())
    }
}

/// The rows of a text that was kept, and how many bytes of it are whole lines of numbers.
pub fn read(text: &str) -> (Vec<Vec<f64>>, usize) {
    let (mut rows, mut whole) = (Vec::new(), 0);
    for line in text.split_inclusive('\n') {
        let Some(numbers) = line.strip_suffix('\n') else { break };
        let row: Result<Vec<f64>, _> = numbers.split(',').map(str::parse).collect();
        let Ok(row) = row else { break };
        rows.push(row);
        whole += line.len();
    }
    (rows, whole)
}
