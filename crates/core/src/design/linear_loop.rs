//! A sampled loop, broken at one signal, and its margins.
//!
//! ```text
//! x_k+1 = A x_k + b w_k,  s_k = c x_k;  closed by w = s.  L(z) = -c (z I - A)^-1 b,  z = e^(i omega T)
//! ```
//!
//! Where the loop is cut a signal w goes in and s comes out; the minus sign is that of a negative feedback.
//! What the sampling delays, half a period on the mean, is in A and b, and margins come on top of it.

use nalgebra::{Complex, DMatrix, DVector};

use crate::math;
use crate::units::DEG_PER_RAD;

/// A loop with its cut.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearLoop {
    /// Transition of the states over a period, the loop open.
    pub a: DMatrix<f64>,
    /// What the signal at the cut does to the states.
    pub b: DVector<f64>,
    /// The signal that comes back to the cut.
    pub c: DVector<f64>,
    /// Period [s].
    pub period_s: f64,
}

/// Margins of a loop that is stable when closed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margins {
    /// Whether the closed loop is stable; without that the margins say nothing.
    pub stable: bool,
    /// Least factor above 1 by which the gain may grow to the limit of stability; `None`: by any.
    pub gain_up: Option<f64>,
    /// Greatest factor below 1 to which the gain may fall to the limit of stability; `None`: to nothing.
    pub gain_down: Option<f64>,
    /// Least phase by which the loop may turn, either way, to the limit of stability [deg]; `None` where the
    /// gain is nowhere 1.
    pub phase_deg: Option<f64>,
    /// Least delay that takes the loop to the limit of stability [s]; `None` where the gain is nowhere 1.
    pub delay_s: Option<f64>,
    /// Greatest frequency at which the gain is 1 [rad/s].
    pub crossover_rad_s: Option<f64>,
    /// Least distance of L from -1, the inverse of the greatest sensitivity.
    pub modulus: f64,
}

/// Frequencies of a response, evenly by the logarithm.
const FREQUENCIES: usize = 240;
/// Lowest frequency of a response [rad/s].
const LOWEST_RAD_S: f64 = 1e-3;
/// Halvings in which a crossing is found between two frequencies.
const HALVINGS: u32 = 40;
/// Thirds of an interval that are left out in the search of a minimum.
const THIRDS: u32 = 12;

impl LinearLoop {
    /// L at a frequency [rad/s]; not a number where the open loop has a pole there.
    pub fn response(&self, omega_rad_s: f64) -> Complex<f64> {
        self.reduced().response(omega_rad_s)
    }

    /// The loop in states whose transition is an upper Hessenberg matrix: its response takes n^2 operations
    /// in place of n^3.
    fn reduced(&self) -> ReducedLoop {
        let (q, a) = self.a.clone().hessenberg().unpack();
        ReducedLoop { a, b: q.tr_mul(&self.b), c: q.tr_mul(&self.c), period_s: self.period_s }
    }

    /// Frequencies [rad/s] from a thousandth to half of the sampling's, evenly by the logarithm.
    pub fn frequencies(&self) -> Vec<f64> {
        let highest = std::f64::consts::PI / self.period_s;
        let decades = math::ln(highest / LOWEST_RAD_S);
        let at = |i: usize| LOWEST_RAD_S * math::exp(decades * i as f64 / (FREQUENCIES - 1) as f64);
        // The last one is short of the limit, where z is -1 and the response real.
        (0..FREQUENCIES).map(|i| at(i).min(highest * (1.0 - 1e-9))).collect()
    }

    /// Whether all states die away when the loop is closed.
    pub fn is_stable(&self) -> bool {
        let closed = &self.a + &self.b * self.c.transpose();
        spectral_radius_below_one(closed)
    }

