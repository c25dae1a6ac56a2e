//! The scalar that the dynamics are written over.
//!
//! The rigid body and its aerodynamics are written once, over any [`Real`]: `f64` flies, dual numbers check
//! the planner's hand-written derivatives in the tests, and lanes of several vehicles can follow. The trait
//! holds what these equations need and nothing else.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A real number or something that behaves like one.
pub trait Real:
    Copy
    + Debug
    + PartialEq
    + num_traits::Zero
    + num_traits::One
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + 'static
{
    /// The constant `x`.
    fn from_f64(x: f64) -> Self;
    /// The value without derivatives: what a table search or a comparison looks at.
    fn value(self) -> f64;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Four-quadrant arc tangent of `self / x` [rad].
    fn atan2(self, x: Self) -> Self;
}

impl Real for f64 {
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        crate::math::straight::atan2(self, x)
    }
}

#[cfg(test)]
pub(crate) mod dual;
