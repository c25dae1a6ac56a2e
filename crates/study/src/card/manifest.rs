//! What a run says of itself in its `<verb>_manifest.json`, and the kinds of evidence that a card reads.

use std::collections::BTreeMap;

use samara_mission::Mission;
use samara_report::json::{VERSION, result_objects, text};

result_objects! {
    /// What a run had for input and what it wrote, as `<verb>_manifest.json` holds it.
    RunManifest(mission: &Mission, verb: &str, beside: &[(&str, String)], files: &BTreeMap<String, String>) [
        let circumstances = beside.iter().map(|(name, value)| ((*name).to_owned(), value.clone()));
    ] {
        /// Verb that was run, with what was asked of it: `drop`, `drops_<autopilot>_<gains>`.
        verb: String = verb.to_owned(),
        /// Version of samara that made the files.
        version: String = VERSION.to_owned(),
        /// Name of the mission.
        mission: String = mission.name.clone(),
        /// Name of the vehicle.
        vehicle: String = mission.vehicle_name.clone(),
        /// Name of the gains.
        gains: String = mission.control.gains_name.clone(),
        /// Seed of everything random.
        seed: u64 = mission.seed,
        /// SHA-256 of all inputs, hexadecimal.
        input_hash: String = mission.inputs.hash.clone(),
        /// Choices beside the files that decide the result.
        choices: BTreeMap<String, String> = mission.inputs.choices.iter().cloned().collect(),
        /// Circumstances that are no inputs: the vehicle's number, the speed of a watched run.
        circumstances: BTreeMap<String, String> = circumstances.collect(),
        /// SHA-256 of each file that was written, by its name, hexadecimal.
        files: BTreeMap<String, String> = files.clone(),
    }
}

/// The object of `<verb>_manifest.json`: circumstances show in the .tlog files only.
pub fn manifest_json(
    mission: &Mission,
    verb: &str,
    circumstances: &[(&str, String)],
    files: &BTreeMap<String, String>,
) -> String {
    text(&RunManifest::of(mission, verb, circumstances, files))
}

impl RunManifest {
    /// Trials that were asked for, of a campaign.
    pub fn trials(&self) -> Option<u64> {
        self.circumstances.get("trials")?.parse().ok()
    }

    /// The release or the plan that was flown, where it is not the mission's own, in words.
    pub fn elsewhere(&self) -> Option<String> {
        let case =
            self.choices.get("release case").map(|case| format!("release case {}", case.replace('_', "-")));
        let trial = || self.circumstances.get("trial").map(|trial| format!("trial {trial} of a campaign"));
        let given =
            || self.choices.get("trajectory sha256").map(|_| "a trajectory that was given".to_owned());
        case.or_else(trial).or_else(given)
    }

    /// Choices that the mission does not make, in words, beside release, seed and autopilot: `feed forward`.
    pub fn otherwise(&self) -> Vec<String> {
        let said = ["seed", "release case", "trajectory sha256", "autopilot", "estimator", "gains"];
        let others = self.choices.iter().filter(|(name, _)| !said.contains(&name.as_str()));
        let words = |(name, value): (&String, &String)| match value.as_str() {
            "yes" => name.clone(),
            value => format!("{name} {value}"),
        };
        others.map(words).collect()
    }
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
    /// `samara study rare`.
    Rare,
    /// `samara study envelope`.
    Envelope,
}

/// What a card knows of a kind of evidence.
struct About {
    /// Verb of its manifest; of a campaign of whole drops, how that begins.
    verb: &'static str,
    /// File that a card reads; of a campaign of whole drops, how its name ends.
    file: &'static str,
    /// A name for people.
    words: &'static str,
}

const fn about(verb: &'static str, file: &'static str, words: &'static str) -> About {
    About { verb, file, words }
}

impl Kind {
    /// Every kind, in order.
    const ALL: [Self; 9] = [
        Self::Plan,
        Self::Tune,
        Self::Design,
        Self::Drop,
        Self::Cases,
        Self::Campaign,
        Self::DropCampaign,
        Self::Rare,
        Self::Envelope,
    ];

    const fn about(self) -> About {
        match self {
            Self::Plan => about("plan", "plan.json", "plan"),
            // A tuning is the gains that it found.
            Self::Tune => about("tune", "gains.json", "tuning"),
            Self::Design => about("design", "design.json", "design"),
            Self::Drop => about("drop", "drop.json", "drop"),
            Self::Cases => about("cases", "cases.json", "drops of the release cases"),
            Self::Campaign => about("assess", "assess.json", "campaign of flights from t = 0"),
            Self::DropCampaign => about("drops_", ".json", "campaign of whole drops"),
            Self::Rare => about("assess_rare", "rare.json", "search of rare failures"),
            Self::Envelope => about("assess_envelope", "envelope.json", "safe-release envelope"),
        }
    }

    /// The kind of a verb of a manifest; `None` for runs that a card does not read.
    pub fn of_verb(verb: &str) -> Option<Self> {
        let is_of = |kind: &Self| match kind {
            Self::DropCampaign => verb.starts_with(kind.about().verb),
            _ => verb == kind.about().verb,
        };
        Self::ALL.into_iter().find(is_of)
    }

    /// The kind of a file of results, by its name; `None` for what a card does not read.
    pub fn of_file(name: &str) -> Option<Self> {
        let is_of = |kind: &Self| match kind {
            // Gains by themselves are no result.
            Self::Tune => false,
            Self::DropCampaign => {
                let About { verb, file, .. } = kind.about();
                name.starts_with(verb) && name.ends_with(file) && !name.ends_with(MANIFEST)
            }
            _ => name == kind.about().file,
        };
        Self::ALL.into_iter().find(is_of)
    }

    /// The file of a run of this kind that a card reads.
    pub fn file(self, verb: &str) -> String {
        let file = self.about().file;
        if self == Self::DropCampaign { format!("{verb}{file}") } else { file.to_owned() }
    }

    /// A name for people.
    pub fn words(self) -> &'static str {
        self.about().words
    }
}

/// How the names of manifests end.
pub const MANIFEST: &str = "_manifest.json";
