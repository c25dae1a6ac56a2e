//! `samara assess --only K`: one trial of each campaign again.

use super::asked::CampaignOf;
use super::campaign::TrialRunner;
use crate::cli::alone_flight::write_flight;
use crate::cli::answer::{Answer, Failure};
use crate::cli::terminal::print;
use samara::assess::judge::words;
use samara::assess::{Outcome, RandomRelease, StudyEntry, judge_trial};
use samara::study::campaign::campaign_csv::write_row;
use samara::study::campaign::only;
use samara::study::kind::FlightFiles;
use samara::study::own::OPTIMAL;
use samara::study::paper::OURS;

/// Flies the trial with each controller: prints what was drawn and what came of it, writes
/// `trial_<K>_<name>.csv` (the flight), `.svg`, `.html` and `.mcap`, and `assess_only_manifest.json`.
pub fn run(
    runner: &TrialRunner<'_>,
    entries: &[StudyEntry],
    trial: u64,
    of: &CampaignOf,
) -> Result<Answer, Failure> {
    let TrialRunner { mission, folder, ref limits, .. } = *runner;
    let release = runner.draw(trial);
    let study = &runner.study;
    let results = runner.in_order(entries, |entry| {
        study.fly_releases(entry, std::slice::from_ref(&release)).into_iter().next()
    });
    let flown: Vec<(&StudyEntry, Outcome)> =
        entries.iter().zip(results).filter_map(|(entry, outcome)| Some((entry, outcome?))).collect();
    let mut rows = Vec::new();
    for (entry, outcome) in &flown {
        write(runner, entry, &release, of)?;
        let mut row = String::new();
        write_row(&mut row, &release, outcome);
        rows.push((*entry, *outcome, row));
    }
    // Beside the manifest of the campaigns, which may be in the same folder.
    let circumstances = [("only", trial.to_string()), ("bound", limits.j_tpf_below.to_string())];
    folder.write_manifest("assess_only", mission, &circumstances)?;
    if of.args.mission.json {
        print(&only::only_json(mission, &release, &rows))?;
    } else {
        print(&only::only_text(mission, &release, &rows))?;
        print(&format!("flights and figures in {}/trial_{trial}_*\n", folder.path().display()))?;
    }
    let failure = flown
        .iter()
        .filter(|(entry, _)| [OURS, OPTIMAL].contains(&entry.name))
        .find_map(|(_, outcome)| words(&judge_trial(outcome, limits)));
    if let (false, Some(why)) = (of.args.mission.json, &failure) {
        print(&format!("FAILED: {why}\n"))?;
    }
    Ok(Answer::from(failure.is_none()))
}

fn write(
    runner: &TrialRunner<'_>,
    entry: &StudyEntry,
    release: &RandomRelease,
    of: &CampaignOf,
) -> Result<(), Failure> {
    let TrialRunner { mission, folder, .. } = *runner;
    let name = format!("trial_{}_{}", release.trial, entry.name);
    let study = runner.study.in_trials_air(entry, std::slice::from_ref(release));
    let flight = FlightFiles {
        title: format!("{}, trial {}, {}", mission.name, release.trial, entry.name),
        name,
        gains: entry.gains_name.clone(),
        plan: runner.study.plan.clone(),
        samples: study.samples(entry, release),
        limits: runner.limits,
        way_to_t0_ned_m: study.way_to_t0(&release.state),
    };
    write_flight(folder, mission, &flight, &of.page)
}
