//! How rare failures are, and the most likely one.

use serde::Deserialize;

use super::campaign::probability;
use super::envelope::SAFE;
use crate::columns::short;

/// `rare.json`.
#[derive(Clone, Debug, Deserialize)]
pub struct RareFound {
    /// J_TPF that a failure reaches.
    pub bound: f64,
    /// Smallest probability that was looked for.
    pub least: f64,
    /// Whether what the controller does not know was drawn, too.
    pub unknowns: bool,
    /// Trials of all populations at a threshold.
    pub per_level: u64,
    /// Flights that it took.
    pub flights: u64,
    /// The probability of reaching the bound; 0 where it was never reached.
    pub probability: f64,
    /// Lower end of the interval at 95 %.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
    /// Coefficient of variation of the probability.
    pub variation: Option<f64>,
    /// The most likely failure, where any was found.
    pub most_likely: Option<MostLikely>,
}

/// The failing trial that is nearest to the nominal one.
#[derive(Clone, Debug, Deserialize)]
pub struct MostLikely {
    /// J_TPF; none where it was lost.
    pub j_tpf: Option<f64>,
    /// Distance from the nominal trial, in standard deviations.
    pub distance: f64,
    quantities: Vec<QuantityShare>,
}

/// The share of a quantity in that distance.
#[derive(Clone, Debug, Deserialize)]
struct QuantityShare {
    quantity: String,
    share: f64,
}

impl RareFound {
    /// The event whose probability was searched for, in words.
    pub fn event(&self) -> String {
        format!("J_TPF >= {}", short(self.bound, 6))
    }

    /// Whether what reaches the bound has failed.
    pub fn is_of_failures(&self) -> bool {
        self.bound >= SAFE
    }

    /// Why it speaks against a go, if it does: failures more probable than is `demanded` are not ruled out.
    pub fn fault(&self, demanded: f64) -> Option<String> {
        (self.is_of_failures() && self.high > demanded).then(|| {
            format!(
                "J_TPF reaches {} with a probability of up to {}; at most {} is asked for",
                short(self.bound, 6),
                probability(self.high, f64::ceil),
                short(demanded, 12)
            )
        })
    }
}

impl MostLikely {
    /// How far it is, and what that is made of, in words.
    pub fn words(&self) -> String {
        let mut quantities: Vec<&QuantityShare> = self.quantities.iter().collect();
        quantities.sort_by(|a, b| b.share.total_cmp(&a.share));
        let largest = quantities.iter().take(2);
        let largest: Vec<String> =
            largest.map(|of| format!("{} {} %", of.quantity, short(100.0 * of.share, 0))).collect();
        format!("{} standard deviations from nominal: {}", short(self.distance, 2), largest.join(", "))
    }
}
