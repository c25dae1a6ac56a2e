//! Random numbers: ChaCha8 (Bernstein 2008), one stream of a seed for each purpose and number, so that no two
//! uses disturb each other and each is the same wherever it runs.
//!
//! A stream's key is its seed with its [`Purpose`] and part, its nonce its number: two streams that differ in
//! any of them have no block of the cipher in common.

mod purpose;

pub use purpose::{Purpose, Trials};

use crate::math;
use crate::real::straight;
use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng as _, SeedableRng as _};
use nalgebra::SVector;

/// A stream of random numbers.
#[derive(Debug)]
pub struct Stream(ChaCha8Rng);

impl Clone for Stream {
    /// A stream that goes on as this one will. (The generator itself is no `Clone`, since keys are made with
    /// it elsewhere.)
    fn clone(&self) -> Self {
        let mut generator = ChaCha8Rng::from_seed(self.0.get_seed());
        generator.set_stream(self.0.get_stream());
        generator.set_word_pos(self.0.get_word_pos());
        Self(generator)
    }
}

impl Stream {
    /// Stream `number` of a seed for a purpose.
    pub fn new(seed: u64, purpose: Purpose, number: u64) -> Self {
        Self::of_part(seed, purpose, 0, number)
    }

    /// Stream `number` of a seed for a part of a purpose, such as an axis or a rotor.
    pub fn of_part(seed: u64, purpose: Purpose, part: u32, number: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..12].copy_from_slice(&(purpose as u32).to_le_bytes());
        key[12..16].copy_from_slice(&part.to_le_bytes());
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(number);
        Self(generator)
    }

    /// 64 random bits, such as the seed of another generator.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in [0, 1), 53 bits.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in `low..high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// A whole number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        ((self.uniform() * n as f64) as usize).min(n.saturating_sub(1))
    }

    /// Normal with mean 0 and standard deviation 1 (Box and Muller 1958, the first of the pair).
    pub fn normal(&mut self) -> f64 {
        let (u, v) = (1.0 - self.uniform(), self.uniform());
        (-2.0 * math::ln(u)).sqrt() * math::cos(std::f64::consts::TAU * v)
    }

    /// `N` independent normal numbers with mean 0 and standard deviation 1.
    pub fn normals<const N: usize>(&mut self) -> SVector<f64, N> {
        SVector::from_fn(|_, _| self.normal())
    }
}

