//! What was chosen, judged on flights that chose nothing: in still air, with everything unknown, and with
//! turbulence on top.

use std::ops::Range;

use super::drops::{FreshFlight, Unknown};
use super::judge::{DesignFlights, DesignJudge};
use super::objective::{DesignObjective, LOST};
use super::search::TriedDesign;
use super::space::Design;
use crate::assess::better::passes_less_often;
use crate::assess::outcome::{J_TPF, OutcomeSummary, Quantity};
use crate::assess::{ChosenAmong, Share, Summary, clearly_less, quantile_rank};
use crate::control::ControlError;
use crate::random::Trials;
use crate::trajectory::Trajectory;
use crate::tune::GainJudge;

/// Conditions of fresh flights: name, and what the controller does not know of.
pub const CONDITIONS: [(&str, Unknown); 3] = [
    ("still_air", Unknown { vehicle: false, air: false }),
    ("unknowns", Unknown { vehicle: true, air: false }),
    ("turbulence", Unknown { vehicle: true, air: true }),
];

/// Results of fresh flights in one condition.
#[derive(Clone, Debug, Default)]
pub struct FreshResults {
    /// J_TPF of each, in the order of their numbers.
    flown: Vec<f64>,
    /// J_TPF of each, in ascending order.
    ascending: Vec<f64>,
    outcomes: OutcomeSummary,
    /// Flights that were safe.
    pub safe: Share,
    /// Flights that passed a limit or were lost.
    pub over_limit: u64,
    /// Flights that were lost.
    pub lost: u64,
    /// Distance of the velocity from the target at the end [m/s].
    pub end_error_m_s: Summary,
}

impl FreshResults {
    /// Takes a flight in, in the order of their numbers.
    pub fn push(&mut self, flight: &FreshFlight) {
        let j_tpf = flight.outcome.j_tpf;
        self.flown.push(j_tpf);
        self.outcomes.push(&flight.outcome);
        self.safe.push(flight.safe);
        self.over_limit += u64::from(!flight.within_limits);
        self.lost += u64::from(j_tpf >= LOST);
        self.end_error_m_s.push(flight.end_error_m_s);
    }

    /// The results of all flights that were taken in.
    #[must_use]
    pub fn whole(mut self) -> Self {
        self.ascending.clone_from(&self.flown);
        self.ascending.sort_by(f64::total_cmp);
        self
    }

    /// The results of these flights.
    pub fn of(flights: &[FreshFlight]) -> Self {
        let mut results = Self::default();
        flights.iter().for_each(|flight| results.push(flight));
        results.whole()
    }

