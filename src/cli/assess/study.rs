//! What the paper's study and a mission's own campaigns begin with: the plan, and what flies the trials.

use std::sync::atomic::AtomicBool;

use super::args::{AssessArgs, Only};
use super::campaign::TrialRunner;
use super::{only, own, paper};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::mission::mission_from_t0;
use crate::cli::narrator::Narrator;
use crate::cli::planning::{TimedPlan, plan_mission, write_plan};
use crate::cli::results::OutputFolder;
use crate::cli::system::threads;
use crate::cli::terminal::print;
use samara::assess::{Limits, SafetyStudy};
use samara::config::Mission;
use samara::plan::{Plan, Status};
use samara::report::{plan_json, plan_text};
use samara::study::campaign::Keep;
use samara::study::own::own_entries;

/// Flies the campaigns, or one trial of each.
pub fn run(args: &AssessArgs, stop: &AtomicBool) -> Result<Answer, Failure> {
    let narrator = Narrator::alone(args.mission.json);
    let mission = mission_from_t0(&args.mission, &args.choice, &narrator)?;
    let verb = if args.only.is_some() { "assess_only" } else { "assess" };
    let folder = OutputFolder::create(verb, args.mission.out.as_deref(), &mission.name)?;
    if args.resume {
        folder.resume([]);
    }
    let plan = plan_mission(&mission, false)?;
    write_plan(&folder, &mission, &plan.plan)?;
    let Some(plan) = converged(args, &mission, plan, &narrator)? else { return Ok(Answer::No) };
    let runner = runner(args, &mission, &plan, &folder, stop)?;
    match (&args.only, args.paper) {
        (Some(Only::Trial(trial)), true) => only::run(&runner, &paper::entries_of(&mission)?, *trial, args),
        (Some(Only::Trial(trial)), false) => {
            only::run(&runner, &own_entries(&mission).bad_input()?, *trial, args)
        }
        (_, true) => paper::run(args, &plan, &runner, &narrator),
        (_, false) => own::run(args, &plan, &runner, &narrator),
    }
}

/// What flies the trials along a plan.
pub fn runner<'a>(
    args: &AssessArgs,
    mission: &'a Mission,
    plan: &Plan,
    folder: &'a OutputFolder,
    stop: &'a AtomicBool,
) -> Result<TrialRunner<'a>, Failure> {
    let whole = mission.safety_study(&plan.trajectory);
    let trials = args.trials_of(mission);
    Ok(TrialRunner {
        mission,
        // The paper's flights end with the plan, and only J_TPF judges them.
        study: if args.paper { SafetyStudy { settle_s: 0.0, ..whole } } else { whole },
        distribution: mission.releases(),
        trials,
        limits: Limits {
            j_tpf_below: args.bound,
            ..if args.paper {
                Limits::of_j_state(mission.limits.safety, mission.limits.steady_within_m_s)
            } else {
                mission.limits
            }
        },
        // The paper's differences between campaigns are taken line by line.
        keep: if args.paper { Keep::All } else { args.rows_kept(trials) },
        folder,
        threads: threads(args.threads)?,
        stop,
    })
}

/// The plan, if it is one; else says why there is none.
pub fn converged(
    args: &AssessArgs,
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
    if args.mission.json {
        print(&plan_json(mission, &timed.plan, Some(timed.solve_ms), None))?;
    }
    Ok(None)
}
