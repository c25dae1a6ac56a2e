//! `samara study effects`: what each effect that a mission names does to its drops.

use std::sync::atomic::AtomicBool;

use clap::Args;

use super::args::{StudyArgs, trials_of};
use super::hosted::{self, Asked, Hosted};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::whole;
use crate::cli::mission::{chosen_mission, origin};
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_to_fly;
use samara::config::{Effect, Mission};
use samara::control::ControlError;
use samara::report::effects::{EffectCampaign, EffectReport};
use samara::sim::ABREAST;
use samara::study::effects::{EffectFlights, EffectsOn};
use samara::study::jobs::{Jobs as _, Round};

/// Trials of a campaign unless it is said otherwise.
const TRIALS: u64 = 1000;

/// Name of the study.
const NAME: &str = "effects";
/// Name of the study in its manifest.
const VERB: &str = "effects";

/// `samara study effects`.
#[derive(Args, Debug)]
pub struct EffectsArgs {
    /// Trials of each campaign [default: 1000].
    #[arg(long, value_name = "N", value_parser = whole::<u64>(2..=1_000_000_000))]
    pub trials: Option<u64>,
    /// What every study has.
    #[command(flatten)]
    pub study: StudyArgs,
}

/// Flies the campaigns, writes and reports them.
pub fn run(args: &EffectsArgs, stop: &AtomicBool) -> Result<Answer, Failure> {
    let (args, asked_for) = (&args.study, args.trials);
    let mission = chosen_mission(&args.mission.mission, &args.choice)?;
    let effects = effects_of(&mission)?;
    let trials = trials_of(asked_for, TRIALS, "effects")?;
    let narrator = Narrator::alone(args.mission.json);
    narrator.say(&origin(&args.mission.mission, &mission));
    let folder = hosted::folder(args, VERB, NAME, &mission)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let plan = &timed.plan.trajectory;
    let all = EffectsOn::campaigns(&effects);
    let settings = [("trials", trials.to_string())];
    let whole = all.len() as u64 * trials;
    let asked =
        Asked { name: NAME, verb: VERB, unit: "drops", whole, threads: args.threads, settings: &settings };
    let hosted = Hosted::new(args, (&mission, &folder), asked, stop)?;
    let flights = all.into_iter().map(|on| Ok((on, EffectFlights::new(&mission, &on.kept(&effects), plan)?)));
    let flights: Vec<_> = flights.collect::<Result<_, ControlError>>().bad_input()?;
    let round = Round::of(trials, ABREAST as u64);
    let campaigns = hosted.run(|host| {
        let campaign = |(on, flights): &(EffectsOn, EffectFlights<'_>)| {
            let drops =
                host.fly(&on.name(), round, &|some, stop| (!stop()).then(|| flights.fly_all(some)))?;
            Ok(EffectCampaign { on: *on, drops })
        };
        flights.iter().map(campaign).collect::<Result<Vec<_>, _>>()
    })?;
    let Some(campaigns) = campaigns else { return hosted.stopped("campaigns", &narrator) };
    let report = EffectReport { mission: &mission, effects, campaigns };
    folder.write_text("effects.txt", &report.document().text())?;
    folder.write_text("effects.json", &report.json())?;
    folder.write_text("effects.csv", &report.csv())?;
    let every = folder.path().join("effects.csv");
    let text = || format!("\n{}every drop in {}\n", report.document().text(), every.display());
    hosted.finish(|| report.json(), text)?;
    Ok(Answer::Yes)
}

/// The effects of a mission that can be flown without a wire.
fn effects_of(mission: &Mission) -> Result<Vec<Effect>, Failure> {
    let refused = |message: String| Err(Failure::input(format!("{}: {message}", mission.file.display())));
    if mission.release.standing {
        return refused("a study of effects flies drops, and this mission begins on the ground".to_owned());
    }
    mission.faults.check_without_wire().bad_input()?;
    let effects = mission.effects();
    if effects.is_empty() {
        let keys: Vec<&str> = Effect::ALL.into_iter().map(Effect::key).collect();
        return refused(format!(
            "a study of effects has nothing to leave out: at least one of these keys is expected: {}",
            keys.join("; ")
        ));
    }
    Ok(effects)
}
