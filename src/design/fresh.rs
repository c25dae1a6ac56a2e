//! What was chosen, judged on flights that chose nothing: in still air, with everything unknown, and with
//! turbulence on top.

use super::judge::{DesignFlights, Unknown};
use super::objective::{LIMIT, LOST};
use crate::assess::{ChosenAmong, Share, Summary, quantile_rank};
use crate::tune::{GainJudge, Longitudinal};

/// Conditions of fresh flights: name, and what the controller does not know of.
pub const CONDITIONS: [(&str, Unknown); 3] = [
    ("still_air", Unknown { vehicle: false, air: false }),
    ("unknowns", Unknown { vehicle: true, air: false }),
    ("turbulence", Unknown { vehicle: true, air: true }),
];

/// A fresh flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreshFlight {
    /// J_TPF; [`LOST`] of a flight that was lost.
    pub j_tpf: f64,
    /// Distance of the velocity from the target at the end [m/s]; infinite of a flight that was lost.
    pub end_error_m_s: f64,
    /// Time from which it is steady [s].
    pub steady_after_s: Option<f64>,
}

/// Flies the random flights of these numbers.
pub fn fly_fresh(
    flights: &DesignFlights,
    pilot: &GainJudge<'_>,
    k: &Longitudinal,
    numbers: std::ops::Range<u64>,
    unknown: Unknown,
) -> Vec<FreshFlight> {
    let drawn: Vec<_> = numbers.map(|number| flights.draw(number, unknown)).collect();
    let flown = pilot.measure_others(k, &drawn).into_iter();
    flown
        .map(|flight| {
            let j_tpf = flight.evaluation.j_tpf;
            FreshFlight {
                // What is no number is lost, too.
                j_tpf: if j_tpf < LOST { j_tpf } else { LOST },
                end_error_m_s: flight.end_error_m_s,
                steady_after_s: flight.steady_after_s,
            }
        })
        .collect()
}

/// Results of fresh flights in one condition.
#[derive(Clone, Debug, Default)]
pub struct FreshResults {
    /// J_TPF of each, in ascending order.
    ascending: Vec<f64>,
    /// J_TPF; of a flight that was lost [`LOST`].
    pub j_tpf: Summary,
    /// Flights within every limit.
    pub safe: Share,
    /// Flights that were lost.
    pub lost: u64,
    /// Distance of the velocity from the target at the end [m/s].
    pub end_error_m_s: Summary,
    /// Time from which a flight is steady, of those that are [s].
    pub steady_after_s: Summary,
}

impl FreshResults {
    /// The results of these flights.
    pub fn of(flights: &[FreshFlight]) -> Self {
        let mut results = Self::default();
        for flight in flights {
            results.ascending.push(flight.j_tpf);
            results.j_tpf.push(flight.j_tpf);
            results.safe.push(flight.j_tpf <= LIMIT);
            results.lost += u64::from(flight.j_tpf >= LOST);
            results.end_error_m_s.push(flight.end_error_m_s);
            flight.steady_after_s.into_iter().for_each(|t_s| results.steady_after_s.push(t_s));
        }
        results.ascending.sort_by(f64::total_cmp);
        results
    }

    /// J_TPF of each flight, in ascending order; of a flight that was lost [`LOST`].
    pub fn ascending(&self) -> &[f64] {
        &self.ascending
    }

    /// The J_TPF that a share `p` of the flights does not exceed; NaN without flights.
    pub fn quantile(&self, p: f64) -> f64 {
        let rank = quantile_rank(self.ascending.len(), p);
        rank.checked_sub(1).map_or(f64::NAN, |i| self.ascending[i])
    }

    /// A bound that the quantile of all flights that there are lies below; `None` of too few.
    pub fn quantile_at_most(&self, p: f64, among: ChosenAmong) -> Option<f64> {
        among.quantile_at_most(&self.ascending, p)
    }

    /// The greatest probability of an unsafe flight that these leave possible.
    pub fn unsafe_at_most(&self, among: ChosenAmong) -> f64 {
        among.misses_at_most(&self.safe)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 1 to 100 hundredths 99 do not exceed 0.99; one that was lost is unsafe and the worst.
    #[test]
    fn closed_form_results() {
        let flight = |j_tpf: f64| FreshFlight { j_tpf, end_error_m_s: 0.1, steady_after_s: None };
        let mut flown: Vec<FreshFlight> = (1..=99).rev().map(|i| flight(f64::from(i) / 100.0)).collect();
        flown.push(flight(LOST));
        let results = FreshResults::of(&flown);
        assert_eq!((results.quantile(0.99), results.j_tpf.max()), (0.99, LOST));
        assert_eq!((results.lost, results.safe.misses(), results.steady_after_s.count()), (1, 1, 0));
        assert!(results.quantile_at_most(0.9, ChosenAmong::ONE).is_some_and(|bound| bound > 0.9));
    }
}
