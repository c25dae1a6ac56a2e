//! Periodic cubic spline: the C2 interpolation of the body's coefficient tables.
//!
//! The planner needs second derivatives, so the tables are interpolated by a cubic spline that is twice
//! continuously differentiable, also across the wrap at +-180 deg. (With linear tables most plans fail.)

use super::ModelError;
use super::axis::Axis;
use crate::real::Real;

/// A twice continuously differentiable periodic interpolant.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicSpline {
    /// The last knot is the first one a period later.
    axis: Axis,
    /// Per interval, the polynomial `c0 + c1 d + c2 d^2 + c3 d^3` in the distance `d` from its left knot.
    pieces: Vec<[f64; 4]>,
}

/// A place on the knots of a spline.
#[derive(Clone, Copy, Debug)]
pub struct Place<S: Real> {
    piece: S::Cell,
    from_knot: S,
}

/// Value, first and second derivative of a spline at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplineJet {
    /// Value at the point.
    pub value: f64,
    /// First derivative at the point.
    pub first: f64,
    /// Second derivative at the point.
    pub second: f64,
}

impl PeriodicSpline {
    /// Interpolates `values` at increasing `knots`; the first and the last value are the same point of the
    /// period and must agree (to 1e-9 of the values' size).
    ///
    /// # Errors
    /// [`ModelError::Table`] when the lengths differ, there are fewer than four knots, they do not increase,
    /// a number is not finite, or the ends disagree.
    pub fn new(knots: &[f64], values: &[f64]) -> Result<Self, ModelError> {
        let n = knots.len();
        if n != values.len() {
            return Err(ModelError::Table(format!("{n} angles but {} values", values.len())));
        }
        if n < 4 {
            return Err(ModelError::Table(format!("at least 4 points expected, found {n}")));
        }
        if let Some(bad) = knots.iter().chain(values).position(|x| !x.is_finite()) {
            return Err(ModelError::Table(format!("entry {} is not finite", bad % n)));
        }
        super::check_increasing(knots)?;
        let size = values.iter().fold(1e-3f64, |m, v| m.max(v.abs()));
        if (values[n - 1] - values[0]).abs() > 1e-9 * size {
            return Err(ModelError::Table(format!(
                "the last value ({}) is the first one ({}) a turn later and must equal it",
                values[n - 1],
                values[0]
            )));
        }
        let slopes = periodic_slopes(knots, values);
        let pieces = (0..n - 1)
            .map(|i| {
                let h = knots[i + 1] - knots[i];
                let secant = (values[i + 1] - values[i]) / h;
                let (s0, s1) = (slopes[i], slopes[(i + 1) % (n - 1)]);
                [values[i], s0, (3.0 * secant - 2.0 * s0 - s1) / h, (s0 + s1 - 2.0 * secant) / (h * h)]
            })
            .collect();
        Ok(Self { axis: Axis::new(knots), pieces })
    }

    /// The values at the knots.
    pub fn values(&self) -> Vec<f64> {
        let first = self.pieces.first().map_or(0.0, |piece| piece[0]);
        self.pieces.iter().map(|piece| piece[0]).chain([first]).collect()
    }

    /// The knots; the last one is the first one a period later.
    pub fn knots(&self) -> &[f64] {
        &self.axis.knots
    }

    /// Coefficients `[c0, c1, c2, c3]` per interval, of `c0 + c1 d + c2 d^2 + c3 d^3` in the distance `d`
    /// from the left knot.
    pub fn pieces(&self) -> &[[f64; 4]] {
        &self.pieces
    }

