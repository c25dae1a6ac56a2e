//! Accelerometer and gyroscope: three axes with the same errors,
//!
//! `y = clip(quantise(x + b_0 + K W(t) + N / sqrt(dt) n))`,
//!
//! with the turn-on bias `b_0`, drawn once per axis, the bias's random walk `W` (variance 1 per second) and a
//! white normal `n`. `N` is the noise density of Allan's deviation `sigma(tau) = N / sqrt(tau)`, `K` the
//! coefficient of its rise `K sqrt(tau / 3)`.

use nalgebra::Vector3;

use super::noise::Walk;
use crate::random::{Purpose, Stream};
use crate::units::US_PER_S;

/// A reading lies so much beyond its whole step: PX4's simulation cuts what it gets to whole steps of 16 bits
/// (SimulatorMavlink.cpp: `sensors.xacc / ACCEL_FIFO_SCALE` becomes an integer), and of what lies on them to
/// within a rounding error about every second one would lose a step, 0.005 m/s^2 and 0.001 rad/s.
const BEYOND: f64 = 1.0 + 1e-6;

/// Errors of a triad of sensors, in the unit u of what they measure (m/s^2, rad/s). All zero: the truth to
/// the bit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Triad {
    /// Noise density N [u/sqrt(Hz)].
    pub noise_density: f64,
    /// Random walk of the bias, K [u/sqrt(s)].
    pub walk: f64,
    /// Standard deviation of the bias at turn-on [u].
    pub turn_on_bias: f64,
    /// Smallest step of the reading [u]; 0: continuous.
    pub resolution: f64,
    /// Greatest reading, either way [u]; `None`: unlimited.
    pub range: Option<f64>,
}

/// A triad in operation, with the present state of its errors.
#[derive(Clone, Debug)]
pub struct TriadSensor {
    triad: Triad,
    /// Standard deviation of the white noise of a reading [u].
    deviation: f64,
    turn_on_bias: Vector3<f64>,
    walk: Walk<3>,
    white: Stream,
}

impl TriadSensor {
    /// Starts a triad that is read once in every `period_us`; `seed` draws its turn-on bias, random walk and
    /// white noise for these purposes.
    pub fn new(triad: Triad, seed: u64, errors: [Purpose; 3], period_us: u64) -> Self {
        let [mut bias, walk, white] = errors.map(|error| Stream::new(seed, error, 0));
        Self {
            triad,
            deviation: triad.noise_density / (period_us as f64 / US_PER_S).sqrt(),
            turn_on_bias: bias.normals() * triad.turn_on_bias,
            walk: Walk::new(walk),
            white,
        }
    }

