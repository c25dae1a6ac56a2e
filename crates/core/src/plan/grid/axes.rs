//! Axes of a grid over release states in the plane of the manoeuvre, and where a state lies between them.

use crate::frames::pitch;
use crate::model::rigid_body::BodyState;

/// State at t = 0 in the plane of the manoeuvre: velocity north [m/s], velocity down [m/s], pitch [rad],
/// pitch rate [rad/s].
pub type GridState = [f64; AXES];

/// Number of axes.
pub const AXES: usize = 4;

/// Names of the axes in messages, in the order of [`GridState`]; each ends in the unit.
pub const AXIS_NAMES: [&str; AXES] = ["v_north_m_s", "v_down_m_s", "pitch_rad", "pitch_rate_rad_s"];

/// Most points on one axis.
pub const AXIS_POINTS_MOST: usize = 64;

/// Most points of a grid.
pub const POINTS_MOST: usize = 10_000;

/// Greatest size of a point, in the unit of its axis: no release comes near.
const SIZE_MOST: f64 = 1000.0;

/// Corners of a cell.
const CORNERS: usize = 1 << AXES;

/// The planar part of a release state.
pub fn grid_state(body: &BodyState) -> GridState {
    [body.v_ned.x, body.v_ned.z, pitch(body.q_ned_from_body), body.omega_body.y]
}

/// Why numbers make no axes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GridAxesError {
    /// An axis with no point or with too many.
    #[error("{axis}: from 1 to {AXIS_POINTS_MOST} points are expected, found {found}")]
    Points {
        /// Name of the axis.
        axis: &'static str,
        /// Number of points found.
        found: usize,
    },
    /// A point beyond what any release has, or not above the one before it.
    #[error(
        "{axis}: numbers from -1000 to 1000 in ascending order are expected, but {value:?} is point {point}"
    )]
    Order {
        /// Name of the axis.
        axis: &'static str,
        /// Index of the point, from 0.
        point: usize,
        /// The point.
        value: f64,
    },
    /// Too many points on all axes together.
    #[error("at most {POINTS_MOST} grid points are expected, found {0}")]
    TooMany(usize),
}

/// Points of each axis, ascending; an axis of one point is one that nothing varies along. The points of the
/// grid are numbered with the last axis running fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct GridAxes {
    points: [Vec<f64>; AXES],
}

impl GridAxes {
    /// Checks the points of the axes, in the order of [`GridState`].
    ///
    /// # Errors
    /// [`GridAxesError`] for an axis without points or with more than [`AXIS_POINTS_MOST`], points beyond
    /// 1000 either way or that do not ascend, more than [`POINTS_MOST`] grid points.
    pub fn new(points: [Vec<f64>; AXES]) -> Result<Self, GridAxesError> {
        for (axis, points) in AXIS_NAMES.into_iter().zip(&points) {
            if !(1..=AXIS_POINTS_MOST).contains(&points.len()) {
                return Err(GridAxesError::Points { axis, found: points.len() });
            }
            let ascends = |i: usize| points[i].abs() <= SIZE_MOST && (i == 0 || points[i] > points[i - 1]);
            if let Some(point) = (0..points.len()).find(|i| !ascends(*i)) {
                return Err(GridAxesError::Order { axis, point, value: points[point] });
            }
        }
        let axes = Self { points };
        if axes.count() > POINTS_MOST {
            return Err(GridAxesError::TooMany(axes.count()));
        }
        Ok(axes)
    }

    /// Axes of so many points each, evenly spaced from the lower to the upper end of a range; one point: the
    /// middle.
    ///
    /// # Errors
    /// [`GridAxesError`] as [`Self::new`].
    pub fn even(ranges: &[[f64; 2]; AXES], shape: [usize; AXES]) -> Result<Self, GridAxesError> {
        let even = |[low, high]: [f64; 2], n: usize| match n {
            1 => vec![0.5 * (low + high)],
            _ => (0..n).map(|i| low + (high - low) * (i as f64 / (n - 1) as f64)).collect(),
        };
        Self::new(std::array::from_fn(|axis| even(ranges[axis], shape[axis].min(AXIS_POINTS_MOST + 1))))
    }

    /// Points of each axis.
    pub fn points(&self) -> &[Vec<f64>; AXES] {
        &self.points
    }

    /// Number of points on each axis.
    pub fn shape(&self) -> [usize; AXES] {
        std::array::from_fn(|axis| self.points[axis].len())
    }

    /// Number of grid points.
    pub fn count(&self) -> usize {
        self.points.iter().map(Vec::len).product()
    }

    /// The state of the grid point of this number, below [`Self::count`].
    pub fn state(&self, number: usize) -> GridState {
        let mut rest = number;
        let mut state = [0.0; AXES];
        for (value, points) in state.iter_mut().zip(&self.points).rev() {
            *value = points[rest % points.len()];
            rest /= points.len();
        }
        state
    }

