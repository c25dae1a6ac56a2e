//! What a kind of study is: all that a host needs to begin it, and all that comes of it. Who offers a kind to
//! people - the program as a verb, Python as a function - asks for nothing else.

use std::ops::Range;
use std::path::Path;

use nalgebra::Vector3;
use samara_core::assess::Limits;
use samara_core::hints::No;
use samara_core::plan::Plan;
use samara_core::printable::printable;
use samara_core::sim::Sample;
use samara_core::trajectory::Trajectory;
use samara_mission::Mission;
use samara_report::document::{Check, Document, Figure, Passage, Section};
use samara_report::figure::FigureError;
use samara_report::html::Html;
use samara_report::json::VERSION;
use serde_json::{Map, Value, json};

use crate::feature::{Feature, Refusals};
use crate::jobs::{Jobs, Stopped};
use crate::settings::{Setting, Values};

/// What a kind of study is, for people.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// Name: `free_fall` is the verb `samara study free-fall`, and its files begin so.
    pub name: &'static str,
    /// Name in its manifest.
    pub manifest: &'static str,
    /// A line that says what it asks.
    pub title: &'static str,
    /// Help: examples first.
    pub help: &'static str,
    /// Name of its jobs, for people.
    pub unit: &'static str,
    /// Whatever it flies.
    pub flies: Flies,
    /// Table of its settings.
    pub settings: &'static [Setting],
    /// The claim that it judges, in words, or why it judges nothing.
    pub judges: Result<&'static str, &'static str>,
    /// How one of its flights alone is named, or why there is none.
    pub alone: Result<&'static str, &'static str>,
    /// What else it has not, each with the reason.
    pub refuses: Refusals,
}

impl About {
    /// Refuses a mission that begins on the ground, and faults of what is not flown.
    ///
    /// # Errors
    /// [`Refused`] for such a mission.
    pub fn suits(&self, mission: &Mission) -> Result<(), Refused> {
        match self.flies {
            Flies::FromT0 => mission.faults.check_from_t0().map_err(Refused::by)?,
            Flies::WholeDrops => mission.faults.check_without_wire().map_err(Refused::by)?,
            Flies::WithoutAPlan => {}
        }
        let words =
            format!("{} is about drops, and this mission begins on the ground", self.name.replace('_', "-"));
        if mission.release.standing { Err(Refused(words)) } else { Ok(()) }
    }

    /// Why a study of this kind has not this; `None` where it has it.
    pub fn refusal(&self, feature: Feature) -> Option<&'static str> {
        match feature {
            Feature::Only => self.alone.err(),
            Feature::Junit => self.judges.err(),
            _ => self.refuses.iter().find(|(of, _)| *of == feature).map(|(_, why)| *why),
        }
    }
}

/// What a kind of study flies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flies {
    /// Along the plan, from t = 0.
    FromT0,
    /// Whole drops along the plan, without a wire.
    WholeDrops,
    /// What needs no plan.
    WithoutAPlan,
}

/// What a study is about.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a> {
    /// The mission.
    pub mission: &'a Mission,
    /// The mission with its own gains, where others were chosen in their place.
    pub own: Option<&'a Mission>,
    /// The plan, which one [`Flies::WithoutAPlan`] has not.
    pub plan: Option<&'a Plan>,
    /// The folder that results go to, from which they name other files; `None`: by whole paths.
    pub folder: Option<&'a Path>,
}

impl<'a> Given<'a> {
    /// The plan.
    ///
    /// # Errors
    /// Where there is none.
    pub fn plan(&self) -> Result<&'a Plan, Refused> {
        self.plan.ok_or_else(|| Refused("a plan is expected".to_owned()))
    }
}

/// Why a mission has no such study, in words.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Refused(pub String);

impl Refused {
    /// A refusal in the words of an error.
    pub fn by(error: impl std::fmt::Display) -> Self {
        Self(error.to_string())
    }
}

/// The trial that `--only K` names, as the trials of a campaign of which it is the only one.
///
/// # Errors
/// [`Refused`] for what is no number of a trial.
pub(crate) fn trial_alone(name: &str) -> Result<Range<u64>, Refused> {
    let number = name.parse().ok().filter(|number| *number < u64::MAX);
    let refused =
        || format!("--only: the number of a trial, from 0, is expected, found `{}`", printable(name));
    number.map(|number| number..number + 1).ok_or_else(|| Refused(refused()))
}

