//! Products of small fixed-size matrices.
//!
//! Plain loops over columns, in a fixed order of operations: the result is the same bits on every machine (a BLAS-like
//! kernel that picks fused multiply-add where it finds it would not be), and the compiler unrolls and vectorises them,
//! since every size is known.

use nalgebra::{SMatrix, SVector};

/// `out += a b`.
#[inline(always)]
pub fn add_mul<const M: usize, const K: usize, const N: usize>(
    out: &mut SMatrix<f64, M, N>,
    a: &SMatrix<f64, M, K>,
    b: &SMatrix<f64, K, N>,
) {
    let (out, a, b) = (&mut out.data.0, &a.data.0, &b.data.0);
    for j in 0..N {
        let mut column = out[j];
        for k in 0..K {
            let x = b[j][k];
            for i in 0..M {
                column[i] += a[k][i] * x;
            }
        }
        out[j] = column;
    }
}

/// `a b`.
#[inline(always)]
pub fn mul<const M: usize, const K: usize, const N: usize>(
    a: &SMatrix<f64, M, K>,
    b: &SMatrix<f64, K, N>,
) -> SMatrix<f64, M, N> {
    let mut out = SMatrix::zeros();
    add_mul(&mut out, a, b);
    out
}

/// `out += a^T b`.
#[inline(always)]
pub fn add_tr_mul<const M: usize, const K: usize, const N: usize>(
    out: &mut SMatrix<f64, M, N>,
    a: &SMatrix<f64, K, M>,
    b: &SMatrix<f64, K, N>,
) {
    // Transposing first turns dot products into the axpy form of `add_mul`, which vectorises.
    add_mul(out, &a.transpose(), b);
}

/// `a^T b`.
#[inline(always)]
pub fn tr_mul<const M: usize, const K: usize, const N: usize>(
    a: &SMatrix<f64, K, M>,
    b: &SMatrix<f64, K, N>,
) -> SMatrix<f64, M, N> {
    let mut out = SMatrix::zeros();
    add_tr_mul(&mut out, a, b);
    out
}

/// LU factors of a square matrix with partial pivoting.
#[derive(Clone, Copy, Debug)]
pub struct Lu<const N: usize> {
    lu: SMatrix<f64, N, N>,
    swaps: [usize; N],
}

impl<const N: usize> Lu<N> {
    /// Factors `a`; `None` when a pivot vanishes or is not finite.
    #[inline(always)]
    pub fn new(mut a: SMatrix<f64, N, N>) -> Option<Self> {
        let mut swaps = [0; N];
        for k in 0..N {
            let mut pivot = k;
            for i in k + 1..N {
                if a[(i, k)].abs() > a[(pivot, k)].abs() {
                    pivot = i;
                }
            }
            swaps[k] = pivot;
            if pivot != k {
                a.swap_rows(pivot, k);
            }
            let diagonal = a[(k, k)];
            if !(diagonal.abs() > 1e-300 && diagonal.is_finite()) {
                return None;
            }
            let inverse = 1.0 / diagonal;
            for i in k + 1..N {
                a[(i, k)] *= inverse;
            }
            let data = &mut a.data.0;
            let pivot_column = data[k];
            for column in data.iter_mut().skip(k + 1) {
                let x = column[k];
                for i in k + 1..N {
                    column[i] -= pivot_column[i] * x;
                }
            }
        }
        Some(Self { lu: a, swaps })
    }

    /// Solves `a x = b` for each column of `b`, in place.
    #[inline(always)]
    pub fn solve<const C: usize>(&self, b: &mut SMatrix<f64, N, C>) {
        let lu = &self.lu.data.0;
        for column in &mut b.data.0 {
            for k in 0..N {
                column.swap(k, self.swaps[k]);
            }
            for k in 0..N {
                let x = column[k];
                for i in k + 1..N {
                    column[i] -= lu[k][i] * x;
                }
            }
            for k in (0..N).rev() {
                column[k] /= lu[k][k];
                let x = column[k];
                for i in 0..k {
                    column[i] -= lu[k][i] * x;
                }
            }
        }
    }

