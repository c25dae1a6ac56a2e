//! What a design costs: the number that a search makes small, and the bounds that it keeps.

use crate::assess::outcome::{ALTITUDE_LOST, PEAK_TILT, Quantity, STEADY_AFTER};
use crate::assess::quantile_rank;

/// J_TPF of a flight that was lost: beyond any that turns over, and finite, so that of two designs which lose
/// flights that with fewer is the better one.
pub const LOST: f64 = 10.0;
/// J_TPF that it costs to break a bound by as much again, or to end off the target by the target's size.
pub const PENALTY: f64 = 2.0;
/// What each flight that passes a limit or is lost costs beside its own J_TPF.
pub const UNSAFE: f64 = 0.05;
/// Weight of the mean J_TPF beside the number that decides: of designs alike in their worst flights the one
/// that is better in all is taken.
pub const MEAN: f64 = 0.05;

/// Weight of the mean time to steady flight beside it, as a share of the horizon of the mission's plan: where
/// J_TPF is as small as the release lets it be, the sooner steady is the better.
pub const STEADY: f64 = 0.02;
/// Share that a flight counts with that is never steady: flights go on for a horizon after their plan.
const NEVER_STEADY: f64 = 2.0;

/// The number of the drawn flights that is to be small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DesignObjective {
    /// The J_TPF that this share of the flights does not exceed.
    Quantile(f64),
    /// The greatest J_TPF.
    Worst,
}

impl DesignObjective {
    /// How many of `flights` may exceed the number.
    fn exceeding(self, flights: usize) -> usize {
        match self {
            Self::Quantile(p) => flights - quantile_rank(flights, p),
            Self::Worst => 0,
        }
    }

    /// The number, of all `flights` or of the first ones: then it is at least that. Values descend.
    fn of(self, descending: &[f64], flights: usize) -> f64 {
        descending.get(self.exceeding(flights)).copied().unwrap_or(0.0)
    }

    /// Name of the number: "p99", "worst".
    pub fn name(self) -> String {
        match self {
            Self::Quantile(p) => format!("p{}", (1000.0 * p).round() / 10.0),
            Self::Worst => "worst".to_owned(),
        }
    }
}

/// Quantities of the flights from the release cases that may be bounded.
pub const BOUNDED: [Quantity; 3] = [STEADY_AFTER, ALTITUDE_LOST, PEAK_TILT];

/// Bounds on the flights from the release cases, in still air; each is kept where it is given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DesignBounds {
    /// Largest value of each of [`BOUNDED`], in its unit.
    pub most: [Option<f64>; BOUNDED.len()],
    /// Energy that the plan takes of the rotors' shafts from t = 0 to its end [J].
    pub energy_j: Option<f64>,
    /// Least distance of each loop's response from -1, and least delay that takes a loop to the limit of
    /// stability [s].
    pub margins: LeastMargins,
}

/// What each loop keeps to instability, at the release, at the plan's peak and at the target, of the vehicle
/// as it is known and of others near it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LeastMargins {
    /// Least distance of each loop's response from -1; `None`: not asked for.
    pub modulus: Option<f64>,
    /// Least delay that takes a loop to the limit of stability [s]; `None`: not asked for.
    pub delay_s: Option<f64>,
}

/// What counts of a drawn flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct JudgedFlight {
    /// J_TPF; [`LOST`] of a flight that was lost.
    pub(super) j_tpf: f64,
    /// Time to steady flight as a share of the horizon of the mission's plan.
    pub(super) steady_share: f64,
    /// Whether the judge of all flights objects to nothing ([`crate::assess::judge_trial`]).
    pub(super) safe: bool,
    /// Whether none of its objections counts: those of limits, and in the mission's own air, too, that it is
    /// never steady ([`super::DesignFlights::own_air`]).
    pub(super) within_limits: bool,
}

impl JudgedFlight {
    /// Time to steady flight [s] as a share of a horizon [s]; what is never steady, or later than counts,
    /// counts alike.
    pub(super) fn share_of(steady_after_s: Option<f64>, horizon_s: f64) -> f64 {
        steady_after_s.map_or(NEVER_STEADY, |steady_s| (steady_s / horizon_s).min(NEVER_STEADY))
    }
}

