//! `samara study KIND`: what is asked of a mission beside its own campaigns. The kinds are the library's
//! ([`KINDS`](samara::study::kinds::KINDS)): each is a verb here by what it says of itself.
//!
//! | file | holds |
//! |---|---|
//! | `args` | what can be typed of any study |
//! | `verb` | the kinds as verbs of the command line |
//! | `asked` | a study as it was asked for |
//! | `hosted` | a study with its threads, progress and rows that are kept |
//! | `results` | files and words of one |
//! | `whole` | a study flown by one process |
//! | `shards` | a study in shards, and put together |
//! | `wire` | drops of `replan` by an autopilot |

pub mod args;
pub mod asked;
mod hosted;
mod results;
#[cfg(feature = "shards")]
pub mod shards;
mod verb;
mod whole;
mod wire;

use std::sync::atomic::AtomicBool;

use super::answer::{Answer, Failure};
use super::fidelity;
use super::system::interrupt_flag;
use asked::StudyOf;
pub use verb::StudyVerbArgs;
use verb::Typed;

/// Flies what was typed.
pub fn run(typed: &StudyVerbArgs) -> Result<Answer, Failure> {
    let stop = interrupt_flag()?;
    match &typed.kind {
        Typed::Fidelity(args) => fidelity::run(args),
        Typed::Study(study) => {
            study.args.parent.watch(&stop)?;
            fly(study, &stop)
        }
    }
}

/// Flies a study, or a part of it.
pub fn fly(study: &StudyOf, stop: &AtomicBool) -> Result<Answer, Failure> {
    if let Some((wire, autopilot)) =
        study.wire.as_ref().and_then(|wire| Some((wire, wire.autopilot.as_ref()?)))
    {
        #[cfg(feature = "shards")]
        if study.args.part.asks() {
            let why = "--autopilot: drops without a wire are expected in shards (samara assess flies an autopilot's)";
            return Err(Failure::input(why.to_owned()));
        }
        return wire::run(study, (wire, autopilot), stop);
    }
    #[cfg(feature = "shards")]
    if study.args.part.asks() {
        return shards::run(study, stop);
    }
    whole::run(study, stop)
}
