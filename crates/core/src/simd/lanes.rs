//! Eight numbers in two registers of AVX2, each the outcome of the same operations as an `f64`'s.

use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub, SubAssign};

use crate::real::{Bits, Cell, Mask, Real, straight};

/// How many flights fly side by side.
pub const LANES: usize = 8;

/// Proof that the processor has AVX2, with which alone [`Lanes`] can be made.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

impl Avx2 {
    /// The proof, where the processor has it.
    #[inline]
    pub fn found() -> Option<Self> {
        std::arch::is_x86_feature_detected!("avx2").then_some(Self(()))
    }
}

/// Eight numbers side by side.
#[derive(Clone, Copy, Debug)]
pub struct Lanes([__m256d; 2]);

/// Eight outcomes of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct Masks([__m256d; 2]);

/// Eight places in tables of fewer than 2^31.
#[derive(Clone, Copy, Debug)]
pub struct Cells([__m128i; 2]);

/// The intrinsic of each half. Whoever calls it has a number of these types, or the proof: there is AVX2.
macro_rules! halves {
    ($made:ident: $($half:ident of $whole:expr),+ => $body:expr) => {{
        let ($($half,)+) = ($($whole,)+);
        // SAFETY: such a number exists only where AVX2 was found.
        unsafe {
            let first = { let ($($half,)+) = ($($half.0[0],)+); $body };
            let second = { let ($($half,)+) = ($($half.0[1],)+); $body };
            $made([first, second])
        }
    }};
}

impl Lanes {
    /// Numbers side by side.
    #[inline(always)]
    pub fn new(_proof: Avx2, x: [f64; LANES]) -> Self {
        // SAFETY: the proof says that there is AVX2; each half reads four of eight numbers.
        unsafe { Self([_mm256_loadu_pd(x.as_ptr()), _mm256_loadu_pd(x.as_ptr().add(4))]) }
    }

    /// The numbers.
    #[inline(always)]
    pub fn to_array(self) -> [f64; LANES] {
        let mut x = [0.0; LANES];
        // SAFETY: as for all of them; each half writes four of eight numbers.
        unsafe {
            _mm256_storeu_pd(x.as_mut_ptr(), self.0[0]);
            _mm256_storeu_pd(x.as_mut_ptr().add(4), self.0[1]);
        }
        x
    }

    /// The numbers, where they are.
    #[inline(always)]
    pub fn as_array(&self) -> &[f64; LANES] {
        // SAFETY: two times four numbers, one after the other, are eight, and are aligned for them.
        unsafe { &*(&raw const self.0).cast() }
    }

    /// The numbers, where they are, to be changed.
    #[inline(always)]
    pub fn as_array_mut(&mut self) -> &mut [f64; LANES] {
        // SAFETY: as above; any bits are numbers.
        unsafe { &mut *(&raw mut self.0).cast() }
    }

    #[inline(always)]
    fn all(self, x: f64) -> Self {
        halves!(Self: _h of self => _mm256_set1_pd(x))
    }

    #[inline(always)]
    fn sign(self) -> Self {
        self.all(-0.0)
    }
}

macro_rules! operators {
    ($($trait:ident $method:ident $assign:ident $assigned:ident $intrinsic:ident)*) => {$(
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                halves!(Self: a of self, b of b => $intrinsic(a, b))
            }
        }
        impl $trait<f64> for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: f64) -> Self {
                self.$method(self.all(b))
            }
        }
        operators!(@assign $assign $assigned $method);
    )*};
    (@assign none $assigned:ident $method:ident) => {};
    (@assign $assign:ident $assigned:ident $method:ident) => {
        impl $assign for Lanes {
            #[inline(always)]
            fn $assigned(&mut self, b: Self) {
                *self = self.$method(b);
            }
        }
    };
}
operators! {
    Add add AddAssign add_assign _mm256_add_pd
    Sub sub SubAssign sub_assign _mm256_sub_pd
    Mul mul MulAssign mul_assign _mm256_mul_pd
    Div div none none _mm256_div_pd
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        halves!(Self: a of self, sign of self.sign() => _mm256_xor_pd(a, sign))
    }
}

impl BitAnd for Masks {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, b: Self) -> Self {
        halves!(Self: a of self, b of b => _mm256_and_pd(a, b))
    }
}

