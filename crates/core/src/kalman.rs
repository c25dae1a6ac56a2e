//! The covariance of the errors of a state, of any size: propagation, and the update by one scalar
//! measurement.
//!
//! Sola (2017), "Quaternion kinematics for the error-state Kalman filter", (269), (274)-(276). Measurements
//! are taken one number at a time, so that the innovation's covariance is a number and nothing is inverted;
//! the update has Joseph's form, which keeps the covariance positive whatever the gain's rounding. Products
//! are plain loops over arrays: no allocation, and the same operations in the same order on every processor.

/// A matrix of N by N numbers, by rows.
pub type Matrix<const N: usize> = [[f64; N]; N];

/// The identity.
pub const fn identity<const N: usize>() -> Matrix<N> {
    let mut m = [[0.0; N]; N];
    let mut i = 0;
    while i < N {
        m[i][i] = 1.0;
        i += 1;
    }
    m
}

/// A covariance; symmetric to the last bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariance<const N: usize>(Matrix<N>);

impl<const N: usize> Covariance<N> {
    /// Independent errors with these variances.
    pub fn of_variances(variances: &[f64; N]) -> Self {
        let mut p = identity();
        for (i, variance) in variances.iter().enumerate() {
            p[i][i] = *variance;
        }
        Self(p)
    }

    /// An entry.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.0[row][column]
    }

    /// The entries, by rows.
    pub fn entries(&self) -> &Matrix<N> {
        &self.0
    }

    /// `P <- F P F^T`.
    pub fn transform(&mut self, f: &Matrix<N>) {
        let mut fp = [[0.0; N]; N];
        for (row, f_row) in fp.iter_mut().zip(f) {
            // Most of F is zero.
            for (factor, p_row) in f_row.iter().zip(&self.0).filter(|(factor, _)| **factor != 0.0) {
                for (sum, p) in row.iter_mut().zip(p_row) {
                    *sum += factor * p;
                }
            }
        }
        for (i, fp_row) in fp.iter().enumerate() {
            for (j, f_row) in f.iter().enumerate().skip(i) {
                let mut sum = 0.0;
                for (factor, x) in f_row.iter().zip(fp_row).filter(|(factor, _)| **factor != 0.0) {
                    sum += factor * x;
                }
                self.0[i][j] = sum;
                self.0[j][i] = sum;
            }
        }
    }

    /// `P <- P + diag(q)`.
    pub fn add_variances(&mut self, q: &[f64; N]) {
        for (i, variance) in q.iter().enumerate() {
            self.0[i][i] += variance;
        }
    }

    /// Forgets what is known of one error: this variance, and no correlation.
    pub fn forget(&mut self, i: usize, variance: f64) {
        for j in 0..N {
            self.0[i][j] = 0.0;
            self.0[j][i] = 0.0;
        }
        self.0[i][i] = variance;
    }

    /// Variance of the innovation of a measurement with the row `h` and noise of variance `r`: `h P h^T + r`.
    pub fn innovation_variance(&self, h: &[f64; N], r: f64) -> f64 {
        dot(h, &self.times(h)) + r
    }

    /// Takes a measurement with the row `h` and noise of variance `r` in, and returns the gain, (274) and
    /// (276) in Joseph's form `(I - K h) P (I - K h)^T + K r K^T`.
    pub fn update(&mut self, h: &[f64; N], r: f64) -> [f64; N] {
        let ph = self.times(h);
        let s = dot(h, &ph) + r;
        let gain = ph.map(|x| x / s);
        // A = I - K h; A P first, then its product with A^T.
        let mut ap = self.0;
        for (row, k) in ap.iter_mut().zip(&gain) {
            for (x, hp) in row.iter_mut().zip(&ph) {
                *x -= k * hp;
            }
        }
        let aph: [f64; N] = std::array::from_fn(|i| dot(&ap[i], h));
        for i in 0..N {
            for j in i..N {
                let x = ap[i][j] - aph[i] * gain[j] + r * gain[i] * gain[j];
                self.0[i][j] = x;
                self.0[j][i] = x;
            }
        }
        gain
    }

    fn times(&self, h: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|i| dot(&self.0[i], h))
    }
}

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
