//! `samara assess`: campaigns of flights with the mission's own gains, the paper's safety study, or a
//! campaign of whole drops.
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
//! | `rows` | how many drops campaigns of the same drops have, for the next and `replan` |
//! | `effects` | `--effects`: campaigns of drops with and without each effect |
//! | `envelope` | `--envelope`: how far from the nominal release a drop may begin and be safe |
//! | `replan` | `--replan`: drops along one plan and along renewed ones |
//! | `hosted` | a study with its threads, progress and rows that are kept |
//! | `points` | a mission with a drop, and trials as points: for `envelope`, `rare` and `sobol` |
//! | `rare` | `--rare`: how rare failures are, and the most likely one |
//! | `sobol` | `--sobol`: what of all that is drawn decides a drop |
//! | `free_fall` | `--free-fall`: how well the release is found by the fall that the accelerometer shows |
//! | `shards` | `--shard` and `samara merge`: parts of a campaign, flown apart and put together |
//! | `drops` | `--autopilot`: a campaign of whole drops |

mod args;
mod campaign;
mod command;
mod drops;
mod effects;
mod envelope;
mod figures;
mod free_fall;
mod hosted;
mod only;
mod own;
mod paper;
mod points;
mod rare;
mod replan;
mod rows;
#[cfg(feature = "shards")]
pub mod shards;
mod sobol;
mod study;

use super::answer::{Answer, Failure};
use super::system::interrupt_flag;
pub use args::AssessArgs;
use args::{Cadences, Only, Pairs};

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
    if let Some(Cadences(cadences)) = &args.replan {
        return replan::run(args, cadences, &stop);
    }
    if let Some(autopilot) = &args.autopilot {
        return drops::run(args, autopilot, &stop);
    }
    refuse_options(args)?;
    if args.effects {
        effects::run(args, &stop)
    } else if let Some(Pairs(pairs)) = &args.envelope {
        envelope::run(args, pairs, &stop)
    } else if let Some(hours) = args.free_fall {
        free_fall::run(args, hours, &stop)
    } else if let Some(least) = args.rare {
        rare::run(args, least, &stop)
    } else if let Some(points) = args.sobol {
        sobol::run(args, points, &stop)
    } else if let Some(Only::Failure(file)) = &args.only {
        rare::fly_again(args, file)
    } else {
        study::run(args, &stop)
    }
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
