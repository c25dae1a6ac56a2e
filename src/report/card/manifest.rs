//! What a run says of itself in its `<verb>_manifest.json`, and the kinds of evidence that a card reads.

use std::collections::BTreeMap;

use serde::Deserialize;

/// The manifest of a run, as [`crate::report::manifest_json`] writes it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct RunManifest {
    /// Verb that was run, with what was asked of it: "drop", `drops_<autopilot>_<gains>`.
    pub verb: String,
    /// Version of samara.
    pub version: String,
    /// Name of the mission.
    pub mission: String,
    /// Name of the vehicle.
    pub vehicle: String,
    /// Name of the gains.
    pub gains: String,
    /// Seed of everything random.
    pub seed: u64,
    /// SHA-256 of all inputs, hexadecimal.
    pub input_hash: String,
    /// Choices beside the files that decide the result.
    pub choices: BTreeMap<String, String>,
    /// Circumstances that are no inputs.
    pub circumstances: BTreeMap<String, String>,
    /// SHA-256 of each file that was written, hexadecimal.
    pub files: BTreeMap<String, String>,
}

/// What a piece of evidence is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// `samara plan`.
    Plan,
    /// `samara tune`.
    Tune,
    /// `samara design`.
    Design,
    /// `samara drop`: one whole drop.
    Drop,
    /// `samara drop --cases`: a drop of each release case.
    Cases,
    /// `samara assess`: flights from t = 0 by the mission's own gains.
    Campaign,
    /// `samara assess --autopilot`: whole drops.
    DropCampaign,
    /// `samara assess --rare`.
    Rare,
    /// `samara assess --envelope`.
    Envelope,
}

impl Kind {
    /// The kind of a verb of a manifest; `None` for runs that a card does not read.
    pub fn of_verb(verb: &str) -> Option<Self> {
        match verb {
            "plan" => Some(Self::Plan),
            "tune" => Some(Self::Tune),
            "design" => Some(Self::Design),
            "drop" => Some(Self::Drop),
            "cases" => Some(Self::Cases),
            "assess" => Some(Self::Campaign),
            "assess_rare" => Some(Self::Rare),
            "assess_envelope" => Some(Self::Envelope),
            _ => verb.starts_with(DROPS).then_some(Self::DropCampaign),
        }
    }

    /// The kind of a file of results, by its name; `None` for what a card does not read.
    pub fn of_file(name: &str) -> Option<Self> {
        match name {
            "plan.json" => Some(Self::Plan),
            "design.json" => Some(Self::Design),
            "drop.json" => Some(Self::Drop),
            "cases.json" => Some(Self::Cases),
            "assess.json" => Some(Self::Campaign),
            "rare.json" => Some(Self::Rare),
            "envelope.json" => Some(Self::Envelope),
            _ => (name.starts_with(DROPS) && name.ends_with(".json") && !name.ends_with("_manifest.json"))
                .then_some(Self::DropCampaign),
        }
    }

    /// The file of a run of this kind that a card reads.
    pub fn file(self, verb: &str) -> String {
        match self {
            Self::Plan => "plan.json".to_owned(),
            // A tuning is the gains that it found.
            Self::Tune => "gains.json".to_owned(),
            Self::Design => "design.json".to_owned(),
            Self::Drop => "drop.json".to_owned(),
            Self::Cases => "cases.json".to_owned(),
            Self::Campaign => "assess.json".to_owned(),
            Self::Rare => "rare.json".to_owned(),
            Self::Envelope => "envelope.json".to_owned(),
            Self::DropCampaign => format!("{verb}.json"),
        }
    }

    /// A name for people.
    pub fn words(self) -> &'static str {
        match self {
            Self::Plan => "plan",
            Self::Tune => "tuning",
            Self::Design => "design",
            Self::Drop => "drop",
            Self::Cases => "drops of the release cases",
            Self::Campaign => "campaign of flights from t = 0",
            Self::DropCampaign => "campaign of whole drops",
            Self::Rare => "search of rare failures",
            Self::Envelope => "safe-release envelope",
        }
    }
}

/// How the verb of a campaign of whole drops begins.
const DROPS: &str = "drops_";