    /// A quantity of the flights that have it.
    pub fn of_quantity(&self, quantity: &Quantity) -> Summary {
        self.outcomes.of(quantity)
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

    /// Whether these flights are better than another design's on the same draws: the quantile or the worst
    /// J_TPF is clearly less ([`clearly_less`]), and the other's quantile is passed less often than chance
    /// allows ([`passes_less_often`]); of a worst flight there is no such test.
    pub fn is_better_than(&self, other: &Self, objective: DesignObjective) -> bool {
        match objective {
            DesignObjective::Quantile(p) => {
                let value = other.quantile(p);
                clearly_less(self.quantile(p), value) && passes_less_often(&self.flown, &other.flown, value)
            }
            DesignObjective::Worst => {
                clearly_less(self.of_quantity(&J_TPF).max(), other.of_quantity(&J_TPF).max())
            }
        }
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

/// Flights that are flown without a look at whether to stop.
pub const PORTION: u64 = 64;
/// Most flights that each finalist is judged by.
const FINALIST_FLIGHTS: u64 = 2000;

/// The numbers of the flights that judge finalists, which no search has; no more than the last judgement has
/// in a condition.
pub fn finalist_numbers(unseen: u64) -> Range<u64> {
    let first = Trials::Finalists.first();
    first..first + FINALIST_FLIGHTS.min(unseen)
}

/// A design along its plan, which flies what its search did not have.
#[derive(Debug)]
pub struct FreshPilot<'p> {
    flights: &'p DesignFlights,
    design: &'p Design,
    plan: &'p Trajectory,
    pilot: GainJudge<'p>,
}

impl<'p> FreshPilot<'p> {
    /// The pilot of a design along its plan.
    ///
    /// # Errors
    /// [`ControlError`] for a vehicle that cannot be controlled.
    pub fn new(
        flights: &'p DesignFlights,
        design: &'p Design,
        plan: &'p Trajectory,
    ) -> Result<Self, ControlError> {
        Ok(Self { flights, design, plan, pilot: flights.pilot(plan, design)? })
    }

    /// Flies the random flights of these numbers.
    pub fn fly(&self, numbers: Range<u64>, unknown: Unknown) -> Vec<FreshFlight> {
        self.flights.fly_fresh(numbers, unknown, (&self.pilot, self.design, self.plan))
    }
}

/// A finalist: a design of the search, judged once more on flights of their own.
#[derive(Clone, Debug)]
pub struct Finalist {
    /// The design as the search knows it.
    pub tried: TriedDesign,
    /// Results of flights that the search did not have.
    pub results: FreshResults,
}

/// The best finalist by the objective of a judge, of those that keep the bounds before others, and of the
/// fewest flights that are not safe - in air that the mission does not name, over a limit; the first of
/// equals.
pub fn best_finalist(finalists: &[Finalist], judge: &DesignJudge<'_>) -> Option<TriedDesign> {
    let ((objective, bounds), own_air) = (judge.objective(), judge.flights().own_air);
    let number = |finalist: &Finalist| match objective {
        DesignObjective::Quantile(p) => finalist.results.quantile(p),
        DesignObjective::Worst => finalist.results.of_quantity(&J_TPF).max(),
    };
    let order = |a: &&Finalist, b: &&Finalist| {
        let rank = |Finalist { tried, results }: &Finalist| {
            let unsafe_flights = if own_air { results.safe.misses() } else { results.over_limit };
            (!tried.judgement.is_allowed(&bounds), unsafe_flights)
        };
        rank(a).cmp(&rank(b)).then(number(a).total_cmp(&number(b)))
    };
    finalists.iter().min_by(order).map(|finalist| finalist.tried)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assess::Outcome;
    use crate::assess::outcome::STEADY_AFTER;

    /// Never steady, and safe below a J_TPF of 1.
    fn flight(j_tpf: f64) -> FreshFlight {
        let safe = j_tpf <= 1.0;
        let outcome = Outcome { j_tpf, steady_after_s: None, ..Outcome::default() };
        FreshFlight { outcome, safe, within_limits: safe, end_error_m_s: 0.1 }
    }

    /// Of 1 to 100 hundredths 99 do not exceed 0.99; one that was lost is unsafe and the worst.
    #[test]
    fn closed_form_results() {
        let mut flown: Vec<FreshFlight> = (1..=99).rev().map(|i| flight(f64::from(i) / 100.0)).collect();
        flown.push(flight(LOST));
        let results = FreshResults::of(&flown);
        assert_eq!((results.quantile(0.99), results.of_quantity(&J_TPF).max()), (0.99, LOST));
        assert_eq!(
            (results.lost, results.safe.misses(), results.of_quantity(&STEADY_AFTER).count()),
            (1, 1, 0)
        );
        assert!(results.quantile_at_most(0.9, ChosenAmong::ONE).is_some_and(|bound| bound > 0.9));
    }

    /// 300 flights at J_TPF 0.300, 0.301, .. 0.599. Each of them lower by a tenth passes the p90 of 0.569 in
    /// no flight instead of 30: better. Lower by 1e-9 is no margin; a tenth lower in four of the 30 is, but
    /// by chance (four pairs of 1/16), and a p90 that is no lower decides against it.
    #[test]
    fn closed_form_better_by_a_margin_and_more_than_chance() {
        let of = |change: &dyn Fn(usize, f64) -> f64| {
            let j_tpf = (0..300).map(|i| change(i, 0.3 + 1e-3 * i as f64));
            FreshResults::of(&j_tpf.map(flight).collect::<Vec<_>>())
        };
        let own = of(&|_, j| j);
        let better = |change: &dyn Fn(usize, f64) -> f64| {
            of(change).is_better_than(&own, DesignObjective::Quantile(0.9))
        };
        assert!(better(&|_, j| 0.9 * j));
        assert!(!better(&|_, j| j));
        assert!(!better(&|_, j| j - 1e-9));
        assert!(!better(&|i, j| if i >= 296 { 0.9 * j } else { j }), "four pairs may be chance");
        assert!(better(&|i, j| if i >= 295 { 0.5 * j } else { j }));
        let worst =
            |change: &dyn Fn(usize, f64) -> f64| of(change).is_better_than(&own, DesignObjective::Worst);
        assert!(worst(&|_, j| 0.9 * j) && !worst(&|_, j| j - 1e-9));
    }
}
