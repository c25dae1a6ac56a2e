//! Room for labels: each goes to the candidate place where it covers least.

use super::canvas::{Anchor, Font, Pen, Point, Stroke};
use samara_core::math;

/// An upright rectangle [px].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LabelPlace {
    /// Left end [px].
    pub x0: f64,
    /// Upper end [px].
    pub y0: f64,
    /// Right end [px].
    pub x1: f64,
    /// Lower end [px].
    pub y1: f64,
}

impl LabelPlace {
    /// A place of this size [px] about a centre.
    pub fn around(centre: Point, width: f64, height: f64) -> Self {
        let (x, y) = centre;
        Self { x0: x - 0.5 * width, y0: y - 0.5 * height, x1: x + 0.5 * width, y1: y + 0.5 * height }
    }

    /// Centre of the place [px].
    pub fn centre(&self) -> Point {
        (0.5 * (self.x0 + self.x1), 0.5 * (self.y0 + self.y1))
    }

    fn common_area(&self, other: &Self) -> f64 {
        let width = self.x1.min(other.x1) - self.x0.max(other.x0);
        let height = self.y1.min(other.y1) - self.y0.max(other.y0);
        width.max(0.0) * height.max(0.0)
    }

    fn area(&self) -> f64 {
        (self.x1 - self.x0) * (self.y1 - self.y0)
    }

    fn holds(&self, p: Point) -> bool {
        p.0 > self.x0 && p.0 < self.x1 && p.1 > self.y0 && p.1 < self.y1
    }
}

/// The places and lines of a panel that labels must keep off.
#[derive(Clone, Debug)]
pub struct Room {
    bounds: LabelPlace,
    taken: Vec<LabelPlace>,
    /// Points of the lines, at most a pixel apart, by the strip of the bounds that they lie in, or next to.
    strips: Vec<Vec<Point>>,
}

/// Height of a strip [px].
const STRIP_PX: f64 = 8.0;

/// Weight of a pixel of a line under a label, as area of another label [px^2].
const AREA_PER_LINE_POINT: f64 = 12.0;
/// Weight of area out of bounds, or shared with another label.
const OVERLAP_WEIGHT: f64 = 10.0;

impl Room {
    /// Room between two corners [px].
    pub fn new(((x0, y0), (x1, y1)): (Point, Point)) -> Self {
        let strips = ((y1 - y0) / STRIP_PX).ceil().max(1.0) as usize;
        let bounds = LabelPlace { x0, y0, x1, y1 };
        Self { bounds, taken: Vec::new(), strips: vec![Vec::new(); strips] }
    }

    /// Keeps labels off a place.
    pub fn take(&mut self, place: LabelPlace) {
        self.taken.push(place);
    }

    /// Keeps labels off a line.
    pub fn take_line(&mut self, points: &[Point]) {
        for pair in points.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let length = math::hypot(b.0 - a.0, b.1 - a.1);
            if length.is_finite() {
                let n = (length.min(5000.0).ceil() as usize).max(1);
                let at = |i: usize| i as f64 / n as f64;
                for point in (0..n).map(|i| (a.0 + (b.0 - a.0) * at(i), a.1 + (b.1 - a.1) * at(i))) {
                    let strip = self.strip(point.1);
                    self.strips[strip].push(point);
                }
            }
        }
    }

    /// The strip that a height lies in, or is nearest to.
    fn strip(&self, y: f64) -> usize {
        (((y - self.bounds.y0) / STRIP_PX) as usize).min(self.strips.len() - 1)
    }

    /// Keeps labels off a coloured line.
    pub fn take_points(&mut self, points: &[(Point, usize)]) {
        self.take_line(&points.iter().map(|p| p.0).collect::<Vec<_>>());
    }

    /// Draws a line and keeps labels off it.
    pub fn line(&mut self, pen: &mut Pen<'_>, points: &[Point], stroke: Stroke) {
        pen.line(points, stroke);
        self.take_line(points);
    }

    /// Writes a text in the middle of the best of the candidates.
    pub fn write(
        &mut self,
        pen: &mut Pen<'_>,
        (text, font): (&str, Font),
        candidates: impl IntoIterator<Item = LabelPlace>,
    ) {
        if let Some(place) = self.best(candidates) {
            pen.text(text, place.centre(), Anchor::Center, font);
        }
    }

    /// The best of the candidates, which is taken from now on; the first among equals. `None` without
    /// candidates.
    pub fn best(&mut self, candidates: impl IntoIterator<Item = LabelPlace>) -> Option<LabelPlace> {
        let mut best: Option<(f64, LabelPlace)> = None;
        for place in candidates {
            let price = self.price(&place);
            if best.is_none_or(|(least, _)| price < least) {
                best = Some((price, place));
            }
        }
        let (_, place) = best?;
        self.take(place);
        Some(place)
    }

    /// The best of the candidates that lie within bounds and on no other label; `None` where there is none.
    pub fn free(&mut self, candidates: impl IntoIterator<Item = LabelPlace>) -> Option<LabelPlace> {
        let bounds = self.bounds;
        let within =
            |p: &LabelPlace| p.x0 >= bounds.x0 && p.y0 >= bounds.y0 && p.x1 <= bounds.x1 && p.y1 <= bounds.y1;
        let free = |p: &LabelPlace| within(p) && !self.taken.iter().any(|t| t.common_area(p) > 0.0);
        let candidates: Vec<LabelPlace> = candidates.into_iter().filter(free).collect();
        self.best(candidates)
    }

    fn price(&self, place: &LabelPlace) -> f64 {
        let outside = place.area() - place.common_area(&self.bounds);
        let covered: f64 = self.taken.iter().map(|t| t.common_area(place)).sum();
        let strips = self.strips.get(self.strip(place.y0)..=self.strip(place.y1)).unwrap_or_default();
        let lines = strips.iter().flatten().filter(|p| place.holds(**p)).count();
        OVERLAP_WEIGHT * (outside + covered) + AREA_PER_LINE_POINT * lines as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_goes_where_nothing_is() {
        let mut room = Room::new(((0.0, 0.0), (100.0, 100.0)));
        room.take_line(&[(0.0, 50.0), (100.0, 50.0)]);
        let at = |x, y| LabelPlace::around((x, y), 20.0, 10.0);
        // On the line, out of bounds, free.
        assert_eq!(room.best([at(50.0, 50.0), at(95.0, 20.0), at(50.0, 20.0)]), Some(at(50.0, 20.0)));
        // The same place is taken now.
        assert_eq!(room.best([at(50.0, 20.0), at(50.0, 80.0)]), Some(at(50.0, 80.0)));
        assert_eq!(room.best([]), None);
        // What may be left out is, where there is no room.
        assert_eq!(room.free([at(50.0, 84.0), at(95.0, 20.0)]), None);
        assert_eq!(room.free([at(50.0, 84.0), at(20.0, 20.0)]), Some(at(20.0, 20.0)));
    }
}
