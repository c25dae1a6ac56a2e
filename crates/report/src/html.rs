//! HTML as a value: what is text is escaped where it comes in, and markup is written here alone, so that no
//! page can forget to.

use std::iter::Sum;
use std::ops::{Add, AddAssign};

/// A piece of HTML: whole elements and escaped text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Html(String);

impl Html {
    /// Text as it is.
    pub fn text(text: &str) -> Self {
        Self(escape(text))
    }

    /// Text in which the symbols of the study (J_TPF, K_pvz) have subscripts.
    pub fn rich(text: &str) -> Self {
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
        Self(html)
    }

    /// A drawing, an SVG document of the program's own.
    pub fn drawing(svg: &str) -> Self {
        Self(svg.trim_start().to_owned())
    }

    /// The piece with the end of its line.
    pub fn line(self) -> Self {
        Self(self.0 + "\n")
    }

    /// Pieces with text between them.
    pub fn joined(pieces: impl IntoIterator<Item = Self>, between: &str) -> Self {
        let mut pieces = pieces.into_iter();
        let first = pieces.next().unwrap_or_default();
        pieces.fold(first, |done, piece| done + Self::text(between) + piece)
    }

    /// The markup.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The markup.
    pub fn into_string(self) -> String {
        self.0
    }
}

impl Add for Html {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + &other.0)
    }
}

impl AddAssign for Html {
    fn add_assign(&mut self, other: Self) {
        self.0 += &other.0;
    }
}

impl Sum for Html {
    fn sum<I: Iterator<Item = Self>>(pieces: I) -> Self {
        pieces.fold(Self::default(), Self::add)
    }
}

/// An element whose content is still to come.
#[derive(Clone, Debug)]
pub struct Element {
    name: &'static str,
    start: String,
}

/// An element of this name, without attributes.
pub fn el(name: &'static str) -> Element {
    Element { name, start: format!("<{name}") }
}

impl Element {
    /// The element with an attribute; its value is text.
    pub fn attribute(mut self, name: &'static str, value: &str) -> Self {
        self.start += &format!(" {name}=\"{}\"", escape(value));
        self
    }

    /// The element with classes; none where the text is empty.
    pub fn class(self, class: &str) -> Self {
        if class.is_empty() { self } else { self.attribute("class", class) }
    }

    /// The element around content.
    pub fn of(self, content: Html) -> Html {
        Html(format!("{}>{}</{}>", self.start, content.0, self.name))
    }

    /// The element around lines: its start has a line of its own.
    pub fn around(self, content: Html) -> Html {
        Html(format!("{}>\n{}</{}>", self.start, content.0, self.name))
    }

    /// The element around text.
    pub fn text(self, text: &str) -> Html {
        self.of(Html::text(text))
    }

    /// The element around text in which the study's symbols have subscripts.
    pub fn rich(self, text: &str) -> Html {
        self.of(Html::rich(text))
    }
}

/// A link to a relative address.
pub fn link(to: &str, text: &str) -> Html {
    el("a").attribute("href", to).text(text)
}

/// A paragraph on a line of its own.
pub fn paragraph(class: &str, content: Html) -> Html {
    el("p").class(class).of(content).line()
}

/// A list of names with what belongs to each: `<dl>`.
pub fn descriptions<'a>(of: impl IntoIterator<Item = (&'a str, Html)>) -> Html {
    let rows = of.into_iter().map(|(name, value)| (el("dt").text(name) + el("dd").of(value)).line());
    el("dl").around(rows.sum()).line()
}

/// A whole document with a style sheet of its own; `body_class` may be empty.
pub fn document(title: &str, style: &str, body_class: &str, body: &Html) -> String {
    let body_start =
        if body_class.is_empty() { String::new() } else { format!(" class=\"{}\"", escape(body_class)) };
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>{}</title>\n<style>\n{style}</style>\n</head>\n<body{body_start}>\n{}</body>\n</html>\n",
        escape(title),
        body.0
    )
}

/// Text escaped for HTML and XML, inside quotes, too.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By HTML's syntax, section 13.1.2: nothing that comes in as text opens an element or ends a value.
    #[test]
    fn text_stays_text_wherever_it_comes_in() {
        let evil = "</script>&\"<b";
        let safe = "&lt;/script&gt;&amp;&quot;&lt;b";
        assert_eq!(Html::text(evil).as_str(), safe);
        assert_eq!(Html::rich("J_TPF < 1, K_pvz").as_str(), "J<sub>TPF</sub> &lt; 1, K<sub>pvz</sub>");
        assert_eq!(el("p").class(evil).text(evil).as_str(), format!("<p class=\"{safe}\">{safe}</p>"));
        assert_eq!(link(evil, evil).as_str(), format!("<a href=\"{safe}\">{safe}</a>"));
        let page = document(evil, "", "", &Html::joined([Html::text("a"), Html::text("b")], evil));
        assert!(page.contains(&format!("<title>{safe}</title>")) && page.contains(&format!("a{safe}b")));
    }
}