impl BitOr for Masks {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, b: Self) -> Self {
        halves!(Self: a of self, b of b => _mm256_or_pd(a, b))
    }
}

impl Not for Masks {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        halves!(Self: a of self => _mm256_xor_pd(a, _mm256_castsi256_pd(_mm256_set1_epi64x(-1))))
    }
}

impl Masks {
    /// The outcomes, one bit each.
    #[inline(always)]
    pub fn bits(self) -> u8 {
        // SAFETY: as for all of them.
        let [low, high] = self.0.map(|half| unsafe { _mm256_movemask_pd(half) });
        (low | (high << 4)) as u8
    }

    /// The outcome of one.
    #[inline(always)]
    pub fn lane(self, i: usize) -> bool {
        Lanes(self.0).as_array()[i].is_sign_negative()
    }

    /// Changes the outcome of one.
    #[inline(always)]
    pub fn set_lane(&mut self, i: usize, outcome: bool) {
        let mut bits = Lanes(self.0);
        bits.as_array_mut()[i] = f64::from_bits(if outcome { u64::MAX } else { 0 });
        self.0 = bits.0;
    }
}

impl Mask for Masks {
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.bits() == u8::MAX
    }
}

impl Cells {
    #[inline(always)]
    fn all(self, x: usize) -> Self {
        halves!(Self: _h of self => _mm_set1_epi32(x as i32))
    }

    /// Whether all places are in a table of this length.
    #[inline(always)]
    fn are_below(self, length: usize) -> bool {
        let length = length.min(i32::MAX as usize);
        let below = halves!(Self: a of self, most of self.all(length) => {
            _mm_andnot_si128(_mm_cmplt_epi32(a, _mm_setzero_si128()), _mm_cmplt_epi32(a, most))
        });
        // SAFETY: as for all of them.
        below.0.iter().all(|half| unsafe { _mm_movemask_epi8(*half) } == 0xffff)
    }

    /// The places.
    #[inline(always)]
    pub fn to_array(self) -> [usize; LANES] {
        let mut x = [0i32; LANES];
        // SAFETY: as for all of them; each half writes four of eight numbers.
        unsafe {
            _mm_storeu_si128(x.as_mut_ptr().cast(), self.0[0]);
            _mm_storeu_si128(x.as_mut_ptr().add(4).cast(), self.0[1]);
        }
        x.map(|place| place as usize)
    }
}

impl Cell for Cells {
    #[inline(always)]
    fn after(self, places: usize) -> Self {
        halves!(Self: a of self, b of self.all(places) => _mm_add_epi32(a, b))
    }
    #[inline(always)]
    fn row(self, columns: usize, column: Self) -> Self {
        halves!(Self: a of self, n of self.all(columns), b of column => {
            _mm_add_epi32(_mm_mullo_epi32(a, n), b)
        })
    }
}

/// Two numbers each of two places.
///
/// # Safety
/// There is AVX2, and there are two numbers at each place.
#[inline(always)]
unsafe fn pairs(first: *const f64, second: *const f64) -> __m256d {
    // SAFETY: as asked for.
    unsafe { _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(_mm_loadu_pd(first)), _mm_loadu_pd(second)) }
}

/// Where rows of a table lie.
///
/// # Safety
/// There is AVX2, and the places are in the table.
#[inline(always)]
unsafe fn places<const K: usize>(table: &[[f64; K]], cell: __m128i) -> [*const f64; 4] {
    let mut places = [0i32; 4];
    // SAFETY: as asked for.
    unsafe {
        _mm_storeu_si128(places.as_mut_ptr().cast(), cell);
        let ([a, b, c, d], rows) = (places, table.as_ptr());
        let ([a, b], [c, d]) =
            ([rows.add(a as usize), rows.add(b as usize)], [rows.add(c as usize), rows.add(d as usize)]);
        [a.cast(), b.cast(), c.cast(), d.cast()]
    }
}

