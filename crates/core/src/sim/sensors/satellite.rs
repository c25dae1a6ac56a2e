//! A satellite receiver: position and velocity as they were a while ago, with white noise.
//!
//! The delay is that between the measurement and its message; the message bears the time of its sending, as a
//! real receiver's does, and an estimator gets the delay as a parameter (PX4: EKF2_GPS_DELAY, 110 ms). It is
//! a whole number of simulation steps.

use std::collections::VecDeque;

use nalgebra::Vector3;

use crate::model::rigid_body::BodyState;
use crate::random::{Purpose, Stream};

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
    /// Age of a fix when it is reported [us].
    pub delay_us: u64,
}

impl Default for Satellite {
    /// A receiver with 10 Hz, without errors or delay.
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

/// Accuracy of a fix that is reported at the least [m], horizontal and vertical: nobody believes a receiver
/// without errors.
const LEAST_ACCURACY_M: [f64; 2] = [0.9, 1.2];

impl Satellite {
    /// Accuracy that is reported with a fix [m], horizontal and vertical.
    pub fn reported_accuracy_m(&self) -> [f64; 2] {
        let [horizontal_m, vertical_m] = LEAST_ACCURACY_M;
        [self.horizontal_noise_m.max(horizontal_m), self.vertical_noise_m.max(vertical_m)]
    }
}

/// Position and velocity that a receiver reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Position in the local frame, NED [m].
    pub p_ned: Vector3<f64>,
    /// Velocity over ground, NED [m/s].
    pub v_ned: Vector3<f64>,
}

impl Fix {
    fn of(body: &BodyState) -> Self {
        Self { p_ned: body.p_ned, v_ned: body.v_ned }
    }
}

/// A satellite receiver in operation, with the recent truth.
#[derive(Clone, Debug)]
pub struct Receiver {
    satellite: Satellite,
    /// In whole steps.
    delay_us: u64,
    track: Track,
    position: Stream,
    velocity: Stream,
}

impl Receiver {
    /// Starts a receiver in steps of `step_us`; `seed` draws its noise.
    pub fn new(satellite: Satellite, seed: u64, step_us: u64) -> Self {
        let [position, velocity] =
            [Purpose::SatellitePosition, Purpose::SatelliteVelocity].map(|error| Stream::new(seed, error, 0));
        let delay_us = (satellite.delay_us + step_us / 2) / step_us * step_us;
        Self { satellite, delay_us, track: Track::default(), position, velocity }
    }

    /// Records the truth at a time, later than those before, and forgets what is older than needed for
    /// `delay_us`.
    pub fn note(&mut self, t_us: u64, body: &BodyState) {
        if self.delay_us > 0 {
            self.track.note(t_us, Fix::of(body), self.delay_us);
        }
    }

    /// The fix that is reported at a time: the truth of the delay before, if that was [recorded](Self::note),
    /// else of `body`; each fix has a noise of its own.
    pub fn read(&mut self, body: &BodyState, t_us: u64) -> Fix {
        let Satellite { horizontal_noise_m, vertical_noise_m, speed_noise_m_s, .. } = self.satellite;
        let mut fix = self.track.at(t_us.saturating_sub(self.delay_us)).unwrap_or_else(|| Fix::of(body));
        if horizontal_noise_m > 0.0 || vertical_noise_m > 0.0 {
            let n = self.position.normals::<3>();
            // What is off is left out: adding a zero would turn -0 into 0.
            for (axis, deviation_m) in
                [horizontal_noise_m, horizontal_noise_m, vertical_noise_m].into_iter().enumerate()
            {
                if deviation_m > 0.0 {
                    fix.p_ned[axis] += n[axis] * deviation_m;
                }
            }
        }
        if speed_noise_m_s > 0.0 {
            fix.v_ned += self.velocity.normals::<3>() * speed_noise_m_s;
        }
        fix
    }
}

/// The true positions and velocities, as far back as the delay needs.
#[derive(Clone, Debug, Default)]
struct Track {
    past: VecDeque<(u64, Fix)>,
}

impl Track {
    /// Notes the truth of a time, later than those noted before, and forgets what is older than needed for
    /// `delay_us` from then.
    fn note(&mut self, t_us: u64, truth: Fix, delay_us: u64) {
        self.past.push_back((t_us, truth));
        while self.past.get(1).is_some_and(|(second_us, _)| second_us.saturating_add(delay_us) <= t_us) {
            self.past.pop_front();
        }
    }

    /// The truth that was recorded last up to a time; before the first, the first. `None`: nothing has been
    /// recorded.
    fn at(&self, t_us: u64) -> Option<Fix> {
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
        let body = BodyState {
            p_ned: fix(3).p_ned,
            v_ned: fix(3).v_ned,
            q_ned_from_body: [1.0, 0.0, 0.0, 0.0],
            omega_body: Vector3::zeros(),
        };
        let receiver = |satellite| Receiver::new(satellite, 1, 4_000);
        let bits = |f: Fix| (f.p_ned.map(f64::to_bits), f.v_ned.map(f64::to_bits));
        assert_eq!(bits(receiver(Satellite::default()).read(&body, 7)), bits(fix(3)));
        let mut noisy = receiver(Satellite {
            horizontal_noise_m: 0.5,
            vertical_noise_m: 0.8,
            speed_noise_m_s: 0.1,
            ..Satellite::default()
        });
        let n = 3_000u64;
        let (mut p, mut v) = (Vector3::zeros(), Vector3::zeros());
        for i in 0..n {
            let read = noisy.read(&body, i * 100_000);
            p += (read.p_ned - fix(3).p_ned).map(|x| x * x) / n as f64;
            v += (read.v_ned - fix(3).v_ned).map(|x| x * x) / n as f64;
        }
        let bound = 5.0 / (2.0 * n as f64).sqrt();
        for (square, deviation) in p.iter().chain(v.iter()).zip([0.5, 0.5, 0.8, 0.1, 0.1, 0.1]) {
            assert!((square.sqrt() / deviation - 1.0).abs() < bound, "{square} {deviation}");
        }
        // One by one: the altitude's noise alone leaves the rest as it is.
        let read = receiver(Satellite { vertical_noise_m: 0.8, ..Satellite::default() }).read(&body, 7);
        assert_eq!((read.p_ned.xy(), read.v_ned), (fix(3).p_ned.xy(), fix(3).v_ned));
        assert_ne!(read.p_ned.z, 2.0);
    }
}
