//! Numbers one by one: a double is a [`Real`].

use super::{Bits, Real, straight};

impl Real for f64 {
    type Mask = bool;
    type Cell = usize;

    #[inline(always)]
    fn of(self, x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Self::copysign(self, sign)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self::floor(self)
    }
    #[inline(always)]
    fn less(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn at_least(self, least: Self) -> Self {
        if self > least { self } else { least }
    }
    #[inline(always)]
    fn at_most(self, most: Self) -> Self {
        if self < most { self } else { most }
    }
    #[inline(always)]
    fn cell(self, last: usize) -> usize {
        // `as usize` saturates: NaN and negatives give 0.
        (self as usize).min(last)
    }
    #[inline(always)]
    fn interval(self, knots: &[f64]) -> usize {
        knots[1..knots.len() - 1].partition_point(|&knot| knot <= self)
    }
    #[inline(always)]
    fn of_cell(self, cell: usize) -> Self {
        cell as Self
    }
    #[inline(always)]
    fn gather<const K: usize>(self, table: &[[f64; K]], cell: usize) -> [Self; K] {
        table[cell]
    }
    #[inline(always)]
    fn gather_two<const K: usize>(self, table: &[[f64; K]], cell: usize) -> [[Self; K]; 2] {
        [table[cell], table[cell + 1]]
    }
    fn constants<const K: usize>(
        self,
        mask: bool,
        before: [[Self; 4]; K],
        function: &mut dyn FnMut(f64) -> [[f64; 4]; K],
    ) -> [[Self; 4]; K] {
        if mask { function(self) } else { before }
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        straight::atan2(self, x)
    }
    #[inline(always)]
    fn exp_of_minus(self) -> Self {
        straight::exp_of_minus(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        straight::ln(self)
    }
    #[inline(always)]
    fn sin_cos_of_turns(self) -> (Self, Self) {
        straight::sin_cos_of_turns(self)
    }
}

impl Bits for f64 {
    #[inline(always)]
    fn two_to_minus(shifted: Self) -> Self {
        Self::from_bits(1023u64.wrapping_sub(shifted.to_bits() & 0xfff) << 52)
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        let shifted = self.to_bits().wrapping_add(0x3ff0_0000_0000_0000 - straight::ROOT_HALF);
        let k = Self::from_bits((shifted >> 52) | 0x4330_0000_0000_0000) - (4_503_599_627_370_496.0 + 1023.0);
        (k, Self::from_bits((shifted & 0x000f_ffff_ffff_ffff) + straight::ROOT_HALF))
    }
    #[inline(always)]
    fn is_odd(shifted: Self) -> bool {
        shifted.to_bits() & 1 == 1
    }
    #[inline(always)]
    fn signed_by(self, shifted: Self, more: u64) -> Self {
        Self::from_bits(self.to_bits() ^ ((shifted.to_bits().wrapping_add(more) & 2) << 62))
    }
}
