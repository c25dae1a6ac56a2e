//! The parts of campaigns of flights from t = 0, put together.

use std::io::{BufWriter, Write as _};
use std::sync::atomic::AtomicBool;

use super::parts::{Part, Parts};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::aside::Aside;
use crate::cli::assess::asked::CampaignOf;
use crate::cli::assess::campaign::{FlownCampaign, TrialRunner};
use crate::cli::assess::study::{converged, runner};
use crate::cli::assess::{own, paper};
use crate::cli::mission::mission_from_t0;
use crate::cli::narrator::Narrator;
use crate::cli::planning::{plan_mission, write_plan};
use crate::cli::results::OutputFolder;
use samara::assess::{Outcome, RandomRelease, StudyEntry};
use samara::study::campaign::Keep;
use samara::study::campaign::campaign_csv::{file_name, header, parse_row};
use samara::study::own::own_entries;
use samara::study::shard::ShardError;
use samara::study::shard::rows::study_rows;
use samara::study::shard::summary::StudyPart;

/// Merges the campaigns.
pub fn run(of: &CampaignOf, parts: &Parts) -> Result<Answer, Failure> {
    let args = &of.args;
    let narrator = &Narrator::alone(args.mission.json);
    let mission = mission_from_t0(&args.mission, &args.choice, narrator)?;
    parts.check_mission(&mission)?;
    let folder = OutputFolder::merged(of.about.manifest, args.mission.out.as_deref(), &mission.name)?;
    let timed = plan_mission(&mission, false)?;
    write_plan(&folder, &mission, &timed.plan)?;
    let Some(plan) = converged(of, &mission, timed, narrator)? else { return Ok(Answer::No) };
    let stop = AtomicBool::new(false);
    let runner = runner(of, &mission, &plan, &folder, &stop)?;
    if of.is_paper() {
        let campaigns = campaigns(parts, paper::entries_of(&mission)?, &runner)?;
        return paper::report(of, &plan, &runner, &campaigns, None);
    }
    let mut campaigns = campaigns(parts, own_entries(&mission).bad_input()?, &runner)?;
    campaigns.iter_mut().try_for_each(|campaign| campaign.find_quantiles(&runner))?;
    own::report(of, &plan, &runner, &campaigns, None)
}

/// The campaigns of the parts, with the files of their lines.
fn campaigns<const N: usize>(
    parts: &Parts,
    entries: [StudyEntry; N],
    runner: &TrialRunner<'_>,
) -> Result<[FlownCampaign; N], Failure> {
    let mut campaigns = entries.map(FlownCampaign::new);
    for part in &parts.parts {
        let summaries: Vec<StudyPart> = part.summary()?;
        for (campaign, summary) in campaigns.iter_mut().zip(&summaries) {
            let all_there = summaries.len() == N && summary.name == campaign.entry.name;
            let named =
                if all_there { Ok(()) } else { Err(ShardError::NotAShard("the mission's campaigns".into())) };
            part.take(named)?;
            let shown = part.take(shown(summary, part, runner))?;
            let taken = part.take(summary.summary.summary(&part.head.range()))?;
            part.take(campaign.append(&taken, shown).map_err(ShardError::from))?;
        }
    }
    if runner.keep != Keep::Summary {
        let written = campaigns.each_mut().map(|campaign| lines(campaign, &parts.parts, runner));
        // Nothing that was there is replaced before all lines are right.
        for aside in written.into_iter().collect::<Result<Vec<_>, _>>()? {
            runner.folder.finish(aside)?;
        }
    }
    Ok(campaigns)
}

/// The first trials of the campaign, where they are of this part.
fn shown(
    summary: &StudyPart,
    part: &Part,
    runner: &TrialRunner<'_>,
) -> Result<Vec<(RandomRelease, Outcome)>, ShardError> {
    let numbered = summary.shown.iter().zip(part.head.first..);
    let trial = |(line, trial): (&String, u64)| {
        let release = runner.draw(trial);
        let outcome = parse_row(line, &release);
        Ok((release, outcome.map_err(|_| ShardError::NotAShard("trials of this mission and seed".into()))?))
    };
    numbered.map(trial).collect()
}

/// Writes the lines of a campaign's trials that are kept.
fn lines(campaign: &mut FlownCampaign, parts: &[Part], runner: &TrialRunner<'_>) -> Result<Aside, Failure> {
    let name = campaign.entry.name;
    let aside = runner.folder.aside(&file_name(&campaign.entry))?;
    let mut file = BufWriter::new(aside.file()?);
    aside.named(file.write_all(header(runner.mission, &campaign.entry).as_bytes()))?;
    for part in parts {
        let (mut found, mut next) = (0, part.head.first);
        let draw = |trial| runner.draw(trial);
        part.rows(
            |table| study_rows(table, name, draw),
            |(release, outcome)| {
                let in_order = release.trial >= next && release.trial < part.head.end;
                part.check_rows(u64::from(in_order), 1)?;
                next = release.trial + 1;
                found += 1;
                aside.named(file.write_all(campaign.line(&release, &outcome, runner).as_bytes()))
            },
        )?;
        let expected = match runner.keep {
            Keep::All => part.head.end - part.head.first,
            _ => {
                let summaries = part.summary::<Vec<StudyPart>>()?;
                summaries.iter().find(|of| of.name == name).map_or(0, |of| of.summary.failed())
            }
        };
        part.check_rows(found, expected)?;
    }
    aside.named(file.flush())?;
    Ok(aside)
}
