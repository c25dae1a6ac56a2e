//! Second-order dual numbers, for exact derivatives in tests: `re + eps1 e1 + eps2 e2 + eps1eps2 e1 e2` with
//! `e1^2 = e2^2 = 0` (J. A. Fike, J. J. Alonso, "The Development of Hyper-Dual Numbers for Exact
//! Second-Derivative Calculations", AIAA 2011-886).

use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use super::Real;

/// A value with its derivatives along two directions, and the mixed second one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HyperDual {
    /// The value.
    pub re: f64,
    /// Derivative along the first direction.
    pub eps1: f64,
    /// Derivative along the second direction.
    pub eps2: f64,
    /// Second derivative along both.
    pub eps1eps2: f64,
}

impl HyperDual {
    /// A function of one variable by its value and first two derivatives at `re`.
    fn chained(self, f: f64, df: f64, ddf: f64) -> Self {
        Self {
            re: f,
            eps1: df * self.eps1,
            eps2: df * self.eps2,
            eps1eps2: df * self.eps1eps2 + ddf * self.eps1 * self.eps2,
        }
    }

    fn recip(self) -> Self {
        let r = 1.0 / self.re;
        self.chained(r, -r * r, 2.0 * r * r * r)
    }
}

impl Add for HyperDual {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self {
            re: self.re + b.re,
            eps1: self.eps1 + b.eps1,
            eps2: self.eps2 + b.eps2,
            eps1eps2: self.eps1eps2 + b.eps1eps2,
        }
    }
}

impl Mul for HyperDual {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Self {
            re: self.re * b.re,
            eps1: self.re * b.eps1 + self.eps1 * b.re,
            eps2: self.re * b.eps2 + self.eps2 * b.re,
            eps1eps2: self.re * b.eps1eps2 + self.eps1 * b.eps2 + self.eps2 * b.eps1 + self.eps1eps2 * b.re,
        }
    }
}

impl Neg for HyperDual {
    type Output = Self;
    fn neg(self) -> Self {
        self.chained(-self.re, -1.0, 0.0)
    }
}

impl Sub for HyperDual {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl Div for HyperDual {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        Mul::mul(self, b.recip())
    }
}

macro_rules! assigns {
    ($($trait:ident $method:ident $op:tt)*) => {$(
        impl $trait for HyperDual {
            fn $method(&mut self, b: Self) {
                *self = *self $op b;
            }
        }
    )*};
}
assigns!(AddAssign add_assign + SubAssign sub_assign - MulAssign mul_assign * DivAssign div_assign /);

impl num_traits::Zero for HyperDual {
    fn zero() -> Self {
        Self::from_f64(0.0)
    }
    fn is_zero(&self) -> bool {
        *self == Self::zero()
    }
}

impl num_traits::One for HyperDual {
    fn one() -> Self {
        Self::from_f64(1.0)
    }
}

impl Real for HyperDual {
    fn from_f64(re: f64) -> Self {
        Self { re, eps1: 0.0, eps2: 0.0, eps1eps2: 0.0 }
    }
    fn value(self) -> f64 {
        self.re
    }
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chained(root, 0.5 / root, -0.25 / (root * self.re))
    }
    fn atan2(self, x: Self) -> Self {
        // d atan2(y, x) = (x dy - y dx) / (x^2 + y^2), whose own derivative is taken by the quotient rule.
        let (y, n) = (self, self * self + x * x);
        let along = |dy: f64, dx: f64| (x.re * dy - y.re * dx) / n.re;
        let top2 = x.re * y.eps1eps2 - y.re * x.eps1eps2 + x.eps2 * y.eps1 - y.eps2 * x.eps1;
        Self {
            re: crate::math::atan2(y.re, x.re),
            eps1: along(y.eps1, x.eps1),
            eps2: along(y.eps2, x.eps2),
            eps1eps2: (top2 - along(y.eps1, x.eps1) * n.eps2) / n.re,
        }
    }
}

/// By hand: derivatives of functions that are known.
#[test]
fn closed_form_second_derivatives() {
    let (y, x) = (
        HyperDual { re: 0.7, eps1: 1.0, eps2: 0.0, eps1eps2: 0.0 },
        HyperDual { re: -1.3, eps1: 0.0, eps2: 1.0, eps1eps2: 0.0 },
    );
    let n = 0.7_f64 * 0.7 + 1.3 * 1.3;
    let angle = y.atan2(x);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} {b}");
    near(angle.eps1, -1.3 / n);
    near(angle.eps2, -0.7 / n);
    near(angle.eps1eps2, (0.7 * 0.7 - 1.3 * 1.3) / (n * n));
    // For x < 0: y sqrt(y x^2) / x^3 = -y^1.5 / x^2.
    let mixed = (y * (y * x * x).sqrt() / (x * x * x)).eps1eps2;
    near(mixed, -3.0 * 0.7_f64.sqrt() / (1.3 * 1.3 * 1.3));
}
