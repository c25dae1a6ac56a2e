//! `samara assess`: campaigns of flights with the mission's own gains, the paper's safety study, or a
//! campaign of whole drops. Studies of other kinds had their options here: `samara study`.
//!
//! | file | holds |
//! |---|---|
//! | `args` | what can be typed |
//! | `study` | the plan, and what flies the trials |
//! | `command` | the command that makes campaigns again |
//! | `own` | campaigns of the mission's own gains: tables, figures, footprint, one page |
//! | `paper` | `--paper`: release cases, campaigns of four controllers, the paper's results beside them |
//! | `campaign` | a campaign's trials, flown, written and continued |
//! | `figures` | the figures of flights |
//! | `only` | one trial again |
//! | `shards` | `--shard` and `samara merge`: parts of a campaign, flown apart and put together |
//! | `drops` | `--autopilot`: a campaign of whole drops |

mod args;
mod campaign;
mod command;
mod drops;
mod figures;
mod only;
mod own;
mod paper;
#[cfg(feature = "shards")]
pub mod shards;
mod study;

use super::answer::{Answer, Failure};
use std::sync::atomic::AtomicBool;

use super::study::args::now_spelt;
use super::study::effects::{self, EffectsArgs};
use super::study::envelope::{self, EnvelopeArgs, RAYS};
use super::study::free_fall::{self, FreeFallArgs};
use super::study::rare::{self, RareArgs};
use super::study::replan::{self, ReplanArgs};
use super::study::sobol::{self, SobolArgs};
use super::system::interrupt_flag;
pub use args::AssessArgs;
use args::Only;
use samara::assess::rare::PER_LEVEL;

/// Flies the study, or drops by an autopilot.
pub fn run(args: AssessArgs) -> Result<Answer, Failure> {
    let args = &args;
    args.refuse_idle()?;
    let stop = interrupt_flag()?;
    args.parent.watch(&stop)?;
    #[cfg(feature = "shards")]
    if args.part.describe {
        refuse_options(args)?;
        return shards::describe(args);
    }
    #[cfg(feature = "shards")]
    if let Some(shard) = args.part.shard {
        refuse_options(args)?;
        return shards::run(args, shard, &stop);
    }
    if let Some(old) = old_spelling(args, &stop)? {
        return Ok(old);
    }
    if let Some(autopilot) = &args.autopilot {
        return drops::run(args, autopilot, &stop);
    }
    refuse_options(args)?;
    study::run(args, &stop)
}

/// Flies the study that an old spelling asks for, and says the new one.
fn old_spelling(args: &AssessArgs, stop: &AtomicBool) -> Result<Option<Answer>, Failure> {
    let study = args.study();
    let answer = if let Some(when) = &args.replan {
        now_spelt("--replan", "replan --when");
        let AssessArgs { trials, autopilot, state, instance, patience, .. } = args;
        let (state, patience) = (state.clone(), patience.clone());
        let (when, autopilot, instance) = (when.clone(), autopilot.clone(), *instance);
        let args = ReplanArgs { study, when, trials: *trials, autopilot, state, instance, patience };
        replan::run(&args, stop)
    } else if args.effects {
        now_spelt("--effects", "effects");
        effects::run(&EffectsArgs { study, trials: args.trials }, stop)
    } else if let Some(pairs) = &args.envelope {
        now_spelt("--envelope", "envelope --pairs");
        let rays = args.rays.unwrap_or(RAYS);
        envelope::run(&EnvelopeArgs { study, pairs: pairs.clone(), rays }, stop)
    } else if let Some(hours) = args.free_fall {
        now_spelt("--free-fall", "free-fall --hours");
        free_fall::run(&FreeFallArgs { study, trials: args.trials, hours }, stop)
    } else if let Some(points) = args.sobol {
        now_spelt("--sobol", "sobol --points");
        sobol::run(&SobolArgs { study, points }, stop)
    } else {
        let only = match &args.only {
            Some(Only::Failure(_)) if args.paper => {
                let why = "--only FILE: a failure of --rare is expected without --paper";
                return Err(Failure::input(why.to_owned()));
            }
            Some(Only::Failure(file)) if args.autopilot.is_none() => Some(file.clone()),
            _ => None,
        };
        let least = match (args.rare, &only) {
            (None, None) => return Ok(None),
            (least, _) => least.unwrap_or(1.0),
        };
        now_spelt("--rare", if only.is_some() { "rare --only" } else { "rare --least" });
        let per_level = args.per_level.unwrap_or(PER_LEVEL);
        let AssessArgs { bound, unknowns, page, .. } = args;
        let (bound, unknowns, page) = (*bound, *unknowns, page.clone());
        rare::run(&RareArgs { study, least, bound, unknowns, per_level, only, page }, stop)
    };
    answer.map(Some)
}

/// The study has no autopilot on a wire: refuses options that are one's.
fn refuse_options(args: &AssessArgs) -> Result<(), Failure> {
    match args.asked().first().filter(|_| args.autopilot.is_none()) {
        Some(option) => {
            let (option, _) = option.text();
            Err(Failure::input(format!("{option}: --autopilot is expected with it")))
        }
        None => Ok(()),
    }
}
