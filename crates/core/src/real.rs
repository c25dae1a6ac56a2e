//! The scalar that the dynamics are written over.
//!
//! The vehicle's derivative - body, air, rotors, motors, bus - is written once, over any [`Real`]: of one
//! flight by `f64`, of eight side by side by a register type ([`crate::simd::lanes::Lanes`]), to the same
//! bits, and with exact derivatives of its own by dual numbers ([`Dual`]). Since eight flights cannot take
//! two branches, a comparison gives a [`Mask`], and [`Real::select`] picks by it; a place in a table is a
//! [`Cell`]. A number of a kind can be made only from another one of that kind ([`Real::of`]): there is none
//! of a register type where there are no such registers.
//!
//! All methods are inlined always, so that what calls them is compiled for the registers of its caller; code
//! over a `Real` must be marked so too, and has no closures, which cannot be.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub, SubAssign};

pub use dual::Dual;

mod dual;
mod single;
pub mod straight;

/// Outcome of a comparison.
pub trait Mask: Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Whether it holds anywhere.
    fn any(self) -> bool;
    /// Whether it holds everywhere.
    fn all(self) -> bool;
}

impl Mask for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
}

/// A place in a table: a whole number, zero or more.
pub trait Cell: Copy + Debug {
    /// So many places on.
    fn after(self, places: usize) -> Self;
    /// The place in row `self` of rows of `columns`, in column `column`.
    fn row(self, columns: usize, column: Self) -> Self;
}

impl Cell for usize {
    #[inline(always)]
    fn after(self, places: usize) -> Self {
        self + places
    }
    #[inline(always)]
    fn row(self, columns: usize, column: Self) -> Self {
        self * columns + column
    }
}

/// A real number or something that behaves like one.
pub trait Real:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + 'static
{
    /// Outcome of a comparison.
    type Mask: Mask;
    /// Place in a table.
    type Cell: Cell;

    /// A constant of this number's kind.
    fn of(self, x: f64) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Size.
    fn abs(self) -> Self;
    /// This size with the sign of another number.
    fn copysign(self, sign: Self) -> Self;
    /// The nearest whole number that is not greater.
    fn floor(self) -> Self;
    /// Whether it is less than another number; not where one of them is none.
    fn less(self, other: Self) -> Self::Mask;
    /// `yes` where the mask holds, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The greater of two numbers, the second where the first is none.
    fn at_least(self, least: Self) -> Self;
    /// The smaller of two numbers, the second where the first is none.
    fn at_most(self, most: Self) -> Self;

    /// The whole part as a place, at most `last`; 0 of what is negative or none.
    fn cell(self, last: usize) -> Self::Cell;
    /// The left knot of the interval of increasing knots, at least two, that it lies in; the outermost one
    /// beyond the ends.
    fn interval(self, knots: &[f64]) -> Self::Cell;
    /// A place as a number of this number's kind.
    fn of_cell(self, cell: Self::Cell) -> Self;
    /// What a table has at a place.
    fn gather<const K: usize>(self, table: &[[f64; K]], cell: Self::Cell) -> [Self; K];

    /// What a table has at a place, and at the next one.
    fn gather_two<const K: usize>(self, table: &[[f64; K]], cell: Self::Cell) -> [[Self; K]; 2];

    /// Constants that a function has at each number where the mask holds, and those of `before` elsewhere.
    /// (The function is called one number at a time: for what seldom happens.)
    fn constants<const K: usize>(
        self,
        mask: Self::Mask,
        before: [[Self; 4]; K],
        function: &mut dyn FnMut(f64) -> [[f64; 4]; K],
    ) -> [[Self; 4]; K];

    /// Four-quadrant arc tangent of `self / x` [rad]: [`straight::atan2`].
    fn atan2(self, x: Self) -> Self;
    /// `exp(-self)` of a number of at least zero: [`straight::exp_of_minus`].
    fn exp_of_minus(self) -> Self;
    /// Natural logarithm of a positive number: [`straight::ln`].
    fn ln(self) -> Self;
    /// Sine and cosine of an angle in turns: [`straight::sin_cos_of_turns`].
    fn sin_cos_of_turns(self) -> (Self, Self);
}

/// A [`Real`] that has the bits of floating-point numbers, of which [`straight`] makes elementary functions.
pub trait Bits: Real {
    /// `2^-n` of the whole number in the last bits of `n + 1.5 2^52`, |n| < 1022.
    fn two_to_minus(shifted: Self) -> Self;
    /// Exponent and mantissa of a positive normal number `2^k m`, m between sqrt(1/2) and sqrt(2).
    fn split(self) -> (Self, Self);
    /// Whether the whole number in the last bits of `n + 1.5 2^52` is odd.
    fn is_odd(shifted: Self) -> Self::Mask;
    /// Itself with its sign changed where bit 1 of `n + more` is set, n as in [`Self::is_odd`].
    fn signed_by(self, shifted: Self, more: u64) -> Self;
}