/// What is known of a design after some of its flights or all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judgement {
    /// The number that decides, of the drawn flights.
    pub j_tpf: f64,
    /// Mean J_TPF of the drawn flights; of a part of them their sum over the whole number.
    pub mean: f64,
    /// Mean time to steady flight of the drawn flights, as a share of the horizon of the mission's plan; what
    /// is never steady counts with 2. Of a part of them, their sum over the whole number.
    pub steady_share: f64,
    /// Greatest J_TPF of all flights.
    pub worst: f64,
    /// Flights that passed a limit or were lost, and in the mission's own air those never steady.
    pub over_limit: f64,
    /// Worst distance from rest at the target of a release case ([`crate::tune::Evaluation::unrest`]).
    pub unrest: f64,
    /// Greatest value among the release cases of each of [`BOUNDED`], in its unit.
    pub most: [f64; BOUNDED.len()],
    /// Energy that the plan takes of the rotors' shafts [J].
    pub energy_j: f64,
    /// Least distance of a loop's response from -1, at most 1; negative where a loop is unstable.
    pub modulus: f64,
    /// Least delay that takes a loop to the limit of stability [s], at most 10 s; zero where a loop is
    /// unstable.
    pub delay_s: f64,
    /// Flights that were flown.
    pub flights: f64,
}

impl Judgement {
    /// A design that has no plan.
    pub const UNPLANNED: Self = Self {
        j_tpf: f64::INFINITY,
        mean: f64::INFINITY,
        steady_share: f64::INFINITY,
        worst: f64::INFINITY,
        over_limit: f64::INFINITY,
        unrest: f64::INFINITY,
        most: [f64::INFINITY; BOUNDED.len()],
        energy_j: f64::INFINITY,
        modulus: f64::NEG_INFINITY,
        delay_s: 0.0,
        flights: 0.0,
    };

    /// Whether there was a plan to fly.
    pub fn is_planned(&self) -> bool {
        self.j_tpf.is_finite()
    }

    /// Takes the drawn flights so far, of `flights` in the end.
    pub(super) fn with_draws(
        self,
        objective: DesignObjective,
        drawn: &[JudgedFlight],
        flights: usize,
    ) -> Self {
        let mut descending: Vec<f64> = drawn.iter().map(|flight| flight.j_tpf).collect();
        descending.sort_by(|a, b| b.total_cmp(a));
        Self {
            j_tpf: objective.of(&descending, flights),
            mean: drawn.iter().map(|flight| flight.j_tpf).sum::<f64>() / flights.max(1) as f64,
            steady_share: drawn.iter().map(|flight| flight.steady_share).sum::<f64>() / flights.max(1) as f64,
            worst: self.worst.max(descending.first().copied().unwrap_or(0.0)),
            over_limit: self.over_limit + drawn.iter().filter(|flight| !flight.within_limits).count() as f64,
            flights: self.flights + drawn.len() as f64,
            ..self
        }
    }

    /// The cost; infinite for a design that has no plan. Of a part of the flights it is at most that of all.
    pub fn cost(&self, bounds: &DesignBounds) -> f64 {
        if !self.is_planned() {
            return f64::INFINITY;
        }
        let over: f64 = self.shares(bounds).map(|share| (share - 1.0).max(0.0)).sum();
        let beside = MEAN * self.mean + STEADY * self.steady_share;
        self.j_tpf + beside + UNSAFE * self.over_limit + PENALTY * (self.unrest + over)
    }

    /// Whether every release case comes to rest, all bounds hold and no flight passes a limit.
    pub fn is_allowed(&self, bounds: &DesignBounds) -> bool {
        self.is_planned()
            && self.unrest == 0.0
            && self.over_limit == 0.0
            && self.shares(bounds).all(|share| share <= 1.0)
    }

    /// Order among judged designs, the best first: what keeps all bounds, by its cost; what keeps them but
    /// for the margins, by how far its loops are from instability; the rest by their cost.
    pub fn rank(&self, bounds: &DesignBounds) -> (bool, bool, f64) {
        let without = DesignBounds { margins: LeastMargins::default(), ..*bounds };
        let (broken, lacking) = (!self.is_allowed(&without), !self.has_margins(bounds));
        let number = if lacking && !broken { -self.modulus } else { self.cost(bounds) };
        (broken, lacking, number)
    }

    /// Whether each loop keeps what it must.
    pub fn has_margins(&self, bounds: &DesignBounds) -> bool {
        let LeastMargins { modulus, delay_s } = bounds.margins;
        modulus.is_none_or(|least| self.modulus >= least) && delay_s.is_none_or(|least| self.delay_s >= least)
    }

