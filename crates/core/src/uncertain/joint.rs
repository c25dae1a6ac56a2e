//! Quantities that are normal together.

use nalgebra::DMatrix;

use super::{Deviations, Distribution, UncertainQuantity};

/// Quantities that are normal together, with their covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct JointNormal {
    quantities: Vec<UncertainQuantity>,
    mean: Vec<f64>,
    covariance: DMatrix<f64>,
    /// The lower triangle whose product with its transpose is the covariance.
    root: DMatrix<f64>,
}

/// What is no covariance of the quantities, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnfitCovariance {
    /// Fewer than two quantities.
    #[error("expected two quantities or more")]
    Few,
    /// A quantity is named twice.
    #[error("expected each quantity once")]
    Twice,
    /// Not as many rows, columns or means as quantities.
    #[error("expected a row, a column and a mean for each quantity")]
    Size,
    /// A number is none, or is infinite.
    #[error("expected finite numbers")]
    NotFinite,
    /// An entry differs from its mirror image.
    #[error("expected a symmetric matrix")]
    Asymmetric,
    /// Some sum of the quantities would have no variance, or a negative one.
    #[error("expected a positive definite matrix")]
    NotPositive,
}

/// Largest difference of mirror images, as a share of the standard deviations.
const SYMMETRIC_WITHIN: f64 = 1e-9;

impl JointNormal {
    /// Quantities with their means and their covariance, row by row, each in its unit or as a share.
    ///
    /// # Errors
    /// [`UnfitCovariance`] says why there is no such distribution.
    pub fn new(
        quantities: Vec<UncertainQuantity>,
        mean: Vec<f64>,
        rows: &[Vec<f64>],
    ) -> Result<Self, UnfitCovariance> {
        let n = quantities.len();
        if n < 2 {
            return Err(UnfitCovariance::Few);
        }
        if (1..n).any(|i| quantities[..i].contains(&quantities[i])) {
            return Err(UnfitCovariance::Twice);
        }
        if mean.len() != n || rows.len() != n || rows.iter().any(|row| row.len() != n) {
            return Err(UnfitCovariance::Size);
        }
        if !mean.iter().chain(rows.iter().flatten()).all(|x| x.is_finite()) {
            return Err(UnfitCovariance::NotFinite);
        }
        let covariance = DMatrix::from_fn(n, n, |i, j| rows[i][j]);
        let size = |i: usize, j: usize| (covariance[(i, i)] * covariance[(j, j)]).abs().sqrt();
        let is_off = |i: usize, j: usize| {
            (covariance[(i, j)] - covariance[(j, i)]).abs() > SYMMETRIC_WITHIN * size(i, j)
        };
        if (0..n).any(|i| (0..i).any(|j| is_off(i, j))) {
            return Err(UnfitCovariance::Asymmetric);
        }
        let root = covariance.clone().cholesky().ok_or(UnfitCovariance::NotPositive)?.l();
        Ok(Self { quantities, mean, covariance, root })
    }

    /// The quantities, in the order of their rows.
    pub fn quantities(&self) -> &[UncertainQuantity] {
        &self.quantities
    }

    /// The distribution of one of them, whatever the others are; `None`: it is not one of them.
    pub fn marginal(&self, quantity: UncertainQuantity) -> Option<Distribution> {
        let i = self.quantities.iter().position(|one| *one == quantity)?;
        Some(Distribution::Normal { mean: self.mean[i], sigma: self.covariance[(i, i)].sqrt() })
    }

    /// The correlation of two of them, from -1 to 1; `None`: they are not both of them.
    pub fn correlation(&self, a: UncertainQuantity, b: UncertainQuantity) -> Option<f64> {
        let place = |quantity| self.quantities.iter().position(|one| *one == quantity);
        let (i, j) = (place(a)?, place(b)?);
        Some(self.covariance[(i, j)] / (self.covariance[(i, i)] * self.covariance[(j, j)]).sqrt())
    }

    /// These without one of them: what the others are does not change. `None`: nothing is left.
    pub(super) fn without(mut self, quantity: UncertainQuantity) -> Option<Self> {
        let Some(i) = self.quantities.iter().position(|one| *one == quantity) else { return Some(self) };
        self.quantities.remove(i);
        self.mean.remove(i);
        self.covariance = self.covariance.remove_row(i).remove_column(i);
        self.root = self.covariance.clone().cholesky()?.l();
        (!self.quantities.is_empty()).then_some(self)
    }

    /// Puts how far the quantities are off at their standard-normal coordinates.
    pub(super) fn set(&self, coordinate: &impl Fn(UncertainQuantity) -> f64, deviations: &mut Deviations) {
        for (i, quantity) in self.quantities.iter().enumerate() {
            let of = |j: usize| self.root[(i, j)] * coordinate(self.quantities[j]);
            deviations.set(*quantity, self.mean[i] + (0..=i).map(of).sum::<f64>());
        }
    }
}
