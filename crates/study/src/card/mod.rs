//! The release card: what a review board signs before a drop - one page of sentences, each with the evidence
//! that it rests on, and whether to go. The evidence is what other verbs have written; a card flies nothing.
//!
//! | file | holds |
//! |---|---|
//! | [`manifest`] | what a run says of itself, and the kinds of evidence |
//! | [`finding`] | what is taken of the results of other verbs, and whether they hold |
//! | this one | the card: its evidence, and the conclusion |
//! | [`decision`] | whether to go: within the whole envelope, restricted, or not |
//! | [`estimates`] | what the inputs merely estimate |
//! | [`sections`] | the sentences of the card |
//! | [`assumptions`] | what is assumed, and what was never modelled |
//! | [`command`] | the commands that make evidence again |
//! | [`json`] | `card.json` |
//! | [`page`] | `card.html` |

pub mod assumptions;
pub mod command;
pub mod decision;
pub mod estimates;
pub mod finding;
pub mod json;
pub mod manifest;
pub mod page;
pub mod sections;
#[cfg(test)]
mod tests;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::campaign::json::{AssessObject, CampaignObject};
use crate::designing::report::DesignObject;
use crate::envelope::report::EnvelopeObject;
use crate::rare::report::RareObject;
use finding::{Finding, Shortfall, fewest_trials, probability};
use manifest::{Kind, RunManifest};
use samara_core::assess::envelope::search::PROBABILITY;
use samara_core::assess::{CONFIDENCE, ChosenAmong};
use samara_mission::{Effect, Mission};
use samara_report::columns::short;
use samara_report::json::DropObject;
use samara_report::shell::command_line;

/// A file that the mission is read from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputFile {
    /// "mission", "vehicle", "gains", "parameters", or what the mission calls it: "rotor table".
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
    /// The mission as a command names it.
    pub mission_word: String,
    /// The files that it is read from.
    pub inputs: Vec<InputFile>,
    /// All evidence that was found, in the order of its numbers: E1 is the first.
    pub evidence: Vec<Evidence>,
    /// The probability of failure that is accepted, where one was named.
    pub accepted: Option<f64>,
    /// How many designs this one was chosen among by the trials of the evidence.
    pub among: ChosenAmong,
    /// Whether what the inputs merely estimate is accepted.
    pub accepts_estimates: bool,
    /// How gains or parameters were chosen, as options of any verb.
    pub chosen: Vec<String>,
    /// The command that makes the card again.
    pub command: String,
}

/// Kinds of reasons not to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ReasonKind {
    /// Evidence says no.
    Failed,
    /// Evidence is missing, or refused.
    Missing,
    /// Inputs are estimates that nobody has accepted.
    Estimated,
}

/// Why not to go.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Reason {
    /// What kind of a reason it is.
    pub kind: ReasonKind,
    /// The reason, a sentence without a full stop.
    pub text: String,
    /// The evidence that it rests on.
    pub from: Vec<String>,
}

/// What a card must rest on: a name, the kinds of which one is enough, and verb and options of the command
/// that makes it.
struct Need {
    name: &'static str,
    kinds: &'static [Kind],
    verb: &'static str,
    options: &'static [&'static str],
}

impl Evidence {
    /// The run, where the evidence is of one that is accepted.
    fn accepted(&self) -> Option<(&RunManifest, &Finding)> {
        Some((self.run.as_ref()?, self.found.as_ref().ok()?))
    }

    /// The release or the plan that was flown, where it is not the mission's own, in words.
    fn elsewhere(&self) -> Option<String> {
        self.run.as_ref()?.elsewhere()
    }

    /// Kind of evidence in words, with the release or the plan that is not the mission's.
    fn words(&self) -> String {
        let elsewhere = self.elsewhere().map_or_else(String::new, |elsewhere| format!(" ({elsewhere})"));
        self.kind.words().to_owned() + &elsewhere
    }

    /// What makes it not what the mission says, beside release and plan, in words; empty where nothing does.
    fn otherwise(&self) -> String {
        self.run.as_ref().map_or_else(String::new, |run| run.otherwise().join(", "))
    }
}

/// The probability of failure that is asked for, where this one is accepted, or none is named.
pub fn demanded(accepted: Option<f64>) -> f64 {
    // What rounding leaves of the difference is no part of it.
    accepted.unwrap_or_else(|| (1e9 * (1.0 - PROBABILITY)).round() / 1e9)
}