/// Why a study has no results.
#[derive(Debug, thiserror::Error)]
pub enum Unfinished {
    /// It was stopped.
    #[error("stopped")]
    Stopped,
    /// A figure could not be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// Nothing was found, which is an answer.
    #[error("{why}")]
    Nothing {
        /// What was looked for: a key of the JSON object, where it is null.
        of: &'static str,
        /// Why there is none, in words.
        why: String,
    },
    /// A file that was made does not hold what it is to hold.
    #[error("a file that was made: {0}")]
    File(String),
}

impl From<Stopped> for Unfinished {
    fn from(_: Stopped) -> Self {
        Self::Stopped
    }
}

/// A kind of study.
pub trait Kind: Sync {
    /// All that it is, for people.
    fn about(&self) -> About;

    /// Whether a mission suits such a study.
    ///
    /// # Errors
    /// [`Refused`] for one that does not.
    fn suits(&self, mission: &Mission) -> Result<(), Refused> {
        self.about().suits(mission)
    }

    /// Why it does not fly what was put in the cascade's place; `None` where it does.
    fn flies_only(&self) -> Option<&'static str> {
        match self.about().flies {
            Flies::FromT0 | Flies::WholeDrops => None,
            Flies::WithoutAPlan => Some("it flies no controller"),
        }
    }

    /// What of a mission its flights do not have, in sentences.
    fn remarks(&self, mission: &Mission) -> Vec<String> {
        match self.about().flies {
            Flies::FromT0 => {
                mission.t0_remarks().into_iter().chain(mission.battery_remark().map(str::to_owned)).collect()
            }
            Flies::WholeDrops | Flies::WithoutAPlan => Vec::new(),
        }
    }

    /// What the rows of a study hang on beside the mission, as names and values: its settings, but for those
    /// that only end a stage of it, or come behind ([`Jobs::stage`]).
    ///
    /// # Errors
    /// [`Refused`] where a setting names what is not there.
    fn hangs_on(&self, mission: &Mission, values: &Values) -> Result<Vec<(&'static str, String)>, Refused> {
        let _ = mission;
        Ok(values.in_order(self.about().settings))
    }

    /// Begins a study.
    ///
    /// # Errors
    /// [`Refused`] for a mission that has none.
    fn begin<'a>(&self, given: Given<'a>, values: &Values) -> Result<Box<dyn Study + 'a>, Refused>;

    /// One flight alone, by what names it.
    ///
    /// # Errors
    /// [`Refused`] where there is none of that name, or of this kind.
    fn alone(&self, given: Given<'_>, values: &Values, name: &str) -> Result<Results, Refused> {
        let _ = (given, values, name);
        Err(Refused(self.about().alone.err().unwrap_or_default().to_owned()))
    }
}

impl dyn Kind + '_ {
    /// The first line of the rows of a study of this kind, which stands for everything that they hang on.
    ///
    /// # Errors
    /// [`Refused`] where a setting names what is not there.
    pub fn head(&self, mission: &Mission, values: &Values) -> Result<String, Refused> {
        let settings: Map<String, Value> = self
            .hangs_on(mission, values)?
            .into_iter()
            .map(|(name, text)| (name.to_owned(), text.into()))
            .collect();
        let object = json!({
            "study": self.about().name, "version": VERSION, "mission": mission.name, "seed": mission.seed,
            "gains": mission.control.gains_name, "input_hash": mission.inputs.hash, "settings": settings,
        });
        Ok(format!("# {object}\n"))
    }
}

/// In what the first line of rows differs from what is expected, in words; `None` where one is no such line.
pub fn differences(found: &str, expected: &str) -> Option<String> {
    let read = |line: &str| {
        let mut object: Map<String, Value> = serde_json::from_str(line.strip_prefix('#')?).ok()?;
        if let Some(Value::Object(settings)) = object.shift_remove("settings") {
            object.extend(settings);
        }
        Some(object)
    };
    let (found, expected) = (read(found)?, read(expected)?);
    let text = |value: Option<&Value>| match value {
        None => "nothing".to_owned(),
        Some(Value::String(text)) => printable(text).into_owned(),
        Some(other) => other.to_string(),
    };
    let changed = expected.iter().filter(|(name, value)| found.get(*name) != Some(value));
    let changed = changed.map(|(name, value)| {
        (name, format!("{name} was {}, is {}", text(found.get(name)), text(Some(value))))
    });
    let unknown = found.iter().filter(|(name, _)| !expected.contains_key(*name));
    let unknown =
        unknown.map(|(name, value)| (name, format!("{name} was {}, is unknown", text(Some(value)))));
    let mut words: Vec<(&String, String)> = changed.chain(unknown).collect();
    // The hash follows what has a name of its own.
    if words.len() > 1 {
        words.retain(|(name, _)| *name != "input_hash");
    }
    Some(words.into_iter().map(|(_, words)| words).collect::<Vec<_>>().join("; "))
}

