//! Gusts: wind that changes over time.

use crate::math;

/// A gust in the vertical plane to the north: air that moves for a while, besides the steady wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gust {
    /// Velocity over time, as a share of the peak.
    pub shape: GustShape,
    /// Beginning of the gust, from t = 0 [s].
    pub start_s: f64,
    /// Duration of the gust [s]; may be infinite for a step.
    pub length_s: f64,
    /// Largest velocity of the air, north and down [m/s].
    pub peak_m_s: [f64; 2],
}

/// Velocity of a gust over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GustShape {
    /// At its peak from beginning to end.
    Step,
    /// `(1 - cos(2 pi t/length))/2` of the peak, the discrete gust of airworthiness codes (EASA CS-25.341).
    OneMinusCosine,
}

impl Gust {
    /// Velocity of the gust at `t_s`, north and down [m/s].
    pub fn at(&self, t_s: f64) -> [f64; 2] {
        let t = t_s - self.start_s;
        if !(t >= 0.0 && t < self.length_s) {
            return [0.0; 2];
        }
        let share = match self.shape {
            GustShape::Step => 1.0,
            GustShape::OneMinusCosine => 0.5 * (1.0 - math::cos(std::f64::consts::TAU * t / self.length_s)),
        };
        self.peak_m_s.map(|v| share * v)
    }
}
