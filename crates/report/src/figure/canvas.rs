//! The sheet that figures are drawn on: lines, shapes and text in pixels, an SVG text in the end.
//!
//! The only file that uses plotters, whose SVG backend takes whole pixels and has neither dashes nor
//! subscripts; so the sheet is ten times as fine as its pixels, dashes are cut here, and subscripts and the
//! document's head are put in at the end. No font is measured: the viewer brings its own, and widths are
//! estimates on the wide side.

use plotters::backend::{DrawingBackend, SVGBackend};
use plotters::prelude::{Color, FontTransform, IntoFont, RGBColor, ShapeStyle, TextStyle};
use plotters::style::FontStyle;
/// The point of a text that is put at its place; vertically always the middle.
pub use plotters::style::text_anchor::HPos as Anchor;
use plotters::style::text_anchor::{Pos, VPos};

use super::color::{INK, Rgb, WHITE};
pub use super::polyline::Point;
use super::polyline::{dashes, thinned};

/// Why a figure cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FigureError {
    /// There is nothing to draw.
    #[error("there is nothing to draw: no position in the flight is finite")]
    Empty,
    /// The drawing backend failed.
    #[error("the figure could not be drawn: {0}")]
    Backend(String),
}

/// Steps of the sheet per pixel.
const FINENESS: f64 = 10.0;
/// Size of a font in plotters' terms, per em.
const SIZE_PER_EM: f64 = 1.24;
/// Curves are thinned to this deviation [px], which is not visible.
const VISIBLE_PX: f64 = 0.12;
/// Marks of the beginning and end of a subscript and of the end of the text after it: characters of Unicode's
/// private use, which no text contains.
const SUBSCRIPT: [char; 3] = ['\u{E000}', '\u{E001}', '\u{E002}'];

/// Colour, width and dashes of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Color.
    pub color: Rgb,
    /// Width [px].
    pub width: f64,
    /// Lengths of dash and gap [px]; `None`: solid.
    pub dash: Option<(f64, f64)>,
}

impl Stroke {
    /// A line without gaps.
    pub fn solid(color: Rgb, width: f64) -> Self {
        Self { color, width, dash: None }
    }

    /// A line of dashes and gaps of these lengths [px].
    pub fn dashed(color: Rgb, width: f64, dash: f64, gap: f64) -> Self {
        Self { color, width, dash: Some((dash, gap)) }
    }
}

/// Size, colour and weight of text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Font {
    /// Size [px].
    pub size: f64,
    /// Color.
    pub color: Rgb,
    /// Whether it is bold.
    pub bold: bool,
}

