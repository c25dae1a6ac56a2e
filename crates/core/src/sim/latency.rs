//! The way of a throttle command from the measurement that it was made of to the speed controller that acts
//! on it, which takes a time.
//!
//! Commands are held for a control period, and so arrive in pieces: what acts in a step is the mean of what
//! arrives in it, which for motors that are slow beside a step is the same. `vehicle.latency_s` is the time;
//! without one nothing is done here.

use std::collections::VecDeque;

use crate::model::MAX_ROTORS;
use crate::real::Real;
#[cfg(target_arch = "x86_64")]
use crate::simd::lanes::{LANES, Lanes};

/// Commands on their way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Latency<S> {
    latency_s: S,
    longest_s: f64,
    /// Commands with the time for which each is given [s], the newest last.
    given: VecDeque<([S; MAX_ROTORS], f64)>,
}

impl Latency<f64> {
    /// A way that takes this time [s], on which nothing is.
    pub(super) fn of(latency_s: f64) -> Self {
        Self { latency_s, longest_s: latency_s, given: VecDeque::new() }
    }

    /// The time that it takes [s].
    pub(super) fn latency_s(&self) -> f64 {
        self.latency_s
    }
}

#[cfg(target_arch = "x86_64")]
impl Latency<Lanes> {
    /// Ways side by side that take these times [s], on which nothing is; a number of their kind is given.
    pub(super) fn abreast(latency_s: [f64; LANES], kind: Lanes) -> Self {
        let mut all = kind;
        *all.as_array_mut() = latency_s;
        Self { latency_s: all, longest_s: latency_s.into_iter().fold(0.0, f64::max), given: VecDeque::new() }
    }
}

impl<S: Real> Latency<S> {
    /// The mean of the commands that arrive in the `dt_s` [s] for which this one is given; zero before the
    /// first has arrived.
    #[inline(always)]
    pub(super) fn arriving(&mut self, command: &[S; MAX_ROTORS], dt_s: f64) -> [S; MAX_ROTORS] {
        if !(self.longest_s > 0.0) {
            return *command;
        }
        self.given.push_back((*command, dt_s));
        let (zero, step_s) = (command[0].of(0.0), command[0].of(dt_s));
        let mut mean = [zero; MAX_ROTORS];
        // Times from now on at which a command was given until, and the latest at which one may still arrive.
        let (mut given_until_s, mut arrived) = (dt_s, 0);
        for (given, lasts_s) in self.given.iter().rev() {
            let given_from_s = given_until_s - lasts_s;
            if given_until_s + self.longest_s <= 0.0 {
                arrived += 1;
            } else {
                let begins_s = (self.latency_s + zero.of(given_from_s)).at_least(zero);
                let ends_s = (self.latency_s + zero.of(given_until_s)).at_most(step_s);
                let share = ((ends_s - begins_s) / step_s).at_least(zero);
                for (mean, given) in mean.iter_mut().zip(given) {
                    *mean += *given * share;
                }
            }
            given_until_s = given_from_s;
        }
        self.given.drain(..arrived);
        mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flown(latency_s: f64, periods_s: &[f64]) -> Vec<f64> {
        let mut latency = Latency::of(latency_s);
        let command = |k: usize| [k as f64 + 1.0; MAX_ROTORS];
        periods_s.iter().enumerate().map(|(k, dt_s)| latency.arriving(&command(k), *dt_s)[0]).collect()
    }

    /// By hand: of a latency of one and a half periods half of the command before the last arrives in the
    /// first half of a period, and half of the last one in the second.
    #[test]
    fn closed_form_means_of_what_arrives() {
        assert_eq!(flown(0.0, &[0.25; 4]), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(flown(0.25, &[0.25; 4]), [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(flown(0.375, &[0.25; 5]), [0.0, 0.5, 1.5, 2.5, 3.5]);
        assert_eq!(flown(0.125, &[0.25; 4]), [0.5, 1.5, 2.5, 3.5]);
        // A long step in which two commands arrive whole and a third for half of it.
        assert_eq!(flown(0.5, &[0.25, 0.25, 1.0]), [0.0, 0.0, 0.25 * 1.0 + 0.25 * 2.0 + 0.5 * 3.0]);
    }

    /// What is on its way is no more than what has not arrived.
    #[test]
    fn what_has_arrived_is_forgotten() {
        let mut latency = Latency::of(0.01);
        for _ in 0..1000 {
            latency.arriving(&[0.5; MAX_ROTORS], 0.004);
            assert!(latency.given.len() <= 5);
        }
    }
}