    /// A reading of `truth` at a time; each reading has a noise of its own.
    pub fn read(&mut self, truth: Vector3<f64>, t_us: u64) -> Vector3<f64> {
        let triad = &self.triad;
        let mut reading = truth;
        // What is off is left out: adding a zero would turn -0 into 0.
        if triad.turn_on_bias > 0.0 {
            reading += self.turn_on_bias;
        }
        if triad.walk > 0.0 {
            reading += self.walk.at(t_us) * triad.walk;
        }
        if triad.noise_density > 0.0 {
            reading += self.white.normals() * self.deviation;
        }
        if triad.resolution > 0.0 {
            reading = reading.map(|x| (x / triad.resolution).round() * triad.resolution * BEYOND);
        }
        if let Some(range) = triad.range {
            reading = reading.map(|x| x.clamp(-range, range));
        }
        reading
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT_US: u64 = 4_000;
    const DT_S: f64 = 0.004;
    const ERRORS: [Purpose; 3] = [Purpose::GyroscopeBias, Purpose::GyroscopeWalk, Purpose::GyroscopeNoise];

    fn readings(triad: &Triad, truth: Vector3<f64>, n: u64) -> Vec<Vector3<f64>> {
        let mut sensor = TriadSensor::new(*triad, 3, ERRORS, DT_US);
        (1..=n).map(|i| sensor.read(truth, i * DT_US)).collect()
    }

    /// Allan's variance over `m` samples: half the mean square of the differences of neighbouring means.
    fn allan_variance(x: &[Vector3<f64>], m: usize) -> f64 {
        let means: Vec<Vector3<f64>> =
            x.chunks_exact(m).map(|c| c.iter().sum::<Vector3<f64>>() / m as f64).collect();
        means.windows(2).map(|w| (w[1] - w[0]).norm_squared()).sum::<f64>() / (6.0 * (means.len() - 1) as f64)
    }

    /// `sigma^2(tau) = N^2 / tau` for white noise; with p pairs of three axes the estimate scatters by about
    /// sqrt(3 / (3 p)).
    #[test]
    fn closed_form_allan_variance_of_white_noise_falls_with_time() {
        let triad = Triad { noise_density: 0.01, ..Triad::default() };
        let x = readings(&triad, Vector3::zeros(), 50_000);
        for m in [1, 10, 100] {
            let expected = 0.01f64.powi(2) / (m as f64 * DT_S);
            let bound = 5.0 / (50_000.0 / m as f64).sqrt();
            let ratio = allan_variance(&x, m) / expected;
            assert!((ratio - 1.0).abs() < bound, "{m}: {ratio}");
        }
    }

    /// `sigma^2(tau) = K^2 tau / 3` for a random walk, at many samples to the mean.
    #[test]
    fn closed_form_allan_variance_of_a_walk_rises_with_time() {
        let triad = Triad { walk: 0.02, ..Triad::default() };
        let x = readings(&triad, Vector3::zeros(), 50_000);
        for m in [25, 100] {
            let expected = 0.02f64.powi(2) * m as f64 * DT_S / 3.0;
            let bound = 5.0 / (50_000.0 / m as f64).sqrt();
            let ratio = allan_variance(&x, m) / expected;
            assert!((ratio - 1.0).abs() < bound, "{m}: {ratio}");
        }
    }

    #[test]
    fn closed_form_a_turn_on_bias_is_constant_and_has_its_deviation_over_seeds() {
        let triad = Triad { turn_on_bias: 0.1, ..Triad::default() };
        let truth = Vector3::new(1.0, -2.0, -9.8);
        assert!(readings(&triad, truth, 100).windows(2).all(|w| w[0] == w[1]));
        let n = 2_000;
        let square = |seed| {
            TriadSensor::new(triad, seed, ERRORS, DT_US).read(Vector3::zeros(), 0).norm_squared() / 3.0
        };
        let deviation = ((0..n).map(square).sum::<f64>() / n as f64).sqrt();
        assert!((deviation / 0.1 - 1.0).abs() < 5.0 / (2.0 * 3.0 * n as f64).sqrt(), "{deviation}");
    }

    #[test]
    fn closed_form_readings_are_whole_steps_within_the_range() {
        let step = 9.80665 / 2048.0;
        let triad =
            Triad { noise_density: 0.5, resolution: step, range: Some(16.0 * 9.80665), ..Triad::default() };
        for x in readings(&triad, Vector3::new(0.0, 200.0, -9.8), 500) {
            let steps = x / step;
            assert!(steps.iter().all(|n| (n - n.round()).abs() < 1.1e-6 * n.abs() + 1e-9), "{x:?}");
            assert!((x.y - 16.0 * 9.80665).abs() < 1e-9 && x.y > 150.0);
        }
        // Half a step either way, no more.
        let fine = Triad { resolution: step, ..Triad::default() };
        let truth = Vector3::new(0.1234, -5.4321, 3.0);
        let off = readings(&fine, truth, 1)[0] - truth;
        assert!(off.amax() <= step / 2.0 && off.amax() > 0.0);
    }

    /// PX4's own lines, of v1.12 to v1.18: what was measured comes out, whatever single precision does to it.
    #[test]
    fn closed_form_px4_cuts_no_step_off() {
        let force_step = 9.80665f32 / 2048.0;
        let rate_step = (2000.0f32 / 32768.0).to_radians();
        for (resolution, px4_step) in [(0.004788403, force_step), (0.001065264, rate_step)] {
            let triad = Triad { resolution, ..Triad::default() };
            let mut sensor = TriadSensor::new(triad, 3, ERRORS, DT_US);
            for steps in -32_700..32_700 {
                let x = sensor.read(Vector3::repeat(f64::from(steps) * resolution), 0).x;
                assert_eq!((x as f32 / px4_step) as i16, steps as i16, "{x}");
            }
        }
    }

    /// To the bit: also a zero's sign.
    #[test]
    fn closed_form_without_errors_the_truth_is_read() {
        let truth = Vector3::new(-0.0, 1e-300, 0.1 + 0.2);
        let read = readings(&Triad::default(), truth, 1)[0];
        assert_eq!(read.map(f64::to_bits), truth.map(f64::to_bits));
    }
}
