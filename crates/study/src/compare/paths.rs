//! The flight paths of two drops, from the side and from above, each panel to one scale.

use std::io::{self, BufRead as _, BufReader, Read};

use samara_core::sim::Sample;
use samara_mission::bounded::BoundedLines;
use samara_report::figure::axis::{Axis, Panel, SMALL, TITLE, range};
use samara_report::figure::canvas::{self, Anchor, FigureError, Font, Pen, Point, Stroke};
use samara_report::figure::color::{FIRST, INK, Rgb, SECOND};

const WIDTH_PX: u32 = 960;
const HEIGHT_PX: u32 = 520;
const TOP_PX: f64 = 96.0;
const BOTTOM_PX: f64 = 464.0;
/// Left and right edges of the panels [px].
const SIDES_PX: [(f64, f64); 2] = [(72.0, 464.0), (552.0, 944.0)];
/// Colours of A and of B.
const COLORS: [Rgb; 2] = [FIRST, SECOND];
/// Time between marks [s].
const MARK_S: f64 = 5.0;
/// Room about the paths, as a part of their extent.
const ROOM: f64 = 0.06;
/// Longest line that is read [bytes].
const LINE_MOST: usize = 1 << 16;
/// Most rows: more than the longest flight has.
const ROWS_MOST: usize = 1 << 20;

/// A place of a flight, since the rotors were freed [s], from the nominal point of release, NED [m].
type Place = [f64; 4];
/// The columns of it.
const COLUMNS: [&str; 4] = ["t_powered_s", "north_m", "east_m", "down_m"];

/// The path of a flight, from the release on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlownPath {
    places: Vec<Place>,
}

impl FlownPath {
    /// Reads the path off `flight.csv`; `None` where that has no such columns, or no flight after a release.
    ///
    /// # Errors
    /// [`io::Error`] where it cannot be read, or has a line or more rows than any flight.
    pub fn read(from: impl Read) -> io::Result<Option<Self>> {
        let mut columns: Option<[usize; 4]> = None;
        let mut places = Vec::new();
        for line in BufReader::new(BoundedLines::new(from, LINE_MOST)).lines() {
            let line = line?;
            if line.starts_with('#') {
                continue;
            }
            let cells: Vec<&str> = line.split(',').collect();
            let Some(at) = columns else {
                let found = COLUMNS.map(|name| cells.iter().position(|cell| *cell == name));
                let [Some(t), Some(n), Some(e), Some(d)] = found else { return Ok(None) };
                columns = Some([t, n, e, d]);
                continue;
            };
            // Before the release there is no such time.
            let place = at.map(|at| cells.get(at).and_then(|cell| cell.parse().ok()));
            if let [Some(t), Some(n), Some(e), Some(d)] = place {
                places.push([t, n, e, d]);
            }
            if places.len() > ROWS_MOST {
                return Err(io::Error::new(io::ErrorKind::InvalidData, "more rows than any flight has"));
            }
        }
        Ok(Some(Self { places }).filter(|path| path.places.len() > 1))
    }

    /// The path of samples, from their release on.
    pub fn of(samples: &[Sample]) -> Self {
        let place = |sample: &Sample| {
            let p_ned = sample.state.body.p_ned;
            Some([sample.t_powered_s?, p_ned.x, p_ned.y, p_ned.z])
        };
        Self { places: samples.iter().filter_map(place).collect() }
    }

    /// The places at round times.
    fn marks(&self) -> impl Iterator<Item = &Place> {
        let number = |place: &Place| (place[0] / MARK_S).floor();
        self.places.windows(2).filter_map(move |pair| match pair {
            [before, after] if number(before) < number(after) => Some(after),
            _ => None,
        })
    }
}

/// Draws both paths, named A and B.
///
/// # Errors
/// [`FigureError::Empty`] where nothing is to be drawn; [`FigureError`] when the backend fails.
pub fn paths_figure(names: &[String; 2], paths: &[FlownPath; 2]) -> Result<String, FigureError> {
    let title = "Two flight paths";
    // North over altitude lost, east over north: what lies to the right, and what lies down or up.
    let side = View { right: 1, along: 3, words: ["north [m]", "down [m]"], is_down: true };
    let above = View { right: 2, along: 1, words: ["east [m]", "north, from above [m]"], is_down: false };
    if paths.iter().all(|path| path.places.is_empty()) {
        return Err(FigureError::Empty);
    }
    canvas::sheet((WIDTH_PX, HEIGHT_PX), (title, ""), |pen| {
        pen.text(title, (16.0, 26.0), Anchor::Left, Font { size: 18.0, color: INK, bold: true });
        for (i, (side, name)) in ["A", "B"].into_iter().zip(names).enumerate() {
            let at = (16.0 + 470.0 * i as f64, 52.0);
            pen.text(&format!("{side}: {name}"), at, Anchor::Left, Font { color: COLORS[i], ..SMALL });
        }
        for (view, sides) in [side, above].iter().zip(SIDES_PX) {
            view.draw(pen, paths, sides);
        }
    })
}

/// A view of the paths.
struct View {
    /// Component of a place that lies to the right.
    right: usize,
    /// Component that lies down, or up.
    along: usize,
    words: [&'static str; 2],
    is_down: bool,
}

impl View {
    fn draw(&self, pen: &mut Pen<'_>, paths: &[FlownPath; 2], sides_px: (f64, f64)) {
        let all = |component: usize| {
            range(paths.iter().flat_map(|path| &path.places).map(move |place| place[component]))
        };
        let (Some(right), Some(along)) = (all(self.right), all(self.along)) else { return };
        let (width_px, height_px) = (sides_px.1 - sides_px.0, BOTTOM_PX - TOP_PX);
        let m_per_px = ((right.1 - right.0) / width_px).max((along.1 - along.0) / height_px).max(1e-3);
        let about = |(low, high): (f64, f64), px: f64| {
            let half = 0.5 * (1.0 + ROOM) * m_per_px * px;
            (0.5 * (low + high) - half, 0.5 * (low + high) + half)
        };
        let y_px = if self.is_down { (TOP_PX, BOTTOM_PX) } else { (BOTTOM_PX, TOP_PX) };
        let panel = Panel {
            x: Axis::new(about(right, width_px), sides_px),
            y: Axis::new(about(along, height_px), y_px),
        };
        panel.grid(pen, 5, 6, true);
        pen.text(self.words[1], (sides_px.0 - 40.0, TOP_PX - 14.0), Anchor::Left, TITLE);
        pen.text(self.words[0], (0.5 * (sides_px.0 + sides_px.1), BOTTOM_PX + 36.0), Anchor::Center, TITLE);
        let px = |place: &Place| -> Point { panel.px(place[self.right], place[self.along]) };
        for (path, color) in paths.iter().zip(COLORS) {
            let points: Vec<Point> = path.places.iter().map(px).collect();
            pen.line(&points, Stroke::solid(color, 2.0));
            path.marks().for_each(|place| pen.disc(px(place), 3.2, color));
        }
    }
}
