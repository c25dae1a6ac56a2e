//! The columns of a table, declared once: lines of CSV, rows of a shard, arrays of numbers and the tables of
//! docs/files.md are made of one list.
//!
//! ```text
//! Columns::default()
//!     .whole("trial", "number of the trial", |row| row.trial)
//!     .number("mass_kg", "mass of the vehicle", |row| row.mass_kg)
//! ```

use std::borrow::Borrow;
use std::fmt::Write as _;

use samara_core::assess::outcome::{J_TPF, QUANTITIES};
use samara_core::assess::{Outcome, Quantity};

type Str = &'static str;
type Of<R, T> = Box<dyn Fn(&R) -> T + Send + Sync>;

/// How a column's value is read off a row.
pub(super) enum Value<R> {
    /// A number; one that is not finite is none.
    Number(Of<R, f64>),
    Whole(Of<R, u64>),
    /// 1 or 0.
    Flag(Of<R, bool>),
    /// A text, and whether it stands in quotation marks in CSV.
    Text(Of<R, Option<String>>, bool),
}

/// A value that was found in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Found<'a> {
    Number(Option<f64>),
    Whole(u64),
    Text(Option<&'a str>),
}

impl<'a> Found<'a> {
    /// The text, where it is one.
    pub(super) fn text(self) -> Option<&'a str> {
        if let Self::Text(text) = self { text } else { None }
    }
}

/// What becomes of a value that was found.
enum Back<R> {
    /// Nothing; a number must be there.
    Left,
    /// It must be the row's own.
    Checked,
    /// It is put into the row.
    Put(Box<dyn Fn(&mut R, Found<'_>) + Send + Sync>),
}

/// A column of a table whose rows are of this type.
pub(super) struct Column<R> {
    /// Name, which ends in the unit.
    pub(super) name: Str,
    /// What it is, for people.
    pub(super) about: Str,
    pub(super) value: Value<R>,
    back: Back<R>,
}

impl<R> Column<R> {
    /// Takes a value that was found into a row; whether it may be there.
    pub(super) fn take(&self, row: &mut R, found: Found<'_>) -> bool {
        match (&self.back, &self.value, found) {
            (Back::Put(put), ..) => put(row, found),
            (Back::Left, _, found) => return found != Found::Number(None),
            (Back::Checked, Value::Number(of), Found::Number(x)) => return x == Some(of(row)),
            (Back::Checked, Value::Whole(of), Found::Whole(n)) => return n == of(row),
            (Back::Checked, ..) => return false,
        }
        true
    }

    /// The value as a cell of CSV: the shortest text that reads back to it, nothing where there is none.
    fn push_cell(&self, line: &mut String, row: &R) {
        // Writing to a String cannot fail.
        let _ = match &self.value {
            Value::Number(of) => match of(row) {
                x if x.is_finite() => write!(line, "{x:?}"),
                _ => Ok(()),
            },
            Value::Whole(of) => write!(line, "{}", of(row)),
            Value::Flag(of) => write!(line, "{}", u8::from(of(row))),
            Value::Text(of, false) => line.write_str(&of(row).unwrap_or_default()),
            Value::Text(of, true) => {
                let text = of(row).unwrap_or_default().replace('"', "'").replace('\n', "; ");
                write!(line, "\"{text}\"")
            }
        };
    }

    /// What a cell of CSV holds; `None`: no such value.
    fn found<'a>(&self, cell: &'a str) -> Option<Found<'a>> {
        match &self.value {
            Value::Number(_) if cell.is_empty() => Some(Found::Number(None)),
            Value::Number(_) => cell.parse().ok().map(|x| Found::Number(Some(x))),
            Value::Whole(_) | Value::Flag(_) => cell.parse().ok().map(Found::Whole),
            Value::Text(..) => Some(Found::Text(Some(cell))),
        }
    }
}

/// Why a line is not the row that it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unread {
    /// The cells are not as many as the columns, or of other kinds.
    Cells,
    /// A value is another than the row's.
    Other,
}

/// The columns of a table whose rows are of this type, in the order of files.
pub struct Columns<R>(pub(super) Vec<Column<R>>);

impl<R> Default for Columns<R> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<R> Columns<R> {
    fn and(mut self, name: Str, about: Str, value: Value<R>) -> Self {
        self.0.push(Column { name, about, value, back: Back::Left });
        self
    }

    /// One more column, of numbers.
    pub fn number<X: Into<Option<f64>>>(
        self,
        name: Str,
        about: Str,
        of: impl Fn(&R) -> X + Send + Sync + 'static,
    ) -> Self {
        let of = move |row: &R| of(row).into().unwrap_or(f64::NAN);
        self.and(name, about, Value::Number(Box::new(of)))
    }

    /// One more column of numbers for each of some names, by its place among them.
    pub fn numbers<X: Into<Option<f64>>>(
        self,
        names: impl IntoIterator<Item = Str>,
        about: Str,
        of: impl Fn(&R, usize) -> X + Copy + Send + Sync + 'static,
    ) -> Self {
        let names = names.into_iter().enumerate();
        names.fold(self, |columns, (i, name)| columns.number(name, about, move |row| of(row, i)))
    }

