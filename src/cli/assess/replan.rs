//! `samara assess --replan`: drops along one plan and along plans that are renewed.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::args::AssessArgs;
use super::rows::{fly_row, trials_of};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::ChoiceArgs;
use crate::cli::mission::{check_replan, chosen_mission, origin};
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_to_fly;
use crate::cli::progress::Progress;
use crate::cli::results::OutputFolder;
use crate::cli::system::thread_pool;
use crate::cli::terminal::print;
use samara::config::Mission;
use samara::plan::Plan;
use samara::replan::Cadence;
use samara::report::replan::{ReplanCampaign, ReplanFlights, ReplanReport, ReplanRow};

/// Trials of a campaign unless it is said otherwise.
const TRIALS: u64 = 300;
/// Trials between two looks at Ctrl-C.
const BLOCK: u64 = 16;

/// Flies the campaigns, writes and reports them.
pub fn run(args: &AssessArgs, cadences: &[Cadence], stop: &AtomicBool) -> Result<Answer, Failure> {
    let rows = rows(args, cadences)?;
    let mission = Arc::new(chosen_mission(&args.mission.mission, &args.choice)?);
    check(&mission, cadences)?;
    let trials = trials_of(args.trials, TRIALS, "--replan")?;
    let narrator = Narrator::alone(args.mission.json);
    narrator.say(&origin(&args.mission.mission, &mission));
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let Some(campaigns) = fly_all(args, &mission, &rows, &timed.plan, trials, stop)? else {
        narrator.say("stopped: nothing is kept of campaigns that are not complete\n");
        narrator.check()?;
        return Ok(Answer::No);
    };
    let report = ReplanReport { mission: &mission, campaigns };
    folder.write_text("replan.txt", &report.text())?;
    folder.write_text("replan.json", &report.json())?;
    folder.write_text("replan.csv", &report.csv())?;
    let asked = cadences.iter().map(Cadence::to_string).collect::<Vec<_>>().join(",");
    folder.write_manifest("replan", &mission, &[("trials", trials.to_string()), ("replan", asked)])?;
    print(&if args.mission.json {
        report.json()
    } else {
        format!("\n{}every drop in {}\n", report.text(), folder.path().join("replan.csv").display())
    })?;
    Ok(Answer::Yes)
}

/// The rows of the table: the first by the mission's own gains, the others by those that were chosen, or that
/// the mission has for renewed plans.
fn rows(args: &AssessArgs, cadences: &[Cadence]) -> Result<Vec<ReplanRow>, Failure> {
    let own = chosen_mission(&args.mission.mission, &ChoiceArgs::default())?;
    let chosen = chosen_mission(&args.mission.mission, &args.choice)?;
    let asked_for = args.choice.gains.is_some() || args.choice.params.is_some();
    let of_renewed = match &own.replan.gains {
        Some(file) if !asked_for => (file.name.as_str(), &file.gains),
        _ => (chosen.control.gains_name.as_str(), &chosen.control.gains),
    };
    Ok(ReplanRow::campaigns(&own, cadences, of_renewed))
}

/// Refuses a mission whose plan cannot be renewed.
fn check(mission: &Mission, cadences: &[Cadence]) -> Result<(), Failure> {
    mission.faults.check_without_wire().bad_input()?;
    cadences.iter().try_for_each(|cadence| check_replan(mission, *cadence))
}

/// Flies every trial of every campaign; `None` when Ctrl-C stopped them.
fn fly_all(
    args: &AssessArgs,
    mission: &Arc<Mission>,
    rows: &[ReplanRow],
    plan: &Plan,
    trials: u64,
    stop: &AtomicBool,
) -> Result<Option<Vec<ReplanCampaign>>, Failure> {
    let pool = thread_pool(args.threads)?;
    let progress = Progress::new("assess", "drops", rows.len() as u64 * trials);
    let mut campaigns = Vec::new();
    for row in rows {
        let flights = ReplanFlights::new(mission, plan, row).bad_input()?;
        progress.set_message(&row.name());
        let flown = fly_row(&pool, &progress, (trials, BLOCK), stop, |trial| flights.fly(trial));
        let Some(drops) = flown else { return Ok(None) };
        campaigns.push(ReplanCampaign { row: row.clone(), drops });
    }
    progress.finish();
    Ok(Some(campaigns))
}
