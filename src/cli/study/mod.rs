//! `samara study KIND`: what is asked of a mission beside its own campaigns.
//!
//! | file | holds |
//! |---|---|
//! | `args` | what can be typed of any study |
//! | `hosted` | a study with its threads, progress and rows that are kept |
//! | `points` | how long flights at points of a trial's coordinates take |
//! | `effects` | campaigns of drops with and without each effect |
//! | `envelope` | how far from the nominal release a drop may begin and be safe |
//! | `replan` | drops along one plan and along renewed ones |
//! | `rare` | how rare failures are, and the most likely one |
//! | `sobol` | what of all that is drawn decides a drop |
//! | `free_fall` | how well the release is found by the fall that the accelerometer shows |

pub mod args;
pub mod effects;
pub mod envelope;
pub mod free_fall;
mod hosted;
mod points;
pub mod rare;
pub mod replan;
pub mod sobol;

use std::sync::atomic::AtomicBool;

use clap::{Args, Subcommand};

use super::answer::{Answer, Failure};
use super::fidelity::{self, FidelityArgs};
use super::system::interrupt_flag;
use args::StudyArgs;

/// `samara study`.
#[derive(Args, Debug)]
#[command(subcommand_required = true, arg_required_else_help = true)]
pub struct StudyVerbArgs {
    /// What is asked.
    #[command(subcommand)]
    kind: Kind,
}

/// The kinds of studies.
#[derive(Debug, Subcommand)]
enum Kind {
    /// What each effect that the mission names does to its drops.
    #[command(after_long_help = include_str!("../help/study_effects.txt"))]
    Effects(effects::EffectsArgs),
    /// How far from the nominal release a drop may begin and be safe.
    #[command(after_long_help = include_str!("../help/study_envelope.txt"))]
    Envelope(envelope::EnvelopeArgs),
    /// How rare failures are, and the most likely one.
    #[command(after_long_help = include_str!("../help/study_rare.txt"))]
    Rare(rare::RareArgs),
    /// What decides a drop, of all that is uncertain.
    #[command(after_long_help = include_str!("../help/study_sobol.txt"))]
    Sobol(sobol::SobolArgs),
    /// What renewing the plan during the drop does.
    #[command(after_long_help = include_str!("../help/study_replan.txt"))]
    Replan(replan::ReplanArgs),
    /// How well the release is found without a wire.
    #[command(after_long_help = include_str!("../help/study_free_fall.txt"))]
    FreeFall(free_fall::FreeFallArgs),
    /// What campaigns of the same trials, flown in several ways, say together: samara fidelity.
    #[command(after_long_help = include_str!("../help/fidelity.txt"))]
    Fidelity(FidelityArgs),
}

impl Kind {
    fn study(&self) -> Option<&StudyArgs> {
        match self {
            Self::Effects(args) => Some(&args.study),
            Self::Envelope(args) => Some(&args.study),
            Self::Rare(args) => Some(&args.study),
            Self::Sobol(args) => Some(&args.study),
            Self::Replan(args) => Some(&args.study),
            Self::FreeFall(args) => Some(&args.study),
            Self::Fidelity(_) => None,
        }
    }
}

/// Flies a study.
pub fn run(args: &StudyVerbArgs) -> Result<Answer, Failure> {
    let stop = interrupt_flag()?;
    if let Some(study) = args.kind.study() {
        study.parent.watch(&stop)?;
    }
    let stop: &AtomicBool = &stop;
    match &args.kind {
        Kind::Effects(args) => effects::run(args, stop),
        Kind::Envelope(args) => envelope::run(args, stop),
        Kind::Rare(args) => rare::run(args, stop),
        Kind::Sobol(args) => sobol::run(args, stop),
        Kind::Replan(args) => replan::run(args, stop),
        Kind::FreeFall(args) => free_fall::run(args, stop),
        Kind::Fidelity(args) => fidelity::run(args),
    }
}
