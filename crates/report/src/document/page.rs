//! A document as one HTML page: no script, no font, no image from elsewhere.

use super::{Document, Figure, Passage};
use crate::html::{Html, descriptions, document, el, link, paragraph};

/// The style sheet of the pages.
const STYLE: &str = include_str!("page.css");

impl Document {
    /// The page: title, verdict, the list of its sections, and each.
    pub fn page(&self) -> String {
        let verdict = |(safe, sentence): &(bool, String)| {
            let class = if *safe { "verdict" } else { "verdict no" };
            paragraph(class, Html::rich(sentence) + Html::text("."))
        };
        let entry = |section: &super::Section| el("li").of(link(&format!("#{}", section.id), section.title));
        let contents = el("ol").of(self.sections.iter().map(entry).sum());
        let mut body = el("h1").text(&self.title).line()
            + self.lead.iter().map(passage).sum()
            + self.verdict.iter().map(verdict).sum()
            + el("nav").attribute("aria-label", "Contents").of(contents).line();
        for section in &self.sections {
            let content = el("h2").text(section.title).line() + section.passages.iter().map(passage).sum();
            body += el("section").attribute("id", section.id).around(content).line();
        }
        document(&self.tab, STYLE, "", &body)
    }
}

fn passage(passage: &Passage) -> Html {
    match passage {
        Passage::Said(said) => paragraph("", Html::rich(said)),
        Passage::Remark(said) => paragraph("soft", Html::rich(said)),
        Passage::Table(grid) => grid.html(),
        Passage::Figure(figure) => figure.html(),
        Passage::Commands(lines) => el("pre").text(lines).line(),
        Passage::Facts(facts) => descriptions(facts.iter().cloned()),
        Passage::OnPage(html) => html.clone(),
        Passage::OnTerminal(_) => Html::default(),
    }
}

impl Figure {
    /// The drawing with its caption and a link to its file.
    fn html(&self) -> Html {
        let drawing = el("div").class("drawing").of(Html::drawing(&self.svg)).line();
        let file = el("a").class("soft").attribute("href", &self.file).text(&self.file);
        let caption = Html::rich(&self.caption) + Html::text(" ") + file;
        el("figure").around(drawing + el("figcaption").of(caption).line()).line()
    }
}