/// A study that was begun.
pub trait Study {
    /// How many jobs it has, or the most that it may have.
    fn jobs(&self) -> u64;

    /// What is to be known before it flies, in sentences.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }

    /// Why its flights take long, where they do.
    fn slow(&self) -> Option<Slow<'_>> {
        None
    }

    /// Has its jobs flown, and says what came of them.
    ///
    /// # Errors
    /// [`Unfinished`] where it was stopped.
    fn run(&self, jobs: &mut dyn Jobs) -> Result<Results, Unfinished>;
}

/// Flights that take long.
pub struct Slow<'a> {
    /// Why, in words.
    pub reason: String,
    /// How many there are, at most.
    pub flights: u64,
    /// How many [`Self::try_some`] flies.
    pub tried: usize,
    /// Flies some, whose time is taken.
    pub try_some: Box<dyn Fn() + 'a>,
}

/// What came of a study. Its files are `<name>.txt`, `.json`, `.html` and `<name>_junit.xml`, and those that
/// are named here.
#[derive(Clone, Debug, Default)]
pub struct Results {
    /// The answer.
    pub document: Document,
    /// The object of `--json`.
    pub json: String,
    /// Tables and further files: name and text.
    pub files: Vec<(String, String)>,
    /// Figures.
    pub figures: Vec<Figure>,
    /// Flights to be looked at.
    pub flights: Vec<FlightFiles>,
    /// Names of files that are not written this time: those of an earlier run go.
    pub absent: Vec<String>,
    /// Whether the answer is yes.
    pub holds: bool,
    /// The answer in a sentence, where it has one.
    pub sentence: Option<String>,
    /// The noes that are in it.
    pub noes: Vec<No>,
    /// What there is to remark, in sentences.
    pub remarks: Vec<String>,
    /// Document and object as they are printed where they say how long it took, which no file does.
    pub timed: Option<(Document, String)>,
    /// Circumstances for the manifest beside the settings: names and values.
    pub noted: Vec<(&'static str, String)>,
    /// Whether these are of a study that was stopped, as far as it came.
    pub stopped: bool,
    /// The file that names one flight of these to be flown again alone, if there is one.
    pub again: Option<String>,
}

impl Results {
    /// The claim that a study judges as a test case, for continuous integration; none of one that judges
    /// nothing.
    pub fn junit(&self, about: &About, mission: &Mission) -> Option<String> {
        let claim = about.judges.ok()?;
        let failure = (!self.holds).then(|| format!("no: {}.txt has the numbers", about.name));
        let check = Check { group: about.name.to_owned(), name: claim.to_owned(), failure };
        Some(Document { checks: vec![check], ..Document::default() }.junit(&mission.name))
    }

    /// The answer as text.
    pub fn text(&self) -> String {
        let sentence = self.sentence.as_ref().map_or_else(String::new, |sentence| format!("{sentence}\n"));
        self.document.text() + &sentence
    }

    /// The page: the answer with the figures, whether the claim that is judged holds, and how all was made.
    pub fn page(&self, about: &About, mission: &Mission, values: &Values) -> String {
        let mut document = self.document.clone();
        document.verdict = about.judges.ok().map(|claim| {
            (self.holds, if self.holds { claim.to_owned() } else { format!("not shown: {claim}") })
        });
        if let Some(section) = document.sections.last_mut() {
            section.passages.extend(self.figures.iter().cloned().map(Passage::Figure));
        }
        let facts = [
            ("program", format!("samara {VERSION}")),
            ("inputs, SHA-256", mission.inputs.hash.clone()),
            ("seed", mission.seed.to_string()),
            ("gains", mission.control.gains_name.clone()),
        ];
        let facts = facts.into_iter().chain(values.in_order(about.settings));
        let facts = facts.map(|(name, text)| (name, Html::text(&text))).collect();
        let passages = vec![Passage::Facts(facts)];
        document.sections.push(Section { id: "origin", title: "How this was made", passages });
        document.page()
    }
}

/// A flight to be looked at by itself: `<name>.csv`, `.svg`, `.html` and `.mcap`.
#[derive(Clone, Debug)]
pub struct FlightFiles {
    /// What its files' names begin with.
    pub name: String,
    /// Title.
    pub title: String,
    /// Name of the gains.
    pub gains: String,
    /// The plan that was flown.
    pub plan: Trajectory,
    /// The flight.
    pub samples: Vec<Sample>,
    /// Limits that judge it.
    pub limits: Limits,
    /// Way from the release to t = 0, where the samples begin, NED [m].
    pub way_to_t0_ned_m: Vector3<f64>,
}
