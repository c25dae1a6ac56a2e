//! Discrete gusts: air that moves for a while, or from some time on, besides the mean wind.

use crate::math;

/// A discrete gust.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gust {
    /// Velocity along the gust, as a share of the peak.
    pub shape: GustShape,
    /// Beginning of the gust, from t = 0 [s].
    pub start_s: f64,
    /// Extent of the gust.
    pub length: GustLength,
    /// Largest velocity of the air, NED [m/s].
    pub peak_ned_m_s: [f64; 3],
}

/// Extent of a gust: of the whole of it, or, where it stays, of its rise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GustLength {
    /// Time that it lasts [s]; may be infinite for a step.
    Time(f64),
    /// Distance that the vehicle flies through the air in it [m].
    Distance(f64),
}

/// Velocity along a gust.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GustShape {
    /// At its peak from beginning to end.
    Step,
    /// `(1 - cos(2 pi x))/2` of the peak over its length, back to zero: the discrete gust of airworthiness
    /// codes (EASA CS-25.341, 14 CFR 25.341, whose gradient H is half the length).
    OneMinusCosine,
    /// `(1 - cos(pi x))/2` of the peak over its length, and the peak from there on: the discrete gust of
    /// MIL-F-8785C, 3.7.1.3, whose d_m is the length.
    Rise,
}

impl Gust {
    /// Velocity of the gust, NED [m/s], `t_s` from t = 0, where the vehicle has flown `distance_m` through
    /// the air since the gust began.
    pub fn at(&self, t_s: f64, distance_m: f64) -> [f64; 3] {
        let t = t_s - self.start_s;
        let x = match self.length {
            GustLength::Time(length_s) => t / length_s,
            GustLength::Distance(length_m) => distance_m / length_m,
        };
        let share = match self.shape {
            _ if !(t >= 0.0) => return [0.0; 3],
            GustShape::Rise if x < 1.0 => 0.5 * (1.0 - math::cos(std::f64::consts::PI * x)),
            GustShape::Rise => 1.0,
            _ if !(x < 1.0) => return [0.0; 3],
            GustShape::Step => 1.0,
            GustShape::OneMinusCosine => 0.5 * (1.0 - math::cos(std::f64::consts::TAU * x)),
        };
        self.peak_ned_m_s.map(|v| share * v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PEAK: [f64; 3] = [3.0, 0.5, -1.0];

    fn gust(shape: GustShape, length: GustLength) -> Gust {
        Gust { shape, start_s: 2.0, length, peak_ned_m_s: PEAK }
    }

    fn share(gust: &Gust, t_s: f64, distance_m: f64) -> f64 {
        let v = gust.at(t_s, distance_m);
        for i in 1..3 {
            assert!((v[i] * PEAK[0] - v[0] * PEAK[i]).abs() < 1e-15, "along the peak");
        }
        v[0] / PEAK[0]
    }

    /// 14 CFR 25.341: `(1 - cos(pi s/H))/2` from 0 to 2 H. MIL-F-8785C, figure 8: 0 before, the rise over
    /// d_m, the peak beyond.
    #[test]
    fn closed_form_shapes_of_the_codes() {
        let (there_and_back, rise) = (GustShape::OneMinusCosine, GustShape::Rise);
        for (length, t_of, x_of) in [
            (GustLength::Time(4.0), 4.0, 0.0),
            // The distance counts, whatever the time.
            (GustLength::Distance(20.0), 0.7, 20.0),
        ] {
            let at = |shape, x: f64| share(&gust(shape, length), 2.0 + x * t_of, x * x_of);
            for (x, codes, milspec) in [
                (0.0, 0.0, 0.0),
                (0.25, 0.5, 0.5 - 0.125f64.sqrt()),
                (0.5, 1.0, 0.5),
                (0.75, 0.5, 0.5 + 0.125f64.sqrt()),
                (1.0, 0.0, 1.0),
                (9.0, 0.0, 1.0),
            ] {
                assert!((at(there_and_back, x) - codes).abs() < 1e-15, "{length:?} {x}");
                assert!((at(rise, x) - milspec).abs() < 1e-15, "{length:?} {x}");
                assert_eq!(at(GustShape::Step, x), if x < 1.0 { 1.0 } else { 0.0 });
            }
        }
        for shape in [there_and_back, rise, GustShape::Step] {
            assert_eq!(share(&gust(shape, GustLength::Time(4.0)), 1.999, 0.0), 0.0);
            assert_eq!(share(&gust(shape, GustLength::Time(4.0)), f64::NAN, 0.0), 0.0);
        }
    }
}
