//! A plan, gains that were searched, a design with its margins.

use serde::Deserialize;

use super::campaign::probability;
use crate::designing::report::{DesignObject, FreshNumbers, FreshObject, MarginObject};
use samara_report::columns::short;

use crate::range_ends::{NumberObject, range_ends_words};
use samara_core::assess::{ChosenAmong, Share};
use samara_core::tune::{RangeEnds, SearchedNumber};

/// `gains.json` of a tuning.
#[derive(Clone, Debug, Deserialize)]
pub struct TuneFound {
    /// Name of the gains.
    pub name: String,
}

impl FreshNumbers {
    /// Flights that never become steady.
    pub fn never_steady(&self) -> u64 {
        self.flights.saturating_sub(self.steady_flights)
    }

    /// Whether a flight failed.
    pub fn any_failed(&self) -> bool {
        self.unsafe_flights > 0
    }

    /// The greatest probability of a failure that these flights leave possible.
    pub fn failing_at_most(&self) -> f64 {
        let safe = Share::of(self.flights.saturating_sub(self.unsafe_flights), self.flights);
        ChosenAmong::new(self.chosen_among).misses_at_most(&safe)
    }

    /// What came of the flights, in words.
    pub fn words(&self) -> String {
        format!(
            "of {} flights that chose nothing {} were not safe, {} never steady",
            self.flights,
            self.unsafe_flights,
            self.never_steady()
        )
    }
}

impl DesignObject {
    /// Whether the chosen design is the mission's own, searched from the inputs with this hash, gains left
    /// out.
    pub fn is_own(&self, hash_without_gains: &str) -> bool {
        self.design == self.own && self.input_hash == hash_without_gains
    }

    /// Margins of the loop that is nearest to instability.
    pub fn tightest(&self) -> Option<&MarginObject> {
        self.margins.iter().min_by(|a, b| a.modulus.total_cmp(&b.modulus))
    }

    /// Which numbers stand at an end of their range, in words; `None`: none does.
    pub fn range_ends_words(&self) -> Option<String> {
        let found = self.at_range_ends.as_ref()?;
        let number = |number: &NumberObject| {
            let NumberObject { name, value, least, most } = number;
            SearchedNumber { name: name.clone().into(), value: *value, least: *least, most: *most }
        };
        let at_end = found.numbers.iter().map(number).collect();
        range_ends_words(&RangeEnds { searched: found.of, at_end })
    }

    /// Fresh flights of the design in the last air, which has everything that is unknown and turbulence.
    pub fn hardest_air(&self) -> Option<&FreshObject> {
        let own = self.fresh.iter().rfind(|fresh| fresh.design == self.name);
        own.or_else(|| self.fresh.iter().rfind(|fresh| fresh.design == crate::designing::OWN))
    }

    /// Why it is no design to fly, if it is none. Flights that it was not chosen by count as the trials of a
    /// campaign do, where no probability of failure is `accepted` or they leave a greater one possible.
    pub fn fault(&self, accepted: Option<f64>) -> Option<String> {
        if let Some(loop_) = self.margins.iter().find(|margins| !margins.stable) {
            return Some(format!("the {} loop is not stable at the {}", loop_.r#loop, loop_.state));
        }
        if !self.allowed {
            return Some(
                "the design breaks a bound or passes a limit on the flights of its search".to_owned(),
            );
        }
        let FreshObject { air, results, .. } =
            self.hardest_air().filter(|fresh| fresh.results.any_failed())?;
        let words = format!("{}, {}", in_air(air), results.words());
        let at_most = results.failing_at_most();
        match accepted {
            None => Some(words),
            Some(accepted) => (at_most > accepted).then(|| {
                format!(
                    "{words}, which leaves a probability of failure of {} possible; at most {} is asked for",
                    probability(at_most, f64::ceil),
                    short(accepted, 12)
                )
            }),
        }
    }
}

/// Where flights flew, in words: `in turbulence`.
pub fn in_air(air: &str) -> String {
    match air {
        "unknowns" => "with unknowns".to_owned(),
        air => format!("in {}", air.replace('_', " ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flight has failed where the judge of `samara design` says so, once: those that are never steady are
    /// among them. Of none 300 leave `1 - 0.05^(1/300)` possible; of 36 of 300 Clopper and Pearson's bound is
    /// 0.15537.
    #[test]
    fn regress_flights_that_are_never_steady_have_failed() {
        let numbers = |unsafe_flights, steady_flights| FreshNumbers {
            flights: 300,
            unsafe_flights,
            steady_flights,
            chosen_among: 1,
            ..FreshNumbers::default()
        };
        let design = |results: FreshNumbers| DesignObject {
            name: "design".to_owned(),
            allowed: true,
            fresh: vec![FreshObject { design: "design".to_owned(), air: "turbulence".to_owned(), results }],
            ..DesignObject::default()
        };
        let good = numbers(0, 300);
        assert!(!good.any_failed());
        assert!((good.failing_at_most() - (1.0 - samara_core::math::powf(0.05, 1.0 / 300.0))).abs() < 1e-12);
        assert_eq!(design(good).fault(None), None);
        let restless = design(numbers(36, 264));
        let why = restless.fault(None).unwrap();
        assert!(why.contains("in turbulence, of 300 flights"), "{why}");
        assert!(why.contains("36 were not safe, 36 never steady"), "{why}");
        assert!(restless.fault(Some(0.1)).unwrap().contains("possible; at most 0.1 is asked for"));
        assert_eq!(restless.fault(Some(0.2)), None);
        assert!((numbers(36, 264).failing_at_most() - 0.155_370).abs() < 1e-6);
    }
}
