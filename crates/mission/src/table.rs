//! Tables of numbers in CSV, read strictly: an exact header, as many fields in every line as the header has,
//! finite numbers only. Nothing is quoted.

use super::error::ConfigError;
use super::source::Source;

/// A line of numbers and the number of the line in its file, from 1.
pub(super) struct NumberedLine {
    pub(super) line: usize,
    pub(super) values: Vec<f64>,
}

/// The lines that hold something, with their numbers, comment lines (`#`) at the top left out.
pub(super) fn lines(source: &Source) -> impl Iterator<Item = (usize, &str)> {
    source
        .text
        .lines()
        .enumerate()
        .map(|(i, text)| (i + 1, text))
        .skip_while(|(_, text)| text.starts_with('#'))
}

/// Refuses a place in a table.
pub(super) fn refuse(source: &Source, line: usize, column: usize, message: String) -> ConfigError {
    ConfigError::Content { file: source.file.clone(), line, column, json_path: String::new(), message }
}

/// No quantity in SI that flies comes near; beyond, products of two numbers of a table might overflow.
const MOST: f64 = 1e9;

/// The numbers of a line; `columns` are the header's names.
pub(super) fn row(
    source: &Source,
    line: usize,
    text: &str,
    columns: &[&str],
) -> Result<NumberedLine, ConfigError> {
    let found = text.split(',').count();
    if found != columns.len() {
        let message = format!("expected {} numbers separated by commas, found {found}", columns.len());
        return Err(refuse(source, line, 1, message));
    }
    let mut values = Vec::with_capacity(columns.len());
    let mut column = 1;
    for (field, name) in text.split(',').zip(columns) {
        let number = field.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        let Some(x) = number.filter(|x| x.abs() <= MOST) else {
            let expected = if number.is_some() { "number from -1e9 to 1e9" } else { "finite number" };
            let message = format!("{name}: expected a {expected}, found `{}`", shortened(field));
            return Err(refuse(source, line, column, message));
        };
        values.push(x);
        column += field.chars().count() + 1;
    }
    Ok(NumberedLine { line, values })
}

/// A field as a message may quote it.
pub(super) fn shortened(field: &str) -> String {
    if field.chars().count() <= 40 {
        field.to_owned()
    } else {
        field.chars().take(40).chain("...".chars()).collect()
    }
}
