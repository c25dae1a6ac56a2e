//! Lines as points: thinned to what is visible, cut into dashes and into runs.

use samara_core::math;

/// A point on the sheet [px], x to the right, y down.
pub type Point = (f64, f64);

/// The points of a line that stays within `tolerance` of all points (Ramer, Douglas and Peucker).
pub fn thinned(points: &[Point], tolerance: f64) -> Vec<Point> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let mut keep = vec![false; points.len()];
    keep[0] = true;
    keep[points.len() - 1] = true;
    let mut open = vec![(0, points.len() - 1)];
    while let Some((a, b)) = open.pop() {
        let farthest = (a + 1..b)
            .map(|i| (i, distance(points[i], points[a], points[b])))
            .max_by(|x, y| x.1.total_cmp(&y.1));
        if let Some((i, d)) = farthest
            && d > tolerance
        {
            keep[i] = true;
            open.extend([(a, i), (i, b)]);
        }
    }
    points.iter().zip(keep).filter_map(|(p, k)| k.then_some(*p)).collect()
}

/// Distance of a point from the line between two others.
fn distance(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length_squared = dx * dx + dy * dy;
    let along = if length_squared > 0.0 {
        (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    math::hypot(p.0 - a.0 - along * dx, p.1 - a.1 - along * dy)
}

/// The parts of a line whose points have one key, each with that key; a part ends where the next one begins.
pub fn runs<K: Copy + PartialEq>(points: &[(Point, K)]) -> Vec<(K, Vec<Point>)> {
    let mut runs = Vec::new();
    let mut start = 0;
    while start + 1 < points.len() {
        let key = points[start].1;
        let run = points[start..].iter().take_while(|p| p.1 == key).count();
        let end = (start + run + 1).min(points.len());
        runs.push((key, points[start..end].iter().map(|p| p.0).collect()));
        start += run;
    }
    runs
}

/// Cuts a line of at least one point into dashes [px].
pub fn dashes(points: &[Point], dash: f64, gap: f64) -> Vec<Vec<Point>> {
    let mut pieces = vec![vec![points[0]]];
    let (mut drawing, mut left) = (true, dash);
    for pair in points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let length = math::hypot(b.0 - a.0, b.1 - a.1);
        let at = |s: f64| (a.0 + (b.0 - a.0) * s / length, a.1 + (b.1 - a.1) * s / length);
        let mut done = 0.0;
        while length - done > left {
            done += left;
            if drawing {
                if let Some(piece) = pieces.last_mut() {
                    piece.push(at(done));
                }
            } else {
                pieces.push(vec![at(done)]);
            }
            drawing = !drawing;
            left = if drawing { dash } else { gap };
        }
        left -= length - done;
        if drawing && let Some(piece) = pieces.last_mut() {
            piece.push(b);
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_a_straight_line_thins_to_its_ends_and_a_corner_stays() {
        let straight: Vec<Point> = (0..100).map(|i| (f64::from(i), 2.0 * f64::from(i))).collect();
        assert_eq!(thinned(&straight, 0.01), [(0.0, 0.0), (99.0, 198.0)]);
        let corner = [(0.0, 0.0), (5.0, 0.0), (10.0, 0.0), (10.0, 5.0), (10.0, 10.0)];
        assert_eq!(thinned(&corner, 0.01), [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)]);
    }

    #[test]
    fn closed_form_dashes_go_around_corners() {
        let pieces = dashes(&[(0.0, 0.0), (5.0, 0.0), (5.0, 10.0)], 4.0, 2.0);
        assert_eq!(pieces[0], [(0.0, 0.0), (4.0, 0.0)]);
        assert_eq!(pieces[1], [(5.0, 1.0), (5.0, 5.0)]);
        assert_eq!(pieces[2], [(5.0, 7.0), (5.0, 10.0)]);
    }
}
