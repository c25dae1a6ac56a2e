//! Dual numbers: values with exact derivatives along `N` directions, through any code over [`Real`]. Where
//! a value is a dual number itself, there are second derivatives too.

use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::Real;

/// A value with its derivatives along `N` directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<S, const N: usize> {
    /// The value.
    pub value: S,
    /// Derivatives of the value along each direction.
    pub slope: [S; N],
}

impl<S: Real, const N: usize> Dual<S, N> {
    /// The variable of a direction (from 0) at a value: its derivative along it is 1, along the others 0.
    pub fn variable(value: S, direction: usize) -> Self {
        let mut slope = [value.of(0.0); N];
        slope[direction] = value.of(1.0);
        Self { value, slope }
    }

    /// A number that is the same along all directions.
    #[inline(always)]
    pub fn constant(value: S) -> Self {
        Self { value, slope: [value.of(0.0); N] }
    }

    /// A function of one variable by its value and its derivative.
    #[inline(always)]
    fn chained(self, value: S, derivative: S) -> Self {
        Self { value, slope: self.slope.map(|slope| derivative * slope) }
    }

    /// A function of two variables by its value and its derivatives.
    #[inline(always)]
    fn of_two(a: Self, b: Self, value: S, [by_a, by_b]: [S; 2]) -> Self {
        Self { value, slope: std::array::from_fn(|i| by_a * a.slope[i] + by_b * b.slope[i]) }
    }
}

impl<S: Real, const N: usize> Add for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self { value: self.value + b.value, slope: std::array::from_fn(|i| self.slope[i] + b.slope[i]) }
    }
}

impl<S: Real, const N: usize> Sub for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self { value: self.value - b.value, slope: std::array::from_fn(|i| self.slope[i] - b.slope[i]) }
    }
}

impl<S: Real, const N: usize> Mul for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        Self::of_two(self, b, self.value * b.value, [b.value, self.value])
    }
}

impl<S: Real, const N: usize> Div for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, b: Self) -> Self {
        let quotient = self.value / b.value;
        let per = b.value.of(1.0) / b.value;
        Self::of_two(self, b, quotient, [per, -(quotient * per)])
    }
}

impl<S: Real, const N: usize> Neg for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: -self.value, slope: self.slope.map(|slope| -slope) }
    }
}

impl<S: Real, const N: usize> Add<f64> for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: f64) -> Self {
        Self { value: self.value + b, ..self }
    }
}

impl<S: Real, const N: usize> Sub<f64> for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: f64) -> Self {
        Self { value: self.value - b, ..self }
    }
}

impl<S: Real, const N: usize> Mul<f64> for Dual<S, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: f64) -> Self {
        Self { value: self.value * b, slope: self.slope.map(|slope| slope * b) }
    }
}

macro_rules! assigns {
    ($($trait:ident $method:ident $op:tt)*) => {$(
        impl<S: Real, const N: usize> $trait for Dual<S, N> {
            #[inline(always)]
            fn $method(&mut self, b: Self) {
                *self = *self $op b;
            }
        }
    )*};
}
assigns!(AddAssign add_assign + SubAssign sub_assign - MulAssign mul_assign *);

impl<S: Real, const N: usize> Real for Dual<S, N> {
    type Mask = S::Mask;
    type Cell = S::Cell;

