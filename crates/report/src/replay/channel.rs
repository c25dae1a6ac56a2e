//! Columns of numbers as compact text for the page's script: whole steps, their second differences, as
//! varints in base64.
//!
//! The motion of a flight is smooth, so nearly all second differences fit into a byte. A difference `d` is
//! the number `2 d` or `-2 d - 1`, seven bits a byte, the lowest first, the eighth bit where more follow; a
//! zero is followed by the number of further zeros. What is not finite or out of bounds keeps the number
//! before it and is listed as a gap.

use serde::Serialize;

use super::base64;
use samara_core::math;

/// Numbers beyond this many steps are gaps: differences of what is within are exact in the script's numbers.
const STEPS_MAX: f64 = (1_u64 << 40) as f64;

/// A column of numbers.
#[derive(Debug, Serialize)]
pub(super) struct Channel {
    name: String,
    /// Size of a step, in the unit of the name: numbers are exact to half of it.
    step: f64,
    /// First row without a number and the one after the last, for each run of them.
    gaps: Vec<(usize, usize)>,
    data: String,
}

impl Channel {
    /// Packs the numbers in steps of that size.
    pub(super) fn new(name: &str, step: f64, values: impl Iterator<Item = f64>) -> Self {
        let mut packer = Packer::default();
        let mut gaps: Vec<(usize, usize)> = Vec::new();
        let mut steps = 0;
        for (row, value) in values.enumerate() {
            let whole = (value / step).round();
            if whole.abs() <= STEPS_MAX {
                steps = whole as i64;
            } else {
                match gaps.last_mut() {
                    Some((_, end)) if *end == row => *end += 1,
                    _ => gaps.push((row, row + 1)),
                }
            }
            packer.push(steps);
        }
        Self { name: name.to_owned(), step, gaps, data: base64::encode(&packer.finish()) }
    }

    /// Packs the numbers in steps of a power of ten that is at most a ten thousandth of the largest.
    pub(super) fn scaled(name: &str, values: impl Iterator<Item = f64> + Clone) -> Self {
        let largest = values.clone().filter(|x| x.is_finite()).fold(0.0, |m: f64, x| m.max(x.abs()));
        let power = math::log10(largest.clamp(1e-6, 1e12)).floor() as i32;
        // Written as text and read again: the nearest number to the power of ten, on any machine.
        let step = format!("1e{}", power - 4).parse().unwrap_or(1.0);
        Self::new(name, step, values)
    }
}

/// Packs whole numbers.
#[derive(Debug, Default)]
struct Packer {
    bytes: Vec<u8>,
    last: i64,
    difference: i64,
    zeros: u64,
}

impl Packer {
    fn push(&mut self, steps: i64) {
        let difference = steps - self.last;
        let second = difference - self.difference;
        (self.last, self.difference) = (steps, difference);
        if second == 0 {
            self.zeros += 1;
        } else {
            self.flush();
            self.varint(if second < 0 { -2 * second - 1 } else { 2 * second } as u64);
        }
    }

    /// Writes the zeros that are waiting.
    fn flush(&mut self) {
        if self.zeros > 0 {
            self.varint(0);
            self.varint(self.zeros - 1);
            self.zeros = 0;
        }
    }

    fn varint(&mut self, mut number: u64) {
        while number >= 128 {
            self.bytes.push((number & 127) as u8 | 128);
            number >>= 7;
        }
        self.bytes.push(number as u8);
    }

    fn finish(mut self) -> Vec<u8> {
        self.flush();
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The inverse of base64, by hand.
    fn bytes_of(text: &str) -> Vec<u8> {
        let digit = |c: u8| match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            _ => 63,
        };
        let bits: Vec<u8> = text.bytes().filter(|c| *c != b'=').map(digit).collect();
        let join = |g: &[u8]| g.iter().fold(0_u32, |sum, d| sum << 6 | u32::from(*d)) << (6 * (4 - g.len()));
        bits.chunks(4).flat_map(|g| join(g).to_be_bytes()[1..g.len()].to_vec()).collect()
    }

    /// What the page's script does in `run.js`.
    fn unpacked(channel: &Channel, count: usize) -> Vec<f64> {
        let bytes = bytes_of(&channel.data);
        let mut at = 0;
        let mut varint = || {
            let mut number = 0;
            for shift in (0..).step_by(7) {
                let byte = bytes[at];
                at += 1;
                number |= u64::from(byte & 127) << shift;
                if byte < 128 {
                    break;
                }
            }
            number
        };
        let (mut steps, mut difference, mut zeros) = (0_i64, 0_i64, 0);
        let mut values = Vec::new();
        for _ in 0..count {
            if zeros > 0 {
                zeros -= 1;
            } else {
                match varint() {
                    0 => zeros = varint(),
                    token if token % 2 == 1 => difference -= token.div_ceil(2) as i64,
                    token => difference += (token / 2) as i64,
                }
            }
            steps += difference;
            values.push(steps as f64 * channel.step);
        }
        assert_eq!(at, bytes.len(), "all bytes are read");
        for &(from, to) in &channel.gaps {
            values[from..to].fill(f64::NAN);
        }
        values
    }

    fn special() -> impl Strategy<Value = f64> {
        prop_oneof![Just(0.0), Just(f64::NAN), Just(f64::INFINITY), Just(1e30)]
    }

    proptest! {
        /// Unpacked numbers are those that were packed, to half a step; what is no number is a gap.
        #[test]
        fn prop_numbers_come_back_to_half_a_step(
            values in proptest::collection::vec(
                prop_oneof![-1e3..1e3, -0.01..0.01, special()],
                0..200,
            ),
        ) {
            let channel = Channel::new("x", 1e-4, values.iter().copied());
            for (before, after) in values.iter().zip(unpacked(&channel, values.len())) {
                if before.is_finite() && *before < 1e9 {
                    prop_assert!((before - after).abs() <= 0.5e-4 * (1.0 + 1e-9), "{before} {after}");
                } else {
                    prop_assert!(after.is_nan());
                }
            }
        }
    }

    /// By hand: 0, 1, 3, 6 steps have the second differences 0, 1, 1, 1.
    #[test]
    fn closed_form_a_parabola_is_a_byte_a_row_and_rest_is_nothing() {
        let channel = Channel::new("x", 0.5, [0.0, 0.5, 1.5, 3.0].into_iter());
        assert_eq!(bytes_of(&channel.data), [0, 0, 2, 2, 2]);
        let rest = Channel::new("x", 1.0, std::iter::repeat_n(0.0, 300));
        assert_eq!(bytes_of(&rest.data), [0, 0xAB, 0x02]);
        assert_eq!(Channel::scaled("x", [250.0, 3.0].into_iter()).step, 0.01);
    }
}
