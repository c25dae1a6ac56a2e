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
    /// Whether nothing speaks against it, and the answer in a sentence without its full stop, of a study that
    /// judges.
    pub verdict: Option<(bool, String)>,
    /// What stands before the sections, on the page above the verdict.
    pub lead: Vec<Passage>,
    /// Sections, the most important first. On a terminal, where the end is what is seen, they stand the
    /// other way round.
    pub sections: Vec<Section>,
    /// What was checked one by one.
    pub checks: Vec<Check>,
}

impl Document {
    /// A document of one section without a verdict: what was done, and what came of it.
    pub fn of_one(title: String, done: String, passages: Vec<Passage>) -> Self {
        let section = Section { id: "results", title: "Results", passages };
        Self {
            tab: title.clone(),
            title,
            lead: vec![Passage::Said(done)],
            sections: vec![section],
            ..Self::default()
        }
    }

    /// The answer in a sentence; nothing of a study that does not judge.
    pub fn sentence(&self) -> &str {
        self.verdict.as_ref().map_or("", |(_, sentence)| sentence)
    }
}

/// A section of a document.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Name of its place in the page.
    pub id: &'static str,
    /// Title on the page; on a terminal its tables have theirs.
    pub title: &'static str,
    /// The passages, in the order in which they are read.
    pub passages: Vec<Passage>,
}

/// A passage of a document.
#[derive(Clone, Debug, PartialEq)]
pub enum Passage {
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
