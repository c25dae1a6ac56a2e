//! A statement of the paper with its bar, and the comparisons that bars are made of.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The reason given where nothing but chance, or another seed, can be it.
pub(super) const WHY_OTHER: &str = "It is reproduced with 100 trials and seed 1: these are fewer, or others.";

/// A statement of the paper and whether it is reproduced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Finding {
    /// The statement in words.
    pub claim: String,
    /// The paper's figure.
    pub paper: String,
    /// This study's figure.
    pub here: String,
    /// The bar in words.
    pub bar: String,
    /// Whether the figure is within the bar.
    pub reproduced: bool,
    /// Reason for a missed bar; `None` where none is known.
    pub why: Option<String>,
}

impl Finding {
    /// Reasons were found once, on the shipped vehicle and mission (`docs/paper.md`), and are given only with
    /// those; a run does not look for them again.
    pub(super) fn new(
        claim: &str,
        paper: impl Into<String>,
        here: String,
        bar: &str,
        reproduced: bool,
        why: &'static str,
    ) -> Self {
        let why = (!reproduced).then(|| why.to_owned());
        Self { claim: claim.to_owned(), paper: paper.into(), here, bar: bar.to_owned(), reproduced, why }
    }

    /// The words "reproduced" or "NOT reproduced".
    pub fn verdict(&self) -> &'static str {
        if self.reproduced { "reproduced" } else { "NOT reproduced" }
    }
}

/// Whether a number is off another by a share of it at most.
pub(super) fn within(x: f64, wanted: f64, share: f64) -> bool {
    (x / wanted - 1.0).abs() <= share
}

/// Whether a number is another's to within a factor, either way.
pub(super) fn within_factor(x: f64, wanted: f64, factor: f64) -> bool {
    let ratio = x / wanted;
    (1.0 / factor..=factor).contains(&ratio)
}

/// Least and greatest of some numbers.
pub(super) fn ends(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    values.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}
