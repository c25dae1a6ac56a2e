//! The multipliers of a plan: by how much its cost changes with what each constraint leaves.
//!
//! The Lagrangian is `J + lambda^T d - z_least^T (x - x_least) - z_most^T (x_most - x)`: the cost rises by
//! `z_least` for each unit by which a lower bound is raised, and falls by `z_most` for each unit by which an
//! upper bound is.

use super::solver::Iterate;

/// Multipliers of a plan's constraints, in units of its cost J_d (32) over those of the constraint; rows of
/// one length, one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Multipliers {
    /// Number of states: `[q0 q1 q2 q3, vn ve vd, P Q R]`, and behind them those of demands, if any.
    pub states: usize,
    /// Number of rotors.
    pub rotors: usize,
    /// Of the defects (33): an interval a row, a state a column.
    pub defect: Vec<f64>,
    /// Of the lower bounds of states: a node a row, a state a column.
    pub state_least: Vec<f64>,
    /// Of the upper bounds of states: a node a row, a state a column.
    pub state_most: Vec<f64>,
    /// Of the lower bounds of thrusts: a node a row, a rotor a column.
    pub thrust_least: Vec<f64>,
    /// Of the upper bounds of thrusts: a node a row, a rotor a column.
    pub thrust_most: Vec<f64>,
    /// Of the lower bounds of a thrust's change: an interval a row, a rotor a column.
    pub change_least: Vec<f64>,
    /// Of the upper bounds of a thrust's change: an interval a row, a rotor a column.
    pub change_most: Vec<f64>,
}

impl Multipliers {
    /// The multipliers of a solution for a vehicle with so many rotors, no more than `NU`.
    pub(super) fn of<const NX: usize, const NU: usize>(iterate: &Iterate<NX, NU>, rotors: usize) -> Self {
        let Iterate { lambda, z_x, z_u, z_w, .. } = iterate;
        let of_rotors = |u: &[f64]| u.iter().take(rotors).copied().collect::<Vec<_>>();
        Self {
            states: NX,
            rotors,
            defect: lambda.iter().flat_map(|row| row.iter().copied()).collect(),
            state_least: z_x.iter().flat_map(|z| z.lo.iter().copied()).collect(),
            state_most: z_x.iter().flat_map(|z| z.hi.iter().copied()).collect(),
            thrust_least: z_u.iter().flat_map(|z| of_rotors(z.lo.as_slice())).collect(),
            thrust_most: z_u.iter().flat_map(|z| of_rotors(z.hi.as_slice())).collect(),
            change_least: z_w.iter().flat_map(|z| of_rotors(z.lo.as_slice())).collect(),
            change_most: z_w.iter().flat_map(|z| of_rotors(z.hi.as_slice())).collect(),
        }
    }
}
