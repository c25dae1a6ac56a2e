//! The command that makes campaigns again, and how campaigns end.

use std::path::Path;

use super::args::{AssessArgs, BOUND, PAPER};
use super::campaign::TrialRunner;
use crate::cli::answer::{Answer, Failure};
use crate::cli::args::AutopilotArg;
use crate::cli::system::Stopwatch;
use crate::cli::terminal::print;
use samara::config::Mission;
use samara::report::shell::command_line;
use samara::study::campaign::Keep;

/// The command that makes the campaigns again, its choices spelt out, quoted for a shell; folder and number
/// of threads do not belong to it.
pub struct Command {
    words: Vec<String>,
    keep: Option<Keep>,
    bound: f64,
}

impl Command {
    /// The command up to the number of trials.
    pub fn of(args: &AssessArgs, mission: &Mission) -> Self {
        let mut words = vec!["samara".to_owned(), "assess".to_owned()];
        if !(args.paper && args.mission.mission == Path::new(PAPER)) {
            words.push(args.mission.named(mission));
        }
        words.extend(args.paper.then(|| "--paper".to_owned()));
        words.extend(choices(args, mission));
        Self { words, keep: args.keep, bound: args.bound }
    }

    /// The command with the autopilot that flies whole drops.
    pub fn by(mut self, autopilot: &AutopilotArg) -> Self {
        self.words.extend(["--autopilot".to_owned(), autopilot.to_string()]);
        self
    }

    /// The whole command.
    pub fn with_trials(&self, trials: u64) -> String {
        // A merged campaign says what is usual, too.
        let keep = self.keep.filter(|keep| *keep != Keep::usual(trials));
        let keep = keep.map(|keep| ["--keep".to_owned(), name_of(keep)]);
        let trials = ["--trials".to_owned(), trials.to_string()];
        self.line(trials.into_iter().chain(keep.into_iter().flatten()))
    }

    /// The command that takes `--only`.
    pub fn alone(&self) -> String {
        self.line([])
    }

    fn line(&self, more: impl IntoIterator<Item = String>) -> String {
        let bound = (self.bound != BOUND).then(|| ["--bound".to_owned(), self.bound.to_string()]);
        command_line(self.words.iter().cloned().chain(more).chain(bound.into_iter().flatten()))
    }
}

/// The options that decide what is flown, but for the autopilot and how many trials.
fn choices(args: &AssessArgs, mission: &Mission) -> Vec<String> {
    let mut words = args.choice.words(mission);
    if args.state.asked() {
        words.extend(["--estimator", "ekf"].map(str::to_owned));
    }
    words.extend(args.feed_forward.then(|| "--feed-forward".to_owned()));
    words
}

fn name_of(keep: Keep) -> String {
    format!("{keep:?}").to_lowercase()
}

/// The arguments of `samara assess` that fly the campaign anywhere, its choices spelt out: without folder,
/// part, and whatever changes no result.
#[cfg(feature = "shards")]
pub fn arguments(args: &AssessArgs, mission: &Mission, trials: u64, keep: Keep) -> Vec<String> {
    let mut words = vec![args.mission.mission.display().to_string()];
    words.extend(choices(args, mission));
    words.extend(["--trials".to_owned(), trials.to_string(), "--keep".to_owned(), name_of(keep)]);
    if args.bound != BOUND {
        words.extend(["--bound".to_owned(), args.bound.to_string()]);
    }
    if let Some(autopilot) = &args.autopilot {
        words.extend(["--autopilot".to_owned(), autopilot.to_string()]);
    }
    words
}

/// Writes the manifest.
pub fn finish(args: &AssessArgs, runner: &TrialRunner<'_>) -> Result<(), Failure> {
    let circumstances = [("trials", runner.trials.to_string()), ("bound", args.bound.to_string())];
    runner.folder.write_manifest("assess", runner.mission, &circumstances)
}

/// Reports campaigns that are complete: how many flights they took, where any were `flown`, where the results
/// are, and last the verdict. `text` and `json` are of the results; the pace is for the terminal and `--json`
/// alone.
pub fn report(
    args: &AssessArgs,
    runner: &TrialRunner<'_>,
    flown: Option<(u64, &Stopwatch)>,
    json: impl FnOnce(Option<f64>) -> String,
    [text, verdict]: [String; 2],
) -> Result<(), Failure> {
    let pace = flown.map(|(flown, watch)| (flown, 1e3 * flown as f64 / watch.ms()));
    if args.mission.json {
        return print(&json(pace.filter(|(flown, _)| *flown > 0).map(|(_, rate)| rate)));
    }
    let folder = runner.folder.path().display();
    let pace = pace
        .map_or_else(String::new, |(flown, rate)| format!("{flown} campaign flights, {rate:.0} a second; "));
    print(&format!("{text}\n{pace}results in {folder}, start with {folder}/assess.html\n{verdict}\n"))
}

/// The answer of campaigns that were stopped.
pub fn stopped(args: &AssessArgs, mission: &Mission) -> Result<Answer, Failure> {
    if args.mission.json {
        let reason = "stopped before the campaigns were complete";
        let object = serde_json::json!({ "mission": mission.name, "campaigns": null, "reason": reason });
        print(&format!("{object:#}\n"))?;
    }
    Ok(Answer::No)
}
