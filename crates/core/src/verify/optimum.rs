//! Optimal trajectories of a double integrator against the solution of their optimality conditions.
//!
//! With `p_dot = v`, `v_dot = u` and an input that is linear between nodes, the collocated states are linear
//! in the inputs at the nodes, exactly: the defects (33)-(37) leave no error in a cubic. The problem is then
//! a quadratic one in the inputs, with the trapezoid's weights of (39), whose Karush-Kuhn-Tucker conditions
//! are linear once it is known which bounds are met:
//!
//! ```text
//! [ H  C' ] [ u  ]   [ -g ]
//! [ C  0  ] [ nu ] = [  d ]       nu >= 0 for bounds met from below
//! ```

use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector, SMatrix, SVector, Vector1, Vector2};

use super::{Check, CheckGroup, VerifyError};
use crate::plan::dynamics::{Curvature, Dynamics, Linearisation};
use crate::plan::problem::{Bounds, Nodes, Problem, QuadraticCost};
use crate::plan::solver::{SolverOptions, StartFrom, solve};

const INTERVALS: usize = 24;
const DT_S: f64 = 0.125;
/// Position [m] and velocity [m/s] at the first node, where the input is zero.
const START: [f64; 2] = [-4.0, 0.5];
/// Half the width of the terminal set about rest at the origin, [m] and [m/s].
const TERMINAL: [f64; 2] = [0.1, 0.05];
/// Of the solver and so of what it is compared with.
const TOLERANCE: f64 = 1e-9;

/// A point on a line, pushed.
#[derive(Clone, Copy, Debug)]
struct DoubleIntegrator;

impl Dynamics<2, 1> for DoubleIntegrator {
    fn value(&self, x: &SVector<f64, 2>, u: &SVector<f64, 1>) -> SVector<f64, 2> {
        Vector2::new(x[1], u[0])
    }

    fn linearise(&self, x: &SVector<f64, 2>, u: &SVector<f64, 1>) -> Linearisation<2, 1> {
        let a = SMatrix::<f64, 2, 2>::new(0.0, 1.0, 0.0, 0.0);
        Linearisation { f: self.value(x, u), a, b: Vector2::new(0.0, 1.0) }
    }

    fn curvature(&self, _: &SVector<f64, 2>, _: &SVector<f64, 1>, _: &SVector<f64, 2>) -> Curvature<2, 1> {
        Curvature::zero()
    }
}

/// The least effort to a terminal set, whose nearest corner it ends in; and a regulator, weights on the way
/// and at the end, that meets no bound.
///
/// # Errors
/// [`VerifyError::Problem`] for a problem that the solver does not take.
pub fn of_a_double_integrator() -> Result<CheckGroup, VerifyError> {
    let effort = problem([0.0, 0.0], [0.0, 0.0], TERMINAL);
    let regulator = problem([3.0, 0.5], [40.0, 10.0], [f64::INFINITY; 2]);
    let (least, corner) = (Solved::of(&effort)?, Exact::of(&effort, &[-TERMINAL[0], TERMINAL[1]]));
    let (regulated, exact) = (Solved::of(&regulator)?, Exact::of(&regulator, &[]));
    let inputs = |solved: &Solved, exact: &Exact| {
        let pairs: Vec<(f64, f64)> =
            solved.inputs.iter().copied().zip(exact.inputs.iter().copied()).collect();
        pairs
    };
    Ok(CheckGroup {
        title: "Optimal transfers of a double integrator, 24 intervals",
        source: "Karush-Kuhn-Tucker conditions of (32)-(39), quadratic in the inputs, as linear equations",
        checks: vec![
            Check::worst("least effort: input at the nodes", "m/s^2", inputs(&least, &corner), 1e-7),
            Check::new("least effort: cost", "m^2/s^3", least.cost, corner.cost, 1e-7),
            Check::worst("regulator: input at the nodes", "m/s^2", inputs(&regulated, &exact), 1e-7),
            Check::new("regulator: cost", "", regulated.cost, exact.cost, 1e-7),
        ],
    })
}

fn problem(q: [f64; 2], s: [f64; 2], terminal: [f64; 2]) -> Problem<DoubleIntegrator, 2, 1> {
    let free = Vector1::new(f64::INFINITY);
    let mut bounds = Bounds::on_input(-free, free, free);
    (bounds.x_end_min, bounds.x_end_max) = (-Vector2::from(terminal), Vector2::from(terminal));
    let cost =
        QuadraticCost::new((Vector2::zeros(), Vector1::zeros()), q.into(), Vector1::new(1.0), s.into());
    let start = (START.into(), Vector1::zeros());
    Problem::new(DoubleIntegrator, start, (INTERVALS, DT_S), cost, bounds)
}

