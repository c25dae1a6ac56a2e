//! Plans on a grid of release states, for flight computers that cannot solve: at each grid point a solved
//! plan, between them multilinear interpolation, node by node.
//!
//! | file | holds |
//! |---|---|
//! | `axes` | the axes, and where a state lies between their points |
//!
//! ```text
//! x(t_k; s) = sum_c w_c(s) x(t_k; s_c),   w_c = product over the axes of share or 1 - share
//! ```
//!
//! over the 16 corners s_c of the cell that the release state s lies in; beyond the edge of the grid s is
//! moved to the edge. What a solve keeps linearly - bounds on thrusts and on their slew, the given velocity
//! and rates at t = 0 - the interpolated plan keeps. In the dynamics it errs, with the square of the size of
//! a cell, and where a bound of the solves comes or goes within the cell, with the size.

mod axes;

use std::ops::ControlFlow;

pub use axes::{
    AXES, AXIS_NAMES, AXIS_POINTS_MOST, GridAxes, GridAxesError, GridPlace, GridState, POINTS_MOST,
    grid_state,
};

use super::guess::Guess;
use super::solver::{SolverOptions, Status};
use super::vehicle::{Plan, PlanError, PlanProblem, plan};
use crate::frames::quaternion_from_euler;
use crate::trajectory::Trajectory;

/// Most nodes of all plans of a grid together.
pub const GRID_NODES_MOST: usize = 1_000_000;

/// Why plans make no grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanGridError {
    /// The axes.
    #[error(transparent)]
    Axes(#[from] GridAxesError),
    /// Another number of plans than of grid points.
    #[error("a plan for each of {points} grid points is expected, found {found}")]
    Count {
        /// Number of grid points.
        points: usize,
        /// Number of plans.
        found: usize,
    },
    /// A plan whose nodes are at other times than the first one's, or for another number of rotors.
    #[error("the plans of a grid have the same node times and rotors, and those of point {point} are others")]
    Nodes {
        /// Number of the grid point.
        point: usize,
    },
    /// More nodes than a grid may have.
    #[error(
        "at most {GRID_NODES_MOST} nodes in all are expected, found {points} grid points of {nodes} nodes"
    )]
    TooLarge {
        /// Number of grid points.
        points: usize,
        /// Number of nodes of a plan.
        nodes: usize,
    },
}

/// A plan for each point of a grid of release states, all on the same node times.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanGrid {
    axes: GridAxes,
    plans: Vec<Trajectory>,
}

/// The plan of a grid for a release state.
#[derive(Clone, Debug, PartialEq)]
pub struct GridPlan {
    /// Interpolated plan; its attitudes are the weighted quaternions, not normalised.
    pub trajectory: Trajectory,
    /// Where the state lies among the grid points, and how far outside.
    pub place: GridPlace,
}

impl PlanGrid {
    /// The grid with these plans, in the order of the points' numbers.
    ///
    /// # Errors
    /// [`PlanGridError`] for another number of plans than of points, plans that differ in node times or
    /// rotors, more than [`GRID_NODES_MOST`] nodes in all.
    pub fn new(axes: GridAxes, plans: Vec<Trajectory>) -> Result<Self, PlanGridError> {
        let points = axes.count();
        let [first, ..] = &plans[..] else { return Err(PlanGridError::Count { points, found: 0 }) };
        if plans.len() != points {
            return Err(PlanGridError::Count { points, found: plans.len() });
        }
        check_size(points, first.nodes().len())?;
        let alike = |plan: &Trajectory| {
            let times = |of: &Trajectory| of.nodes().iter().map(|node| node.t_s).collect::<Vec<_>>();
            plan.n_rotors() == first.n_rotors() && times(plan) == times(first)
        };
        match plans.iter().position(|plan| !alike(plan)) {
            Some(point) => Err(PlanGridError::Nodes { point }),
            None => Ok(Self { axes, plans }),
        }
    }

    /// The axes.
    pub fn axes(&self) -> &GridAxes {
        &self.axes
    }

    /// The plan of each grid point, in the order of their numbers.
    pub fn plans(&self) -> &[Trajectory] {
        &self.plans
    }

    /// The plan for a release state: multilinear between the grid points, that of the edge beyond it. At a
    /// grid point it is the solved plan to the bit.
    pub fn at(&self, state: &GridState) -> GridPlan {
        let place = self.axes.place(state);
        let [(first, weight), rest @ ..] = place.corners;
        let rest: Vec<(&Trajectory, f64)> = rest
            .iter()
            .filter(|(_, weight)| *weight > 0.0)
            .map(|(number, weight)| (&self.plans[*number], *weight))
            .collect();
        GridPlan { trajectory: self.plans[first].weighted(weight, &rest), place }
    }
}

/// Refuses a grid of more nodes than [`GRID_NODES_MOST`].
///
/// # Errors
/// [`PlanGridError::TooLarge`].
pub fn check_size(points: usize, nodes: usize) -> Result<(), PlanGridError> {
    if points.saturating_mul(nodes) > GRID_NODES_MOST {
        return Err(PlanGridError::TooLarge { points, nodes });
    }
    Ok(())
}