impl Card<'_> {
    /// The greatest probability of failure that a campaign may leave possible: the accepted one, else what
    /// is left of the share of safe flights that an envelope's edge stands for.
    pub fn demanded(&self) -> f64 {
        demanded(self.accepted)
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

    fn drops(&self) -> impl Iterator<Item = (String, &Evidence, &DropObject)> {
        self.standing().filter_map(|(id, evidence, _, found)| match found {
            Finding::Drop(drop) => Some((id, evidence, drop)),
            _ => None,
        })
    }

    fn campaigns(&self) -> impl Iterator<Item = (String, &RunManifest, &AssessObject)> {
        self.standing().filter_map(|(id, _, run, found)| match found {
            Finding::Campaign(campaign) => Some((id, run, campaign)),
            _ => None,
        })
    }

    fn rare(&self) -> impl Iterator<Item = (String, &RunManifest, &RareObject)> {
        self.standing().filter_map(|(id, _, run, found)| match found {
            Finding::Rare(rare) => Some((id, run, rare)),
            _ => None,
        })
    }

    fn designs(&self) -> impl Iterator<Item = (String, &DesignObject)> {
        self.standing().filter_map(|(id, _, _, found)| match found {
            Finding::Design(design) => Some((id, design)),
            _ => None,
        })
    }

    /// Envelopes of the mission's own release.
    fn envelopes(&self) -> impl Iterator<Item = (String, &EnvelopeObject)> {
        self.standing().filter_map(|(id, evidence, _, found)| match found {
            Finding::Envelope(envelope) if evidence.elsewhere().is_none() => Some((id, envelope)),
            _ => None,
        })
    }

    /// Effects that the mission names and that flights from t = 0 leave out: they act, or are drawn, in whole
    /// drops only.
    fn left_out_from_t0(&self) -> Vec<Effect> {
        let named = self.mission.effects();
        let mut left_out = vec![Effect::RandomWind, Effect::Canopy, Effect::RotorStart, Effect::Battery];
        left_out.retain(|effect| named.contains(effect));
        left_out
    }

    /// What the card must rest on: flights from t = 0 are a campaign of the mission where they have all that
    /// it names.
    fn needs(&self) -> [Need; 3] {
        let whole_drops = !self.left_out_from_t0().is_empty();
        let (verb, kinds) = ("assess", &[Kind::Campaign, Kind::DropCampaign]);
        [
            Need { name: "drop from the nominal release", kinds: &[Kind::Drop], verb: "drop", options: &[] },
            match whole_drops {
                true => Need {
                    name: "campaign of whole drops",
                    kinds,
                    verb,
                    options: &["--autopilot", "reference"],
                },
                false => Need { name: "campaign", kinds, verb, options: &[] },
            },
            Need {
                name: "safe-release envelope",
                kinds: &[Kind::Envelope],
                verb: "study envelope",
                options: &[],
            },
        ]
    }

    /// Why not to go: what evidence says no to, then what is missing or refused, then estimates that are not
    /// accepted. None: go, within the envelope or a part of it.
    pub fn reasons(&self) -> Vec<Reason> {
        let failed = self.standing().filter_map(|(id, evidence, _, found)| {
            let text = format!("{}: {}", evidence.words(), self.fault(found)?);
            Some(Reason { kind: ReasonKind::Failed, text, from: vec![id] })
        });
        let missing = self.needs().into_iter().filter_map(|need| self.missing(&need));
        failed.chain(self.not_covered()).chain(missing).chain(self.not_accepted()).collect()
    }

    /// Why there is nothing that is enough for a need, if there is nothing.
    fn missing(&self, need: &Need) -> Option<Reason> {
        let of_kind: Vec<(usize, &Evidence)> = self
            .evidence
            .iter()
            .enumerate()
            .filter(|(_, evidence)| need.kinds.contains(&evidence.kind))
            .collect();
        // What says no is a reason already.
        let says_no =
            |evidence: &Evidence| evidence.accepted().is_some_and(|(_, found)| self.fault(found).is_some());
        if of_kind.iter().any(|(_, evidence)| self.shortfall(evidence).is_none() || says_no(evidence)) {
            return None;
        }
        let verb = std::iter::once("samara").chain(need.verb.split(' '));
        let mut words: Vec<String> = verb.map(str::to_owned).collect();
        words.push(self.mission_word.clone());
        words.extend(self.chosen.iter().cloned());
        words.extend(need.options.iter().map(|option| (*option).to_owned()));
        let (trials, usual) =
            (fewest_trials(self.demanded(), self.among), self.mission.study.monte_carlo.trials as u64);
        if need.kinds.contains(&Kind::Campaign) && usual < trials {
            words.extend(["--trials".to_owned(), trials.to_string()]);
        }
        let (name, command) = (need.name, command_line(words));
        let short = of_kind.iter().filter_map(|(place, evidence)| Some((*place, self.shortfall(evidence)?)));
        let nearest = short.min_by(|(_, a), (_, b)| a.distance.total_cmp(&b.distance));
        let text = match nearest {
            None => format!("a {name} is missing: {command}"),
            Some((place, Shortfall { why, .. })) => {
                format!("no {name} is enough ({}: {why}): {command}", Self::id(place))
            }
        };
        let from = of_kind.iter().map(|(place, _)| Self::id(*place)).collect();
        Some(Reason { kind: ReasonKind::Missing, text, from })
    }

    /// Why a piece of evidence is not enough of its kind, if it is not.
    fn shortfall(&self, evidence: &Evidence) -> Option<Shortfall> {
        let (run, found) = match (&evidence.found, &evidence.run) {
            (Err(why), _) => return Some(Shortfall::refused(why)),
            (Ok(found), Some(run)) => (run, found),
            (Ok(_), None) => return None,
        };
        if let Some(elsewhere) = run.elsewhere() {
            return Some(Shortfall::of_kind(format!("it is of {elsewhere}")));
        }
        match found {
            Finding::Campaign(campaign) => {
                let left_out = self.left_out_from_t0();
                if evidence.kind == Kind::Campaign && !left_out.is_empty() {
                    let left_out: Vec<&str> = left_out.into_iter().map(Effect::name).collect();
                    let why = format!("from t = 0, without what the mission names: {}", left_out.join(", "));
                    return Some(Shortfall::of_kind(why));
                }
                campaign.shortfall(run.trials(), self.demanded(), self.among)
            }
            Finding::Envelope(envelope) => {
                let why = format!("it has not looked at {}", envelope.not_looked_at()?);
                Some(Shortfall { distance: envelope.missing_share(), why })
            }
            _ => None,
        }
    }

    /// Why evidence says no, if it does.
    fn fault(&self, found: &Finding) -> Option<String> {
        match found {
            Finding::Plan(plan) => plan.fault(self.mission),
            Finding::Tune(_) => None,
            Finding::Design(design) => design.fault(self.accepted),
            Finding::Drop(drop) => drop.fault().map(|fault| format!("not safe: {fault}")),
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
            Finding::Campaign(campaign) => campaign.fault(self.accepted, self.among),
            Finding::Rare(rare) => rare.fault(self.demanded()),
            Finding::Envelope(envelope) => envelope.fault(),
        }
    }

    /// Failures that accepted evidence has, though it does not say no, in words.
    fn failures(&self) -> Vec<String> {
        let trials = self.campaigns().filter_map(|(id, _, campaign)| {
            let CampaignObject { trials, unsafe_trials, .. } = campaign.judged()?;
            (*unsafe_trials > 0).then(|| format!("{unsafe_trials} of {trials} trials failed ({id})"))
        });
        let fresh = self.designs().filter_map(|(id, design)| {
            let fresh = design.hardest_air().filter(|fresh| fresh.results.any_failed())?;
            Some(format!("{} ({id})", fresh.results.words()))
        });
        let searched = self.rare().filter(|(_, _, rare)| rare.is_of_failures() && rare.probability > 0.0);
        let searched = searched.map(|(id, _, rare)| {
            format!(
                "{} has a probability of {} ({id})",
                rare.event(),
                probability(rare.probability, f64::round)
            )
        });
        trials.chain(fresh).chain(searched).collect()
    }

    /// The conclusion in sentences: whether to go, what failed, and the probability of failure that was asked
    /// for.
    pub fn conclusion(&self) -> String {
        let reasons = self.reasons();
        let verdict = self.verdict(&reasons);
        let p = short(self.demanded(), 12);
        if !reasons.is_empty() {
            let asked = match self.accepted {
                Some(_) => format!("A probability of failure of up to {p} is accepted"),
                None => format!(
                    "No failure is accepted, and a probability of failure of at most {p} is asked for"
                ),
            };
            return format!("{verdict}. {asked}.");
        }
        let failures = match self.failures() {
            none if none.is_empty() => "no trial failed".to_owned(),
            some => first(&some, NAMED),
        };
        let asked = match self.accepted {
            Some(_) => format!("A probability of failure of up to {p} is accepted"),
            None => format!("A probability of failure of at most {p} is asked for"),
        };
        let by = self.evidence.iter().enumerate().filter(|(_, evidence)| {
            matches!(evidence.found, Ok(Finding::Campaign(_))) && self.shortfall(evidence).is_none()
        });
        let by: Vec<String> = by.map(|(place, _)| Self::id(place)).collect();
        let percent = short(100.0 * CONFIDENCE, 1);
        let by = first(&by, NAMED);
        let mut text = format!(
            "{verdict}; {failures}. {asked}; {by} leaves no more possible, at {percent} % confidence."
        );
        let otherwise: Vec<String> = self
            .standing()
            .filter(|(_, evidence, ..)| !evidence.otherwise().is_empty())
            .map(|(id, evidence, ..)| format!("{id} ({})", evidence.otherwise()))
            .collect();
        if !otherwise.is_empty() {
            text += &format!(" Not as the mission says: {}.", first(&otherwise, NAMED));
        }
        if !self.estimates().is_empty() {
            text += " Estimates of the inputs are accepted.";
        }
        text
    }
}

/// Most failures and most pieces of evidence that the conclusion names.
const NAMED: usize = 3;

/// The first so many words with commas between, and how many more there are.
fn first(words: &[String], most: usize) -> String {
    let shown = words.iter().take(most).cloned().collect::<Vec<_>>().join(", ");
    match words.len().saturating_sub(most) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}
