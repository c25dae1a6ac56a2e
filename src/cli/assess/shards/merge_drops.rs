//! The parts of a campaign of whole drops, put together.

use std::io::{BufWriter, Write as _};

use super::parts::Parts;
use crate::cli::answer::{Answer, Failure};
use crate::cli::args::AutopilotArg;
use crate::cli::assess::asked::CampaignOf;
use crate::cli::assess::drops::{DropCampaign, campaign_name, planned};
use crate::cli::mission::print_origin;
use crate::cli::pilot::pilot_and_mission;
use crate::cli::planning::{plan_mission, write_plan};
use crate::cli::results::OutputFolder;
use samara::study::campaign::exact::MeasureValues;
use samara::study::campaign::{CampaignSummary, Keep, TrialRecord};
use samara::study::drops::{DropTally, header, row};
use samara::study::shard::ShardError;
use samara::study::shard::rows::drop_rows;
use samara::study::shard::summary::DropsPart;

/// Merges the drops.
pub fn run(of: &CampaignOf, autopilot: &AutopilotArg, parts: &Parts) -> Result<Answer, Failure> {
    let args = &of.args;
    let (pilot, mission) = pilot_and_mission(&of.pilot(autopilot))?;
    print_origin(&args.mission, &mission)?;
    parts.check_mission(&mission)?;
    let name = campaign_name(pilot.as_ref(), &mission);
    let folder = OutputFolder::merged(&name, args.mission.out.as_deref(), &mission.name)?;
    let timed = plan_mission(&mission, false)?;
    write_plan(&folder, &mission, &timed.plan)?;
    let Some(planned) = planned(of, &mission, timed)? else { return Ok(Answer::No) };
    let campaign = DropCampaign::new(of, (pilot, mission), planned, folder.path());
    let (mut tally, mut summary) = (DropTally::default(), CampaignSummary::default());
    for part in &parts.parts {
        let record: DropsPart = part.summary()?;
        let trials = part.head.range();
        let (of_page, of_table) =
            (part.take(record.summary.summary(&trials))?, part.take(record.tally.tally(&trials))?);
        part.take(summary.append(&of_page).map_err(ShardError::from))?;
        part.take(tally.append(&of_table).map_err(ShardError::from))?;
    }
    let keep = parts.settings.keep;
    if keep != Keep::Summary {
        let values = lines(&campaign, parts, &folder)?;
        summary.exact = (keep == Keep::All).then(|| values.quantiles());
    }
    let all_safe = !tally.any_failed();
    campaign.finish(&folder, parts.head.autopilot_version.as_deref(), keep, (&tally, summary))?;
    Ok(Answer::from(all_safe))
}

/// Writes the lines of the trials that are kept; the numbers of those.
fn lines(
    campaign: &DropCampaign<'_>,
    parts: &Parts,
    folder: &OutputFolder,
) -> Result<MeasureValues, Failure> {
    let mission = &campaign.mission;
    let aside = folder.aside(&campaign.csv())?;
    let mut file = BufWriter::new(aside.file()?);
    let mut write = |text: &str| aside.named(file.write_all(text.as_bytes()));
    write(&header(mission, campaign.pilot.name()))?;
    let mut values = MeasureValues::default();
    for part in &parts.parts {
        let (mut found, mut next) = (0, part.head.first);
        part.rows(
            |table| drop_rows(table, mission),
            |trial| {
                let in_order = trial.drawn.trial >= next && trial.drawn.trial < part.head.end;
                part.check_rows(u64::from(in_order), 1)?;
                next = trial.drawn.trial + 1;
                found += 1;
                values.push(&TrialRecord::of_drop(&trial));
                write(&row(mission, &trial))
            },
        )?;
        let expected = match parts.settings.keep {
            Keep::All => part.head.end - part.head.first,
            _ => part.summary::<DropsPart>()?.tally.failed(),
        };
        part.check_rows(found, expected)?;
    }
    aside.named(file.flush())?;
    drop(file);
    folder.finish(aside)?;
    Ok(values)
}