/// The problem of a grid point: that of the nominal release with velocity north and down, pitch and pitch
/// rate of the state at t = 0, without roll and yaw.
pub fn grid_problem<'a>(nominal: &PlanProblem<'a>, state: &GridState) -> PlanProblem<'a> {
    let [v_north_m_s, v_down_m_s, pitch_rad, rate_rad_s] = *state;
    let [q0, q1, q2, q3] = quaternion_from_euler(0.0, pitch_rad, 0.0);
    let [.., v_east_m_s, _, roll_rate_rad_s, _, yaw_rate_rad_s] = nominal.initial;
    let initial =
        [q0, q1, q2, q3, v_north_m_s, v_east_m_s, v_down_m_s, roll_rate_rad_s, rate_rad_s, yaw_rate_rad_s];
    PlanProblem { initial, ..nominal.clone() }
}

/// Solves the problem of a grid point, from the nominal plan, and where that does not converge from a
/// straight line. The result depends on these arguments alone.
///
/// # Errors
/// [`PlanError`] for a problem that cannot be posed.
pub fn solve_grid_point(
    nominal: (&PlanProblem<'_>, &Plan),
    state: &GridState,
    options: &SolverOptions,
) -> Result<Plan, PlanError> {
    let problem = grid_problem(nominal.0, state);
    let solve = |guess: &Guess<'_>| plan(&problem, guess, options, &mut |_| ControlFlow::Continue(()));
    let warm = solve(&nominal.1.moved_on(0))?;
    if warm.status == Status::Converged { Ok(warm) } else { solve(&Guess::StraightLine) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::Node;
    use nalgebra::Vector3;

    fn axes() -> GridAxes {
        GridAxes::new([vec![-1.0, 0.0, 2.0], vec![3.0, 4.0], vec![0.1], vec![-1.0, 0.5]]).unwrap()
    }

    /// A plan that is linear in the state.
    fn linear(state: &GridState) -> Trajectory {
        let [a, b, c, d] = *state;
        let node = |t_s: f64| Node {
            t_s,
            q_ned_from_body: [1.0, 0.0, 0.1 * a - 0.2 * d * t_s, 0.0],
            v_ned: Vector3::new(a + t_s * d, 2.0 * c, b - 3.0 * a * t_s),
            omega_body: Vector3::new(0.0, d * (1.0 - t_s), 0.0),
            thrust_n: [10.0 + a + b, 20.0 - d, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
            a_ned: Vector3::new(d, 0.0, -3.0 * a),
        };
        Trajectory::new([0.0, 0.5, 1.5].map(node).to_vec(), 4).unwrap()
    }

    fn grid() -> PlanGrid {
        let axes = axes();
        let plans = (0..axes.count()).map(|number| linear(&axes.state(number))).collect();
        PlanGrid::new(axes, plans).unwrap()
    }

    fn largest_difference(a: &Trajectory, b: &Trajectory) -> f64 {
        let values = |node: &Node| {
            let mut values = vec![node.t_s];
            values.extend(node.q_ned_from_body);
            values.extend(node.v_ned.iter().chain(node.omega_body.iter()).chain(node.a_ned.iter()));
            values.extend(node.thrust_n);
            values
        };
        let nodes = a.nodes().iter().zip(b.nodes());
        nodes
            .flat_map(|(a, b)| values(a).into_iter().zip(values(b)).collect::<Vec<_>>())
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
    }

    /// What is linear in the state is interpolated to rounding, and beyond the edge it is that of the edge.
    #[test]
    fn closed_form_linear_plans() {
        let grid = grid();
        for state in [[-0.3, 3.2, 0.1, -0.7], [1.9, 4.0, 0.1, 0.5], [0.0, 3.0, 0.1, 0.0]] {
            let found = grid.at(&state);
            assert!(largest_difference(&found.trajectory, &linear(&state)) < 1e-14, "{found:?}");
            assert!(!found.place.is_clamped());
        }
        let found = grid.at(&[5.0, 3.5, 0.1, -2.0]);
        assert!(largest_difference(&found.trajectory, &linear(&[2.0, 3.5, 0.1, -1.0])) < 1e-14);
        assert_eq!(found.place.outside, [3.0, 0.0, 0.0, -1.0]);
    }

    /// Grid points give back their plans to the bit.
    #[test]
    fn closed_form_grid_points_are_the_solves() {
        let grid = grid();
        for number in 0..grid.axes().count() {
            let found = grid.at(&grid.axes().state(number)).trajectory;
            assert_eq!(found, grid.plans()[number]);
            let bits = |t: &Trajectory| t.nodes().iter().map(|n| n.v_ned.z.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&found), bits(&grid.plans()[number]));
        }
    }

    #[test]
    fn what_makes_no_grid_is_refused() {
        let (axes, plans) = (axes(), grid().plans().to_vec());
        let short = PlanGrid::new(axes.clone(), plans[1..].to_vec());
        assert_eq!(short, Err(PlanGridError::Count { points: 12, found: 11 }));
        assert!(matches!(PlanGrid::new(axes.clone(), vec![]), Err(PlanGridError::Count { found: 0, .. })));
        let mut other = plans;
        let fewer = other[5].nodes()[..2].to_vec();
        other[5] = Trajectory::new(fewer, 4).unwrap();
        assert_eq!(PlanGrid::new(axes, other), Err(PlanGridError::Nodes { point: 5 }));
        assert!(check_size(10_000, 100).is_ok() && check_size(10_000, 101).is_err());
        assert!(check_size(usize::MAX, 2).is_err());
    }
}
