//! The way of a throttle command from the measurement that it was made of to the speed controller that acts on
//! it, which takes a time.
//!
//! Commands are held for a control period, and so arrive in pieces: what acts in a step is the mean of what
//! arrives in it, which for motors that are slow beside a step is the same. `vehicle.latency_s` is the time;
//! without one nothing is done here.

use std::collections::VecDeque;

use crate::model::MAX_ROTORS;
use crate::real::Real;

/// Commands on their way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Latency<S> {
    latency_s: f64,
    /// Commands with the time for which each is given [s], the newest last.
    given: VecDeque<([S; MAX_ROTORS], f64)>,
}

impl<S: Real> Latency<S> {
    /// A way that takes this time [s], on which nothing is.
    pub(super) fn of(latency_s: f64) -> Self {
        Self { latency_s, given: VecDeque::new() }
    }

    /// Whether commands arrive at once.
    pub(super) fn is_none(&self) -> bool {
        !(self.latency_s > 0.0)
    }

    /// The mean of the commands that arrive in the `dt_s` [s] for which this one is given; zero before the
    /// first has arrived.
    #[inline(always)]
    pub(super) fn arriving(&mut self, command: &[S; MAX_ROTORS], dt_s: f64) -> [S; MAX_ROTORS] {
        if self.is_none() {
            return *command;
        }
        self.given.push_back((*command, dt_s));
        let mut mean = [command[0].of(0.0); MAX_ROTORS];
        // Times from now on, at which a command begins to arrive and has arrived.
        let (mut begins_s, mut arrived) = (self.latency_s + dt_s, 0);
        for (given, lasts_s) in self.given.iter().rev() {
            let ends_s = begins_s;
            begins_s -= lasts_s;
            if ends_s <= 0.0 {
                arrived += 1;
                continue;
            }
            let share = (ends_s.min(dt_s) - begins_s.max(0.0)) / dt_s;
            if share > 0.0 {
                for (mean, given) in mean.iter_mut().zip(given) {
                    *mean += *given * share;
                }
            }
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