    /// Margins of the loop.
    pub fn margins(&self) -> Margins {
        let reduced = self.reduced();
        let frequencies = self.frequencies();
        let responses: Vec<Complex<f64>> = frequencies.iter().map(|w| reduced.response(*w)).collect();
        let mut margins = Margins { stable: self.is_stable(), ..Margins::default() };
        let finite = |l: &Complex<f64>| l.re.is_finite() && l.im.is_finite();
        let distances: Vec<f64> = responses.iter().map(distance).collect();
        let nearest = (0..distances.len()).filter(|i| distances[*i].is_finite());
        let nearest = nearest.min_by(|a, b| distances[*a].total_cmp(&distances[*b]));
        margins.modulus = nearest.map_or(f64::INFINITY, |i| {
            let (below, above) = (i.saturating_sub(1), (i + 1).min(frequencies.len() - 1));
            reduced.least_distance([frequencies[below], frequencies[above]]).min(distances[i])
        });
        for (w, l) in frequencies.windows(2).zip(responses.windows(2)) {
            if !(finite(&l[0]) && finite(&l[1])) {
                continue;
            }
            // The gain passes 1.
            if (size(l[0]) >= 1.0) != (size(l[1]) >= 1.0) {
                let crossing = reduced.crossing([w[0], w[1]], |l| size(l) - 1.0);
                margins.note_crossover(crossing, reduced.response(crossing));
            }
            // The negative real axis is passed.
            if (l[0].im >= 0.0) != (l[1].im >= 0.0) && l[0].re + l[1].re < 0.0 {
                let at = reduced.response(reduced.crossing([w[0], w[1]], |l| l.im));
                let factor = 1.0 / size(at);
                let (up, down) = (&mut margins.gain_up, &mut margins.gain_down);
                if factor > 1.0 {
                    *up = Some(up.map_or(factor, |other| other.min(factor)));
                } else {
                    *down = Some(down.map_or(factor, |other| other.max(factor)));
                }
            }
        }
        margins
    }
}

impl Margins {
    /// Takes a frequency at which the gain is 1, with L there.
    fn note_crossover(&mut self, omega_rad_s: f64, l: Complex<f64>) {
        // From -180 deg counter-clockwise, within a turn: what a delay takes away.
        let ahead = (math::atan2(l.im, l.re) + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU);
        let either_way = ahead.min(std::f64::consts::TAU - ahead) * DEG_PER_RAD;
        let delay_s = ahead / omega_rad_s;
        self.phase_deg = Some(self.phase_deg.map_or(either_way, |other| other.min(either_way)));
        self.delay_s = Some(self.delay_s.map_or(delay_s, |other| other.min(delay_s)));
        let greatest = self.crossover_rad_s.map_or(omega_rad_s, |other| other.max(omega_rad_s));
        self.crossover_rad_s = Some(greatest);
    }
}

/// A loop whose transition is an upper Hessenberg matrix.
struct ReducedLoop {
    a: DMatrix<f64>,
    b: DVector<f64>,
    c: DVector<f64>,
    period_s: f64,
}

impl ReducedLoop {
    fn response(&self, omega_rad_s: f64) -> Complex<f64> {
        let (sin, cos) = math::sin_cos(omega_rad_s * self.period_s);
        let (n, z) = (self.b.len(), Complex::new(cos, sin));
        let mut x: Vec<Complex<f64>> = self.b.iter().map(|b| Complex::new(*b, 0.0)).collect();
        let row_of = |row: usize| -> Vec<Complex<f64>> {
            let minus = |column: usize| Complex::new(-self.a[(row, column)], 0.0);
            (0..n).map(|column| if column == row { z + minus(column) } else { minus(column) }).collect()
        };
        // Elimination with the larger pivot of two rows; of those above the rest are zero.
        let mut rows: Vec<Vec<Complex<f64>>> = (0..n).map(row_of).collect();
        for k in 0..n.saturating_sub(1) {
            if rows[k + 1][k].norm_sqr() > rows[k][k].norm_sqr() {
                rows.swap(k, k + 1);
                x.swap(k, k + 1);
            }
            let (above, below) = rows.split_at_mut(k + 1);
            let (pivot, next) = (&above[k], &mut below[0]);
            if next[k].norm_sqr() > 0.0 {
                let factor = next[k] / pivot[k];
                for column in k + 1..n {
                    next[column] -= factor * pivot[column];
                }
                x[k + 1] = x[k + 1] - factor * x[k];
            }
        }
        for k in (0..n).rev() {
            let known: Complex<f64> = (k + 1..n).map(|column| rows[k][column] * x[column]).sum();
            x[k] = (x[k] - known) / rows[k][k];
        }
        -x.iter().zip(self.c.iter()).map(|(x, c)| x * *c).sum::<Complex<f64>>()
    }

