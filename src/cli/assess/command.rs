//! The command that makes campaigns again, and how campaigns end.

use super::args::AssessArgs;
use super::campaign::TrialRunner;
use crate::cli::answer::{Answer, Failure};
use crate::cli::args::AutopilotArg;
use crate::cli::system::Stopwatch;
use crate::cli::terminal::print;
use samara::config::Mission;
use samara::config::shipped::is_built_in;

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

/// Writes the manifest.
pub fn finish(args: &AssessArgs, runner: &TrialRunner<'_>) -> Result<(), Failure> {
    let circumstances = [("trials", runner.trials.to_string()), ("bound", args.bound.to_string())];
    runner.folder.write_manifest("assess", runner.mission, &circumstances)
}

/// Reports campaigns that are complete: how many flights they took, where the results are, and last the
/// verdict. `text` and `json` are of the results; the pace is for the terminal and `--json` alone.
pub fn report(
    args: &AssessArgs,
    runner: &TrialRunner<'_>,
    (flown, watch): (u64, &Stopwatch),
    json: impl FnOnce(Option<f64>) -> String,
    [text, verdict]: [String; 2],
) -> Result<(), Failure> {
    let flights_per_s = 1e3 * flown as f64 / watch.ms();
    if args.mission.json {
        return print(&json((flown > 0).then_some(flights_per_s)));
    }
    let folder = runner.folder.path().display();
    print(&format!(
        "{text}\n{flown} campaign flights, {flights_per_s:.0} a second; results in {folder}, start with {folder}/assess.html\n{verdict}\n"
    ))
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