/// Rows of a table, read as they lie, two numbers at a time: a gather reads each number by itself.
///
/// # Safety
/// The places are in the table.
#[inline(always)]
unsafe fn rows<const K: usize>(kind: Lanes, table: &[[f64; K]], cell: Cells) -> [Lanes; K] {
    let mut rows = [kind; K];
    for half in 0..2 {
        // SAFETY: such numbers exist only where AVX2 was found; each pointer is to K numbers of the table.
        unsafe {
            let [a, b, c, d] = places(table, cell.0[half]);
            for k in 0..K / 2 {
                let (ac, bd) = (pairs(a.add(2 * k), c.add(2 * k)), pairs(b.add(2 * k), d.add(2 * k)));
                rows[2 * k].0[half] = _mm256_unpacklo_pd(ac, bd);
                rows[2 * k + 1].0[half] = _mm256_unpackhi_pd(ac, bd);
            }
            if K % 2 == 1 {
                let k = K - 1;
                rows[k].0[half] = _mm256_set_pd(*d.add(k), *c.add(k), *b.add(k), *a.add(k));
            }
        }
    }
    rows
}

impl Real for Lanes {
    type Mask = Masks;
    type Cell = Cells;

    #[inline(always)]
    fn of(self, x: f64) -> Self {
        self.all(x)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        halves!(Self: a of self => _mm256_sqrt_pd(a))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        halves!(Self: a of self, sign of self.sign() => _mm256_andnot_pd(sign, a))
    }
    #[inline(always)]
    fn copysign(self, b: Self) -> Self {
        halves!(Self: a of self, b of b, sign of self.sign() => {
            _mm256_or_pd(_mm256_andnot_pd(sign, a), _mm256_and_pd(sign, b))
        })
    }
    #[inline(always)]
    fn floor(self) -> Self {
        halves!(Self: a of self => _mm256_floor_pd(a))
    }
    #[inline(always)]
    fn less(self, b: Self) -> Masks {
        halves!(Masks: a of self, b of b => _mm256_cmp_pd::<_CMP_LT_OQ>(a, b))
    }
    #[inline(always)]
    fn select(mask: Masks, yes: Self, no: Self) -> Self {
        halves!(Self: mask of mask, yes of yes, no of no => _mm256_blendv_pd(no, yes, mask))
    }
    #[inline(always)]
    fn at_least(self, b: Self) -> Self {
        halves!(Self: a of self, b of b => _mm256_max_pd(a, b))
    }
    #[inline(always)]
    fn at_most(self, b: Self) -> Self {
        halves!(Self: a of self, b of b => _mm256_min_pd(a, b))
    }

