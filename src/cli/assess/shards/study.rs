//! A part of campaigns of flights from t = 0.

use std::sync::atomic::AtomicBool;

use super::part::{GROUP_ROWS, check_campaign, head_of, report, stopped};
use super::place::PartPlace;
use crate::cli::answer::{Answer, Failure};
use crate::cli::aside::Aside;
use crate::cli::assess::asked::CampaignOf;
use crate::cli::assess::campaign::TrialRunner;
use crate::cli::assess::study::{converged, entries, runner};
use crate::cli::mission::mission_from_t0;
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_mission;
use crate::cli::progress::ProgressLine;
use crate::cli::results::{OutputFolder, place_of};
use samara::assess::StudyEntry;
use samara::study::campaign::campaign_csv::write_row;
use samara::study::campaign::{CampaignSummary, SHOWN, TrialRecord};
use samara::study::cut::Cut;
use samara::study::shard::rows::{StudyRow, study_table};
use samara::study::shard::summary::{StudyPart, SummaryRecord};
use samara::study::shard::{ShardHead, ShardWriter};

/// Flies the part, unless it is there.
pub fn run(of: &CampaignOf, shard: Cut, stop: &AtomicBool) -> Result<Answer, Failure> {
    let narrator = Narrator::alone(true);
    let args = &of.args;
    let mission = mission_from_t0(&args.mission, &args.choice, &narrator)?;
    let head = head_of(of, &mission, None, shard)?;
    check_campaign(of, &head)?;
    let folder = OutputFolder::plain(&place_of(args.mission.out.as_deref(), &mission.name))?;
    let place = PartPlace::new(folder.path(), shard)?;
    if place.is_whole(&head)? {
        return report(of, shard, &head, &place, false);
    }
    let plan = plan_mission(&mission, false)?;
    let Some(plan) = converged(of, &mission, plan, &narrator)? else { return Ok(Answer::No) };
    let runner = runner(of, &mission, &plan, &folder, stop)?;
    let entries = entries(of, &mission)?;
    let aside = place.begin()?;
    let mut writer = aside.named(ShardWriter::new(aside.file()?, &study_table("", &[])))?;
    let progress = ProgressLine::new("assess", "flights", entries.len() as u64 * (head.end - head.first));
    let mut parts = Vec::new();
    for entry in &entries {
        let Some(part) = fly(entry, &head, &runner, &progress, (&mut writer, &aside))? else {
            progress.finish();
            return Ok(stopped(shard));
        };
        parts.push(part);
    }
    progress.finish();
    aside.named(writer.finish(&head, &parts))?;
    aside.finish()?;
    report(of, shard, &head, &place, true)
}

/// Flies the part of one campaign; `None` when it was stopped.
fn fly(
    entry: &StudyEntry,
    head: &ShardHead,
    runner: &TrialRunner<'_>,
    progress: &ProgressLine,
    (writer, aside): (&mut ShardWriter, &Aside),
) -> Result<Option<StudyPart>, Failure> {
    let mut summary = CampaignSummary::from_trial(head.first);
    let (mut rows, mut shown) = (Vec::new(), Vec::new());
    let whole = runner.fly(entry, head.range(), progress, |release, outcome| {
        let record = TrialRecord::of_flight(release.trial, &outcome, &runner.limits);
        summary.push(&record);
        if release.trial < SHOWN as u64 {
            let mut line = String::new();
            write_row(&mut line, &release, &outcome);
            shown.push(line.trim_end().to_owned());
        }
        if runner.keep.keeps(record.failure.is_some()) {
            rows.push(StudyRow { release, outcome, failure: record.failure });
        }
        if rows.len() >= GROUP_ROWS {
            aside.named(writer.write(&study_table(entry.name, &rows)))?;
            rows.clear();
        }
        Ok(())
    })?;
    if !whole {
        return Ok(None);
    }
    aside.named(writer.write(&study_table(entry.name, &rows)))?;
    Ok(Some(StudyPart { name: entry.name.to_owned(), summary: SummaryRecord::of(&summary), shown }))
}
