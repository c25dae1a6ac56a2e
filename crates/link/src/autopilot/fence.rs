//! Areas on the map that a vehicle must stay in, or keep out of, as PX4's `Geofence` judges them.
//!
//! With areas to stay in, it must be in at least one of them; it must be in none of those to keep out of.
//! Heights do not count: an area reaches from the ground to the sky, and GF_MAX_VER_DIST is the lid. What
//! follows is GF_ACTION ([`super::failsafe`]).

use std::sync::Arc;

use nalgebra::Vector2;

/// The edge of an area, north and east in the local frame [m].
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// Corners in order, at least three; the last is joined to the first.
    Polygon(Vec<Vector2<f64>>),
    /// All that is nearer to the centre than the radius [m].
    Circle {
        /// North and east [m].
        centre_ne: Vector2<f64>,
        /// Radius [m].
        radius_m: f64,
    },
}

impl Outline {
    /// Whether it holds a place. A polygon that crosses itself holds what an odd number of its edges lies
    /// around of, as in PX4.
    pub fn holds(&self, p_ne: Vector2<f64>) -> bool {
        match self {
            Self::Circle { centre_ne, radius_m } => (p_ne - centre_ne).norm() < *radius_m,
            Self::Polygon(corners) => {
                let before = corners.iter().cycle().skip(corners.len().saturating_sub(1));
                // Edges that lie east of the place and span its northing.
                let crossed = corners.iter().zip(before).filter(|(a, b)| {
                    let spans = (a.x > p_ne.x) != (b.x > p_ne.x);
                    spans && p_ne.y < (b.y - a.y) * (p_ne.x - a.x) / (b.x - a.x) + a.y
                });
                crossed.count() % 2 == 1
            }
        }
    }
}

/// Whether to stay in an area or to keep out of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// An inclusion.
    StayIn,
    /// An exclusion.
    KeepOut,
}

/// An area of the fence.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// Whether to stay in or to keep out.
    pub rule: Rule,
    /// Where it is.
    pub outline: Outline,
}

/// All areas.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fence {
    areas: Arc<Vec<Area>>,
}

impl Fence {
    /// Of these areas; none is no fence.
    pub fn new(areas: Vec<Area>) -> Self {
        Self { areas: Arc::new(areas) }
    }

    /// How many areas there are of a kind.
    pub fn count(&self, rule: Rule) -> usize {
        self.of(rule).count()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// Whether there are areas to stay in and a place, north and east [m], is in none of them.
    pub fn is_left_at(&self, p_ne: Vector2<f64>) -> bool {
        self.count(Rule::StayIn) > 0 && !self.of(Rule::StayIn).any(|area| area.outline.holds(p_ne))
    }

    /// Whether a place, north and east [m], is in an area to keep out of.
    pub fn is_entered_at(&self, p_ne: Vector2<f64>) -> bool {
        self.of(Rule::KeepOut).any(|area| area.outline.holds(p_ne))
    }

    fn of(&self, rule: Rule) -> impl Iterator<Item = &Area> {
        self.areas.iter().filter(move |area| area.rule == rule)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use proptest::prelude::*;

    fn polygon(corners: &[(f64, f64)]) -> Outline {
        Outline::Polygon(corners.iter().map(|&(n, e)| Vector2::new(n, e)).collect())
    }

    #[test]
    fn closed_form_a_notched_square() {
        // A square of 10 m with a wedge cut out from the east down to its middle.
        let notched = polygon(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (5.0, 5.0), (0.0, 10.0)]);
        for (n, e, inside) in [
            (5.0, 4.9, true),
            (5.0, 5.1, false),
            (9.0, 8.9, true),
            (9.0, 9.1, false),
            (-0.1, 5.0, false),
            (10.1, 5.0, false),
            (5.0, -0.1, false),
            (1.0, 8.9, true),
        ] {
            assert_eq!(notched.holds(Vector2::new(n, e)), inside, "{n} {e}");
        }
        let circle = Outline::Circle { centre_ne: Vector2::new(3.0, 4.0), radius_m: 5.0 };
        assert!(circle.holds(Vector2::new(0.01, 0.01)) && !circle.holds(Vector2::new(-0.01, -0.01)));
    }

    #[test]
    fn closed_form_in_one_of_these_and_in_none_of_those() {
        let circle = |n: f64, rule| Area {
            rule,
            outline: Outline::Circle { centre_ne: Vector2::new(n, 0.0), radius_m: 10.0 },
        };
        let at = |n: f64| Vector2::new(n, 0.0);
        let none = Fence::default();
        assert!(none.is_empty() && !none.is_left_at(at(1e6)) && !none.is_entered_at(at(0.0)));
        let fence = Fence::new(vec![
            circle(0.0, Rule::StayIn),
            circle(15.0, Rule::StayIn),
            circle(20.0, Rule::KeepOut),
        ]);
        let judged = |n| (fence.is_left_at(at(n)), fence.is_entered_at(at(n)));
        assert_eq!([judged(0.0), judged(12.0), judged(26.0)], [(false, false), (false, true), (true, true)]);
        assert_eq!(judged(-11.0), (true, false));
    }

    proptest! {
        /// A convex polygon holds what lies left of all its edges.
        #[test]
        fn prop_regular_polygons_agree_with_their_half_planes(
            n in 3usize..20, turn in 0.0f64..6.0, x in -12.0f64..12.0, y in -12.0f64..12.0,
        ) {
            let corner = |i: usize| {
                let angle = turn + core::f64::consts::TAU * i as f64 / n as f64;
                Vector2::new(10.0 * math::cos(angle), 10.0 * math::sin(angle))
            };
            let p = Vector2::new(x, y);
            let side = |i: usize| (corner(i + 1) - corner(i)).perp(&(p - corner(i)));
            prop_assume!((0..n).all(|i| side(i).abs() > 1e-6));
            let outline = Outline::Polygon((0..n).map(corner).collect());
            prop_assert_eq!(outline.holds(p), (0..n).all(|i| side(i) > 0.0));
        }
    }
}
