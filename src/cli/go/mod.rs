//! `samara go`: from a mission to its release card, by the verbs that a user would type, one after the other.
//!
//! | file | holds |
//! |---|---|
//! | `args` | what can be typed |
//! | `ledger` | what has been done, by which one that was stopped goes on |
//! | this one | the steps, in their order |

mod args;
mod ledger;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::answer::{Answer, Failure};
use super::args::parsed;
use super::assess::{self, AssessArgs};
use super::card::{self, CardArgs};
use super::check::{self, CheckArgs};
use super::drop::{self, DropArgs};
use super::mission::has_a_drop;
use super::results::{OutputFolder, place_of};
use super::study::{self, StudyVerbArgs};
use super::system::was_interrupted;
use super::terminal::{held, print, print_err};
pub use args::GoArgs;
use ledger::{Entry, Ledger, Said};
use samara::assess::ChosenAmong;
use samara::config::Mission;
use samara::report::json::VERSION;
use samara::report::shell::command_line;
use samara::study::card::demanded;
use samara::study::card::finding::fewest_trials;

/// A step on the way.
struct Step {
    name: &'static str,
    title: &'static str,
    /// The verb and what is typed after it, but for folder and output form.
    words: Vec<String>,
    run: fn(&[String]) -> Result<Answer, Failure>,
    /// How the files begin by which a flight that was stopped goes on; none where nothing is kept.
    rows: Option<&'static str>,
    /// Whether failures are the card's to judge, where some are accepted.
    counts: bool,
}

/// Goes the way to the card. Yes: the card is a go.
pub fn run(args: &GoArgs) -> Result<Answer, Failure> {
    let mission = card::present_mission(&args.card)?;
    has_a_drop(&mission)?;
    let root = args.card.mission.out.clone().unwrap_or_else(|| place_of(None, &mission.name).join("go"));
    let folder = OutputFolder::plain(&root)?;
    let way = Way { args, mission: &mission, root: &root, folder: &folder };
    let (walked, ended) = way.walk()?;
    let card = root.join("card.html");
    if args.card.mission.json {
        let steps: Vec<_> = walked.iter().map(Walked::json).collect();
        let card = (ended == Ended::AtTheCard).then(|| card.display().to_string());
        print(&format!(
            "{:#}\n",
            json!({ "version": VERSION, "mission": mission.name, "steps": steps, "ended": ended.name(), "card": card })
        ))?;
    } else {
        match ended {
            Ended::AtTheCard => print(&format!("start with {}\n", card.display()))?,
            Ended::AtANo => print("ended at the first no; --past-no goes on to the card\n")?,
            Ended::Stopped => print("stopped: the same command goes on\n")?,
        }
    }
    Ok(Answer::from(ended == Ended::AtTheCard && walked.last().is_some_and(|last| last.said.yes)))
}

/// How the way ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ended {
    AtTheCard,
    AtANo,
    Stopped,
}

impl Ended {
    const fn name(self) -> &'static str {
        match self {
            Self::AtTheCard => "card",
            Self::AtANo => "no",
            Self::Stopped => "stopped",
        }
    }
}

/// A step that has its answer.
struct Walked {
    name: &'static str,
    command: String,
    /// Whether the answer was there already.
    kept: bool,
    said: Said,
}

impl Walked {
    fn json(&self) -> serde_json::Value {
        let Self { name, command, kept, said } = self;
        json!({ "step": name, "command": command, "kept": kept, "yes": said.yes, "conclusion": said.conclusion })
    }
}

/// The way of one mission.
struct Way<'a> {
    args: &'a GoArgs,
    mission: &'a Mission,
    root: &'a Path,
    folder: &'a OutputFolder,
}

