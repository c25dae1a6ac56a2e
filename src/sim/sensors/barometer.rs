//! A barometer: PX4's atmosphere, with noise and a drift.
//!
//! `p = 1013.25 (1 - 2.25577e-5 h)^5.25588` hPa is what PX4 inverts for an altitude, whatever air a mission has. A pressure that
//! repeats itself bit by bit is taken for dead there: the noise is small where nothing is said, but not zero.

use super::Noise;

/// Errors of a barometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barometer {
    /// Standard deviation of a reading's noise [hPa].
    pub noise_hpa: f64,
    /// Random walk of its bias [hPa/sqrt(s)].
    pub drift_hpa_per_sqrt_s: f64,
}

impl Default for Barometer {
    /// No drift, and noise of 0.01 hPa, about 8 cm.
    fn default() -> Self {
        Self { noise_hpa: 0.01, drift_hpa_per_sqrt_s: 0.0 }
    }
}

impl Barometer {
    /// The pressure [hPa] that is read at an altitude [m], once every `period_us`. Draws from the streams `noise_stream` and `drift_stream`.
    pub fn read(
        &self,
        altitude_m: f64,
        noise: &mut Noise,
        [noise_stream, drift_stream]: [u64; 2],
        t_us: u64,
        period_us: u64,
    ) -> f64 {
        let mut reading = pressure_hpa(altitude_m);
        if self.noise_hpa > 0.0 {
            reading += self.noise_hpa * noise.normal(noise_stream, t_us);
        }
        if self.drift_hpa_per_sqrt_s > 0.0 {
            reading += self.drift_hpa_per_sqrt_s
                * noise.walk(drift_stream, t_us / period_us, period_us as f64 * 1e-6).x;
        }
        reading
    }
}

/// The pressure [hPa] from which PX4 recovers an altitude [m].
pub fn pressure_hpa(altitude_m: f64) -> f64 {
    1013.25 * (1.0 - 2.25577e-5 * altitude_m).max(0.0).powf(5.25588)
}

/// The inverse of [`pressure_hpa`].
pub fn pressure_altitude_m(pressure_hpa: f64) -> f64 {
    (1.0 - (pressure_hpa.max(0.0) / 1013.25).powf(1.0 / 5.25588)) / 2.25577e-5
}

#[cfg(test)]
mod tests {
    use super::*;

    /// US standard atmosphere, as the formula is meant: 954.61 hPa at 500 m, 898.76 at 1000 m.
    #[test]
    fn reference_pressure_is_the_standard_atmospheres() {
        for (h, p) in [(0.0, 1013.25), (500.0, 954.61), (1000.0, 898.76)] {
            assert!((pressure_hpa(h) - p).abs() < 0.02, "{h} m: {}", pressure_hpa(h));
            assert!((pressure_altitude_m(pressure_hpa(h)) - h).abs() < 1e-9);
        }
        assert_eq!(pressure_hpa(1e6), 0.0);
    }

    #[test]
    fn closed_form_noise_and_drift_have_their_deviations_and_zero_is_the_truth() {
        let silent = Barometer { noise_hpa: 0.0, drift_hpa_per_sqrt_s: 0.0 };
        assert_eq!(
            silent.read(500.0, &mut Noise::new(1), [0, 1], 4_000, 4_000).to_bits(),
            pressure_hpa(500.0).to_bits()
        );
        let n = 3_000u64;
        let deviation = |b: Barometer, at: &dyn Fn(u64) -> (u64, u64)| {
            let square = |i| {
                let (seed, t_us) = at(i);
                (b.read(500.0, &mut Noise::new(seed), [0, 1], t_us, 4_000) - pressure_hpa(500.0)).powi(2)
            };
            ((0..n).map(square).sum::<f64>() / n as f64).sqrt()
        };
        let bound = 5.0 / (2.0 * n as f64).sqrt();
        let noisy = deviation(Barometer { noise_hpa: 0.03, ..silent }, &|i| (1, i * 4_000));
        assert!((noisy / 0.03 - 1.0).abs() < bound, "{noisy}");
        // After 25 s, over seeds: 5 times the drift of a second.
        let drifted = deviation(Barometer { drift_hpa_per_sqrt_s: 0.002, ..silent }, &|i| (i, 25_000_000));
        assert!((drifted / 0.01 - 1.0).abs() < bound, "{drifted}");
    }
}