    /// The frequency between two at which a measure of L changes its sign.
    fn crossing(&self, [mut low, mut high]: [f64; 2], measure: impl Fn(Complex<f64>) -> f64) -> f64 {
        let begins = measure(self.response(low)) >= 0.0;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let end = if (measure(self.response(middle)) >= 0.0) == begins { &mut low } else { &mut high };
            *end = middle;
        }
        0.5 * (low + high)
    }

    /// Least distance of L from -1 between two frequencies, where it has one minimum there.
    fn least_distance(&self, [mut low, mut high]: [f64; 2]) -> f64 {
        let mut least = f64::INFINITY;
        for _ in 0..THIRDS {
            let third = (high - low) / 3.0;
            let at = [low + third, high - third].map(|omega| distance(&self.response(omega)));
            least = least.min(at[0]).min(at[1]);
            if at[0] < at[1] { high -= third } else { low += third }
        }
        least
    }
}

/// Distance of L from -1.
fn distance(l: &Complex<f64>) -> f64 {
    math::hypot(1.0 + l.re, l.im)
}

/// Size of a complex number.
pub fn size(l: Complex<f64>) -> f64 {
    math::hypot(l.re, l.im)
}

/// Whether every eigenvalue lies within the unit circle: powers of the matrix die away. Squared forty times
/// it is known to a part in 10^12.
fn spectral_radius_below_one(mut a: DMatrix<f64>) -> bool {
    // ln of the norm of the power, over the exponent: the logarithm of the spectral radius (Gelfand).
    let mut log_scale = 0.0;
    let mut exponent = 1.0f64;
    for _ in 0..40 {
        let norm = a.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        if norm == 0.0 {
            return true;
        }
        if !norm.is_finite() {
            return false;
        }
        a /= norm;
        log_scale = 2.0 * (log_scale + math::ln(norm));
        a = &a * &a;
        exponent *= 2.0;
    }
    let norm = a.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    (log_scale + math::ln(norm.max(f64::MIN_POSITIVE))) / exponent < 0.0
}

