//! The columns of a table, declared once: lines of CSV, rows of a shard, arrays of numbers and the tables of
//! docs/files.md are made of one list.
//!
//! ```text
//! Columns::none()
//!     .whole("trial", "number of the trial", |row| row.trial)
//!     .number("mass_kg", "mass of the vehicle", |row| row.mass_kg)
//! ```

use std::borrow::{Borrow, Cow};
use std::fmt::Write as _;

use samara_core::assess::outcome::{J_TPF, Outcome, QUANTITIES, Quantity};

type Str = &'static str;
/// Columns of numbers: of each the name, and a value for each row.
pub type Arrays = Vec<(Cow<'static, str>, Vec<f64>)>;
type Of<R, T> = Box<dyn Fn(&R) -> T + Send + Sync>;
type Put<R> = Box<dyn Fn(&mut R, Found<'_>) + Send + Sync>;

/// What may be held by columns that all threads read.
pub trait Shared: Send + Sync + 'static {}
impl<T: Send + Sync + 'static> Shared for T {}

/// How a column's value is read off a row.
pub enum Value<R> {
    /// A number, or none.
    Number(Of<R, Option<f64>>),
    /// A whole number.
    Whole(Of<R, u64>),
    /// A text, and whether it stands in quotation marks in CSV.
    Text(Of<R, Option<String>>, bool),
}

/// A value that was found in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found<'a> {
    /// A number, or none.
    Number(Option<f64>),
    /// A whole number.
    Whole(u64),
    /// A text, or none.
    Text(Option<&'a str>),
}

impl<'a> Found<'a> {
    /// The text, where it is one.
    pub fn text(self) -> Option<&'a str> {
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
    Put(Put<R>),
}

/// A column of a table whose rows are of this type.
pub struct Column<R> {
    /// Name, which ends in the unit.
    pub name: Cow<'static, str>,
    /// Meaning, for people.
    pub about: Str,
    /// Value of the column.
    pub value: Value<R>,
    back: Back<R>,
}

impl<R> Column<R> {
    /// Takes a value that was found into a row; whether it may be there.
    pub fn take(&self, row: &mut R, found: Found<'_>) -> bool {
        match (&self.back, &self.value) {
            (Back::Put(put), _) => {
                put(row, found);
                true
            }
            (Back::Checked, Value::Number(of)) => found == Found::Number(of(row)),
            (Back::Checked, Value::Whole(of)) => found == Found::Whole(of(row)),
            _ => found != Found::Number(None),
        }
    }

    /// The value as a number, where it is one.
    pub fn number(&self, row: &R) -> Option<f64> {
        match &self.value {
            Value::Number(of) => of(row),
            Value::Whole(of) => Some(of(row) as f64),
            Value::Text(..) => None,
        }
    }

    /// The value as a cell of CSV: the shortest text that reads back to it, nothing where there is none.
    pub fn push_cell(&self, line: &mut String, row: &R) {
        // Writing to a String cannot fail.
        let _ = match &self.value {
            Value::Number(of) => of(row).filter(|x| x.is_finite()).map_or(Ok(()), |x| write!(line, "{x:?}")),
            Value::Whole(of) => write!(line, "{}", of(row)),
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
            Value::Whole(_) => cell.parse().ok().map(Found::Whole),
            _ => Some(Found::Text(Some(cell))),
        }
    }
}

/// The columns of a table whose rows are of this type, in the order of files.
pub struct Columns<R>(pub Vec<Column<R>>);

impl<R> Columns<R> {
    /// No column yet.
    pub fn none() -> Self {
        Self(Vec::new())
    }

    fn and(mut self, name: impl Into<Cow<'static, str>>, about: Str, value: Value<R>) -> Self {
        self.0.push(Column { name: name.into(), about, value, back: Back::Left });
        self
    }

    /// One more column, of numbers.
    pub fn number<X: Into<Option<f64>>>(self, name: Str, about: Str, of: impl Fn(&R) -> X + Shared) -> Self {
        self.and(name, about, Value::Number(Box::new(move |row| of(row).into())))
    }

    /// One more column of numbers for each of some names, by its place among them.
    pub fn numbers<X: Into<Option<f64>>>(
        self,
        names: impl IntoIterator<Item = impl Into<Cow<'static, str>>>,
        about: Str,
        of: impl Fn(&R, usize) -> X + Clone + Shared,
    ) -> Self {
        names.into_iter().enumerate().fold(self, |columns, (i, name)| {
            let of = of.clone();
            columns.and(name, about, Value::Number(Box::new(move |row| of(row, i).into())))
        })
    }

    /// One more column, of whole numbers.
    pub fn whole(self, name: Str, about: Str, of: impl Fn(&R) -> u64 + Shared) -> Self {
        self.and(name, about, Value::Whole(Box::new(of)))
    }

    /// One more column, of 1 and 0.
    pub fn flag(self, name: Str, about: Str, of: impl Fn(&R) -> bool + Shared) -> Self {
        self.whole(name, about, move |row| of(row).into())
    }

    /// One more column, of words that have neither a comma nor a quotation mark.
    pub fn word(self, name: Str, about: Str, of: impl Fn(&R) -> Option<String> + Shared) -> Self {
        self.and(name, about, Value::Text(Box::new(of), false))
    }

    /// One more column, of any text.
    pub fn text(self, name: Str, about: Str, of: impl Fn(&R) -> Option<String> + Shared) -> Self {
        self.and(name, about, Value::Text(Box::new(of), true))
    }

    /// A column for each of some quantities of a flight; the J_TPF of one that came to none is infinite.
    pub fn quantities(
        mut self,
        quantities: impl IntoIterator<Item = &'static Quantity>,
        of: impl Fn(&R) -> Option<&Outcome> + Copy + Shared,
    ) -> Self {
        for quantity in quantities {
            let lost = (*quantity == J_TPF).then_some(f64::INFINITY);
            let value = move |row: &R| of(row).and_then(|outcome| quantity.of(outcome)).or(lost);
            self = self.number(quantity.key, "[what the flight came to](#what-a-flight-came-to)", value);
        }
        self
    }

    /// What is found in these columns must be the row's own.
    pub fn checked(mut self, names: &[&str]) -> Self {
        let checked = self.0.iter_mut().filter(|column| names.contains(&&*column.name));
        checked.for_each(|column| column.back = Back::Checked);
        self
    }

    /// What is found in a column is put into the row.
    pub fn put(mut self, name: &str, put: impl Fn(&mut R, Found<'_>) + Shared) -> Self {
        let column = self.0.iter_mut().find(|column| column.name == name);
        let _ = column.map(|column| column.back = Back::Put(Box::new(put)));
        self
    }

    /// What is found in the columns of quantities is put into the row's outcome.
    pub fn put_quantities(self, of: impl Fn(&mut R) -> Option<&mut Outcome> + Copy + Shared) -> Self {
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
        self.0.iter().map(|column| &*column.name).collect::<Vec<_>>().join(",")
    }

    /// Appends a row as a line of CSV.
    pub fn push_line(&self, text: &mut String, row: &R) {
        for column in &self.0 {
            column.push_cell(text, row);
            text.push(',');
        }
        text.pop();
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

    /// Reads a line (without its end) into a row: whether the line is the row's. `None`: the cells are not as
    /// many as the columns, or of other kinds. Texts that hold a comma are not read.
    pub fn read(&self, line: &str, row: &mut R) -> Option<bool> {
        let cells: Vec<&str> = line.split(',').collect();
        let found = self.0.iter().zip(&cells).map(|(column, cell)| column.found(cell));
        let found = found.collect::<Option<Vec<_>>>().filter(|_| cells.len() == self.0.len())?;
        Some(self.0.iter().zip(found).all(|(column, found)| column.take(row, found)))
    }

    /// The columns of numbers; a value that there is not is not finite.
    pub fn arrays(&self, rows: impl IntoIterator<Item = impl Borrow<R>>) -> Arrays {
        let rows: Vec<_> = rows.into_iter().collect();
        let numbers = self.0.iter().filter(|column| !matches!(column.value, Value::Text(..)));
        let array =
            |of: &Column<R>| rows.iter().map(|row| of.number(row.borrow()).unwrap_or(f64::NAN)).collect();
        numbers.map(|column| (column.name.clone(), array(column))).collect()
    }

    /// The numbers of a column; `None` where there is no such column, or no value in any row.
    pub fn values(&self, name: &str, rows: &[&R]) -> Option<Vec<f64>> {
        let column = self.0.iter().find(|column| column.name == name)?;
        let numbers: Vec<Option<f64>> = rows.iter().map(|row| column.number(row)).collect();
        let some = numbers.is_empty() || numbers.iter().any(Option::is_some);
        some.then(|| numbers.into_iter().map(|x| x.unwrap_or(f64::NAN)).collect())
    }
}
