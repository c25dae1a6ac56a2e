//! A document as text for the terminal.

use super::{Document, Part};

impl Document {
    /// The document as text: what it begins with, then its sections, the most important last; parts stand a
    /// blank line apart, remarks with what they are to. The verdict is the caller's last line.
    pub fn text(&self) -> String {
        let parts = self.lead.iter().chain(self.sections.iter().rev().flat_map(|section| &section.parts));
        let mut text = String::new();
        for part in parts {
            let (said, with_the_last) = match part {
                Part::Said(said) => (format!("{said}\n"), false),
                Part::Remark(said) => (format!("{said}\n"), true),
                Part::Table(grid) => (grid.text(), false),
                Part::OnTerminal(lines) => (lines.clone(), false),
                Part::Figure(_) | Part::Commands(_) | Part::Facts(_) | Part::OnPage(_) => continue,
            };
            if !text.is_empty() && !with_the_last {
                text.push('\n');
            }
            text += &said;
        }
        text
    }
}
