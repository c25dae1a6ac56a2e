//! `samara assess --effects`: what each effect that a mission names does to its drops.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use super::args::AssessArgs;
use super::rows::{fly_groups, trials_of};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::mission::{chosen_mission, origin};
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_to_fly;
use crate::cli::progress::ProgressLine;
use crate::cli::results::OutputFolder;
use crate::cli::system::thread_pool;
use crate::cli::terminal::print;
use samara::config::{Effect, Mission};
use samara::report::effects::{EffectCampaign, EffectReport};
use samara::sim::ABREAST;
use samara::study::effects::{EffectFlights, EffectsOn};
use samara::trajectory::Trajectory;

/// Trials of a campaign unless it is said otherwise.
const TRIALS: u64 = 1000;
/// Trials between two looks at Ctrl-C.
const BLOCK: u64 = 64;

/// Flies the campaigns, writes and reports them.
pub fn run(args: &AssessArgs, stop: &AtomicBool) -> Result<Answer, Failure> {
    let mission = chosen_mission(&args.mission.mission, &args.choice)?;
    let effects = effects_of(&mission)?;
    let trials = trials_of(args.trials, TRIALS, "--effects")?;
    let narrator = Narrator::alone(args.mission.json);
    narrator.say(&origin(&args.mission.mission, &mission));
    let folder = OutputFolder::create("effects", args.mission.out.as_deref(), &mission.name)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let plan = &timed.plan.trajectory;
    let Some(campaigns) = fly_all(args, &mission, &effects, plan, trials, stop)? else {
        narrator.say("stopped: nothing is kept of campaigns that are not complete\n");
        narrator.check()?;
        return Ok(Answer::No);
    };
    let report = EffectReport { mission: &mission, effects, campaigns };
    folder.write_text("effects.txt", &report.document().text())?;
    folder.write_text("effects.json", &report.json())?;
    folder.write_text("effects.csv", &report.csv())?;
    folder.write_manifest("effects", &mission, &[("trials", trials.to_string())])?;
    print(&if args.mission.json {
        report.json()
    } else {
        format!(
            "\n{}every drop in {}\n",
            report.document().text(),
            folder.path().join("effects.csv").display()
        )
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
    let progress = ProgressLine::new("assess", "drops", all.len() as u64 * trials);
    let mut campaigns = Vec::new();
    for on in all {
        let flights = EffectFlights::new(mission, &on.kept(effects), plan).bad_input()?;
        progress.set_message(&on.name());
        let fly = |some: Range<u64>| flights.fly_all(some);
        let flown = fly_groups(&pool, &progress, (trials, BLOCK, ABREAST as u64), stop, fly);
        let Some(drops) = flown else { return Ok(None) };
        campaigns.push(EffectCampaign { on, drops });
    }
    progress.finish();
    Ok(Some(campaigns))
}
