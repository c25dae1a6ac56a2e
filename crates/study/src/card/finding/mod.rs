//! What a card takes of the results of other verbs, and whether each holds what is asked of it.
//!
//! | file | holds |
//! |---|---|
//! | `design` | a plan, gains that were searched, a design with its margins |
//! | `drop` | a drop, and drops of the release cases |
//! | `campaign` | a campaign, and the probabilities that it leaves possible |
//! | `rare` | how rare failures are, and the most likely one |
//! | `envelope` | a safe-release envelope |

mod campaign;
mod design;
mod envelope;
mod rare;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::manifest::{Kind, RunManifest};
use crate::campaign::json::AssessObject;
use crate::designing::report::DesignObject;
use crate::envelope::report::EnvelopeObject;
use crate::paper::IS_THE_PAPERS;
use crate::rare::report::RareObject;
pub use campaign::{fewest_trials, probability};
pub use design::{TuneFound, in_air};
pub use envelope::Coverage;
pub use samara_report::json::pilot_words;
use samara_report::json::{CaseDrop, CasesObject, DropObject};
use samara_report::plan::PlanObject;

/// Results of a run, as far as a card needs them.
#[derive(Clone, Debug)]
pub enum Finding {
    /// A plan, or why there is none.
    Plan(PlanObject),
    /// Gains that were searched.
    Tune(TuneFound),
    /// A design with its margins.
    Design(DesignObject),
    /// A drop.
    Drop(DropObject),
    /// Drops of the release cases.
    Cases(Vec<CaseDrop>),
    /// A campaign, of flights from t = 0 or of whole drops.
    Campaign(AssessObject),
    /// How rare failures are, and the most likely one.
    Rare(RareObject),
    /// A safe-release envelope.
    Envelope(EnvelopeObject),
}

/// Why a piece of evidence is not enough of its kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortfall {
    /// How far it is from being enough: at most 1 where more of the same would do, larger where it is of
    /// another kind, or refused.
    pub distance: f64,
    /// The reason in words.
    pub why: String,
}

impl Shortfall {
    /// Of evidence that more of the same would not make enough.
    pub fn of_kind(why: String) -> Self {
        Self { distance: 2.0, why }
    }

    /// Of evidence that is refused.
    pub fn refused(why: &str) -> Self {
        Self { distance: 3.0, why: format!("refused, {why}") }
    }
}

/// The beginning of results' objects.
#[derive(Deserialize)]
struct Head {
    input_hash: String,
}

impl Finding {
    /// The finding of a run's file.
    ///
    /// # Errors
    /// A sentence that says why the text is not what the run's manifest says it is.
    pub fn parse(kind: Kind, run: &RunManifest, text: &str) -> Result<Self, String> {
        // A design's object has the hash without gains, and gains and cases have none.
        if !matches!(kind, Kind::Tune | Kind::Design | Kind::Cases) {
            let Head { input_hash } = parsed(text)?;
            if input_hash != run.input_hash {
                return Err("its hash of the inputs is not that of its manifest".to_owned());
            }
        }
        Ok(match kind {
            Kind::Plan => Self::Plan(parsed(text)?),
            Kind::Tune => Self::Tune(parsed(text)?),
            Kind::Design => Self::Design(parsed(text)?),
            Kind::Drop => Self::Drop(parsed(text)?),
            Kind::Cases => Self::Cases(parsed::<CasesObject>(text)?.cases),
            Kind::Campaign if is_the_papers(text) => return Err(IS_THE_PAPERS.to_owned()),
            Kind::Campaign | Kind::DropCampaign => Self::Campaign(parsed(text)?),
            Kind::Rare => Self::Rare(parsed(text)?),
            Kind::Envelope => Self::Envelope(parsed(text)?),
        })
    }
}

/// Whether an `assess.json` is of `samara assess --paper`.
fn is_the_papers(text: &str) -> bool {
    serde_json::from_str::<Value>(text).is_ok_and(|object| object.get("table5").is_some())
}

fn parsed<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_str(text).map_err(|error| format!("it is not what the verb writes: {error}"))
}