    #[inline(always)]
    fn of(self, x: f64) -> Self {
        Self::constant(self.value.of(x))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chained(root, root.of(0.5) / root)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self::select(self.value.less(self.value.of(0.0)), -self, self)
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        let value = self.value.copysign(sign.value);
        let turned = self.value.of(1.0).copysign(self.value) * self.value.of(1.0).copysign(value);
        self.chained(value, turned)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self::constant(self.value.floor())
    }
    #[inline(always)]
    fn less(self, other: Self) -> S::Mask {
        self.value.less(other.value)
    }
    #[inline(always)]
    fn select(mask: S::Mask, yes: Self, no: Self) -> Self {
        Self {
            value: S::select(mask, yes.value, no.value),
            slope: std::array::from_fn(|i| S::select(mask, yes.slope[i], no.slope[i])),
        }
    }
    #[inline(always)]
    fn at_least(self, least: Self) -> Self {
        Self::select(least.less(self), self, least)
    }
    #[inline(always)]
    fn at_most(self, most: Self) -> Self {
        Self::select(self.less(most), self, most)
    }
    #[inline(always)]
    fn cell(self, last: usize) -> S::Cell {
        self.value.cell(last)
    }
    #[inline(always)]
    fn interval(self, knots: &[f64]) -> S::Cell {
        self.value.interval(knots)
    }
    #[inline(always)]
    fn of_cell(self, cell: S::Cell) -> Self {
        Self::constant(self.value.of_cell(cell))
    }
    #[inline(always)]
    fn gather<const K: usize>(self, table: &[[f64; K]], cell: S::Cell) -> [Self; K] {
        self.value.gather(table, cell).map(Self::constant)
    }
    #[inline(always)]
    fn gather_two<const K: usize>(self, table: &[[f64; K]], cell: S::Cell) -> [[Self; K]; 2] {
        self.value.gather_two(table, cell).map(|row| row.map(Self::constant))
    }
    fn constants<const K: usize>(
        self,
        mask: S::Mask,
        before: [[Self; 4]; K],
        function: &mut dyn FnMut(f64) -> [[f64; 4]; K],
    ) -> [[Self; 4]; K] {
        let before = before.map(|row| row.map(|number| number.value));
        self.value.constants(mask, before, function).map(|row| row.map(Self::constant))
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        let square = x.value * x.value + self.value * self.value;
        Self::of_two(self, x, self.value.atan2(x.value), [x.value / square, -(self.value / square)])
    }
    #[inline(always)]
    fn exp_of_minus(self) -> Self {
        let value = self.value.exp_of_minus();
        self.chained(value, -value)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        self.chained(self.value.ln(), self.value.of(1.0) / self.value)
    }
    #[inline(always)]
    fn sin_cos_of_turns(self) -> (Self, Self) {
        let (sin, cos) = self.value.sin_cos_of_turns();
        let per_turn = std::f64::consts::TAU;
        (self.chained(sin, cos * per_turn), self.chained(cos, sin * -per_turn))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Twice = Dual<Dual<f64, 2>, 2>;

    fn variables(values: [f64; 2]) -> [Twice; 2] {
        [0, 1].map(|i| Dual::variable(Dual::variable(values[i], i), i))
    }

    /// By hand: derivatives of functions that are known.
    #[test]
    fn closed_form_second_derivatives() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-13, "{a} {b}");
        let [y, x] = variables([0.7, -1.3]);
        let n = 0.7_f64 * 0.7 + 1.3 * 1.3;
        let angle = y.atan2(x);
        near(angle.value.slope[0], -1.3 / n);
        near(angle.slope[1].value, -0.7 / n);
        near(angle.slope[0].slope[1], (0.7 * 0.7 - 1.3 * 1.3) / (n * n));
        // For x < 0: y sqrt(y x^2) / x^3 = -y^1.5 / x^2.
        let mixed = y * (y * x * x).sqrt() / (x * x * x);
        near(mixed.slope[0].slope[1], -3.0 * 0.7_f64.sqrt() / (1.3 * 1.3 * 1.3));
        // |x| y^2, of which the sign of x is lost.
        near((x.abs() * y * y).slope[1].slope[0], -1.4);
        near(y.copysign(x).slope[0].value, -1.0);
        let (sin, cos) = (y * (1.0 / std::f64::consts::TAU)).sin_cos_of_turns();
        near(sin.slope[0].slope[0], -sin.value.value);
        near(cos.slope[0].value, -sin.value.value);
        near(y.exp_of_minus().slope[0].slope[0], y.exp_of_minus().value.value);
        near(y.ln().slope[0].slope[0], -1.0 / (0.7 * 0.7));
    }
}
