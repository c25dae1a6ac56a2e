//! Random numbers for sensors, by address: ChaCha8 at a place that seed, stream and time give, so that it does not matter who
//! asks first or how often.
//!
//! A random walk has a memory, and yet none is kept here: Levy's construction of Brownian motion. Its values at the ends of spans of
//! 2^30 ticks are sums of independent numbers; between them the middle of an interval is drawn given its ends (their mean, and a
//! normal number of variance a quarter of the interval's length), then the middle of the half in question, down to the tick.
//! Each middle has its own address. The halves on the way to the last tick are kept: the next tick shares them but for two in the
//! mean, and what is kept changes no bit.

use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

/// Random words that belong to a microsecond of [`Noise::normal`]: room for one number, and whole blocks of ChaCha.
const WORDS_PER_US: u128 = 32;
/// Random words that belong to a [`Noise::triple`]: 36 are taken.
const WORDS_PER_TRIPLE: u128 = 64;
/// A span of the walk is 2^30 ticks.
const SPAN_BITS: u32 = 30;

/// A source of random numbers for the sensors of one vehicle.
#[derive(Clone, Debug)]
pub struct Noise {
    generator: ChaCha8Rng,
    /// The way to the last time of each walk, by its stream.
    ways: Vec<(u64, Vec<Interval>)>,
}

/// A part of a span of a walk, half of the one before it on the way to a time.
#[derive(Clone, Copy, Debug)]
struct Interval {
    span: u64,
    /// 1 is the whole span, 2 and 3 its halves, and so on; also the address of its middle (that of the step across the span is 0).
    index: u64,
    from: u64,
    length: u64,
    left: Vector3<f64>,
    right: Vector3<f64>,
}

impl Interval {
    fn contains(&self, tick: u64) -> bool {
        (self.from..self.from + self.length).contains(&tick)
    }
}

impl Noise {
    /// The source of a seed.
    pub fn new(seed: u64) -> Self {
        Self { generator: ChaCha8Rng::seed_from_u64(seed), ways: Vec::new() }
    }

    fn at(&self, stream: u64, word: u128) -> ChaCha8Rng {
        let mut random = self.generator.clone();
        random.set_stream(stream);
        random.set_word_pos(word);
        random
    }

