//! Vectors of three numbers over any [`Real`]: what nalgebra's are for `f64`, inlined always.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use nalgebra::{Matrix3, Vector3};

use crate::real::Real;

/// A vector of three numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct V3<S> {
    /// First component.
    pub x: S,
    /// Second component.
    pub y: S,
    /// Third component.
    pub z: S,
}

impl<S: Real> V3<S> {
    /// A vector of components.
    #[inline(always)]
    pub fn new(x: S, y: S, z: S) -> Self {
        Self { x, y, z }
    }

    /// The vector of length zero, of numbers of a kind of which one is given.
    #[inline(always)]
    pub fn zero(kind: S) -> Self {
        let zero = kind.of(0.0);
        Self { x: zero, y: zero, z: zero }
    }

    /// A constant vector of numbers of a kind, of which one is given.
    #[inline(always)]
    pub fn constant(kind: S, v: &Vector3<f64>) -> Self {
        Self { x: kind.of(v.x), y: kind.of(v.y), z: kind.of(v.z) }
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, b: Self) -> S {
        self.x * b.x + self.y * b.y + self.z * b.z
    }

    /// Scalar product with a constant vector.
    #[inline(always)]
    pub fn along(self, b: &Vector3<f64>) -> S {
        self.x * b.x + self.y * b.y + self.z * b.z
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        Self {
            x: self.y * b.z - self.z * b.y,
            y: self.z * b.x - self.x * b.z,
            z: self.x * b.y - self.y * b.x,
        }
    }

    /// Length.
    #[inline(always)]
    pub fn norm(self) -> S {
        self.dot(self).sqrt()
    }

    /// `yes` where the mask holds, `no` elsewhere.
    #[inline(always)]
    pub fn select(mask: S::Mask, yes: Self, no: Self) -> Self {
        Self {
            x: S::select(mask, yes.x, no.x),
            y: S::select(mask, yes.y, no.y),
            z: S::select(mask, yes.z, no.z),
        }
    }

    /// A constant matrix times the vector.
    #[inline(always)]
    pub fn times(self, m: &Matrix3<f64>) -> Self {
        Self {
            x: self.x * m.m11 + self.y * m.m12 + self.z * m.m13,
            y: self.x * m.m21 + self.y * m.m22 + self.z * m.m23,
            z: self.x * m.m31 + self.y * m.m32 + self.z * m.m33,
        }
    }
}

impl<S: Real> Add for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self { x: self.x + b.x, y: self.y + b.y, z: self.z + b.z }
    }
}

impl<S: Real> Sub for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self { x: self.x - b.x, y: self.y - b.y, z: self.z - b.z }
    }
}

impl<S: Real> Mul<S> for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: S) -> Self {
        Self { x: self.x * b, y: self.y * b, z: self.z * b }
    }
}

impl<S: Real> Div<S> for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn div(self, b: S) -> Self {
        Self { x: self.x / b, y: self.y / b, z: self.z / b }
    }
}

impl<S: Real> Neg for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<S: Real> AddAssign for V3<S> {
    #[inline(always)]
    fn add_assign(&mut self, b: Self) {
        *self = *self + b;
    }
}

impl<S: Real> SubAssign for V3<S> {
    #[inline(always)]
    fn sub_assign(&mut self, b: Self) {
        *self = *self - b;
    }
}

impl From<Vector3<f64>> for V3<f64> {
    #[inline(always)]
    fn from(v: Vector3<f64>) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<V3<f64>> for Vector3<f64> {
    #[inline(always)]
    fn from(v: V3<f64>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Each bit is nalgebra's.
        #[test]
        fn reference_vectors_are_those_of_nalgebra(
            a in prop::array::uniform3(-9.0f64..9.0), b in prop::array::uniform3(-9.0f64..9.0),
            m in prop::array::uniform9(-9.0f64..9.0), s in -9.0f64..9.0,
        ) {
            let (m, a, b) = (Matrix3::from_row_slice(&m), Vector3::from(a), Vector3::from(b));
            let (u, v) = (V3::from(a), V3::from(b));
            prop_assert_eq!(Vector3::from(u + v), a + b);
            prop_assert_eq!(Vector3::from(-(u - v)), -(a - b));
            prop_assert_eq!(Vector3::from(u * s), a * s);
            prop_assert_eq!(Vector3::from(u / s), a / s);
            prop_assert_eq!(Vector3::from(u.cross(v)), a.cross(&b));
            prop_assert_eq!(Vector3::from(u.times(&m)), m * a);
            prop_assert_eq!((u.dot(v), u.along(&b), u.norm()), (a.dot(&b), a.dot(&b), a.norm()));
        }
    }
}
