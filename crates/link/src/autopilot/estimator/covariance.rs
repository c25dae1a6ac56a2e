//! The covariance of the error state: propagation, and the update by one scalar measurement.
//!
//! Sola (2017), "Quaternion kinematics for the error-state Kalman filter", (269), (274)-(276). Measurements
//! are taken one number at a time, so that the innovation's covariance is a number and nothing is inverted;
//! the update has Joseph's form, which keeps the covariance positive whatever the gain's rounding. Products
//! are plain loops over arrays: no allocation, and the same operations in the same order on every processor.

/// Size of the error state: position, velocity, attitude, accelerometer bias, gyro bias (three each, Sola's
/// order), and the barometer's offset.
pub const N: usize = 16;
/// Where position begins.
pub const POSITION: usize = 0;
/// Where velocity begins.
pub const VELOCITY: usize = 3;
/// Where attitude begins: a rotation vector in body axes.
pub const ATTITUDE: usize = 6;
/// Where the accelerometer's bias begins.
pub const ACCELEROMETER_BIAS: usize = 9;
/// Where the gyro's bias begins.
pub const GYRO_BIAS: usize = 12;
/// The barometer's offset.
pub const BARO_OFFSET: usize = 15;

/// A column of the error state's size.
pub type Column = [f64; N];
/// A matrix of the error state's size, by rows.
pub type Matrix = [Column; N];

/// The identity.
pub const IDENTITY: Matrix = {
    let mut m = [[0.0; N]; N];
    let mut i = 0;
    while i < N {
        m[i][i] = 1.0;
        i += 1;
    }
    m
};

/// A covariance; symmetric to the last bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariance(Matrix);

impl Covariance {
    /// Independent errors with these variances.
    pub fn of_variances(variances: &Column) -> Self {
        let mut p = IDENTITY;
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
    pub fn entries(&self) -> &Matrix {
        &self.0
    }

    /// `P <- F P F^T`.
    pub fn transform(&mut self, f: &Matrix) {
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
    pub fn add_variances(&mut self, q: &Column) {
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
    pub fn innovation_variance(&self, h: &Column, r: f64) -> f64 {
        dot(h, &self.times(h)) + r
    }

    /// Takes a measurement with the row `h` and noise of variance `r` in, and returns the gain, (274) and
    /// (276) in Joseph's form `(I - K h) P (I - K h)^T + K r K^T`.
    pub fn update(&mut self, h: &Column, r: f64) -> Column {
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
        let aph: Column = std::array::from_fn(|i| dot(&ap[i], h));
        for i in 0..N {
            for j in i..N {
                let x = ap[i][j] - aph[i] * gain[j] + r * gain[i] * gain[j];
                self.0[i][j] = x;
                self.0[j][i] = x;
            }
        }
        gain
    }

    fn times(&self, h: &Column) -> Column {
        std::array::from_fn(|i| dot(&self.0[i], h))
    }
}

fn dot(a: &Column, b: &Column) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
