//! `samara assess --effects`: what each effect that a mission names does to its drops.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::args::AssessArgs;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::mission::{chosen_mission, origin};
use crate::cli::narrator::Narrator;
use crate::cli::planning::{plan_mission, write_plan};
use crate::cli::progress::Progress;
use crate::cli::results::OutputFolder;
use crate::cli::system::thread_pool;
use crate::cli::terminal::print;
use samara::config::{Effect, Mission};
use samara::plan::Status;
use samara::report::effects::{EffectCampaign, EffectDrop, EffectFlights, EffectReport, EffectsOn};
use samara::report::{plan_json, plan_text};
use samara::trajectory::Trajectory;

/// Trials of a campaign unless it is said otherwise.
const TRIALS: u64 = 1000;
/// Most trials of a campaign: all are kept, for what they differ by.
const MOST_TRIALS: u64 = 100_000;
/// Trials between two looks at Ctrl-C.
const BLOCK: u64 = 64;

/// Flies the campaigns, writes and reports them.
pub fn run(args: &AssessArgs, stop: &AtomicBool) -> Result<Answer, Failure> {
    let mission = chosen_mission(&args.mission.mission, &args.choice)?;
    let effects = effects_of(&mission)?;
    let trials = args.trials.unwrap_or(TRIALS);
    if trials > MOST_TRIALS {
        let message = format!("--trials: at most {MOST_TRIALS} are expected with --effects, found {trials}");
        return Err(Failure::input(message));
    }
    let narrator = Narrator::alone(args.mission.json);
    narrator.say(&origin(&args.mission.mission, &mission));
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let timed = plan_mission(&mission, false)?;
    write_plan(&folder, &mission, &timed.plan)?;
    if timed.plan.status != Status::Converged {
        narrator.say(&format!("no plan to fly: {}", plan_text(&timed.plan, &mission.limits.safety, None)));
        narrator.check()?;
        if args.mission.json {
            print(&plan_json(&mission, &timed.plan, Some(timed.solve_ms)))?;
        }
        return Ok(Answer::No);
    }
    let plan = &timed.plan.trajectory;
    let Some(campaigns) = fly_all(args, &mission, &effects, plan, trials, stop)? else {
        narrator.say("stopped: nothing is kept of campaigns that are not complete\n");
        narrator.check()?;
        return Ok(Answer::No);
    };
    let report = EffectReport { mission: &mission, effects, campaigns };
    folder.write_text("effects.txt", &report.text())?;
    folder.write_text("effects.json", &report.json())?;
    folder.write_text("effects.csv", &report.csv())?;
    folder.write_manifest("effects", &mission, &[("trials", trials.to_string())])?;
    print(&if args.mission.json {
        report.json()
    } else {
        format!("\n{}every drop in {}\n", report.text(), folder.path().join("effects.csv").display())
    })?;
    Ok(Answer::Yes)
}

/// The effects of a mission that can be flown without a wire.
fn effects_of(mission: &Mission) -> Result<Vec<Effect>, Failure> {
    let refused = |message: String| Err(Failure::input(format!("{}: {message}", mission.file.display())));
    if mission.release.standing {
        return refused("--effects flies drops, and this mission begins on the ground".to_owned());
    }
    mission.faults.check_without_wire().bad_input()?;
    let effects = mission.effects();
    if effects.is_empty() {
        let keys: Vec<&str> = Effect::ALL.into_iter().map(Effect::key).collect();
        return refused(format!(
            "--effects has nothing to leave out: at least one of these keys is expected: {}",
            keys.join("; ")
        ));
    }
    Ok(effects)
}

/// Flies every trial of every campaign; `None` when Ctrl-C stopped them.
fn fly_all(
    args: &AssessArgs,
    mission: &Mission,
    effects: &[Effect],
    plan: &Trajectory,
    trials: u64,
    stop: &AtomicBool,
) -> Result<Option<Vec<EffectCampaign>>, Failure> {
    let pool = thread_pool(args.threads)?;
    let all = EffectsOn::campaigns(effects);
    let progress = Progress::new("assess", "drops", all.len() as u64 * trials);
    let mut campaigns = Vec::new();
    for on in all {
        let flights = EffectFlights::new(mission, &on.kept(effects), plan).bad_input()?;
        progress.set_message(&on.name());
        let mut drops: Vec<EffectDrop> = Vec::new();
        for from in (0..trials).step_by(BLOCK as usize) {
            if stop.load(Ordering::Relaxed) {
                progress.finish();
                return Ok(None);
            }
            let block = from..trials.min(from + BLOCK);
            let flown = block.end - block.start;
            drops.extend(pool.install(|| block.into_par_iter().map(|k| flights.fly(k)).collect::<Vec<_>>()));
            progress.inc(flown);
        }
        campaigns.push(EffectCampaign { on, drops });
    }
    progress.finish();
    Ok(Some(campaigns))
}