/// The transition over a period and what a held input adds, `x' = A x + B u`: the exponential of `[A B; 0
/// 0] T` by Taylor's series of a small step, squared.
pub fn sampled(a: &DMatrix<f64>, b: &DMatrix<f64>, period_s: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    let (n, m) = (a.nrows(), b.ncols());
    let mut whole = DMatrix::zeros(n + m, n + m);
    whole.view_mut((0, 0), (n, n)).copy_from(a);
    whole.view_mut((0, n), (n, m)).copy_from(b);
    whole *= period_s;
    let norm = whole.iter().fold(0.0f64, |most, x| most.max(x.abs())) * (n + m) as f64;
    let mut halvings = 0u32;
    while norm / 2f64.powi(halvings as i32) > 0.5 && halvings < 60 {
        halvings += 1;
    }
    let small = whole / 2f64.powi(halvings as i32);
    let mut term = DMatrix::identity(n + m, n + m);
    let mut sum = term.clone();
    for k in 1..=16u32 {
        term = &term * &small / f64::from(k);
        sum += &term;
    }
    for _ in 0..halvings {
        sum = &sum * &sum;
    }
    (sum.view((0, 0), (n, n)).into_owned(), sum.view((0, n), (n, m)).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The double integrator under `-(kp y + kd y')`, sampled, with `late` periods of delay.
    fn double_integrator(kp: f64, kd: f64, period_s: f64, late: usize) -> LinearLoop {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
        let (f, g) = sampled(&a, &b, period_s);
        let n = 2 + late;
        let (mut a, mut b, mut c) = (DMatrix::zeros(n, n), DVector::zeros(n), DVector::zeros(n));
        a.view_mut((0, 0), (2, 2)).copy_from(&f);
        // A chain of delays: w goes into the last place and comes out of the first.
        if late == 0 {
            b.rows_mut(0, 2).copy_from(&g.column(0));
        } else {
            a.view_mut((0, 2), (2, 1)).copy_from(&g);
            (0..late - 1).for_each(|i| a[(2 + i, 3 + i)] = 1.0);
            b[n - 1] = 1.0;
        }
        (c[0], c[1]) = (-kp, -kd);
        LinearLoop { a, b, c, period_s }
    }

    /// `L = (kp + kd s)/s^2 e^(-s tau)`: |L| = 1 at `w^2 = (kd^2 + sqrt(kd^4 + 4 kp^2))/2`, with a phase
    /// margin of `atan(kd w/kp) - w tau` and a delay margin of that over w. Sampling adds half a period.
    #[test]
    fn closed_form_double_integrator_with_delay() {
        let (kp, kd, period_s) = (4.0f64, 3.0f64, 1e-3);
        let crossover = (0.5 * (kd * kd + (kd.powi(4) + 4.0 * kp * kp).sqrt())).sqrt();
        for late in [0usize, 20] {
            let tau_s = (late as f64 + 0.5) * period_s;
            let phase = math::atan2(kd * crossover, kp) - crossover * tau_s;
            let margins = double_integrator(kp, kd, period_s, late).margins();
            let near = |found: Option<f64>, wanted: f64| {
                assert!(found.is_some_and(|x| (x / wanted - 1.0).abs() < 1e-4), "{found:?} {wanted}");
            };
            assert!(margins.stable && margins.gain_down.is_none());
            near(margins.crossover_rad_s, crossover);
            near(margins.phase_deg, phase * DEG_PER_RAD);
            near(margins.delay_s, phase / crossover);
        }
    }

    /// Without delay the sampled loop has its poles at `z^2 + (kp T^2/2 + kd T - 2) z + 1 + kp T^2/2 - kd T`:
    /// Jury's limit `4 - 2 kd T > 0` gives the gain margin `2/(kd T)`.
    #[test]
    fn closed_form_gain_margin_of_sampling() {
        let (kp, kd, period_s) = (4.0, 3.0, 0.01);
        let margins = double_integrator(kp, kd, period_s, 0).margins();
        // At half of the sampling's frequency; the response ends just short of it.
        let sampled = double_integrator(66.6 * kp, 66.6 * kd, period_s, 0);
        let beyond = double_integrator(66.7 * kp, 66.7 * kd, period_s, 0);
        assert!(margins.stable && sampled.is_stable() && !beyond.is_stable());
    }

    /// The gain margin is the factor at which the closed loop loses its stability, the delay margin the
    /// delay.
    #[test]
    fn prop_margins_are_the_limits_of_stability() {
        let (kp, kd, period_s) = (4.0, 3.0, 0.01);
        let margins = double_integrator(kp, kd, period_s, 10).margins();
        let gain = margins.gain_up.unwrap();
        let at = |factor: f64| double_integrator(factor * kp, factor * kd, period_s, 10).is_stable();
        assert!(at(0.999 * gain) && !at(1.001 * gain), "{gain}");
        let late = margins.delay_s.unwrap() / period_s;
        let with = |more: f64| double_integrator(kp, kd, period_s, 10 + more as usize).is_stable();
        assert!(with(late.floor()) && !with(late.ceil()), "{late}");
        let unstable = double_integrator(kp, -0.1, period_s, 0).margins();
        assert!(!unstable.stable);
    }

    /// `x' = -x + u` over T: `e^-T` and `1 - e^-T`.
    #[test]
    fn closed_form_sampling_of_a_lag() {
        let lag = DMatrix::from_element(1, 1, -1.0);
        let (f, g) = sampled(&lag, &DMatrix::from_element(1, 1, 1.0), 3.0);
        let decay = math::exp(-3.0);
        assert!((f[(0, 0)] - decay).abs() < 1e-14 && (g[(0, 0)] - 1.0 + decay).abs() < 1e-14);
    }
}