    /// Shares of the bounds that are used; of modulus and delay 1 at their bounds, and more by what is
    /// missing.
    fn shares(&self, bounds: &DesignBounds) -> impl Iterator<Item = f64> + use<> {
        let LeastMargins { modulus, delay_s } = bounds.margins;
        let modulus = modulus.map(|least| 1.0 + least - self.modulus);
        let delay = delay_s.map(|least| 2.0 - self.delay_s / least);
        let used = self.most.into_iter().zip(bounds.most).chain([(self.energy_j, bounds.energy_j)]);
        used.filter_map(|(x, bound)| bound.map(|most| x / most)).chain(modulus).chain(delay)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn safe(j_tpf: f64) -> JudgedFlight {
        JudgedFlight { j_tpf, steady_share: 0.4, safe: j_tpf <= 1.0, within_limits: j_tpf <= 1.0 }
    }

    const NOTHING: Judgement = Judgement {
        j_tpf: 0.0,
        mean: 0.0,
        steady_share: 0.0,
        worst: 0.0,
        over_limit: 0.0,
        unrest: 0.0,
        most: [10.0, 50.0, 12.0],
        energy_j: 100.0,
        modulus: 0.2,
        delay_s: 0.03,
        flights: 0.0,
    };

    /// 1 to 100 hundredths: two may exceed the quantile 0.98; a bound broken by a fifth costs 0.4.
    #[test]
    fn closed_form_quantiles_and_penalties() {
        let drawn: Vec<JudgedFlight> = (1..=100).map(|i| safe(f64::from(i) / 100.0)).collect();
        let judged = NOTHING.with_draws(DesignObjective::Quantile(0.98), &drawn, 100);
        assert_eq!((judged.j_tpf, judged.worst, judged.over_limit), (0.98, 1.0, 0.0));
        assert!((judged.mean - 0.505).abs() < 1e-12);
        let free = judged.cost(&DesignBounds::default());
        assert!((free - 0.98 - MEAN * 0.505 - STEADY * 0.4).abs() < 1e-12);
        let bounds = DesignBounds { most: [None, Some(50.0 / 1.2), None], ..DesignBounds::default() };
        assert!((judged.cost(&bounds) - free - 0.4).abs() < 1e-12 && !judged.is_allowed(&bounds));
        assert!(judged.is_allowed(&DesignBounds { energy_j: Some(100.0), ..DesignBounds::default() }));
        // A modulus a tenth below its bound; unstable by two tenths it costs five times as much.
        let margins = LeastMargins { modulus: Some(0.3), delay_s: None };
        let margin = DesignBounds { margins, ..DesignBounds::default() };
        assert!((judged.cost(&margin) - free - 0.1 * PENALTY).abs() < 1e-12 && !judged.is_allowed(&margin));
        let unstable = Judgement { modulus: -0.2, ..judged };
        assert!((unstable.cost(&margin) - free - 0.5 * PENALTY).abs() < 1e-12);
        // A delay margin of three quarters of what is asked for.
        let margins = LeastMargins { modulus: None, delay_s: Some(0.04) };
        let late = DesignBounds { margins, ..DesignBounds::default() };
        assert!((judged.cost(&late) - free - 0.25 * PENALTY).abs() < 1e-12 && !judged.is_allowed(&late));
        assert_eq!(Judgement::UNPLANNED.cost(&bounds), f64::INFINITY);
        let tilted = [JudgedFlight { j_tpf: 0.5, steady_share: 2.0, safe: false, within_limits: false }];
        let judged = NOTHING.with_draws(DesignObjective::Worst, &tilted, 1);
        assert!(judged.over_limit == 1.0 && !judged.is_allowed(&DesignBounds::default()));
    }

    /// A part of the flights never costs more than all of them: that is what lets a search give up early.
    #[test]
    fn prop_a_part_costs_at_most_as_much_as_all() {
        for objective in [DesignObjective::Quantile(0.9), DesignObjective::Worst] {
            let drawn: Vec<JudgedFlight> =
                (0..64u32).map(|i| safe(f64::from((i * 29) % 64) / 50.0)).collect();
            let cost =
                |n: usize| NOTHING.with_draws(objective, &drawn[..n], 64).cost(&DesignBounds::default());
            assert!((1..=64).all(|n| cost(n - 1) <= cost(n)), "{objective:?}");
        }
    }

    /// By hand: a quarter of the horizon; later than twice it, or never, is twice.
    #[test]
    fn closed_form_shares_of_the_horizon() {
        let share = |steady_s| JudgedFlight::share_of(steady_s, 8.0);
        assert_eq!([Some(2.0), Some(16.5), None].map(share), [0.25, 2.0, 2.0]);
    }

    #[test]
    fn closed_form_names() {
        assert_eq!(DesignObjective::Quantile(0.99).name(), "p99");
        assert_eq!(DesignObjective::Quantile(0.995).name(), "p99.5");
    }
}
