//! A barometer: PX4's atmosphere, with noise and a drift.
//!
//! `p = 1013.25 (1 - 2.25577e-5 h)^5.25588` hPa is what PX4 inverts for an altitude, whatever air a mission
//! has: the US Standard Atmosphere 1976 with the altitude for the geopotential one, 0.2 hPa off at 4 km. A
//! sensor that repeats a pressure bit by bit is taken for dead there: by default the noise is small but not
//! zero.

use super::noise::Walk;
use crate::math;
use crate::random::{Purpose, Stream};

/// Rate and errors of a barometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barometer {
    /// Time between readings [us]; 0: one at each step.
    pub period_us: u64,
    /// Standard deviation of a reading's noise [hPa].
    pub noise_hpa: f64,
    /// Random walk of the bias [hPa/sqrt(s)].
    pub drift_hpa_per_sqrt_s: f64,
}

impl Default for Barometer {
    /// A reading at each step; no drift, and noise of 0.01 hPa, about 8 cm.
    fn default() -> Self {
        Self { period_us: 0, noise_hpa: 0.01, drift_hpa_per_sqrt_s: 0.0 }
    }
}

/// A barometer in operation, with the present state of its errors.
#[derive(Clone, Debug)]
pub struct BarometerSensor {
    barometer: Barometer,
    drift: Walk<1>,
    white: Stream,
}

impl BarometerSensor {
    /// Starts a barometer; `seed` draws its errors.
    pub fn new(barometer: Barometer, seed: u64) -> Self {
        let [white, drift] =
            [Purpose::BarometerNoise, Purpose::BarometerDrift].map(|error| Stream::new(seed, error, 0));
        Self { barometer, drift: Walk::new(drift), white }
    }

    /// A reading of the pressure [hPa] at an altitude [m]; each reading has a noise of its own.
    pub fn read(&mut self, altitude_m: f64, t_us: u64) -> f64 {
        let mut reading = pressure_hpa(altitude_m);
        if self.barometer.noise_hpa > 0.0 {
            reading += self.barometer.noise_hpa * self.white.normal();
        }
        if self.barometer.drift_hpa_per_sqrt_s > 0.0 {
            reading += self.barometer.drift_hpa_per_sqrt_s * self.drift.at(t_us).x;
        }
        reading
    }
}

/// The pressure [hPa] from which PX4 recovers an altitude [m].
pub fn pressure_hpa(altitude_m: f64) -> f64 {
    1013.25 * math::powf((1.0 - 2.25577e-5 * altitude_m).max(0.0), 5.25588)
}

/// Altitude [m] that PX4 recovers from a pressure [hPa]: the inverse of [`pressure_hpa`].
pub fn pressure_altitude_m(pressure_hpa: f64) -> f64 {
    (1.0 - math::powf(pressure_hpa.max(0.0) / 1013.25, 1.0 / 5.25588)) / 2.25577e-5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Atmosphere;

    /// Below 4 km.
    #[test]
    fn reference_the_sensors_air_is_nearly_the_standard_atmosphere() {
        for altitude_m in (0..=8).map(|k| 500.0 * f64::from(k)) {
            let standard_hpa = 0.01 * Atmosphere::Us1976.at(altitude_m).unwrap().pressure_pa;
            assert!((pressure_hpa(altitude_m) - standard_hpa).abs() < 0.25, "{altitude_m} m: {standard_hpa}");
        }
    }

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
        let silent = Barometer { period_us: 0, noise_hpa: 0.0, drift_hpa_per_sqrt_s: 0.0 };
        let truth = pressure_hpa(500.0);
        assert_eq!(BarometerSensor::new(silent, 1).read(500.0, 4_000).to_bits(), truth.to_bits());
        let n = 3_000u64;
        let deviation = |errors: &mut dyn Iterator<Item = f64>| {
            (errors.map(|reading| (reading - truth).powi(2)).sum::<f64>() / n as f64).sqrt()
        };
        let bound = 5.0 / (2.0 * n as f64).sqrt();
        let mut noisy = BarometerSensor::new(Barometer { noise_hpa: 0.03, ..silent }, 1);
        let noisy = deviation(&mut (0..n).map(|i| noisy.read(500.0, i * 4_000)));
        assert!((noisy / 0.03 - 1.0).abs() < bound, "{noisy}");
        // After 25 s, over seeds: 5 times the drift of a second.
        let drifting = Barometer { drift_hpa_per_sqrt_s: 0.002, ..silent };
        let after_25_s = |seed| BarometerSensor::new(drifting, seed).read(500.0, 25_000_000);
        let drifted = deviation(&mut (0..n).map(after_25_s));
        assert!((drifted / 0.01 - 1.0).abs() < bound, "{drifted}");
    }
}
