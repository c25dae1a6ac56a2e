//! The filters of PX4 that matter to its loops.

use crate::math;
use nalgebra::Vector3;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Second-order Butterworth low pass by the bilinear transform (`math::LowPassFilter2p`), three axes. A
/// cutoff of nothing or at half the sampling rate and beyond filters nothing, as there.
#[derive(Clone, Debug)]
pub struct LowPass2 {
    b0: f64,
    a1: f64,
    a2: f64,
    delay: Option<[Vector3<f64>; 2]>,
}

/// PX4 takes no lower cutoff [Hz].
const LEAST_CUTOFF_HZ: f64 = 5.0;

impl LowPass2 {
    /// For a sampling rate and a cutoff [Hz].
    pub fn new(sampling_hz: f64, cutoff_hz: f64) -> Self {
        if !(cutoff_hz > 0.0 && sampling_hz > 0.0 && cutoff_hz < 0.5 * sampling_hz) {
            return Self { b0: 1.0, a1: 0.0, a2: 0.0, delay: None };
        }
        let ohm = math::tan(PI * cutoff_hz.max(LEAST_CUTOFF_HZ) / sampling_hz);
        let damping = 2.0 * FRAC_1_SQRT_2 * ohm;
        let c = 1.0 + damping + ohm * ohm;
        Self {
            b0: ohm * ohm / c,
            a1: 2.0 * (ohm * ohm - 1.0) / c,
            a2: (1.0 - damping + ohm * ohm) / c,
            delay: None,
        }
    }

    /// The next sample; the first one is taken as having been there for ever.
    pub fn apply(&mut self, sample: Vector3<f64>) -> Vector3<f64> {
        let passes = self.a1 == 0.0 && self.a2 == 0.0;
        if passes {
            return sample;
        }
        let [d1, d2] = self.delay.unwrap_or_else(|| [sample / (1.0 + self.a1 + self.a2); 2]);
        let d0 = sample - d1 * self.a1 - d2 * self.a2;
        self.delay = Some([d0, d1]);
        (d0 + d1 * 2.0 + d2) * self.b0
    }
}

/// First-order low pass (`AlphaFilter`). A cutoff of nothing filters nothing.
#[derive(Clone, Copy, Debug)]
pub struct LowPass1 {
    alpha: f64,
}

impl LowPass1 {
    /// For a sampling rate and a cutoff [Hz].
    pub fn new(sampling_hz: f64, cutoff_hz: f64) -> Self {
        let b = 2.0 * PI * cutoff_hz / sampling_hz;
        Self { alpha: if cutoff_hz > 0.0 { b / (1.0 + b) } else { 1.0 } }
    }

    /// What becomes of a filtered value with the next sample.
    pub fn apply(&self, filtered: f64, sample: f64) -> f64 {
        filtered + self.alpha * (sample - filtered)
    }
}

/// Differences of a vector through a first-order low pass (`control::BlockDerivative`).
#[derive(Clone, Debug, Default)]
pub struct Derivative {
    before: Option<Vector3<f64>>,
    slope: Vector3<f64>,
}

impl Derivative {
    /// The slope after the next sample, `dt_s` after the last one.
    pub fn update(&mut self, sample: Vector3<f64>, cutoff_hz: f64, dt_s: f64) -> Vector3<f64> {
        if let Some(before) = self.before {
            let b = 2.0 * PI * cutoff_hz * dt_s;
            let a = b / (1.0 + b);
            self.slope += ((sample - before) / dt_s - self.slope) * a;
        }
        self.before = Some(sample);
        self.slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: at its cutoff a Butterworth filter passes 1/sqrt(2), far below it everything.
    #[test]
    fn closed_form_half_the_power_passes_at_the_cutoff() {
        for (frequency_hz, expected) in [(40.0, FRAC_1_SQRT_2), (0.5, 1.0)] {
            let mut filter = LowPass2::new(250.0, 40.0);
            let power = (0..5000)
                .map(|i| {
                    filter.apply(Vector3::x() * math::sin(2.0 * PI * frequency_hz * f64::from(i) / 250.0)).x
                })
                .skip(2500)
                .map(|y| y * y / 2500.0)
                .sum::<f64>();
            assert!(((2.0 * power).sqrt() - expected).abs() < 2e-3, "{frequency_hz} Hz: {power}");
        }
        let mut none = LowPass2::new(250.0, 200.0);
        assert_eq!(none.apply(Vector3::y()), Vector3::y());
    }

    /// Closed form: the slope of a ramp is found with the filter's time constant.
    #[test]
    fn closed_form_the_slope_of_a_ramp() {
        let mut derivative = Derivative::default();
        let ramp = (0..200).map(|i| Vector3::z() * (3.0 * 0.01 * f64::from(i)));
        let slope = ramp.map(|sample| derivative.update(sample, 5.0, 0.01)).last().unwrap();
        assert!((slope - Vector3::z() * 3.0).norm() < 1e-9);
    }
}
