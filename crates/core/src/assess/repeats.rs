//! One drop flown again and again: how far equal flights lie apart.
//!
//! What is the same to the last bit has no spread. A flight by software in a process of its own may differ
//! from the next one by the order in which that software's threads happen to run.

use nalgebra::Vector3;

use super::Summary;
use super::outcome::{Outcome, OutcomeSummary};
use crate::sim::Sample;

/// When positions are compared: so long after t = 0 [s].
pub const REPEAT_INSTANT_S: f64 = 10.0;

/// Times of a log are multiples of its step; this is less than any [s].
const TIME_ROUNDING_S: f64 = 1e-9;

/// What is compared of a repeated flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RepeatedFlight {
    /// The flight's numbers.
    pub outcome: Outcome,
    /// Position [`REPEAT_INSTANT_S`] after t = 0, NED [m]; none where the flight was over before.
    pub position_ned_m: Option<Vector3<f64>>,
}

/// Position of a flight log at the first sample that is [`REPEAT_INSTANT_S`] after t = 0 or later, NED [m].
pub fn repeat_position(log: &[Sample]) -> Option<Vector3<f64>> {
    let late =
        |sample: &&Sample| sample.t_powered_s.is_some_and(|t_s| t_s >= REPEAT_INSTANT_S - TIME_ROUNDING_S);
    log.iter().find(late).map(|sample| sample.state.body.p_ned)
}

/// The spread of repeated flights.
#[derive(Clone, Debug, Default)]
pub struct RepeatSpread {
    /// How many flights there are.
    pub flights: u64,
    /// The numbers of those that have them.
    pub outcomes: OutcomeSummary,
    /// Positions [`REPEAT_INSTANT_S`] after t = 0: north, east, down [m].
    pub position_ned_m: [Summary; 3],
    /// The greatest distance of a position from their mean [m].
    pub farthest_from_mean_m: f64,
    /// The greatest distance between two positions [m].
    pub farthest_apart_m: f64,
}

impl RepeatSpread {
    /// The spread of these flights.
    pub fn of(flights: &[RepeatedFlight]) -> Self {
        let mut spread = Self::default();
        for flight in flights {
            spread.flights += 1;
            spread.outcomes.push(&flight.outcome);
        }
        let positions: Vec<Vector3<f64>> = flights.iter().filter_map(|f| f.position_ned_m).collect();
        for position in &positions {
            spread.position_ned_m.iter_mut().zip(position.iter()).for_each(|(axis, x)| axis.push(*x));
        }
        let mean = Vector3::from_fn(|axis, _| spread.position_ned_m[axis].mean());
        for (i, position) in positions.iter().enumerate() {
            spread.farthest_from_mean_m = spread.farthest_from_mean_m.max((position - mean).norm());
            for other in &positions[..i] {
                spread.farthest_apart_m = spread.farthest_apart_m.max((position - other).norm());
            }
        }
        spread
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assess::outcome::{J_TPF, STEADY_AFTER};

    fn flight(j_tpf: f64, steady_after_s: Option<f64>, north_m: f64, down_m: f64) -> RepeatedFlight {
        let position_ned_m = Some(Vector3::new(north_m, 1.0, down_m));
        let outcome = Outcome { j_tpf, steady_after_s, ..Outcome::default() };
        RepeatedFlight { outcome, position_ned_m }
    }

    /// A triangle of 3, 4 and 5 m: its mean is (1, 1, 4/3), the vertex furthest from it (0, 1, 4) is
    /// `sqrt(1 + 64/9)` away.
    #[test]
    fn closed_form_spread_of_a_right_triangle() {
        let flights =
            [flight(0.4, Some(2.0), 0.0, 0.0), flight(0.5, None, 3.0, 0.0), flight(0.6, Some(3.0), 0.0, 4.0)];
        let spread = RepeatSpread::of(&flights);
        assert!((spread.farthest_apart_m - 5.0).abs() < 1e-12);
        assert!((spread.farthest_from_mean_m - (1.0 + 64.0 / 9.0_f64).sqrt()).abs() < 1e-12);
        assert!((spread.outcomes.of(&J_TPF).std() - 0.1).abs() < 1e-12);
        let steady = spread.outcomes.of(&STEADY_AFTER);
        assert_eq!((steady.count(), steady.max()), (2, 3.0));
        assert!((spread.position_ned_m[0].std() - 3.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(spread.position_ned_m[1].std(), 0.0);
    }

    #[test]
    fn a_flight_that_is_over_early_has_no_position() {
        assert_eq!(repeat_position(&[]), None);
        let early = RepeatedFlight { position_ned_m: None, ..flight(0.5, None, 0.0, 0.0) };
        let spread = RepeatSpread::of(&[early, early]);
        assert_eq!((spread.farthest_apart_m, spread.position_ned_m[0].count()), (0.0, 0));
    }
}