    /// One more column, of whole numbers.
    pub fn whole(self, name: Str, about: Str, of: impl Fn(&R) -> u64 + Send + Sync + 'static) -> Self {
        self.and(name, about, Value::Whole(Box::new(of)))
    }

    /// One more column, of 1 and 0.
    pub fn flag(self, name: Str, about: Str, of: impl Fn(&R) -> bool + Send + Sync + 'static) -> Self {
        self.and(name, about, Value::Flag(Box::new(of)))
    }

    /// One more column, of words that have neither a comma nor a quotation mark.
    pub fn word(
        self,
        name: Str,
        about: Str,
        of: impl Fn(&R) -> Option<String> + Send + Sync + 'static,
    ) -> Self {
        self.and(name, about, Value::Text(Box::new(of), false))
    }

    /// One more column, of any text.
    pub fn text(
        self,
        name: Str,
        about: Str,
        of: impl Fn(&R) -> Option<String> + Send + Sync + 'static,
    ) -> Self {
        self.and(name, about, Value::Text(Box::new(of), true))
    }

    /// A column for each of some quantities of a flight; the J_TPF of one that came to none is infinite.
    pub fn quantities(
        mut self,
        quantities: impl IntoIterator<Item = &'static Quantity>,
        of: impl Fn(&R) -> Option<&Outcome> + Copy + Send + Sync + 'static,
    ) -> Self {
        for quantity in quantities {
            let lost = if *quantity == J_TPF { f64::INFINITY } else { f64::NAN };
            let value = move |row: &R| of(row).and_then(|outcome| quantity.of(outcome)).unwrap_or(lost);
            self = self.number(quantity.key, "[what the flight came to](#what-a-flight-came-to)", value);
        }
        self
    }

    /// What is found in these columns must be the row's own.
    pub(super) fn checked(mut self, names: &[&str]) -> Self {
        let checked = self.0.iter_mut().filter(|column| names.contains(&column.name));
        checked.for_each(|column| column.back = Back::Checked);
        self
    }

    /// What is found in a column is put into the row.
    pub(super) fn put(mut self, name: &str, put: impl Fn(&mut R, Found<'_>) + Send + Sync + 'static) -> Self {
        let back = Back::Put(Box::new(put));
        if let Some(column) = self.0.iter_mut().find(|column| column.name == name) {
            column.back = back;
        }
        self
    }

    /// What is found in the columns of quantities is put into the row's outcome.
    pub(super) fn put_quantities(
        self,
        of: impl Fn(&mut R) -> Option<&mut Outcome> + Copy + Send + Sync + 'static,
    ) -> Self {
        QUANTITIES.iter().fold(self, |columns, quantity| {
            columns.put(quantity.key, move |row, found| {
                if let (Some(outcome), Found::Number(x)) = (of(row), found) {
                    quantity.put(outcome, x);
                }
            })
        })
    }

    /// The names, between commas.
    pub fn names(&self) -> String {
        self.0.iter().map(|column| column.name).collect::<Vec<_>>().join(",")
    }

    /// Appends a row as a line of CSV.
    pub fn push_line(&self, text: &mut String, row: &R) {
        for (place, column) in self.0.iter().enumerate() {
            if place > 0 {
                text.push(',');
            }
            column.push_cell(text, row);
        }
        text.push('\n');
    }

    /// A row as a line of CSV.
    pub fn line(&self, row: &R) -> String {
        let mut line = String::new();
        self.push_line(&mut line, row);
        line
    }

    /// A CSV file: what stands above the columns' names, these and the rows.
    pub fn csv(&self, above: &str, rows: impl IntoIterator<Item = impl Borrow<R>>) -> String {
        let mut text = format!("{above}{}\n", self.names());
        rows.into_iter().for_each(|row| self.push_line(&mut text, row.borrow()));
        text
    }

    /// Reads a line (without its end) into a row. Texts that hold a comma are not read.
    pub(super) fn read(&self, line: &str, row: &mut R) -> Result<(), Unread> {
        let cells: Vec<&str> = line.split(',').collect();
        let found = self.0.iter().zip(&cells).map(|(column, cell)| column.found(cell));
        let found = found.collect::<Option<Vec<_>>>().filter(|_| cells.len() == self.0.len());
        let mut found = self.0.iter().zip(found.ok_or(Unread::Cells)?);
        if found.all(|(column, found)| column.take(row, found)) { Ok(()) } else { Err(Unread::Other) }
    }

    /// The columns of numbers as arrays, each a name and a value for each row: not finite where it has none.
    pub fn arrays(&self, rows: impl IntoIterator<Item = impl Borrow<R>>) -> Vec<(&'static str, Vec<f64>)> {
        let columns = self.0.iter().filter(|column| !matches!(column.value, Value::Text(..)));
        let mut arrays: Vec<_> = columns.clone().map(|column| (column.name, Vec::new())).collect();
        for row in rows {
            for (column, (_, array)) in columns.clone().zip(&mut arrays) {
                array.push(match &column.value {
                    Value::Number(of) => of(row.borrow()),
                    Value::Whole(of) => of(row.borrow()) as f64,
                    Value::Flag(of) => f64::from(of(row.borrow())),
                    Value::Text(..) => f64::NAN,
                });
            }
        }
        arrays
    }
}
