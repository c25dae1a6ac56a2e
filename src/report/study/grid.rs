//! A table of words and numbers, as text for the terminal and as HTML.

use std::fmt::Write as _;

/// A table: the first column to the left, the others to the right.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    /// Title of the table.
    pub title: String,
    /// Head of each column.
    pub head: Vec<String>,
    /// Rows, as long as the head.
    pub rows: Vec<TableRow>,
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
        Self { title: title.to_owned(), head: head.into_iter().map(Into::into).collect(), rows: Vec::new() }
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
    pub fn html(&self) -> String {
        let mut html =
            format!("<figure class=\"table\"><table>\n<caption>{}</caption>\n<thead><tr>", rich(&self.title));
        for cell in &self.head {
            html += &format!("<th scope=\"col\">{}</th>", rich(cell));
        }
        html += "</tr></thead>\n<tbody>\n";
        for row in &self.rows {
            html += if row.aside { "<tr class=\"aside\">" } else { "<tr>" };
            for (i, cell) in row.cells.iter().enumerate() {
                let cell = rich(cell);
                html += &if i == 0 {
                    format!("<th scope=\"row\">{cell}</th>")
                } else {
                    format!("<td>{cell}</td>")
                };
            }
            html += "</tr>\n";
        }
        html + "</tbody>\n</table></figure>\n"
    }
}

/// Text escaped for HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Text escaped for HTML, the symbols of the study (J_TPF, K_pvz) with subscripts.
pub fn rich(text: &str) -> String {
    let mut html = escape(text);
    for base in ["J", "K"] {
        let mark = format!("{base}_");
        let mut parts = html.split(mark.as_str()).map(str::to_owned);
        let first = parts.next().unwrap_or_default();
        html = parts.fold(first, |done, part| {
            let end = part.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(part.len());
            format!("{done}{base}<sub>{}</sub>{}", &part[..end], &part[end..])
        });
    }
    html
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_and_text_is_escaped() {
        assert_eq!(rich("J_TPF < 1, K_pvz"), "J<sub>TPF</sub> &lt; 1, K<sub>pvz</sub>");
        let mut grid = Grid::new("a < b", ["case", "J", "long head"]);
        grid.row("first", ["1".to_owned(), "2".to_owned()]);
        grid.aside("paper", ["10".to_owned(), String::new()]);
        assert_eq!(grid.text(), "a < b\ncase      J  long head\nfirst     1          2\n  paper  10\n");
        let html = grid.html();
        assert!(
            html.contains("<caption>a &lt; b</caption>") && html.contains("<tr class=\"aside\"><th"),
            "{html}"
        );
    }
}