    /// Solves `a^T x = b`.
    #[inline(always)]
    pub fn solve_transposed(&self, b: &SVector<f64, N>) -> SVector<f64, N> {
        let mut x = *b;
        for k in 0..N {
            for i in 0..k {
                x[k] -= self.lu[(i, k)] * x[i];
            }
            x[k] /= self.lu[(k, k)];
        }
        for k in (0..N).rev() {
            for i in k + 1..N {
                x[k] -= self.lu[(i, k)] * x[i];
            }
        }
        for k in (0..N).rev() {
            x.swap_rows(k, self.swaps[k]);
        }
        x
    }
}

/// Cholesky factor of a symmetric positive definite matrix.
#[derive(Clone, Copy, Debug)]
pub struct Cholesky<const N: usize> {
    l: SMatrix<f64, N, N>,
}

impl<const N: usize> Cholesky<N> {
    /// The factor of the identity.
    pub fn identity() -> Self {
        Self { l: SMatrix::identity() }
    }

    /// Factors the lower triangle of `a`; `None` unless `a` is positive definite.
    #[inline(always)]
    pub fn new(mut a: SMatrix<f64, N, N>) -> Option<Self> {
        for k in 0..N {
            for j in 0..k {
                let x = a[(k, j)];
                for i in k..N {
                    a[(i, k)] -= a[(i, j)] * x;
                }
            }
            if !(a[(k, k)] > 0.0 && a[(k, k)].is_finite()) {
                return None;
            }
            let root = a[(k, k)].sqrt();
            for i in k..N {
                a[(i, k)] /= root;
            }
        }
        Some(Self { l: a })
    }

    /// Solves `a x = b` for each column of `b`, in place.
    #[inline(always)]
    pub fn solve<const C: usize>(&self, b: &mut SMatrix<f64, N, C>) {
        for j in 0..C {
            for k in 0..N {
                b[(k, j)] /= self.l[(k, k)];
                let x = b[(k, j)];
                for i in k + 1..N {
                    b[(i, j)] -= self.l[(i, k)] * x;
                }
            }
            for k in (0..N).rev() {
                for i in k + 1..N {
                    b[(k, j)] -= self.l[(i, k)] * b[(i, j)];
                }
                b[(k, j)] /= self.l[(k, k)];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn matrix<const R: usize, const C: usize>(values: &[f64]) -> SMatrix<f64, R, C> {
        SMatrix::from_iterator(values.iter().copied())
    }

    proptest! {
        #[test]
        fn prop_lu_solves(values in proptest::collection::vec(-3.0f64..3.0, 25), b in proptest::collection::vec(-3.0f64..3.0, 5)) {
            let a: SMatrix<f64, 5, 5> = matrix(&values);
            prop_assume!(a.determinant().abs() > 1e-3);
            let b: SVector<f64, 5> = matrix(&b);
            let lu = Lu::new(a).unwrap();
            let mut x = b;
            lu.solve(&mut x);
            prop_assert!((a * x - b).amax() < 1e-9);
            prop_assert!((a.transpose() * lu.solve_transposed(&b) - b).amax() < 1e-9);
        }

        #[test]
        fn prop_cholesky_solves(values in proptest::collection::vec(-3.0f64..3.0, 16), b in proptest::collection::vec(-3.0f64..3.0, 4)) {
            let m: SMatrix<f64, 4, 4> = matrix(&values);
            let a = tr_mul(&m, &m) + SMatrix::identity() * 0.1;
            let b: SVector<f64, 4> = matrix(&b);
            let mut x = b;
            Cholesky::new(a).unwrap().solve(&mut x);
            prop_assert!((a * x - b).amax() < 1e-9);
            prop_assert!(Cholesky::new(a - SMatrix::identity() * 100.0).is_none());
        }
    }
}