impl Way<'_> {
    /// Walks it to its end, or to the first no.
    fn walk(&self) -> Result<(Vec<Walked>, Ended), Failure> {
        let mut ledger = Ledger::read(self.root);
        let steps = self.steps();
        let count = steps.len();
        let mut walked: Vec<Walked> = Vec::new();
        for (number, step) in steps.iter().enumerate() {
            print_err(&format!("samara go: {} of {count}, {}: ", number + 1, step.title));
            let Some(done) = self.take(step, &mut ledger)? else { return Ok((walked, Ended::Stopped)) };
            if !self.args.card.mission.json {
                print(&line(number + 1, step, &done))?;
            }
            let (yes, is_last) = (done.said.yes, number + 1 == count);
            let goes_on = yes || self.args.past_no || (step.counts && self.args.card.p_failure.is_some());
            walked.push(done);
            if !goes_on && !is_last {
                return Ok((walked, Ended::AtANo));
            }
        }
        Ok((walked, Ended::AtTheCard))
    }

    /// The card of what lies in these folders, and in those that were named.
    fn of_card(&self, folders: &[PathBuf]) -> CardArgs {
        let mut card = self.args.card.clone();
        card.evidence.extend_from_slice(folders);
        card.mission.json = false;
        card.mission.out = Some(self.root.to_owned());
        card
    }

    /// The steps in their order.
    fn steps(&self) -> Vec<Step> {
        let card = &self.args.card;
        let word = card.mission_word(self.mission);
        let words = |verb: &[&str], more: Vec<String>| -> Vec<String> {
            let verb = verb.iter().map(|word| (*word).to_owned());
            verb.chain([word.clone()]).chain(card.options()).chain(more).collect()
        };
        let option = |name: &str, value: String| vec![name.to_owned(), value];
        let autopilot = || option("--autopilot", self.args.autopilot.to_string());
        let fewest = || fewest_trials(demanded(card.p_failure), ChosenAmong::new(card.chosen_among));
        let trials = || option("--trials", self.args.trials.unwrap_or_else(fewest).to_string());
        let step = |name, title, words, run| Step { name, title, words, run, rows: None, counts: false };
        let folders = ["drop", "campaign", "drops", "envelope"].map(|name| self.root.join(name));
        vec![
            step("check", "check", words(&["check"], vec![]), |w| check::run(&parsed::<CheckArgs>(w)?)),
            step("drop", "a drop", words(&["drop"], autopilot()), |w| drop::run(&parsed::<DropArgs>(w)?)),
            Step {
                rows: Some("campaign_"),
                counts: true,
                ..step("campaign", "campaign", words(&["assess"], trials()), |w| {
                    assess::run(parsed::<AssessArgs>(w)?)
                })
            },
            Step {
                rows: Some("drops_"),
                counts: true,
                ..step("drops", "whole drops", words(&["assess"], [autopilot(), trials()].concat()), |w| {
                    assess::run(parsed::<AssessArgs>(w)?)
                })
            },
            Step {
                rows: Some("envelope_rows"),
                ..step("envelope", "envelope", words(&["study", "envelope"], vec![]), |w| {
                    study::run(&parsed::<StudyVerbArgs>(w)?)
                })
            },
            step("card", "card", self.of_card(&folders).words(self.mission), |w| {
                card::run(&parsed::<CardArgs>(w)?)
            }),
        ]
    }

    /// The answer of a step, kept or found; `None`: it was stopped.
    fn take(&self, step: &Step, ledger: &mut Ledger) -> Result<Option<Walked>, Failure> {
        let is_card = step.name == "card";
        let place = if is_card { self.root.to_owned() } else { self.root.join(step.name) };
        let mut words = step.words.clone();
        if step.name != "check" && !is_card {
            words.extend(["--out".to_owned(), place.display().to_string()]);
        }
        let command = command_line(["samara".to_owned()].into_iter().chain(words.iter().cloned()));
        let inputs = self.mission.inputs.hash.clone();
        let known = ledger.of(step.name, &command, &inputs).cloned();
        // A look at numbers and the card itself take no time, and are never kept.
        if let Some(Entry { answer: Some(said), .. }) = &known
            && !is_card
            && step.name != "check"
            && card::accepts(&CardArgs { evidence: vec![place.clone()], ..self.args.card.clone() })?
        {
            print_err("kept\n");
            return Ok(Some(Walked { name: step.name, command, kept: true, said: said.clone() }));
        }
        let begun = known.is_some_and(|entry| entry.answer.is_none());
        if begun && step.rows.is_some_and(|rows| has(&place, rows)) {
            words.push("--resume".to_owned());
        }
        print_err(&format!("{command}\n"));
        let entry = Entry { command: command.clone(), inputs, answer: None };
        ledger.note(step.name, entry.clone(), self.folder)?;
        let (answer, text) = held(|| (step.run)(&words));
        let answer = match answer {
            Ok(answer) => answer,
            // What the verb had to say before it failed belongs to the failure.
            Err(failure) => {
                print_err(&text);
                return Err(failure);
            }
        };
        if was_interrupted() {
            return Ok(None);
        }
        let said = said(step, answer == Answer::Yes, &text);
        ledger.note(step.name, Entry { answer: Some(said.clone()), ..entry }, self.folder)?;
        Ok(Some(Walked { name: step.name, command, kept: false, said }))
    }
}

