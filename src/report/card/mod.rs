//! The release card: what a review board signs before a drop - one page of sentences, each with the evidence
//! that it rests on, and whether to go. The evidence is what other verbs have written; a card flies nothing.
//!
//! | file | holds |
//! |---|---|
//! | [`manifest`] | what a run says of itself, and the kinds of evidence |
//! | [`finding`] | what is taken of the results of other verbs, and whether they hold |
//! | this one | the card: its evidence, and the conclusion |
//! | [`sections`] | the sentences of the card |
//! | [`assumptions`] | what is assumed, and what was never modelled |
//! | [`command`] | the commands that make evidence again |
//! | [`json`] | `card.json` |
//! | [`page`] | `card.html` |

pub mod assumptions;
pub mod command;
pub mod finding;
pub mod json;
pub mod manifest;
pub mod page;
pub mod sections;

use crate::assess::envelope::search::PROBABILITY;
use crate::config::Mission;
use crate::report::shell::command_line;
use finding::{CampaignFound, DropFound, EnvelopeFound, Finding, RareFound, fewest_trials};
use manifest::{Kind, RunManifest};

/// A file that the mission is read from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputFile {
    /// "mission", "vehicle" or "gains".
    pub role: &'static str,
    /// Path, as it was found; of what is inside the program it begins with `built-in:`.
    pub file: String,
    /// SHA-256, hexadecimal.
    pub sha256: String,
}

/// A piece of evidence that was found.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// Subject of the evidence.
    pub kind: Kind,
    /// Path of its file, as it was found.
    pub file: String,
    /// Path of its file from the card's folder.
    pub link: String,
    /// SHA-256 of the file, hexadecimal; `None`: it cannot be read.
    pub sha256: Option<String>,
    /// The run that wrote it; `None`: no manifest lists it.
    pub run: Option<RunManifest>,
    /// The finding, or why the evidence is refused.
    pub found: Result<Finding, String>,
    /// The command that makes it again, where that is known.
    pub command: Option<String>,
}

/// The release card of a mission.
#[derive(Clone, Debug)]
pub struct Card<'a> {
    /// The mission, with the chosen gains.
    pub mission: &'a Mission,
    /// The files that it is read from.
    pub inputs: Vec<InputFile>,
    /// All evidence that was found, in the order of its numbers: E1 is the first.
    pub evidence: Vec<Evidence>,
    /// The probability of failure that is accepted, where one was named.
    pub accepted: Option<f64>,
    /// How gains or parameters were chosen, as options of any verb.
    pub chosen: Vec<String>,
    /// The command that makes the card again.
    pub command: String,
}

/// Why not to go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reason {
    /// Whether evidence says no; else it is missing, or refused.
    pub failed: bool,
    /// The reason, a sentence without a full stop.
    pub text: String,
    /// The evidence that it rests on.
    pub from: Vec<String>,
}

/// What a card must rest on: the kinds of which one is enough, a name, and the command that makes it, after
/// `samara VERB MISSION`.
const NEEDED: [(&[Kind], &str, &str, &[&str]); 3] = [
    (&[Kind::Drop], "drop from the nominal release", "drop", &[]),
    (&[Kind::Campaign, Kind::DropCampaign], "campaign", "assess", &[]),
    (&[Kind::Envelope], "safe-release envelope", "assess", &["--envelope"]),
];

impl Evidence {
    /// The run, where the evidence is of one that is accepted.
    fn accepted(&self) -> Option<(&RunManifest, &Finding)> {
        Some((self.run.as_ref()?, self.found.as_ref().ok()?))
    }

    /// The release that a drop came from, where it is not the nominal one, in words.
    fn release_words(&self) -> Option<String> {
        let run = self.run.as_ref()?;
        let case =
            run.choices.get("release case").map(|case| format!("release case {}", case.replace('_', "-")));
        case.or_else(|| run.circumstances.get("trial").map(|trial| format!("trial {trial} of a campaign")))
    }
}