    #[inline(always)]
    fn cell(self, last: usize) -> Cells {
        let bounded = self.at_least(self.all(0.0)).at_most(self.all(last as f64));
        halves!(Cells: a of bounded => _mm256_cvttpd_epi32(a))
    }
    #[inline(always)]
    fn interval(self, knots: &[f64]) -> Cells {
        let mut places = self.to_array();
        for place in &mut places {
            *place = place.interval(knots) as f64;
        }
        let places = Self::new(Avx2(()), places);
        halves!(Cells: a of places => _mm256_cvttpd_epi32(a))
    }
    #[inline(always)]
    fn of_cell(self, cell: Cells) -> Self {
        halves!(Self: a of cell => _mm256_cvtepi32_pd(a))
    }
    #[inline(always)]
    fn gather<const K: usize>(self, table: &[[f64; K]], cell: Cells) -> [Self; K] {
        assert!(cell.are_below(table.len()), "a place beyond its table");
        // SAFETY: all of these places are in the table.
        unsafe { rows(self, table, cell) }
    }
    #[inline(always)]
    fn gather_two<const K: usize>(self, table: &[[f64; K]], cell: Cells) -> [[Self; K]; 2] {
        assert!(cell.are_below(table.len().saturating_sub(1)), "a place beyond its table");
        // Twice as many numbers, each at two places.
        let mut two = [[self; K]; 2];
        for half in 0..2 {
            // SAFETY: as for all of them; each of these places and the next are in the table, so that each
            // pointer is to 2 K numbers of it.
            unsafe {
                let [a, b, c, d] = places(table, cell.0[half]);
                for k in 0..K {
                    let (k0, k1) = (2 * k, 2 * k + 1);
                    let (ac, bd) = (pairs(a.add(k0), c.add(k0)), pairs(b.add(k0), d.add(k0)));
                    two[k0 / K][k0 % K].0[half] = _mm256_unpacklo_pd(ac, bd);
                    two[k1 / K][k1 % K].0[half] = _mm256_unpackhi_pd(ac, bd);
                }
            }
        }
        two
    }
    fn constants<const K: usize>(
        self,
        mask: Masks,
        before: [[Self; 4]; K],
        function: &mut dyn FnMut(f64) -> [[f64; 4]; K],
    ) -> [[Self; 4]; K] {
        let mut rows = before.map(|row| row.map(Self::to_array));
        for (i, x) in self.to_array().into_iter().enumerate() {
            if mask.bits() >> i & 1 == 1 {
                for (row, now) in rows.iter_mut().zip(function(x)) {
                    for (number, now) in row.iter_mut().zip(now) {
                        number[i] = now;
                    }
                }
            }
        }
        rows.map(|row| row.map(|number| Self::new(Avx2(()), number)))
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

impl Bits for Lanes {
    #[inline(always)]
    fn two_to_minus(shifted: Self) -> Self {
        halves!(Self: a of shifted => {
            let n = _mm256_and_si256(_mm256_castpd_si256(a), _mm256_set1_epi64x(0xfff));
            _mm256_castsi256_pd(_mm256_slli_epi64::<52>(_mm256_sub_epi64(_mm256_set1_epi64x(1023), n)))
        })
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        let root_half = straight::ROOT_HALF as i64;
        let shifted = halves!(Self: a of self => {
            let by = _mm256_set1_epi64x(0x3ff0_0000_0000_0000 - root_half);
            _mm256_castsi256_pd(_mm256_add_epi64(_mm256_castpd_si256(a), by))
        });
        let k = halves!(Self: a of shifted => {
            let exponent = _mm256_srli_epi64::<52>(_mm256_castpd_si256(a));
            let whole = _mm256_or_si256(exponent, _mm256_set1_epi64x(0x4330_0000_0000_0000));
            _mm256_castsi256_pd(whole)
        });
        let m = halves!(Self: a of shifted => {
            let mask = _mm256_set1_epi64x(0x000f_ffff_ffff_ffff);
            let mantissa = _mm256_and_si256(_mm256_castpd_si256(a), mask);
            _mm256_castsi256_pd(_mm256_add_epi64(mantissa, _mm256_set1_epi64x(root_half)))
        });
        (k - (4_503_599_627_370_496.0 + 1023.0), m)
    }
    #[inline(always)]
    fn is_odd(shifted: Self) -> Masks {
        halves!(Masks: a of shifted => {
            let one = _mm256_set1_epi64x(1);
            let odd = _mm256_and_si256(_mm256_castpd_si256(a), one);
            _mm256_castsi256_pd(_mm256_cmpeq_epi64(odd, one))
        })
    }
    #[inline(always)]
    fn signed_by(self, shifted: Self, more: u64) -> Self {
        halves!(Self: x of self, a of shifted => {
            let n = _mm256_add_epi64(_mm256_castpd_si256(a), _mm256_set1_epi64x(more as i64));
            let bit = _mm256_and_si256(n, _mm256_set1_epi64x(2));
            _mm256_xor_pd(x, _mm256_castsi256_pd(_mm256_slli_epi64::<62>(bit)))
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Numbers of any kind: usual ones, large and small ones, and none.
    fn any_number() -> impl Strategy<Value = f64> {
        prop_oneof![
            8 => -9.0f64..9.0, 2 => -1e-9f64..1e-9, 2 => -1e9f64..1e9,
            1 => Just(0.0), 1 => Just(-0.0), 1 => Just(f64::INFINITY), 1 => Just(f64::NAN), 1 => Just(1.0),
        ]
    }

    fn bits(x: [f64; LANES]) -> [u64; LANES] {
        // All that are none are the same.
        x.map(|x| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// Each operation on eight numbers has the bits of eight operations on one.
        #[test]
        fn prop_lanes_have_the_bits_of_single_numbers(
            a in prop::array::uniform8(any_number()), b in prop::array::uniform8(any_number()),
            table in prop::collection::vec(prop::array::uniform3(-9.0f64..9.0), 2..40),
            knots in prop::collection::vec(-9.0f64..9.0, 2..20), more: u8,
        ) {
            let Some(proof) = Avx2::found() else { return Ok(()) };
            let (x, y) = (Lanes::new(proof, a), Lanes::new(proof, b));
            let mut knots = knots;
            knots.sort_by(f64::total_cmp);
            macro_rules! same {
                ($($many:expr => |$a:ident, $b:ident| $one:expr;)+) => {$(
                    let wanted: [f64; LANES] = std::array::from_fn(|i| { let ($a, $b) = (a[i], b[i]); $one });
                    prop_assert_eq!(bits($many.to_array()), bits(wanted), "{}", stringify!($one));
                )+};
            }
            let last = table.len() - 1;
            let cell = |x: f64| x.cell(last);
            same! {
                x + y => |a, b| a + b;
                x - y => |a, b| a - b;
                x * y => |a, b| a * b;
                x / y => |a, b| a / b;
                -x => |a, _b| -a;
                x + 0.3 => |a, _b| a + 0.3;
                x.of(2.0) => |_a, _b| 2.0;
                x.sqrt() => |a, _b| a.sqrt();
                x.abs() => |a, _b| a.abs();
                x.floor() => |a, _b| a.floor();
                Real::copysign(x, y) => |a, b| a.copysign(b);
                x.at_least(y) => |a, b| Real::at_least(a, b);
                x.at_most(y) => |a, b| Real::at_most(a, b);
                Lanes::select(x.less(y), x, y) => |a, b| f64::select(a.less(b), a, b);
                Lanes::select(!x.less(y) | y.less(x), y, x) => |a, b| {
                    f64::select(!a.less(b) | b.less(a), b, a)
                };
                Lanes::select(!x.less(y) & y.less(x), y, x) => |a, b| {
                    f64::select(!a.less(b) & b.less(a), b, a)
                };
                x.of_cell(x.cell(last)) => |a, _b| a.of_cell(cell(a));
                x.of_cell(x.cell(last).row(3, y.cell(last)).after(5)) => |a, b| {
                    a.of_cell(cell(a).row(3, cell(b)).after(5))
                };
                x.of_cell(x.interval(&knots)) => |a, _b| a.of_cell(a.interval(&knots));
                x.gather(&table, x.cell(last))[2] => |a, _b| table[cell(a)][2];
                x.gather(&table, x.cell(last))[1] => |a, _b| table[cell(a)][1];
                x.gather_two(&table, x.cell(last - 1))[0][1] => |a, _b| table[a.cell(last - 1)][1];
                x.gather_two(&table, x.cell(last - 1))[0][2] => |a, _b| table[a.cell(last - 1)][2];
                x.gather_two(&table, x.cell(last - 1))[1][0] => |a, _b| table[a.cell(last - 1) + 1][0];
                x.gather_two(&table, x.cell(last - 1))[1][2] => |a, _b| table[a.cell(last - 1) + 1][2];
                x.atan2(y) => |a, b| Real::atan2(a, b);
                x.abs().exp_of_minus() => |a, _b| a.abs().exp_of_minus();
                (x.abs() + 1e-9).ln() => |a, _b| Real::ln(a.abs() + 1e-9);
                x.sin_cos_of_turns().0 => |a, _b| a.sin_cos_of_turns().0;
                x.sin_cos_of_turns().1 => |a, _b| a.sin_cos_of_turns().1;
                x.constants(x.less(y), [[x, y, y, y]], &mut |a| [[a + 1.0, a, a, a]])[0][0] => |a, b| {
                    if a < b { a + 1.0 } else { a }
                };
                straight::acos(x) => |a, _b| straight::acos(a);
                x.signed_by(y + 6_755_399_441_055_744.0, u64::from(more)) => |a, b| {
                    a.signed_by(b + 6_755_399_441_055_744.0, u64::from(more))
                };
            }
            prop_assert_eq!(x.less(y).any(), (0..LANES).any(|i| a[i] < b[i]));
            prop_assert_eq!(x.less(y).all(), (0..LANES).all(|i| a[i] < b[i]));
        }
    }

    #[test]
    #[should_panic(expected = "beyond its table")]
    fn a_place_beyond_a_table_is_refused() {
        let proof = Avx2::found().expect("beyond its table: there is none");
        let x = Lanes::new(proof, [0.0; LANES]);
        x.gather(&[[1.0]], x.cell(0).after(1));
    }

    #[test]
    #[should_panic(expected = "beyond its table")]
    fn the_place_after_the_last_of_a_table_is_refused() {
        let proof = Avx2::found().expect("beyond its table: there is none");
        let x = Lanes::new(proof, [0.0; LANES]);
        x.gather_two(&[[1.0], [2.0]], x.cell(0).after(1));
    }
}
