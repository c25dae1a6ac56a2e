//! An element's children and numbers, with their places.

use std::path::Path;

use roxmltree::Node;

use crate::error::ConfigError;
use crate::foreign::known::Place;

/// An element of a file.
#[derive(Clone, Copy)]
pub(super) struct Element<'a> {
    pub(super) file: &'a Path,
    pub(super) node: Node<'a, 'a>,
}

impl<'a> Element<'a> {
    /// The children that are elements of a name.
    pub(super) fn all(self, name: &'a str) -> impl Iterator<Item = Self> {
        let nodes = self.node.children().filter(move |node| node.has_tag_name(name));
        nodes.map(move |node| Self { node, ..self })
    }

    /// The first child of a name.
    pub(super) fn child(self, name: &'a str) -> Option<Self> {
        self.all(name).next()
    }

    /// The child of a name, without which the element says too little.
    pub(super) fn needed(self, name: &'a str) -> Result<Self, ConfigError> {
        self.child(name).ok_or_else(|| self.refuse(format!("expected `<{name}>` in it, found none")))
    }

    /// An attribute.
    pub(super) fn attribute(self, name: &str) -> Option<&'a str> {
        self.node.attribute(name).map(str::trim)
    }

    /// The attribute `name`.
    pub(super) fn name(self) -> &'a str {
        self.attribute("name").unwrap_or_default()
    }

    /// The text in it.
    pub(super) fn text(self) -> &'a str {
        self.node.text().unwrap_or_default().trim()
    }

    /// As many numbers as are expected, finite, separated by white space.
    pub(super) fn numbers<const N: usize>(self) -> Result<[f64; N], ConfigError> {
        let mut words = self.text().split_whitespace();
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let parsed = words.next().and_then(|word| word.parse::<f64>().ok());
            *number = parsed.filter(|x| x.is_finite()).ok_or_else(|| self.expected(N))?;
        }
        if words.next().is_some() { Err(self.expected(N)) } else { Ok(numbers) }
    }

    fn expected(self, n: usize) -> ConfigError {
        let shown: String = self.text().chars().take(40).collect();
        let numbers = if n == 1 { "a finite number".to_owned() } else { format!("{n} finite numbers") };
        self.refuse(format!("expected {numbers}, found `{shown}`"))
    }

    /// A number from one bound to another one, the first excluded where that is 0 and `open`.
    fn within(self, low: f64, high: f64, open: bool) -> Result<f64, ConfigError> {
        let [x] = self.numbers()?;
        if (low..=high).contains(&x) && !(open && x <= low) {
            return Ok(x);
        }
        let expected = if open { "a number greater than" } else { "a number from" };
        let to = if open { "and at most" } else { "to" };
        Err(self.refuse(format!("expected {expected} {low} {to} {high}, found {x}")))
    }

    /// A number greater than 0.
    pub(super) fn positive(self, most: f64) -> Result<f64, ConfigError> {
        self.within(0.0, most, true)
    }

    /// A number from `low` on.
    pub(super) fn from(self, low: f64, most: f64) -> Result<f64, ConfigError> {
        self.within(low, most, false)
    }

    pub(super) fn place(self) -> Place {
        let at = self.node.document().text_pos_at(self.node.range().start);
        let tag = self.node.tag_name().name();
        let what = match self.name() {
            "" => tag.to_owned(),
            name => format!("{tag} {name}"),
        };
        Place { file: self.file.to_owned(), line: at.row as usize, column: at.col as usize, what }
    }

    pub(super) fn refuse(self, message: impl Into<String>) -> ConfigError {
        self.place().refuse(message)
    }
}
