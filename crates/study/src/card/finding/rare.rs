//! How rare failures are, and the most likely one.

use super::campaign::probability;
use super::envelope::SAFE;
use crate::rare::report::{MostLikely, QuantityShare, RareObject};
use samara_report::columns::short;

impl RareObject {
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