/// Whether a folder has something whose name begins so.
fn has(folder: &Path, begins: &str) -> bool {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.into_iter().any(|entry| entry.file_name().to_string_lossy().starts_with(begins))
}

/// How a line begins that is a command.
const COMMAND: &str = "samara ";
/// How a line begins that says what causes a no.
const CAUSE: &str = "cause: ";

/// The conclusion of what a verb has printed.
fn said(step: &Step, yes: bool, text: &str) -> Said {
    let lines = || text.lines().map(str::trim).filter(|line| !line.is_empty());
    let conclusion: Vec<String> = match (step.name, yes) {
        // All that is odd stands below its heading.
        ("check", false) => {
            let found = lines().skip_while(|line| *line != "odd").skip(1);
            found.filter(|line| !line.starts_with(COMMAND)).map(str::to_owned).collect()
        }
        // The decision is the first line, what speaks against it is indented.
        ("card", _) => {
            let of_mission = |line: &&str| line.starts_with("mission ") || line.starts_with("gains ");
            let mut said = text.lines().filter(|line| !of_mission(line));
            let first = said.next().map(str::to_owned);
            first
                .into_iter()
                .chain(said.take_while(|line| line.starts_with("  ")).map(str::to_owned))
                .collect()
        }
        _ => {
            let cause = lines().rfind(|line| line.starts_with(CAUSE));
            let last = lines().rfind(|line| !line.starts_with(CAUSE) && !line.starts_with(COMMAND));
            last.into_iter().chain(cause).map(str::to_owned).collect()
        }
    };
    let mut closer: Vec<String> = Vec::new();
    for command in lines().filter(|line| line.starts_with(COMMAND)) {
        if !closer.iter().any(|known| known == command) {
            closer.push(command.to_owned());
        }
    }
    Said { yes, conclusion, closer }
}

/// A step for the terminal: its number, title and conclusion; where it is a no, the commands to look closer.
fn line(number: usize, step: &Step, walked: &Walked) -> String {
    let Said { yes, conclusion, closer } = &walked.said;
    let mut conclusion = conclusion.iter();
    let first = conclusion.next().map_or("", String::as_str);
    let kept = if walked.kept { " (kept)" } else { "" };
    let mut text = format!("{number} {:<12} {first}{kept}\n", step.title);
    conclusion.for_each(|line| text += &format!("               {}\n", line.trim_start()));
    if !yes && step.name != "card" {
        let again = if closer.is_empty() { std::slice::from_ref(&walked.command) } else { closer };
        again.iter().for_each(|command| text += &format!("               {command}\n"));
    }
    text
}
