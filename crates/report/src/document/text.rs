//! A document as text for the terminal.

use super::{Document, Passage};

impl Document {
    /// The document as text: what it begins with, then its sections, the most important last; passages stand
    /// a blank line apart, remarks with what they are to. The verdict is the caller's last line.
    pub fn text(&self) -> String {
        let passages =
            self.lead.iter().chain(self.sections.iter().rev().flat_map(|section| &section.passages));
        let mut text = String::new();
        for passage in passages {
            let (said, with_the_last) = match passage {
                Passage::Said(said) => (format!("{said}\n"), false),
                Passage::Remark(said) => (format!("{said}\n"), true),
                Passage::Table(grid) => (grid.text(), false),
                Passage::OnTerminal(lines) => (lines.clone(), false),
                Passage::Figure(_) | Passage::Commands(_) | Passage::Facts(_) | Passage::OnPage(_) => {
                    continue;
                }
            };
            if !text.is_empty() && !with_the_last {
                text.push('\n');
            }
            text += &said;
        }
        text
    }
}
