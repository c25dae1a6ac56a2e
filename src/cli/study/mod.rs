//! `samara study KIND`: what is asked of a mission beside its own campaigns. The kinds are the library's
//! ([`KINDS`](samara::study::kinds::KINDS)): each is a verb here by what it says of itself.
//!
//! | file | holds |
//! |---|---|
//! | `args` | what can be typed of any study |
//! | `verb` | the kinds as verbs of the command line |
//! | `asked` | a study as it was asked for |
//! | `options` | settings as options |
//! | `noted` | what was typed, as shards hold it |
//! | `merge` | what is to be typed for shards to be put together |
//! | `hosted` | a study with its threads, progress and rows that are kept |
//! | `results` | files and words of one |
//! | `whole` | a study flown by one process |
//! | `shards` | a study in shards, and put together |
//! | `parts_folder` | the folder of the shards, and what was asked |
//! | `wire` | drops of `replan` by an autopilot |
//! | `searches` | `samara design` and `samara tune` |
//! | `evaluate` | `samara evaluate` |

pub mod args;
pub mod asked;
#[cfg(feature = "shards")]
pub mod evaluate;
mod hosted;
#[cfg(feature = "shards")]
pub mod merge;
pub mod noted;
pub mod options;
#[cfg(feature = "shards")]
pub mod parts_folder;
mod results;
pub mod searches;
#[cfg(feature = "shards")]
pub mod shards;
mod verb;
mod whole;
mod wire;

use std::sync::atomic::AtomicBool;

use super::answer::{Answer, Failure};
use super::system::interrupt_flag;
use asked::StudyOf;
use samara::study::feature::Feature;
pub use verb::StudyVerbArgs;

/// Flies what was typed.
pub fn run(StudyVerbArgs { study }: &StudyVerbArgs) -> Result<Answer, Failure> {
    let stop = interrupt_flag()?;
    study.args.parent.watch(&stop)?;
    fly(study, &stop)
}

/// Flies a study, or a part of it.
pub fn fly(study: &StudyOf, stop: &AtomicBool) -> Result<Answer, Failure> {
    let about = study.kind.about();
    for (feature, asked) in [(Feature::Only, study.only.is_some()), (Feature::Keep, study.keep)] {
        if let Some(why) = about.refusal(feature).filter(|_| asked) {
            return Err(Failure::input(format!("--{}: {why}", feature.name())));
        }
    }
    #[cfg(feature = "shards")]
    if study.args.part.asks() {
        return shards::run(study, stop);
    }
    whole::run(study, stop)
}
