//! A random walk (Brownian motion): what the bias of a sensor does.

use nalgebra::SVector;

use crate::random::Stream;
use crate::units::US_PER_S;

/// N independent random walks: zero at time 0, variance 1 per second.
#[derive(Clone, Debug)]
pub struct Walk<const N: usize> {
    stream: Stream,
    at_us: u64,
    value: SVector<f64, N>,
}

impl<const N: usize> Walk<N> {
    /// Walks at their beginning, driven by a stream of random numbers.
    pub fn new(stream: Stream) -> Self {
        Self { stream, at_us: 0, value: SVector::zeros() }
    }

    /// Values of the walks at a time; a time before the last one asked for counts as that.
    pub fn at(&mut self, t_us: u64) -> SVector<f64, N> {
        if t_us > self.at_us {
            let elapsed_s = (t_us - self.at_us) as f64 / US_PER_S;
            self.value += self.stream.normals() * elapsed_s.sqrt();
            self.at_us = t_us;
        }
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `Var[W(t) - W(s)] = t - s`, increments independent of what was, in steps long or short; within five
    /// standard deviations.
    #[test]
    fn closed_form_a_walk_s_increments_have_the_variance_of_their_time() {
        let n = 3_000;
        let (from_us, to_us) = (1_000_000, 3_500_000);
        let mut sums = [0.0; 3];
        for seed in 0..n {
            let mut walk = Walk::<1>::new(Stream::new(seed, crate::random::Purpose::Dice, 5));
            assert_eq!(walk.at(0).x, 0.0);
            (0..250).for_each(|i| _ = walk.at(i * 4_000));
            let start = walk.at(from_us).x;
            let step = walk.at(to_us).x - start;
            assert_eq!(walk.at(to_us), walk.at(from_us));
            sums[0] += start * start;
            sums[1] += step * step / 2.5;
            sums[2] += start * step / 2.5f64.sqrt();
        }
        let bound = 5.0 / (n as f64).sqrt();
        let [before, after, together] = sums.map(|sum| sum / n as f64);
        assert!((before - 1.0).abs() < bound * 2f64.sqrt(), "{before}");
        assert!((after - 1.0).abs() < bound * 2f64.sqrt(), "{after}");
        assert!(together.abs() < bound, "{together}");
    }
}
