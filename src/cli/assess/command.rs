//! The command that makes campaigns again, and how campaigns end.

use super::args::AssessArgs;
use super::campaign::TrialRunner;
use crate::cli::answer::{Answer, Failure};
use crate::cli::args::AutopilotArg;
use crate::cli::system::Stopwatch;
use crate::cli::terminal::print;
use samara::config::Mission;
use samara::config::shipped::is_built_in;
#[cfg(feature = "shards")]
use samara::report::campaign::Keep;

/// The command that makes the campaigns again, its choices spelt out; folder and number of threads do not
/// belong to it.
pub struct Command {
    text: String,
    bound: String,
}

impl Command {
    /// The command up to the number of trials.
    pub fn of(args: &AssessArgs, mission: &Mission) -> Self {
        let mut text = if args.paper {
            "samara assess --paper".to_owned()
        } else {
            // A built-in mission by its name, which means it anywhere else, too.
            let file = if is_built_in(&mission.file) { &args.mission.mission } else { &mission.file };
            format!("samara assess {}", file.display())
        };
        if let Some(gains) = &args.choice.gains {
            text += &format!(" --gains {gains}");
        }
        if let Some(params) = &args.choice.params {
            text += &format!(" --params {}", params.display());
        }
        if let Some(case) = &args.choice.case {
            text += &format!(" --case {case}");
        }
        text += &format!(" --seed {}", mission.seed);
        let bound = if args.bound == 1.0 { String::new() } else { format!(" --bound {}", args.bound) };
        Self { text, bound }
    }

    /// The command with the autopilot that flies whole drops.
    pub fn by(mut self, autopilot: &AutopilotArg) -> Self {
        self.text += &format!(" --autopilot {autopilot}");
        self
    }

    /// The whole command.
    pub fn with_trials(&self, trials: u64) -> String {
        format!("{} --trials {trials}{}", self.text, self.bound)
    }

    /// The command that takes `--only`.
    pub fn alone(&self) -> String {
        format!("{}{}", self.text, self.bound)
    }
}

/// The arguments of `samara assess` that fly the campaign anywhere, its choices spelt out: without folder,
/// part, and whatever changes no result.
#[cfg(feature = "shards")]
pub fn arguments(args: &AssessArgs, mission: &Mission, trials: u64, keep: Keep) -> Vec<String> {
    let mut words = vec![args.mission.mission.display().to_string()];
    let mut add = |option: &str, value: Option<String>| {
        words.extend(value.into_iter().flat_map(|value| [option.to_owned(), value]));
    };
    add("--gains", args.choice.gains.clone());
    add("--params", args.choice.params.as_ref().map(|path| path.display().to_string()));
    add("--case", args.choice.case.clone());
    add("--seed", Some(mission.seed.to_string()));
    add("--trials", Some(trials.to_string()));
    add("--keep", Some(format!("{keep:?}").to_lowercase()));
    add("--bound", (args.bound != 1.0).then(|| args.bound.to_string()));
    add("--autopilot", args.autopilot.as_ref().map(ToString::to_string));
    add("--estimator", args.state.asked().then(|| "ekf".to_owned()));
    if args.feed_forward {
        words.push("--feed-forward".to_owned());
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