    /// The spline of the values multiplied by a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { pieces: self.pieces.iter().map(|p| p.map(|c| factor * c)).collect(), ..self.clone() }
    }

    /// The knots with the way to find an interval.
    pub(crate) fn axis(&self) -> &Axis {
        &self.axis
    }

    /// Value at `x`, which lies between the first and the last knot (beyond, the outermost piece continues).
    #[inline(always)]
    pub fn eval<S: Real>(&self, x: S) -> S {
        self.at(self.place(x))
    }

    /// Where `x` lies, for this spline and others of the same knots.
    #[inline(always)]
    pub fn place<S: Real>(&self, x: S) -> Place<S> {
        let piece = self.axis.interval(x);
        Place { piece, from_knot: self.axis.beyond_knot(x, piece) }
    }

    /// Value at a place.
    #[inline(always)]
    pub fn at<S: Real>(&self, Place { piece, from_knot: d }: Place<S>) -> S {
        let [c0, c1, c2, c3] = d.gather(&self.pieces, piece);
        c0 + d * (c1 + d * (c2 + d * c3))
    }

    /// Value and first two derivatives at `x`.
    #[inline(always)]
    pub fn jet(&self, x: f64) -> SplineJet {
        let i = self.axis.interval(x);
        let [c0, c1, c2, c3] = self.pieces[i];
        let d = x - self.axis.knots[i];
        SplineJet {
            value: c0 + d * (c1 + d * (c2 + d * c3)),
            first: c1 + d * (2.0 * c2 + d * 3.0 * c3),
            second: 2.0 * c2 + 6.0 * c3 * d,
        }
    }
}

/// Slopes at the knots of the periodic C2 cubic spline: the cyclic tridiagonal system that equates the second
/// derivatives on both sides of each knot, solved densely (it is small and solved once).
fn periodic_slopes(knots: &[f64], values: &[f64]) -> Vec<f64> {
    let m = knots.len() - 1;
    let h: Vec<f64> = (0..m).map(|i| knots[i + 1] - knots[i]).collect();
    let secant: Vec<f64> = (0..m).map(|i| (values[i + 1] - values[i]) / h[i]).collect();
    let mut a = nalgebra::DMatrix::<f64>::zeros(m, m);
    let mut b = nalgebra::DVector::<f64>::zeros(m);
    for i in 0..m {
        let (prev, next) = ((i + m - 1) % m, (i + 1) % m);
        a[(i, prev)] += 1.0 / h[prev];
        a[(i, i)] += 2.0 * (1.0 / h[prev] + 1.0 / h[i]);
        a[(i, next)] += 1.0 / h[i];
        b[i] = 3.0 * (secant[prev] / h[prev] + secant[i] / h[i]);
    }
    // Strictly diagonally dominant, hence regular; a failed solve could only come from knots that are not
    // finite.
    a.lu().solve(&b).map_or_else(|| vec![f64::NAN; m], |s| s.iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    fn sine(n: usize) -> PeriodicSpline {
        let knots: Vec<f64> = (0..=n).map(|i| -1.0 + 2.0 * i as f64 / n as f64).collect();
        let mut values: Vec<f64> = knots.iter().map(|x| math::sin(std::f64::consts::PI * x)).collect();
        values[n] = values[0];
        PeriodicSpline::new(&knots, &values).unwrap()
    }

    #[test]
    fn closed_form_sine_converges_with_fourth_order() {
        let error = |n| {
            let s = sine(n);
            (0..1000).fold(0.0f64, |m, i| {
                let x = -1.0 + 0.002 * i as f64;
                m.max((s.eval(x) - math::sin(std::f64::consts::PI * x)).abs())
            })
        };
        let order = math::log2(error(20) / error(40));
        assert!((3.7..4.4).contains(&order), "order {order}");
    }

    #[test]
    fn prop_second_derivative_is_continuous_also_across_the_wrap() {
        let s = sine(12);
        for i in 0..12 {
            let x = -1.0 + i as f64 / 6.0;
            let left = if i == 0 { s.jet(1.0 - 1e-12) } else { s.jet(x - 1e-12) };
            assert!((left.second - s.jet(x + 1e-12).second).abs() < 1e-8, "knot {i}");
            assert!((left.first - s.jet(x + 1e-12).first).abs() < 1e-8, "knot {i}");
        }
    }

    #[test]
    fn tables_that_cannot_be_are_refused() {
        let k = [0.0, 1.0, 2.0, 3.0];
        assert!(PeriodicSpline::new(&k, &[0.0, 1.0, 0.0]).is_err());
        assert!(PeriodicSpline::new(&[0.0, 1.0, 1.0, 3.0], &[0.0; 4]).is_err());
        assert!(PeriodicSpline::new(&k, &[0.0, 1.0, 0.0, 1.0]).is_err());
        assert!(PeriodicSpline::new(&k, &[0.0, f64::NAN, 0.0, 0.0]).is_err());
    }
}