/// What the planner's solver finds.
struct Solved {
    /// Inputs from the second node on [m/s^2].
    inputs: Vec<f64>,
    cost: f64,
}

impl Solved {
    fn of(problem: &Problem<DoubleIntegrator, 2, 1>) -> Result<Self, VerifyError> {
        let nodes =
            Nodes { x: vec![problem.x_initial; INTERVALS + 1], u: vec![problem.u_initial; INTERVALS + 1] };
        let options = SolverOptions { tolerance: TOLERANCE, ..SolverOptions::default() };
        let solution = solve(problem, StartFrom::Guess(nodes), &options, &mut |_| ControlFlow::Continue(()))?;
        let inputs = solution.iterate.nodes.u.iter().skip(1).map(|u| u[0]).collect();
        Ok(Self { inputs, cost: solution.objective })
    }
}

/// What the optimality conditions say.
struct Exact {
    inputs: Vec<f64>,
    cost: f64,
}

impl Exact {
    /// The optimum with the end held at `end` (position [m], velocity [m/s]), or free.
    fn of(problem: &Problem<DoubleIntegrator, 2, 1>, end: &[f64]) -> Self {
        // Row k of `of_inputs[i]`: what the inputs from the second node on make of state i at node k; beside
        // it what the start makes of it.
        let n = INTERVALS;
        let mut of_inputs = [DMatrix::<f64>::zeros(n + 1, n), DMatrix::<f64>::zeros(n + 1, n)];
        let of_start = |i: usize, k: usize| match i {
            0 => START[0] + START[1] * DT_S * k as f64,
            _ => START[1],
        };
        for k in 0..n {
            // An input that is linear over an interval, from input k - 1 (zero for the first) to input k.
            for i in 0..n {
                let (p, v) = (of_inputs[0][(k, i)], of_inputs[1][(k, i)]);
                let (from, to) = (f64::from(u8::from(i + 1 == k)), f64::from(u8::from(i == k)));
                of_inputs[0][(k + 1, i)] = p + v * DT_S + (2.0 * from + to) * DT_S * DT_S / 6.0;
                of_inputs[1][(k + 1, i)] = v + 0.5 * (from + to) * DT_S;
            }
        }
        let c = &problem.cost;
        let weight = |k: usize| if k == 0 || k == n { 0.5 * DT_S } else { DT_S };
        let mut hessian = DMatrix::<f64>::zeros(n, n);
        let mut gradient = DVector::<f64>::zeros(n);
        let mut constant = 0.0;
        for k in 0..n {
            hessian[(k, k)] += 2.0 * weight(k + 1) * c.r[0];
        }
        for (i, of_inputs) in of_inputs.iter().enumerate() {
            for k in 0..=n {
                let at_end = if k == n { c.s[i] } else { 0.0 };
                let w = weight(k) * c.q[i] + at_end;
                let row = of_inputs.row(k).transpose();
                hessian += &row * row.transpose() * (2.0 * w);
                gradient += &row * (2.0 * w * of_start(i, k));
                constant += w * of_start(i, k) * of_start(i, k);
            }
        }
        let m = end.len();
        let mut kkt = DMatrix::<f64>::zeros(n + m, n + m);
        let mut right = DVector::<f64>::zeros(n + m);
        kkt.view_mut((0, 0), (n, n)).copy_from(&hessian);
        right.rows_mut(0, n).copy_from(&-&gradient);
        for (i, held) in end.iter().enumerate() {
            let row = of_inputs[i].row(n);
            kkt.view_mut((n + i, 0), (1, n)).copy_from(&row);
            kkt.view_mut((0, n + i), (n, 1)).copy_from(&row.transpose());
            right[n + i] = held - of_start(i, n);
        }
        let solved = kkt.lu().solve(&right).unwrap_or_else(|| DVector::from_element(n + m, f64::NAN));
        let inputs = solved.rows(0, n).into_owned();
        let cost = 0.5 * inputs.dot(&(&hessian * &inputs)) + gradient.dot(&inputs) + constant;
        Self { inputs: inputs.iter().copied().collect(), cost }
    }
}
