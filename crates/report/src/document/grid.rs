//! A table of words and numbers, as text for the terminal and as HTML.

use std::fmt::Write as _;

use crate::html::{Html, el};

/// A table: the first column to the left, the others to the right.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    /// Title of the table.
    pub title: String,
    /// Head of each column.
    pub head: Vec<String>,
    /// Rows, as long as the head.
    pub rows: Vec<TableRow>,
    /// Whether its cells are words more than numbers: on a page they are set to the left.
    pub words: bool,
}

/// A row of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct TableRow {
    /// Text of each cell.
    pub cells: Vec<String>,
    /// Whether the row is secondary: the paper's figures, and other remarks to the row above.
    pub aside: bool,
}

impl Grid {
    /// An empty table.
    pub fn new(title: &str, head: impl IntoIterator<Item = impl Into<String>>) -> Self {
        let head = head.into_iter().map(Into::into).collect();
        Self { title: title.to_owned(), head, ..Self::default() }
    }

    /// Adds a row.
    pub fn row(&mut self, first: &str, others: impl IntoIterator<Item = String>) {
        self.push(first, others, false);
    }

    /// Adds a row that belongs to the one above.
    pub fn aside(&mut self, first: &str, others: impl IntoIterator<Item = String>) {
        self.push(first, others, true);
    }

    fn push(&mut self, first: &str, others: impl IntoIterator<Item = String>, aside: bool) {
        let cells = std::iter::once(first.to_owned()).chain(others).collect();
        self.rows.push(TableRow { cells, aside });
    }

    /// The table as aligned text with a title line.
    pub fn text(&self) -> String {
        let indent = |row: &TableRow| if row.aside { 2 } else { 0 };
        let width = |column: usize| {
            let of = |row: &TableRow| {
                let cell = row.cells.get(column).map_or(0, |c| c.chars().count());
                cell + if column == 0 { indent(row) } else { 0 }
            };
            let head = self.head.get(column).map_or(0, |c| c.chars().count());
            self.rows.iter().map(of).max().unwrap_or(0).max(head)
        };
        let widths: Vec<usize> = (0..self.head.len()).map(width).collect();
        let line = |cells: &[String], indent: usize| {
            let mut text = String::new();
            for (i, (cell, w)) in cells.iter().zip(&widths).enumerate() {
                let _ = match i {
                    0 => write!(text, "{}{cell:<w$}", " ".repeat(indent), w = w.saturating_sub(indent)),
                    _ => write!(text, "  {cell:>w$}"),
                };
            }
            text.trim_end().to_owned() + "\n"
        };
        let mut text = format!("{}\n{}", self.title, line(&self.head, 0));
        for row in &self.rows {
            text += &line(&row.cells, indent(row));
        }
        text
    }

    /// The table as HTML with a caption.
    pub fn html(&self) -> Html {
        let head = self.head.iter().map(|cell| el("th").attribute("scope", "col").rich(cell)).sum();
        let row = |row: &TableRow| {
            let cells = row.cells.iter().enumerate().map(|(i, cell)| match i {
                0 => el("th").attribute("scope", "row").rich(cell),
                _ => el("td").rich(cell),
            });
            el("tr").class(if row.aside { "aside" } else { "" }).of(cells.sum()).line()
        };
        let caption = el("caption").rich(&self.title).line();
        let body = el("tbody").around(self.rows.iter().map(row).sum()).line();
        let table = el("table").around(caption + el("thead").of(el("tr").of(head)).line() + body);
        el("figure").class(if self.words { "table words" } else { "table" }).of(table).line()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_and_text_is_escaped() {
        let mut grid = Grid::new("a < b", ["case", "J", "long head"]);
        grid.row("first", ["1".to_owned(), "2".to_owned()]);
        grid.aside("paper", ["10".to_owned(), String::new()]);
        assert_eq!(grid.text(), "a < b\ncase      J  long head\nfirst     1          2\n  paper  10\n");
        let html = grid.html().into_string();
        assert!(
            html.contains("<caption>a &lt; b</caption>") && html.contains("<tr class=\"aside\"><th"),
            "{html}"
        );
    }
}