    /// A number of about normal distribution, drawn by stream and time: the sum of twelve uniform ones, which takes nothing but
    /// additions and so is the same everywhere.
    pub fn normal(&self, stream: u64, t_us: u64) -> f64 {
        let mut random = self.at(stream, u128::from(t_us) * WORDS_PER_US);
        let uniform = |_| (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        (0..12).map(uniform).sum::<f64>() - 6.0
    }

    /// Three such numbers, drawn by stream and index (below 2^62), of 32 random bits in each summand.
    pub fn triple(&self, stream: u64, index: u64) -> Vector3<f64> {
        let mut random = self.at(stream, u128::from(index) * WORDS_PER_TRIPLE);
        let mut normal = || {
            // The sum of twelve whole numbers is exact.
            let sum = (0..12).map(|_| u64::from(random.next_u32())).sum::<u64>();
            (sum as f64 + 6.0) / (1u64 << 32) as f64 - 6.0
        };
        Vector3::new(normal(), normal(), normal())
    }

    /// Three independent random walks at a tick, one of every `tick_s` [s]: zero at tick 0, variance 1 per second. A stream has
    /// one `tick_s`.
    pub fn walk(&mut self, stream: u64, tick: u64, tick_s: f64) -> Vector3<f64> {
        let known = self.ways.iter().position(|(of, _)| *of == stream);
        let mut way = known.map_or_else(Vec::new, |at| std::mem::take(&mut self.ways[at].1));
        while way.pop_if(|last| !last.contains(tick)).is_some() {}
        let mut interval = way.last().copied().unwrap_or_else(|| {
            let span = self.span(stream, tick >> SPAN_BITS, tick_s);
            way.push(span);
            span
        });
        while interval.from != tick {
            interval = self.half(stream, &interval, tick, tick_s);
            way.push(interval);
        }
        match known {
            Some(at) => self.ways[at].1 = way,
            None => self.ways.push((stream, way)),
        }
        interval.left
    }

    fn node(&self, stream: u64, span: u64, index: u64) -> Vector3<f64> {
        self.triple(stream, (span << (SPAN_BITS + 1)) + index)
    }

    fn span(&self, stream: u64, span: u64, tick_s: f64) -> Interval {
        let length = 1u64 << SPAN_BITS;
        let across = |span| self.node(stream, span, 0) * (length as f64 * tick_s).sqrt();
        let left: Vector3<f64> = (0..span).map(across).sum();
        Interval { span, index: 1, from: span << SPAN_BITS, length, left, right: left + across(span) }
    }

    /// The half of an interval that contains a tick.
    fn half(&self, stream: u64, whole: &Interval, tick: u64, tick_s: f64) -> Interval {
        let deviation = (whole.length as f64 * tick_s).sqrt() / 2.0;
        let middle =
            (whole.left + whole.right) / 2.0 + self.node(stream, whole.span, whole.index) * deviation;
        let first = Interval { index: 2 * whole.index, length: whole.length / 2, right: middle, ..*whole };
        let middle_tick = first.from + first.length;
        if tick < middle_tick {
            first
        } else {
            Interval { index: first.index + 1, from: middle_tick, left: middle, right: whole.right, ..first }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variance(x: &[f64]) -> f64 {
        x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64
    }

    /// Mean 0, variance 1, no memory. The bounds are 5 standard deviations of the estimates.
    #[test]
    fn closed_form_triples_are_normal_and_independent() {
        let noise = Noise::new(7);
        let n = 4_000;
        let x: Vec<Vector3<f64>> = (0..n).map(|i| noise.triple(3, i * 4_000)).collect();
        let bound = 5.0 / (n as f64).sqrt();
        for axis in 0..3 {
            let axis: Vec<f64> = x.iter().map(|v| v[axis]).collect();
            assert!((axis.iter().sum::<f64>() / n as f64).abs() < bound);
            assert!((variance(&axis) - 1.0).abs() < bound * 2f64.sqrt(), "{}", variance(&axis));
        }
        let correlation = |pairs: Vec<(f64, f64)>| pairs.iter().map(|(a, b)| a * b).sum::<f64>() / n as f64;
        assert!(correlation(x.iter().map(|v| (v.x, v.y)).collect()).abs() < bound);
        assert!(correlation(x.windows(2).map(|w| (w[0].x, w[1].x)).collect()).abs() < bound);
        let other = |i| noise.triple(4, i * 4_000).x;
        assert!(correlation((0..n).zip(&x).map(|(i, v)| (v.x, other(i))).collect()).abs() < bound);
    }

    /// `Var[W(t) - W(s)] = t - s`, increments independent, over a dyadic time, an odd one and the end of a span.
    #[test]
    fn closed_form_a_walk_s_increments_have_the_variance_of_their_time() {
        let mut noise = Noise::new(11);
        let streams = 0..1_000u64;
        let bound = 5.0 * (2.0 / 3_000.0f64).sqrt();
        for (from_us, to_us) in [
            (0, 1),
            (0, 4_000),
            (4_000, 8_000),
            (1_000_000, 11_000_000),
            (536_870_911, 536_870_913),
            (1_073_741_000, 1_073_743_001),
            (2_000_000_000, 2_400_000_000),
        ] {
            let mut steps = Vec::new();
            let mut together = 0.0;
            for stream in streams.clone() {
                let start = noise.walk(stream, from_us, 1e-6);
                let step =
                    (noise.walk(stream, to_us, 1e-6) - start) / ((to_us - from_us) as f64 * 1e-6).sqrt();
                together += step.dot(&start) / (from_us.max(1) as f64 * 1e-6).sqrt();
                steps.extend(step.iter().copied());
            }
            assert!((variance(&steps) - 1.0).abs() < bound, "{from_us} {to_us}: {}", variance(&steps));
            assert!((together / 3_000.0).abs() < 5.0 / 3_000f64.sqrt(), "{from_us} {to_us}");
        }
        assert_eq!(noise.walk(0, 0, 1e-6), Vector3::zeros());
    }

    /// Continuity where spans meet, and the same bits whatever was asked before.
    #[test]
    fn prop_a_walk_is_the_same_in_any_order_of_asking() {
        for seed in [0, 1, u64::MAX] {
            let times: Vec<u64> = (0..50).map(|i| i * 43_210_987).collect();
            let mut one = Noise::new(seed);
            let forwards: Vec<_> = times.iter().map(|t| one.walk(5, *t, 1e-6)).collect();
            let mut another = Noise::new(seed);
            let mut backwards: Vec<_> = times.iter().rev().map(|t| another.walk(5, *t, 1e-6)).collect();
            backwards.reverse();
            assert_eq!(forwards, backwards);
            let fresh: Vec<_> = times.iter().map(|t| Noise::new(seed).walk(5, *t, 1e-6)).collect();
            assert_eq!(forwards, fresh);
            let seam = (1u64 << 30) as f64;
            let (before, after) = (one.walk(5, seam as u64 - 1, 1e-6), one.walk(5, seam as u64, 1e-6));
            assert!((before - after).amax() < 0.01);
        }
    }
}
