//! Inequality constraints on the path, `g(x, u, u') <= 0`, at nodes and midpoints: the seam.
//!
//! A constraint is an implementation of [`PathConstraint`]; those that a plan can be asked for are in
//! `demands`. How they are held: `slacks`. A problem without constraints pays nothing.

use std::fmt::Debug;

use nalgebra::{SMatrix, SVector};

use super::dynamics::Curvature;

/// Where on the path a constraint is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPlace {
    /// Number of the interval, from 0.
    pub interval: usize,
    /// The midpoint of the interval; otherwise the node at its end.
    pub middle: bool,
    /// Time of the place [s], on a horizon that is not stretched.
    pub t_s: f64,
    /// The last node.
    pub last: bool,
}

/// State and input at a place of the path.
#[derive(Clone, Copy, Debug)]
pub struct Point<'a, const NX: usize, const NU: usize> {
    /// The place.
    pub place: PathPlace,
    /// State.
    pub x: &'a SVector<f64, NX>,
    /// Input.
    pub u: &'a SVector<f64, NU>,
    /// Rate of change of the input over the interval [1/s]; zero at nodes, where it jumps.
    pub u_dot: SVector<f64, NU>,
}

/// Gradient of a constraint at a point.
#[derive(Clone, Copy, Debug)]
pub struct PointGradient<const NX: usize, const NU: usize> {
    /// By the state.
    pub x: SVector<f64, NX>,
    /// By the input.
    pub u: SVector<f64, NU>,
    /// By the rate of change of the input.
    pub u_dot: SVector<f64, NU>,
}

impl<const NX: usize, const NU: usize> PointGradient<NX, NU> {
    /// The gradient of a constant.
    pub fn zero() -> Self {
        Self { x: SVector::zeros(), u: SVector::zeros(), u_dot: SVector::zeros() }
    }
}

/// Second derivatives that involve the change of the input over an interval.
#[derive(Clone, Copy, Debug)]
pub struct MoveTerms<const NX: usize, const NU: usize> {
    /// By the change of the input, twice; symmetric.
    pub ww: SMatrix<f64, NU, NU>,
    /// By the change of the input (rows) and the state (columns).
    pub wx: SMatrix<f64, NU, NX>,
    /// By the change of the input (rows) and the input (columns).
    pub wu: SMatrix<f64, NU, NU>,
}

impl<const NX: usize, const NU: usize> MoveTerms<NX, NU> {
    /// No second derivatives.
    pub fn zero() -> Self {
        Self { ww: SMatrix::zeros(), wx: SMatrix::zeros(), wu: SMatrix::zeros() }
    }
}

/// Second derivatives of constraints at a point, to which each adds its own.
#[derive(Clone, Copy, Debug)]
pub struct PointCurvature<const NX: usize, const NU: usize> {
    /// By state and input.
    pub states: Curvature<NX, NU>,
    /// By the rate of change of the input and the others.
    pub moves: MoveTerms<NX, NU>,
}

impl<const NX: usize, const NU: usize> PointCurvature<NX, NU> {
    /// No second derivatives.
    pub fn zero() -> Self {
        Self { states: Curvature::zero(), moves: MoveTerms::zero() }
    }
}

/// An inequality constraint on the path, `g(x, u, u') <= 0`, twice continuously differentiable; best scaled
/// so that its values are about 1.
pub trait PathConstraint<const NX: usize, const NU: usize>: Debug + Send + Sync {
    /// Whether the constraint is one at this place. (The first node, which is given, is no place.)
    fn applies(&self, place: &PathPlace) -> bool;
    /// Value of `g`.
    fn value(&self, at: &Point<'_, NX, NU>) -> f64;
    /// Gradient of `g`.
    fn gradient(&self, at: &Point<'_, NX, NU>) -> PointGradient<NX, NU>;
    /// Adds the second derivatives of `weight g` to `sum`; a linear constraint has none.
    fn add_curvature(&self, _at: &Point<'_, NX, NU>, _weight: f64, _sum: &mut PointCurvature<NX, NU>) {}
}

/// A constraint at a place, linearised there.
#[derive(Clone, Copy, Debug)]
pub struct PathRow<const NX: usize, const NU: usize> {
    /// Number of the interval, from 0.
    pub interval: usize,
    /// At the midpoint of the interval; otherwise at the node at its end.
    pub middle: bool,
    /// Gradient by the state.
    pub x: SVector<f64, NX>,
    /// Gradient by the input.
    pub u: SVector<f64, NU>,
    /// Gradient by the change of the input over the interval.
    pub w: SVector<f64, NU>,
}
