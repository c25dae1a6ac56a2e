//! The command that makes campaigns again, and how campaigns end.

use std::path::Path;

use super::args::PAPER;
use super::asked::CampaignOf;
use super::campaign::TrialRunner;
use crate::cli::answer::{Answer, Failure};
use crate::cli::system::Stopwatch;
use crate::cli::terminal::print;
use samara::config::Mission;
use samara::study::asked::Asked;
use samara::study::campaign::settings::options;

/// The command that makes the campaigns again, quoted for a shell; folder and number of threads do not belong
/// to it.
pub fn command(of: &CampaignOf, mission: &Mission) -> Result<String, Failure> {
    Ok(line(of, mission, of.asked(mission)?))
}

/// The command that takes `--only`.
pub fn alone(of: &CampaignOf, mission: &Mission) -> Result<String, Failure> {
    let mut asked = of.asked(mission)?;
    asked.settings.retain(|(name, _)| name == "bound");
    Ok(line(of, mission, asked))
}

fn line(of: &CampaignOf, mission: &Mission, asked: Asked) -> String {
    // The paper's mission has its name, wherever its file is.
    let is_the_papers = of.is_paper() && asked.mission == Path::new(PAPER);
    let asked =
        if is_the_papers { asked } else { Asked { mission: of.args.mission.named(mission), ..asked } };
    let verb: &[&str] = if of.is_paper() { &["assess", "--paper"] } else { &["assess"] };
    asked.command(verb, options(of.about.settings, &asked))
}

/// Writes the manifest.
pub fn finish(of: &CampaignOf, runner: &TrialRunner<'_>) -> Result<(), Failure> {
    runner.folder.write_manifest(of.about.manifest, runner.mission, &of.circumstances(runner.mission)?)
}

/// Reports campaigns that are complete: how many flights they took, where any were `flown`, where the results
/// are, and last the verdict. `text` and `json` are of the results; the pace is for the terminal and `--json`
/// alone.
pub fn report(
    of: &CampaignOf,
    runner: &TrialRunner<'_>,
    flown: Option<(u64, &Stopwatch)>,
    json: impl FnOnce(Option<f64>) -> String,
    [text, verdict]: [String; 2],
) -> Result<(), Failure> {
    let pace = flown.map(|(flown, watch)| (flown, 1e3 * flown as f64 / watch.ms()));
    if of.args.mission.json {
        return print(&json(pace.filter(|(flown, _)| *flown > 0).map(|(_, rate)| rate)));
    }
    let folder = runner.folder.path().display();
    let pace = pace
        .map_or_else(String::new, |(flown, rate)| format!("{flown} campaign flights, {rate:.0} a second; "));
    print(&format!("{text}\n{pace}results in {folder}, start with {folder}/assess.html\n{verdict}\n"))
}

/// The answer of campaigns that were stopped.
pub fn stopped(of: &CampaignOf, mission: &Mission) -> Result<Answer, Failure> {
    if of.args.mission.json {
        let reason = "stopped before the campaigns were complete";
        let object = serde_json::json!({ "mission": mission.name, "campaigns": null, "reason": reason });
        print(&format!("{object:#}\n"))?;
    }
    Ok(Answer::No)
}