    /// The cell that a state lies in, with the weights of its corners. Beyond an edge the edge counts.
    pub fn place(&self, state: &GridState) -> GridPlace {
        let mut corners = [(0, 1.0); CORNERS];
        let mut outside = [0.0; AXES];
        for (axis, points) in self.points.iter().enumerate() {
            let (low, high) = (points[0], points[points.len() - 1]);
            // What is no number counts as the lower end.
            let at = if state[axis] > low { state[axis].min(high) } else { low };
            if points.len() > 1 {
                outside[axis] = state[axis] - at;
            }
            // The last point that does not lie above: its share is above 0 always.
            let i = points.partition_point(|point| *point <= at) - 1;
            let share = points.get(i + 1).map_or(0.0, |next| (at - points[i]) / (next - points[i]));
            for (corner, (number, weight)) in corners.iter_mut().enumerate() {
                let upper = corner >> (AXES - 1 - axis) & 1;
                *number = *number * points.len() + i + if share > 0.0 { upper } else { 0 };
                *weight *= if upper == 1 { share } else { 1.0 - share };
            }
        }
        GridPlace { corners, outside }
    }
}

/// Where a state lies among the points of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPlace {
    /// Number and weight of each corner of the cell; the weights sum to 1, that of the first, the lowest in
    /// every axis, is above 0.
    pub corners: [(usize, f64); CORNERS],
    /// How far the state lies beyond the upper edge of each axis, below the lower edge negative; 0 inside,
    /// and along an axis of one point.
    pub outside: GridState,
}

impl GridPlace {
    /// Whether the state lies outside the grid, whose edge stands for it.
    pub fn is_clamped(&self) -> bool {
        self.outside != [0.0; AXES]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn axes() -> GridAxes {
        GridAxes::new([vec![-1.0, 0.5, 2.0], vec![3.0], vec![-0.2, 0.3], vec![-1.0, 0.0, 0.25, 4.0]]).unwrap()
    }

    /// The last axis runs fastest; the points are those of the axes.
    #[test]
    fn closed_form_numbers_of_points() {
        let axes = axes();
        assert_eq!((axes.shape(), axes.count()), ([3, 1, 2, 4], 24));
        assert_eq!(axes.state(0), [-1.0, 3.0, -0.2, -1.0]);
        assert_eq!(axes.state(1), [-1.0, 3.0, -0.2, 0.0]);
        assert_eq!(axes.state(4), [-1.0, 3.0, 0.3, -1.0]);
        assert_eq!(axes.state(23), [2.0, 3.0, 0.3, 4.0]);
        let even = GridAxes::even(&[[-1.0, 1.0], [3.0, 5.0], [0.0, 1.0], [0.0, 1.0]], [3, 1, 2, 2]).unwrap();
        assert_eq!(even.points()[..2], [vec![-1.0, 0.0, 1.0], vec![4.0]]);
    }

    /// A grid point is its own corner, with all the weight.
    #[test]
    fn closed_form_place_of_a_grid_point() {
        let axes = axes();
        for number in 0..axes.count() {
            let place = axes.place(&axes.state(number));
            let heavy: Vec<_> = place.corners.iter().filter(|(_, weight)| *weight != 0.0).collect();
            assert_eq!((heavy, place.is_clamped()), (vec![&(number, 1.0)], false));
        }
    }

    /// By hand: a quarter of the way in one axis, beyond the edge in two others.
    #[test]
    fn closed_form_place_between_and_outside() {
        let place = axes().place(&[-2.5, 7.0, 0.5, 1.1875]);
        let heavy: Vec<_> = place.corners.iter().filter(|(_, weight)| *weight != 0.0).collect();
        assert_eq!(heavy, [&(6, 0.75), &(7, 0.25)]);
        assert_eq!(place.outside, [-1.5, 0.0, 0.2, 0.0]);
        assert!(axes().place(&[f64::NAN; AXES]).is_clamped());
    }

    #[test]
    fn what_makes_no_axes_is_refused() {
        let with = |last: Vec<f64>| GridAxes::new([vec![0.0], vec![0.0], vec![0.0], last]);
        let refused = |last: Vec<f64>| with(last).unwrap_err().to_string();
        assert_eq!(refused(vec![]), "pitch_rate_rad_s: from 1 to 64 points are expected, found 0");
        assert!(refused(vec![0.0; 65]).contains("found 65"));
        assert!(refused(vec![0.0, 0.0]).contains("0.0 is point 1"));
        assert!(refused(vec![f64::NAN]).contains("NaN is point 0"));
        let many = |n: usize| (0..n).map(|i| i as f64).collect::<Vec<_>>();
        let too_many = GridAxes::new([many(22), many(22), many(22), vec![0.0]]);
        assert_eq!(too_many, Err(GridAxesError::TooMany(10_648)));
        assert!(GridAxes::even(&[[0.0, 1.0]; AXES], [usize::MAX, 1, 1, 1]).is_err());
    }

    proptest! {
        /// Weights sum to 1 and are none below 0; inside, the weighted corners are the state itself.
        #[test]
        fn prop_weighted_corners_are_the_state(
            v_north in -1.0..2.0f64, pitch in -0.2..0.3f64, rate in -1.0..4.0f64
        ) {
            let (axes, state) = (axes(), [v_north, 3.0, pitch, rate]);
            let place = axes.place(&state);
            prop_assert!(!place.is_clamped() && place.corners[0].1 > 0.0);
            let mut sum = [0.0; AXES + 1];
            for (number, weight) in place.corners {
                prop_assert!(weight >= 0.0 && number < axes.count());
                let point = axes.state(number);
                sum[AXES] += weight;
                for axis in 0..AXES {
                    sum[axis] += weight * point[axis];
                }
            }
            prop_assert!((sum[AXES] - 1.0).abs() < 1e-14);
            for axis in 0..AXES {
                prop_assert!((sum[axis] - state[axis]).abs() < 1e-13, "{sum:?} {state:?}");
            }
        }
    }
}
