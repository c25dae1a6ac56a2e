//! The state of a running solve.

use super::super::box_bounds::BoxBounds;
use super::super::problem::Problem;
use super::{Counts, Iterate, SolverOptions};

/// The best point seen: feasible with the least cost, else the least infeasible.
pub(super) struct Best<const NX: usize, const NU: usize> {
    pub(super) iterate: Iterate<NX, NU>,
    pub(super) objective: f64,
    pub(super) violation_max: f64,
}

/// A running solve.
pub(super) struct Run<'a, D, const NX: usize, const NU: usize> {
    pub(super) problem: &'a Problem<D, NX, NU>,
    pub(super) boxes: BoxBounds<NX, NU>,
    pub(super) options: &'a SolverOptions,
    pub(super) iterate: Iterate<NX, NU>,
    pub(super) mu: f64,
    pub(super) counts: Counts,
    pub(super) best: Option<Best<NX, NU>>,
    /// Whether the solve has gone on from where its inputs lead to.
    pub(super) rolled_out: bool,
    pub(super) step_length: f64,
    /// By how much the constraints on the path give way in the Newton step ([`super::super::slacks`]).
    pub(super) give: f64,
}