/// Draws on a white sheet of `size` pixels and returns the document. `title` and `origin`, the comment lines
/// of a result's stamp, go into its head.
///
/// # Errors
/// [`FigureError`] when plotters fails.
pub fn sheet(
    size: (u32, u32),
    (title, origin): (&str, &str),
    draw: impl FnOnce(&mut Pen<'_>),
) -> Result<String, FigureError> {
    let fine = |x: u32| (f64::from(x) * FINENESS) as u32;
    let mut svg = String::new();
    let backend = SVGBackend::with_string(&mut svg, (fine(size.0), fine(size.1)));
    let mut pen = Pen { backend, failure: None };
    pen.rectangle((0.0, 0.0), (f64::from(size.0), f64::from(size.1)), WHITE);
    draw(&mut pen);
    pen.attempt(|backend| backend.present());
    let failure = pen.failure.take();
    drop(pen);
    match failure {
        Some(reason) => Err(FigureError::Backend(reason)),
        None => Ok(document(&svg, size, (title, origin.replace("# ", "").trim_end()))),
    }
}

/// The document made of plotters' text: with our head and subscripts, without redundant attributes.
fn document(svg: &str, (width, height): (u32, u32), (title, description): (&str, &str)) -> String {
    let body = svg.split_once('\n').map_or("", |(_, body)| body);
    let head = format!(
        "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {} {}\" xmlns=\"http://www.w3.org/2000/svg\" \
         stroke-linejoin=\"round\" stroke-linecap=\"round\">\n<title>{}</title>\n<desc>{}</desc>\n",
        f64::from(width) * FINENESS,
        f64::from(height) * FINENESS,
        escape(title),
        escape(description),
    );
    let body = body
        .replace(" opacity=\"1\"", "")
        .replace(" \"/>", "\"/>")
        .replace(SUBSCRIPT[0], "<tspan font-size=\"75%\" dy=\"0.3em\">")
        // Some viewers drop a space that begins a tspan.
        .replace(&format!("{} ", SUBSCRIPT[1]), "</tspan><tspan dx=\"0.28em\" dy=\"-0.225em\">")
        .replace(SUBSCRIPT[1], "</tspan><tspan dy=\"-0.225em\">")
        .replace(SUBSCRIPT[2], "</tspan>");
    head + &body
}

fn escape(text: &str) -> String {
    plain(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// The text with a subscript: `sub("J", "TPF")`.
pub fn sub(base: &str, subscript: &str) -> String {
    format!("{base}{}{subscript}{}", SUBSCRIPT[0], SUBSCRIPT[1])
}

/// The text without marks of subscripts.
fn plain(text: &str) -> String {
    text.replace(SUBSCRIPT[0], "_").replace(SUBSCRIPT[1], "")
}

/// Width of a text [px], estimated for a wide sans-serif.
pub fn text_width(text: &str, size: f64) -> f64 {
    let em: f64 = text
        .chars()
        .map(|c| match c {
            ' ' | '.' | ',' | ':' | 'i' | 'l' | 'j' | 't' | 'f' | '[' | ']' | '/' => 0.34,
            'm' | 'w' | 'M' | 'W' => 0.9,
            c if SUBSCRIPT.contains(&c) => 0.0,
            _ => 0.6,
        })
        .sum();
    em * size
}

/// Draws on a sheet. An error of plotters is kept and returned at the end.
pub struct Pen<'a> {
    backend: SVGBackend<'a>,
    failure: Option<String>,
}

impl<'a> Pen<'a> {
    fn attempt<E: std::fmt::Display>(&mut self, draw: impl FnOnce(&mut SVGBackend<'a>) -> Result<(), E>) {
        if let Err(e) = draw(&mut self.backend) {
            self.failure.get_or_insert(e.to_string());
        }
    }

    /// A line through the points; a point that is not finite parts it. Thinned to what is visible.
    pub fn line(&mut self, points: &[Point], stroke: Stroke) {
        for run in points.split(|p| !(p.0.is_finite() && p.1.is_finite())) {
            let run = thinned(run, VISIBLE_PX);
            match stroke.dash {
                _ if run.len() < 2 => {}
                None => self.polyline(&run, stroke),
                Some((dash, gap)) => {
                    for piece in dashes(&run, dash, gap) {
                        self.polyline(&piece, stroke);
                    }
                }
            }
        }
    }

    fn polyline(&mut self, points: &[Point], stroke: Stroke) {
        let style = shape(stroke.color, fine_width(stroke.width), false);
        let mut fine: Vec<_> = points.iter().map(|p| fine_point(*p)).collect();
        fine.dedup();
        self.attempt(|b| b.draw_path(fine, &style));
    }

    /// Draws a filled polygon.
    pub fn polygon(&mut self, points: &[Point], color: Rgb) {
        let fine: Vec<_> = points.iter().map(|p| fine_point(*p)).collect();
        self.attempt(|b| b.fill_polygon(fine, &shape(color, 0, true)));
    }

    /// Draws a filled rectangle between two corners.
    pub fn rectangle(&mut self, (x0, y0): Point, (x1, y1): Point, color: Rgb) {
        self.polygon(&[(x0, y0), (x1, y0), (x1, y1), (x0, y1)], color);
    }

    /// Draws a filled disc.
    pub fn disc(&mut self, centre: Point, radius: f64, color: Rgb) {
        let style = shape(color, 0, true);
        self.attempt(|b| b.draw_circle(fine_point(centre), fine_width(radius), &style, true));
    }

    /// Draws a disc within a dark rim.
    pub fn dot(&mut self, centre: Point, (outer, inner): (f64, f64), color: Rgb) {
        self.disc(centre, outer, INK);
        self.disc(centre, inner, color);
    }

    /// Writes a text, its middle line at the place.
    pub fn text(&mut self, text: &str, at: Point, anchor: Anchor, font: Font) {
        let weight = if font.bold { FontStyle::Bold } else { FontStyle::Normal };
        let color = rgb(font.color);
        let style = TextStyle::from(
            ("sans-serif", font.size * FINENESS * SIZE_PER_EM)
                .into_font()
                .style(weight)
                .transform(FontTransform::None),
        )
        .color(&color)
        .pos(Pos::new(anchor, VPos::Center));
        let open = text.matches(SUBSCRIPT[1]).count();
        let text = format!("{text}{}", SUBSCRIPT[2].to_string().repeat(open));
        self.attempt(|b| b.draw_text(&text, &style, fine_point(at)));
    }
}

fn rgb((r, g, b): Rgb) -> RGBColor {
    RGBColor(r, g, b)
}

fn shape(color: Rgb, stroke_width: u32, filled: bool) -> ShapeStyle {
    ShapeStyle { color: rgb(color).to_rgba(), filled, stroke_width }
}

fn fine_point(p: Point) -> (i32, i32) {
    // `as` saturates.
    ((p.0 * FINENESS).round() as i32, (p.1 * FINENESS).round() as i32)
}

fn fine_width(width: f64) -> u32 {
    (width * FINENESS).round() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_subscripts_are_set() {
        let svg = sheet((20, 10), ("a < b", "c & d"), |pen| {
            let font = Font { size: 10.0, color: WHITE, bold: false };
            pen.text(&format!("1 < {}", sub("J", "TPF")), (1.0, 5.0), Anchor::Left, font);
        })
        .unwrap();
        assert!(svg.contains("<title>a &lt; b</title>") && svg.contains("1 &lt; J<tspan"), "{svg}");
        assert!(svg.contains("viewBox=\"0 0 200 100\"") && svg.trim_end().ends_with("</svg>"), "{svg}");
    }
}