impl Card<'_> {
    /// The greatest probability of failure that a campaign may leave possible: the accepted one, else what
    /// is left of the share of safe flights that an envelope's edge stands for.
    pub fn demanded(&self) -> f64 {
        // What rounding leaves of the difference is no part of it.
        self.accepted.unwrap_or_else(|| (1e9 * (1.0 - PROBABILITY)).round() / 1e9)
    }

    /// Number of a piece of evidence, as sentences name it.
    fn id(place: usize) -> String {
        format!("E{}", place + 1)
    }

    /// Evidence that is accepted, with its number.
    fn standing(&self) -> impl Iterator<Item = (String, &Evidence, &RunManifest, &Finding)> {
        self.evidence.iter().enumerate().filter_map(|(place, evidence)| {
            let (run, found) = evidence.accepted()?;
            Some((Self::id(place), evidence, run, found))
        })
    }

    /// Evidence that is refused, with its number and why.
    pub fn refused(&self) -> impl Iterator<Item = (String, &Evidence, &str)> {
        self.evidence.iter().enumerate().filter_map(|(place, evidence)| {
            let why = evidence.found.as_ref().err()?;
            Some((Self::id(place), evidence, why.as_str()))
        })
    }

    fn drops(&self) -> impl Iterator<Item = (String, &Evidence, &DropFound)> {
        self.standing().filter_map(|(id, evidence, _, found)| match found {
            Finding::Drop(drop) => Some((id, evidence, drop)),
            _ => None,
        })
    }

    fn campaigns(&self) -> impl Iterator<Item = (String, &RunManifest, &CampaignFound)> {
        self.standing().filter_map(|(id, _, run, found)| match found {
            Finding::Campaign(campaign) => Some((id, run, campaign)),
            _ => None,
        })
    }

    fn rare(&self) -> impl Iterator<Item = (String, &RunManifest, &RareFound)> {
        self.standing().filter_map(|(id, _, run, found)| match found {
            Finding::Rare(rare) => Some((id, run, rare)),
            _ => None,
        })
    }

    fn envelopes(&self) -> impl Iterator<Item = (String, &EnvelopeFound)> {
        self.standing().filter_map(|(id, _, _, found)| match found {
            Finding::Envelope(envelope) => Some((id, envelope)),
            _ => None,
        })
    }

    /// Why not to go: what evidence says no to, then what is missing or refused. None: go, within the
    /// envelope.
    pub fn reasons(&self) -> Vec<Reason> {
        let failed = self.standing().filter_map(|(id, evidence, _, found)| {
            let text = format!("{}: {}", evidence.kind.words(), self.fault(evidence, found)?);
            Some(Reason { failed: true, text, from: vec![id] })
        });
        let missing = NEEDED.iter().filter_map(|(kinds, name, verb, options)| {
            let of_kind =
                || self.evidence.iter().enumerate().filter(|(_, evidence)| kinds.contains(&evidence.kind));
            let short: Vec<(String, Option<String>)> =
                of_kind().map(|(place, evidence)| (Self::id(place), self.shortfall(evidence))).collect();
            // What says no is a reason already.
            let says_no = |evidence: &Evidence| {
                evidence.accepted().is_some_and(|(_, found)| self.fault(evidence, found).is_some())
            };
            let enough = short.iter().any(|(_, shortfall)| shortfall.is_none());
            if enough || of_kind().any(|(_, evidence)| says_no(evidence)) {
                return None;
            }
            let file = self.mission.file.display().to_string();
            let mission =
                file.strip_prefix("built-in:").map_or(file.as_str(), |_| self.mission.name.as_str());
            let chosen = self.chosen.iter().map(String::as_str);
            let words = ["samara", *verb, mission].into_iter().chain(chosen).chain(options.iter().copied());
            let mut words: Vec<String> = words.map(str::to_owned).collect();
            let (trials, usual) =
                (fewest_trials(self.demanded()), self.mission.study.monte_carlo.trials as u64);
            if kinds.contains(&Kind::Campaign) && usual < trials {
                words.extend(["--trials".to_owned(), trials.to_string()]);
            }
            let command = command_line(words);
            let first = short.first().and_then(|(id, shortfall)| Some((id, shortfall.as_ref()?)));
            let text = match first {
                None => format!("a {name} is missing: {command}"),
                Some((id, why)) => format!("no {name} is enough ({id}: {why}): {command}"),
            };
            Some(Reason { failed: false, text, from: short.into_iter().map(|(id, _)| id).collect() })
        });
        failed.chain(missing).collect()
    }

    /// Why a piece of evidence is not enough of its kind, if it is not.
    fn shortfall(&self, evidence: &Evidence) -> Option<String> {
        match (&evidence.found, &evidence.run) {
            (Err(why), _) => Some(format!("refused, {why}")),
            (Ok(Finding::Campaign(campaign)), Some(run)) => {
                let asked = run.circumstances.get("trials").and_then(|trials| trials.parse().ok());
                campaign.shortfall(asked, self.demanded())
            }
            (Ok(Finding::Drop(_)), _) => {
                evidence.release_words().map(|release| format!("it is of the {release}"))
            }
            _ => None,
        }
    }

    /// Why a piece of evidence says no, if it does.
    fn fault(&self, evidence: &Evidence, found: &Finding) -> Option<String> {
        match found {
            Finding::Plan(plan) if !plan.converged() => {
                let why = plan.diagnosis.as_deref().map_or_else(String::new, |why| format!(", {why}"));
                Some(format!("no plan was found: {}{why}", plan.status.replace('_', " ")))
            }
            Finding::Plan(_) | Finding::Tune(_) => None,
            Finding::Design(design) => design.fault(),
            Finding::Drop(drop) => drop.fault().map(|fault| match evidence.release_words() {
                Some(release) => format!("not safe ({release}): {fault}"),
                None => format!("not safe: {fault}"),
            }),
            Finding::Cases(cases) => {
                let failed: Vec<String> = cases
                    .iter()
                    .filter_map(|case| Some((case, case.drop.fault()?)))
                    .map(|(case, fault)| {
                        format!("{} by {}: {fault}", case.case.replace('_', "-"), case.autopilot)
                    })
                    .collect();
                let first = failed.first()?;
                Some(format!("{} of {} not safe, such as {first}", failed.len(), cases.len()))
            }
            Finding::Campaign(campaign) => campaign.fault(self.accepted),
            Finding::Rare(rare) => rare.fault(self.demanded()),
            Finding::Envelope(envelope) => envelope.fault(),
        }
    }

    /// The conclusion in a sentence.
    pub fn conclusion(&self) -> String {
        let reasons = self.reasons();
        let failed = reasons.iter().filter(|reason| reason.failed).count();
        match (reasons.len(), failed) {
            (0, _) => "Go, within the envelope below: every piece of evidence that is asked for is there, belongs to \
                       these inputs, and is safe."
                .to_owned(),
            (_, 0) => "No go: evidence that is asked for is missing.".to_owned(),
            (all, failed) if all == failed => "No go: the evidence speaks against it.".to_owned(),
            _ => "No go: the evidence speaks against it, and some that is asked for is missing.".to_owned(),
        }
    }
}
