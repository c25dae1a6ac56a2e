//! What the paper's study and a mission's own campaigns begin with: the plan, and what flies the trials.

use std::sync::atomic::AtomicBool;

use super::asked::CampaignOf;
use super::campaign::TrialRunner;
use super::{only, own, paper};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::mission::mission_from_t0;
use crate::cli::narrator::Narrator;
use crate::cli::planning::{TimedPlan, plan_mission, write_plan};
use crate::cli::results::OutputFolder;
use crate::cli::system::threads;
use crate::cli::terminal::print;
use samara::assess::{Limits, SafetyStudy, StudyEntry};
use samara::config::Mission;
use samara::plan::{Plan, Status};
use samara::report::{plan_json, plan_text};
use samara::study::own::own_entries;

/// Flies the campaigns, or one trial of each.
pub fn run(of: &CampaignOf, stop: &AtomicBool) -> Result<Answer, Failure> {
    let args = &of.args;
    let narrator = Narrator::alone(args.mission.json);
    let mission = mission_from_t0(&args.mission, &args.choice, &narrator)?;
    let verb = if of.only.is_some() { "assess_only" } else { of.about.manifest };
    let folder = OutputFolder::create(verb, args.mission.out.as_deref(), &mission.name)?;
    if args.resume {
        folder.resume([]);
    }
    let plan = plan_mission(&mission, false)?;
    write_plan(&folder, &mission, &plan.plan)?;
    let Some(plan) = converged(of, &mission, plan, &narrator)? else { return Ok(Answer::No) };
    let runner = runner(of, &mission, &plan, &folder, stop)?;
    match (of.only, of.is_paper()) {
        (Some(trial), _) => only::run(&runner, &entries(of, &mission)?, trial, of),
        (None, true) => paper::run(of, &plan, &runner, &narrator),
        (None, false) => own::run(of, &plan, &runner, &narrator),
    }
}

/// The controllers of the campaigns.
pub fn entries(of: &CampaignOf, mission: &Mission) -> Result<Vec<StudyEntry>, Failure> {
    if of.is_paper() {
        return paper::entries_of(mission).map(Vec::from);
    }
    own_entries(mission).map(Vec::from).bad_input()
}

/// What flies the trials along a plan.
pub fn runner<'a>(
    of: &CampaignOf,
    mission: &'a Mission,
    plan: &Plan,
    folder: &'a OutputFolder,
    stop: &'a AtomicBool,
) -> Result<TrialRunner<'a>, Failure> {
    let whole = mission.safety_study(&plan.trajectory);
    let (settings, _) = of.settings(mission)?;
    Ok(TrialRunner {
        mission,
        // The paper's flights end with the plan, and only J_TPF judges them.
        study: if of.is_paper() { SafetyStudy { settle_s: 0.0, ..whole } } else { whole },
        distribution: mission.releases(),
        trials: settings.trials,
        limits: Limits {
            j_tpf_below: settings.bound,
            ..if of.is_paper() {
                Limits::of_j_state(mission.limits.safety, mission.limits.steady_within_m_s)
            } else {
                mission.limits
            }
        },
        keep: settings.keep,
        folder,
        threads: threads(of.args.threads)?,
        stop,
    })
}

/// The plan, if it is one; else says why there is none.
pub fn converged(
    of: &CampaignOf,
    mission: &Mission,
    timed: TimedPlan,
    narrator: &Narrator,
) -> Result<Option<Plan>, Failure> {
    if timed.plan.status == Status::Converged {
        return Ok(Some(timed.plan));
    }
    let text = plan_text(mission, &timed.plan, None);
    narrator.say(&format!("no optimal trajectory to assess: {text}"));
    narrator.check()?;
    if of.args.mission.json {
        print(&plan_json(mission, &timed.plan, Some(timed.solve_ms), None))?;
    }
    Ok(None)
}
