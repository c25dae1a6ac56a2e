//! A part of a campaign of whole drops.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, Ordering};

use super::part::{GROUP_ROWS, check_campaign, head_of, report, stopped};
use super::place::PartPlace;
use crate::cli::answer::{Answer, Failure};
use crate::cli::args::AutopilotArg;
use crate::cli::assess::asked::CampaignOf;
use crate::cli::assess::drops::all::Files;
use crate::cli::assess::drops::{DropCampaign, planned};
use crate::cli::pilot::pilot_and_mission;
use crate::cli::planning::plan_mission;
use crate::cli::progress::ProgressLine;
use crate::cli::results::{OutputFolder, place_of};
use samara::study::campaign::{CampaignSummary, TrialRecord};
use samara::study::cut::Cut;
use samara::study::drops::{DropTally, DropTrial};
use samara::study::shard::ShardWriter;
use samara::study::shard::rows::drop_table;
use samara::study::shard::summary::{DropTallyRecord, DropsPart, SummaryRecord};

/// Flies the part, unless it is there.
pub fn run(
    of: &CampaignOf,
    autopilot: &AutopilotArg,
    shard: Cut,
    stop: &AtomicBool,
) -> Result<Answer, Failure> {
    let (pilot, mission) = pilot_and_mission(&of.pilot(autopilot))?;
    let mut head = head_of(of, &mission, Some(pilot.name()), shard)?;
    let keep = of.settings(&mission)?.0.keep;
    check_campaign(of, &head)?;
    let folder = OutputFolder::plain(&place_of(of.args.mission.out.as_deref(), &mission.name))?;
    let place = PartPlace::new(folder.path(), shard)?;
    if place.is_whole(&head)? {
        return report(of, shard, &head, &place, false);
    }
    let Some(planned) = planned(of, &mission, plan_mission(&mission, false)?)? else {
        return Ok(Answer::No);
    };
    let campaign = DropCampaign::new(of, (pilot, mission), planned, folder.path());
    campaign.check()?;
    let aside = place.begin()?;
    let mut writer = aside.named(ShardWriter::new(aside.file()?, &drop_table(&[])))?;
    let (mut tally, mut summary) =
        (DropTally::from_trial(head.first), CampaignSummary::from_trial(head.first));
    let mut version: Option<String> = None;
    let (mut early, mut rows) = (BTreeMap::<u64, DropTrial>::new(), Vec::new());
    let progress = ProgressLine::new("assess", "drops", head.end - head.first);
    let files = Files { scratch: aside.scratch(), kept: None };
    campaign.fly_trials(head.range(), &BTreeSet::new(), &files, stop, |over| {
        if !over.flown {
            // A drop that could not begin says nothing of the vehicle: the part is flown again.
            let why = over.trial.failure.unwrap_or_default();
            return Err(Failure::input(format!("trial {}: {why}", over.trial.drawn.trial)));
        }
        match (&version, over.version) {
            (Some(known), Some(found)) if *known != found => {
                return Err(Failure::input(format!(
                    "a part is flown by one version of the autopilot: {known}, then {found}"
                )));
            }
            (None, Some(found)) => version = Some(found),
            _ => {}
        }
        early.insert(over.trial.drawn.trial, over.trial);
        while let Some(trial) = early.remove(&(head.first + tally.flown())) {
            tally.push(&trial);
            summary.push(&TrialRecord::of_drop(&trial));
            if keep.keeps(trial.failure.is_some()) {
                rows.push(trial);
            }
            if rows.len() >= GROUP_ROWS {
                aside.named(writer.write(&drop_table(&rows)))?;
                rows.clear();
            }
            progress.inc(1);
        }
        Ok(())
    })?;
    progress.finish();
    if stop.load(Ordering::Relaxed) || tally.flown() < head.end - head.first {
        return Ok(stopped(shard));
    }
    aside.named(writer.write(&drop_table(&rows)))?;
    head.autopilot_version = version;
    let part = DropsPart { summary: SummaryRecord::of(&summary), tally: DropTallyRecord::of(&tally) };
    aside.named(writer.finish(&head, &part))?;
    aside.finish()?;
    report(of, shard, &head, &place, true)
}
