//! What the inputs of a card merely estimate or guess, as their files say it, or do not say.

use super::{Card, Reason, ReasonKind};
use samara_mission::Origin;

/// What an input file says of its estimates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EstimatedInput {
    /// "vehicle" or "mission".
    pub role: &'static str,
    /// Keys whose numbers are estimated; `None`: the file does not say.
    pub keys: Option<Vec<String>>,
    /// Number of the input file.
    pub from: &'static str,
    /// Where its estimates are from, as far as the file says so.
    pub origins: Vec<Origin>,
}

impl EstimatedInput {
    /// What is estimated, a sentence without a full stop.
    pub fn words(&self) -> String {
        match &self.keys {
            Some(keys) => format!("{}: {}", self.role, keys.join(", ")),
            None => format!("{}: its file does not say which of its numbers are (key estimated)", self.role),
        }
    }
}

impl EstimatedInput {
    /// What is estimated, and how, as far as the file says so; a sentence without a full stop.
    pub fn words_with_origins(&self) -> String {
        let Some(keys) = &self.keys else { return self.words() };
        let with_origin = |key: &String| match self.origins.iter().find(|origin| origin.keys.contains(key)) {
            Some(origin) => format!("{key} ({})", origin.words()),
            None => key.clone(),
        };
        format!("{}: {}", self.role, keys.iter().map(with_origin).collect::<Vec<_>>().join(", "))
    }
}

impl Card<'_> {
    /// The inputs that are estimated in part, or do not say whether they are.
    pub fn estimates(&self) -> Vec<EstimatedInput> {
        let estimated = &self.mission.estimated;
        let inputs = [
            EstimatedInput {
                role: "vehicle",
                keys: estimated.vehicle.clone(),
                from: "I2",
                origins: estimated.origins.clone(),
            },
            EstimatedInput {
                role: "mission",
                keys: estimated.mission.clone(),
                from: "I1",
                origins: Vec::new(),
            },
        ];
        inputs.into_iter().filter(|input| input.keys.as_ref().is_none_or(|keys| !keys.is_empty())).collect()
    }

    /// The reason not to go where estimates are not accepted.
    pub(super) fn not_accepted(&self) -> Option<Reason> {
        let estimates = self.estimates();
        if self.accepts_estimates || estimates.is_empty() {
            return None;
        }
        let words: Vec<String> = estimates.iter().map(EstimatedInput::words).collect();
        let text =
            format!("estimated, not measured, in {}: --accept-estimates accepts it", words.join("; in "));
        let from = estimates.iter().map(|input| input.from.to_owned()).collect();
        Some(Reason { kind: ReasonKind::Estimated, text, from })
    }
}
