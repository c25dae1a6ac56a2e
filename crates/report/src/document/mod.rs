//! A study's answer as a value: a verdict, and sections of tables, figures and remarks in the order in which
//! they are read. Each form that it takes has one renderer.
//!
//! | file | holds |
//! |---|---|
//! | `grid` | [`Grid`], a table of words and numbers |
//! | `text` | the document for the terminal |
//! | `page` | the document as one HTML page, self-contained |
//! | `junit` | its checks as test cases, for continuous integration |

mod grid;
mod junit;
mod page;
mod text;

pub use grid::{Grid, TableRow};

use crate::html::Html;

/// A study's answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Document {
    /// Title of the page.
    pub title: String,
    /// Title for a browser's tab.
    pub tab: String,
    /// Whether nothing speaks against it, and the answer in a sentence without its full stop.
    pub verdict: (bool, String),
    /// What stands before the sections, on the page above the verdict.
    pub lead: Vec<Part>,
    /// Sections, the most important first. On a terminal, where the end is what is seen, they stand the
    /// other way round.
    pub sections: Vec<Section>,
    /// What was checked one by one.
    pub checks: Vec<Check>,
}

/// A section of a document.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Name of its place in the page.
    pub id: &'static str,
    /// Title on the page; on a terminal its tables have theirs.
    pub title: &'static str,
    /// The parts, in the order in which they are read.
    pub parts: Vec<Part>,
}

/// A part of a document.
#[derive(Clone, Debug, PartialEq)]
pub enum Part {
    /// A statement.
    Said(String),
    /// A remark to what stands above it.
    Remark(String),
    /// A table.
    Table(Grid),
    /// A drawing; not for terminals.
    Figure(Figure),
    /// Commands to type, a line each; not for terminals.
    Commands(String),
    /// Names with what belongs to each; not for terminals.
    Facts(Vec<(&'static str, Html)>),
    /// What a page says in its own way.
    OnPage(Html),
    /// What a terminal says in its own way, whole lines.
    OnTerminal(String),
}

/// A drawing of a document.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name of the file with the drawing.
    pub file: String,
    /// Caption below the drawing.
    pub caption: String,
    /// The drawing as an SVG document.
    pub svg: String,
}

/// Something that was checked, and why it failed, if it did.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Whatever the check is one of.
    pub group: String,
    /// Name of the check.
    pub name: String,
    /// Why it failed.
    pub failure: Option<String>,
}
