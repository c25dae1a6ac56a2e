//! Products of small fixed-size matrices.
//!
//! Plain loops over columns, in a fixed order of operations: the result is the same bits on every machine (a
//! BLAS-like kernel that picks fused multiply-add where it finds it would not be), and the compiler unrolls
//! and vectorises them, since every size is known.

use nalgebra::SMatrix;

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

/// `out += scale a`. (With nalgebra's operators the compiler sees an iterator instead of a loop over known
/// sizes.)
#[inline(always)]
pub fn add_scaled<const M: usize, const N: usize>(
    out: &mut SMatrix<f64, M, N>,
    a: &SMatrix<f64, M, N>,
    scale: f64,
) {
    for (out, a) in out.data.0.iter_mut().zip(&a.data.0) {
        for i in 0..M {
            out[i] += scale * a[i];
        }
    }
}

/// `scale a`.
#[inline(always)]
pub fn scaled<const M: usize, const N: usize>(a: &SMatrix<f64, M, N>, scale: f64) -> SMatrix<f64, M, N> {
    let mut out = *a;
    for column in &mut out.data.0 {
        for x in column {
            *x *= scale;
        }
    }
    out
}

/// `(a + a^T) / 2`.
#[inline(always)]
pub fn symmetric_part<const N: usize>(a: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    scaled(&(a + a.transpose()), 0.5)
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

/// The inverse of `a`; `None` when it is singular or not finite.
///
/// Gauss-Jordan elimination in place without a search for pivots: made for matrices near plus or minus the
/// identity, such as the Jacobian of a defect. Where a pivot turns out small, nalgebra's inverse with
/// pivoting takes over.
#[inline(always)]
pub fn inverse<const N: usize>(a: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
    const SMALL: f64 = 1e-2;
    let unit = SMatrix::<f64, N, N>::identity().data.0;
    let mut inverse = *a;
    let columns = &mut inverse.data.0;
    for k in 0..N {
        let diagonal = columns[k][k];
        if !(diagonal.abs() > SMALL && diagonal.is_finite()) {
            return a.try_inverse().filter(|x| x.iter().all(|x| x.is_finite()));
        }
        let scale = 1.0 / diagonal;
        // What the scaled row k takes off each row (off itself, all but the scaled value). No single entry is
        // written: the processor would have to wait for it before it could load the column again.
        let mut factors = columns[k];
        factors[k] = diagonal - 1.0;
        columns[k] = unit[k];
        for column in columns.iter_mut() {
            let x = column[k] * scale;
            for i in 0..N {
                column[i] -= factors[i] * x;
            }
        }
    }
    Some(inverse)
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
    use nalgebra::SVector;
    use proptest::prelude::*;

    fn matrix<const R: usize, const C: usize>(values: &[f64]) -> SMatrix<f64, R, C> {
        SMatrix::from_iterator(values.iter().copied())
    }

    #[test]
    fn closed_form_singular_matrices_have_no_inverse() {
        assert!(inverse(&SMatrix::<f64, 2, 2>::new(1.0, 2.0, 2.0, 4.0)).is_none());
        assert!(inverse(&SMatrix::<f64, 2, 2>::new(f64::NAN, 2.0, 2.0, 4.0)).is_none());
        let swap = SMatrix::<f64, 3, 3>::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0);
        assert_eq!(inverse(&swap), Some(swap.transpose()));
    }

    proptest! {
        #[test]
        fn prop_inverse_inverts(values in proptest::collection::vec(-3.0f64..3.0, 25)) {
            let a: SMatrix<f64, 5, 5> = matrix(&values);
            prop_assume!(a.determinant().abs() > 1e-3);
            let inverse = inverse(&a).unwrap();
            prop_assert!((a * inverse - SMatrix::identity()).amax() < 1e-9 * (1.0 + inverse.amax()));
        }

        #[test]
        fn prop_cholesky_solves(
            values in proptest::collection::vec(-3.0f64..3.0, 16),
            b in proptest::collection::vec(-3.0f64..3.0, 4),
        ) {
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
