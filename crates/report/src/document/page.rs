//! A document as one HTML page: no script, no font, no image from elsewhere.

use super::{Document, Figure, Part};
use crate::html::{Html, descriptions, document, el, link, paragraph};

/// The style sheet of the pages.
const STYLE: &str = include_str!("page.css");

impl Document {
    /// The page: title, verdict, the list of its sections, and each.
    pub fn page(&self) -> String {
        let (safe, sentence) = &self.verdict;
        let class = if *safe { "verdict" } else { "verdict no" };
        let entry = |section: &super::Section| el("li").of(link(&format!("#{}", section.id), section.title));
        let contents = el("ol").of(self.sections.iter().map(entry).sum());
        let mut body = el("h1").text(&self.title).line()
            + self.lead.iter().map(part).sum()
            + paragraph(class, Html::rich(sentence) + Html::text("."))
            + el("nav").attribute("aria-label", "Contents").of(contents).line();
        for section in &self.sections {
            let content = el("h2").text(section.title).line() + section.parts.iter().map(part).sum();
            body += el("section").attribute("id", section.id).around(content).line();
        }
        document(&self.tab, STYLE, "", &body)
    }
}

fn part(part: &Part) -> Html {
    match part {
        Part::Said(said) => paragraph("", Html::rich(said)),
        Part::Remark(said) => paragraph("soft", Html::rich(said)),
        Part::Table(grid) => grid.html(),
        Part::Figure(figure) => figure.html(),
        Part::Commands(lines) => el("pre").text(lines).line(),
        Part::Facts(facts) => descriptions(facts.iter().cloned()),
        Part::OnPage(html) => html.clone(),
        Part::OnTerminal(_) => Html::default(),
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
