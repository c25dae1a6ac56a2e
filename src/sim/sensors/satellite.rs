//! A satellite receiver: position and velocity as they were a while ago, with white noise.
//!
//! The delay is that between the measurement and its message; the message bears the time of its sending, as a real receiver's
//! does, and an estimator is told the delay (PX4: EKF2_GPS_DELAY, 110 ms). It is a whole number of simulation steps.

use std::collections::VecDeque;

use nalgebra::Vector3;

use super::Noise;

/// Rate and errors of a satellite receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Satellite {
    /// Time between fixes [us].
    pub period_us: u64,
    /// Standard deviation of north and east, each [m].
    pub horizontal_noise_m: f64,
    /// Standard deviation of the altitude [m].
    pub vertical_noise_m: f64,
    /// Standard deviation of each component of the velocity [m/s].
    pub speed_noise_m_s: f64,
    /// Age of a fix when it is told [us].
    pub delay_us: u64,
}

impl Default for Satellite {
    /// 10 Hz, no errors, no delay.
    fn default() -> Self {
        Self {
            period_us: 100_000,
            horizontal_noise_m: 0.0,
            vertical_noise_m: 0.0,
            speed_noise_m_s: 0.0,
            delay_us: 0,
        }
    }
}

/// Position and velocity, NED [m, m/s].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Position in the local frame, NED [m].
    pub p_ned: Vector3<f64>,
    /// Velocity over ground, NED [m/s].
    pub v_ned: Vector3<f64>,
}

impl Satellite {
    /// The fix of a true position and velocity. Draws from two streams, `stream` the first.
    pub fn read(&self, truth: Fix, noise: &Noise, stream: u64, t_us: u64) -> Fix {
        let mut fix = truth;
        if self.horizontal_noise_m > 0.0 || self.vertical_noise_m > 0.0 {
            let n = noise.triple(stream, t_us);
            let deviation = [self.horizontal_noise_m, self.horizontal_noise_m, self.vertical_noise_m];
            for (axis, deviation_m) in deviation.into_iter().enumerate() {
                if deviation_m > 0.0 {
                    fix.p_ned[axis] += n[axis] * deviation_m;
                }
            }
        }
        if self.speed_noise_m_s > 0.0 {
            fix.v_ned += noise.triple(stream + 1, t_us) * self.speed_noise_m_s;
        }
        fix
    }
}

/// Where the vehicle has been, as far back as the delay asks.
#[derive(Clone, Debug, Default)]
pub struct Track {
    past: VecDeque<(u64, Fix)>,
}

impl Track {
    /// Notes the truth of a time, later than those noted before, and forgets what is older than needed for `delay_us` from then.
    pub fn note(&mut self, t_us: u64, truth: Fix, delay_us: u64) {
        self.past.push_back((t_us, truth));
        while self.past.get(1).is_some_and(|(second_us, _)| second_us.saturating_add(delay_us) <= t_us) {
            self.past.pop_front();
        }
    }

    /// The truth that was noted last up to a time; before the first, the first. `None`: nothing has been noted.
    pub fn at(&self, t_us: u64) -> Option<Fix> {
        let last = self.past.iter().rev().find(|(noted_us, _)| *noted_us <= t_us);
        last.or(self.past.front()).map(|(_, fix)| *fix)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fix(i: u64) -> Fix {
        Fix { p_ned: Vector3::new(i as f64, -0.0, 2.0), v_ned: Vector3::new(-0.0, i as f64, 5.0) }
    }

    /// Exactly n steps back, and no more is kept than that takes.
    #[test]
    fn closed_form_a_delay_is_exact_in_steps() {
        for steps in [0, 1, 27, 250] {
            let delay_us = steps * 4_000;
            let mut track = Track::default();
            assert_eq!(track.at(0), None);
            for i in 0..1_000u64 {
                track.note(i * 4_000, fix(i), delay_us);
                let seen = track.at((i * 4_000).saturating_sub(delay_us));
                assert_eq!(seen, Some(fix(i.saturating_sub(steps))), "{steps} {i}");
            }
            assert_eq!(track.past.len() as u64, steps + 1);
        }
    }

    #[test]
    fn closed_form_noise_has_its_deviations_and_none_leaves_the_truth() {
        let noise = Noise::new(1);
        let bits = |f: Fix| (f.p_ned.map(f64::to_bits), f.v_ned.map(f64::to_bits));
        assert_eq!(bits(Satellite::default().read(fix(3), &noise, 20, 7)), bits(fix(3)));
        let noisy = Satellite {
            horizontal_noise_m: 0.5,
            vertical_noise_m: 0.8,
            speed_noise_m_s: 0.1,
            ..Satellite::default()
        };
        let n = 3_000u64;
        let (mut p, mut v) = (Vector3::zeros(), Vector3::zeros());
        for i in 0..n {
            let read = noisy.read(fix(3), &noise, 20, i * 100_000);
            p += (read.p_ned - fix(3).p_ned).map(|x| x * x) / n as f64;
            v += (read.v_ned - fix(3).v_ned).map(|x| x * x) / n as f64;
        }
        let bound = 5.0 / (2.0 * n as f64).sqrt();
        for (square, deviation) in p.iter().chain(v.iter()).zip([0.5, 0.5, 0.8, 0.1, 0.1, 0.1]) {
            assert!((square.sqrt() / deviation - 1.0).abs() < bound, "{square} {deviation}");
        }
        // One by one: the altitude's noise alone leaves the rest as it is.
        let vertical = Satellite { vertical_noise_m: 0.8, ..Satellite::default() };
        let read = vertical.read(fix(3), &noise, 20, 7);
        assert_eq!((read.p_ned.xy(), read.v_ned), (fix(3).p_ned.xy(), fix(3).v_ned));
        assert_ne!(read.p_ned.z, 2.0);
    }
}