/// Two independent normal numbers with mean 0 and standard deviation 1 of 64 random bits (Box and Muller
/// 1958), without branches; none is beyond 6.8 in size.
#[inline(always)]
pub fn normal_pair(bits: u64) -> [f64; 2] {
    const PER_2_32: f64 = 1.0 / 4_294_967_296.0;
    let (sin, cos) = straight::sin_cos_of_turns(straight::of_u32(bits) * PER_2_32);
    let radius = (-2.0 * straight::ln((straight::of_u32(bits >> 32) + 0.5) * PER_2_32)).sqrt();
    [radius * cos, radius * sin]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_clone_goes_on_as_the_stream_does() {
        let mut stream = Stream::new(7, Purpose::Dice, 3);
        for _ in 0..40 {
            let mut clone = stream.clone();
            stream.bits();
            clone.bits();
            let mut ahead = clone.clone();
            let wanted: Vec<u64> = (0..20).map(|_| clone.bits()).collect();
            assert_eq!((0..20).map(|_| ahead.bits()).collect::<Vec<_>>(), wanted);
            assert_eq!(stream.clone().bits(), wanted[0]);
        }
    }

    /// Mean 0, variance 1, fourth moment 3, no memory, nothing in common with the stream beside it: each
    /// within five standard deviations of its estimate (variances of x^2 and x^4: 2 and 96).
    #[test]
    fn closed_form_normals_are_normal_and_independent() {
        let n = 30_000;
        let draw = |number| {
            let mut stream = Stream::new(7, Purpose::Dice, number);
            (0..n).map(|_| stream.normal()).collect::<Vec<f64>>()
        };
        let pairs = |i: usize| {
            let mut stream = Stream::new(7, Purpose::Dice, 5);
            (0..n).map(|_| normal_pair(stream.bits())[i]).collect::<Vec<f64>>()
        };
        for (x, other) in [(draw(3), draw(4)), (pairs(0), pairs(1))] {
            let mean = |terms: &mut dyn Iterator<Item = f64>| terms.sum::<f64>() / n as f64;
            let bound = 5.0 / (n as f64).sqrt();
            assert!(mean(&mut x.iter().copied()).abs() < bound);
            assert!((mean(&mut x.iter().map(|x| x * x)) - 1.0).abs() < bound * 2f64.sqrt());
            assert!((mean(&mut x.iter().map(|x| x.powi(4))) - 3.0).abs() < bound * 96f64.sqrt());
            assert!(mean(&mut x.windows(2).map(|w| w[0] * w[1])).abs() < bound);
            assert!(mean(&mut x.iter().zip(&other).map(|(a, b)| a * b)).abs() < bound);
        }
    }

    /// First two numbers and the ninth, which begins the second block, of streams whose keys and nonces are
    /// laid out as [`Stream::new`] says: by a ChaCha8 in Python, which gives ECRYPT's vector for a key of
    /// zeros (3e00ef2f895f40d6..).
    #[test]
    fn data_streams_are_chacha8_of_seed_purpose_and_number() {
        let drawn = |seed, purpose, part, number| {
            let mut stream = Stream::of_part(seed, purpose, part, number);
            let bits: Vec<u64> = (0..9).map(|_| stream.bits()).collect();
            [bits[0], bits[1], bits[8]]
        };
        assert_eq!(
            drawn(20_230_414, Purpose::Release, 0, 7),
            [0xed6d_4b32_e1b0_936f, 0x4d41_f1f9_56d0_9462, 0x2d52_d9e2_1222_1d93],
        );
        assert_eq!(
            drawn(1, Purpose::VortexRing, 3, Trials::Envelope.first() + 5),
            [0x286a_3969_ce51_2de0, 0x2b50_937f_e00b_5cc1, 0xe964_8dfb_79a8_72d4],
        );
    }

    /// Of each seed every purpose, part and number has a stream of its own (the compiler keeps the numbers of
    /// purposes apart). Of 64 random bits each, these 40 000 streams begin alike by chance once in 2e10
    /// tests.
    #[test]
    fn prop_no_two_streams_meet() {
        let purposes = [
            (Purpose::Release, 1),
            (Purpose::TipOff, 1),
            (Purpose::Unknowns, 1),
            (Purpose::Turbulence, 3),
            (Purpose::VortexRing, 8),
            (Purpose::GyroscopeNoise, 1),
            (Purpose::Garbage, 5),
            (Purpose::Sobol, 1),
        ];
        let mut begun = std::collections::BTreeMap::new();
        for seed in [0, 1, 2, 3, 20_230_414, 0x7469_705f_6f66_6600, u64::MAX] {
            for (purpose, parts) in purposes {
                let search = Trials::Search.first();
                let numbers = || (0..200).chain(search..search + 50).chain([u64::MAX]);
                for (part, number) in (0..parts).flat_map(|part| numbers().map(move |number| (part, number)))
                {
                    let bits = Stream::of_part(seed, purpose, part, number).bits();
                    let before = begun.insert(bits, (seed, purpose, part, number));
                    assert_eq!(before, None, "as stream {number} of {seed} for part {part} of {purpose:?}");
                }
            }
        }
    }

    #[test]
    fn closed_form_uniforms_fill_their_range() {
        let mut stream = Stream::new(1, Purpose::Dice, 0);
        let x: Vec<f64> = (0..10_000).map(|_| stream.between(-2.0, 4.0)).collect();
        assert!(x.iter().all(|x| (-2.0..4.0).contains(x)));
        // Standard deviation 6 / sqrt(12) of each.
        assert!((x.iter().sum::<f64>() / 1e4 - 1.0).abs() < 5.0 * 6.0 / 12f64.sqrt() / 100.0);
        assert!((0..1_000).all(|_| stream.below(3) < 3) && stream.below(0) == 0);
    }
}
