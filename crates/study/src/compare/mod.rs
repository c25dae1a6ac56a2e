//! Two runs, two missions, or a flight log and a mission, held against each other: B less A throughout.
//!
//! | file | holds |
//! |---|---|
//! | [`channels`] | quantities over time, a flight's beside a prediction's |
//! | [`seconds`] | predictions of a second, begun anew all along a logged drop |
//! | [`campaigns`] | two campaigns of one seed, trial by trial |
//! | [`drops`] | two drops |
//! | [`paths`] | their flight paths, drawn |
//! | [`logged`] | a drop out of a flight log, and what a mission predicts of it |
//! | [`replayed`] | a drop out of a flight log, flown again by its commands |
//! | [`missions`] | files and derived numbers of two missions |
//! | `sides` | words on A and on B |
//! | this one | what is said of all of it |

pub mod campaigns;
pub mod channels;
pub mod drops;
pub mod logged;
pub mod missions;
pub mod paths;
pub mod replayed;
pub mod seconds;
mod sides;
#[cfg(test)]
mod tests;

use campaigns::{CampaignPair, CampaignPairObject};
use drops::{DropPair, DropPairObject};
use logged::{LoggedPair, LoggedPairObject};
use missions::{MissionPair, MissionPairObject};
use samara_core::assess::CONFIDENCE;
use samara_report::document::{Document, Figure, Passage, Section};
use samara_report::json::{VERSION, result_objects, text};
use sides::sides;

/// Name of the file that the drawing of the flight paths goes to.
pub const PATHS: &str = "compare.svg";

/// Name of the page on which a prediction is seen with the flight as its ghost.
pub const REPLAY: &str = "drop.html";

/// What there is to compare of two runs or missions.
#[derive(Clone, Debug, Default)]
pub struct Compared {
    /// How A and B were named.
    pub names: [String; 2],
    /// Campaigns that both runs have.
    pub campaigns: Vec<CampaignPair>,
    /// Drops, where both runs have one.
    pub drops: Option<DropPair>,
    /// A drop out of a log and its prediction, where those are compared.
    pub logged: Option<LoggedPair>,
    /// Both flight paths as a drawing, where both are known.
    pub paths: Option<String>,
    /// The page of a prediction with the flight as its ghost, where those are compared.
    pub replay: Option<String>,
    /// Missions, where those are compared.
    pub missions: Option<MissionPair>,
}

impl Compared {
    /// What is said of it.
    pub fn document(&self) -> Document {
        let [a, b] = &self.names;
        let title = format!("{a} and {b}");
        let mut sections = Vec::new();
        let mut section = |id, title, passages: Vec<Passage>| sections.push(Section { id, title, passages });
        if !self.campaigns.is_empty() {
            section(
                "campaigns",
                "Campaigns",
                self.campaigns.iter().flat_map(CampaignPair::passages).collect(),
            );
        }
        let figure = self.paths.as_ref().map(|svg| {
            let caption = "Both flight paths, from the side and from above; a mark each 5 s.".to_owned();
            Passage::Figure(Figure { file: PATHS.to_owned(), caption, svg: svg.clone() })
        });
        if let Some(drops) = &self.drops {
            section("drops", "Drops", drops.passages().into_iter().chain(figure.clone()).collect());
        }
        if let Some(logged) = &self.logged {
            let title = "The drop of the log, and what was predicted";
            section("logged", title, logged.passages().into_iter().chain(figure).collect());
        }
        if let Some(missions) = &self.missions {
            section("missions", "Missions", missions.passages());
        }
        let lead = sides([a.clone(), b.clone()]).into();
        Document { tab: title.clone(), title, lead, sections, ..Document::default() }
    }

    /// The object of `--json` and of `compare.json`.
    pub fn json(&self) -> String {
        text(&CompareObject::of(self))
    }
}

result_objects! {
    /// Two runs, two missions or a log and a mission held against each other, as `compare.json` has it: B
    /// less A.
    CompareObject(of: &Compared) [let [a, b] = &of.names;] {
        /// Version of samara that made the result.
        version: String = VERSION.to_owned(),
        /// How A was named.
        a: String = a.clone(),
        /// How B was named.
        b: String = b.clone(),
        /// Confidence of the intervals.
        confidence: f64 = CONFIDENCE,
        /// Campaigns that both runs have.
        campaigns: Vec<CampaignPairObject> = of.campaigns.iter().map(CampaignPairObject::of).collect(),
        /// The drops; null where not both runs have one.
        drops: Option<DropPairObject> = of.drops.as_ref().map(DropPairObject::of),
        /// What differs between two missions; null where others are compared.
        missions: Option<MissionPairObject> = of.missions.as_ref().map(MissionPairObject::of),
        /// A drop out of a log and its prediction; null where others are compared.
        logged: Option<LoggedPairObject> = of.logged.as_ref().map(LoggedPairObject::of),
    }
}
