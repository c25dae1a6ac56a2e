//! The command line as a whole: its verbs. What can be typed after a verb stands beside it.

use clap::{Parser, Subcommand};

use super::assess::AssessArgs;
#[cfg(feature = "shards")]
use super::assess::shards::merge::MergeArgs;
use super::autopilot::AutopilotArgs;
use super::card::CardArgs;
use super::check::CheckArgs;
use super::compare::CompareArgs;
use super::doctor::DoctorArgs;
use super::drop::DropArgs;
use super::faults::FaultsArgs;
use super::fidelity::FidelityArgs;
use super::go::GoArgs;
use super::identify::IdentifyArgs;
use super::init::InitArgs;
use super::list::ListArgs;
use super::log::LogArgs;
use super::new::NewArgs;
use super::noes::NoesArgs;
use super::params::ParamsArgs;
use super::plan::PlanArgs;
use super::replay::ReplayArgs;
use super::rotor::RotorArgs;
use super::schema::SchemaArgs;
use super::shell_files::{CompletionsArgs, ManArgs};
use super::sim::SimArgs;
use super::stream::StreamArgs;
use super::study::StudyVerbArgs;
#[cfg(feature = "shards")]
use super::study::evaluate::EvaluateArgs;
use super::study::searches::{DesignArgs, TuneArgs};
use super::verify::VerifyArgs;
#[cfg(feature = "view")]
use super::view::ViewArgs;

/// Plan and fly the drop of a multirotor from a parachute.
#[derive(Debug, Parser)]
#[command(version, about, propagate_version = true, max_term_width = 100)]
#[command(
    after_help = "Exit codes: 0 ok, 1 the result says no, 2 bad input or nowhere to write to, 3 internal\n\
                        error, 4 a search asks others (--ask). Start with: samara drop"
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub verb: Verb,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Plan, drop and fly a vehicle over MAVLink, and judge the flight.
    #[command(after_long_help = include_str!("help/drop.txt"))]
    Drop(DropArgs),
    /// Look at a mission in the browser, change it, and see it flown anew at once.
    #[cfg(feature = "view")]
    #[command(after_long_help = include_str!("help/view.txt"))]
    View(ViewArgs),
    /// Solve the optimal control problem of the drop by direct collocation.
    #[command(after_long_help = include_str!("help/plan.txt"))]
    Plan(PlanArgs),
    /// Search the gains of the cascade.
    #[command(after_long_help = samara::study::tuning::search::HELP)]
    Tune(TuneArgs),
    /// Search plan and gains together, robust in the air that there is.
    #[command(after_long_help = samara::study::designing::search::HELP)]
    Design(DesignArgs),
    /// Judge candidates that a search asks about: `samara design --ask`, `samara tune --ask`.
    #[cfg(feature = "shards")]
    #[command(hide = true, after_long_help = include_str!("help/evaluate.txt"))]
    Evaluate(EvaluateArgs),
    /// Fly campaigns: from random releases, of whole drops, the paper's study.
    #[command(after_long_help = samara::study::campaign::HELP)]
    Assess(Box<AssessArgs>),
    /// Study effects, the envelope, rare failures, what decides, renewed plans, ..
    #[command(after_long_help = include_str!("help/study.txt"))]
    Study(Box<StudyVerbArgs>),
    /// Make the release card of a mission: all evidence on one page, and whether to go.
    #[command(after_long_help = include_str!("help/card.txt"))]
    Card(CardArgs),
    /// Go all the way to the card: check, drop, campaigns, envelope; ends at the first no.
    #[command(after_long_help = include_str!("help/go.txt"))]
    Go(GoArgs),
    /// Hold two runs, or two missions, against each other: trial by trial, key by key.
    #[command(after_long_help = include_str!("help/compare.txt"))]
    Compare(CompareArgs),
    /// Put the shards of a campaign or a study together, or say which are missing.
    #[cfg(feature = "shards")]
    #[command(after_long_help = include_str!("help/merge.txt"))]
    Merge(MergeArgs),
    /// Hold campaigns of the same trials, flown in several ways, against each other.
    #[command(after_long_help = include_str!("help/fidelity.txt"))]
    Fidelity(FidelityArgs),
    /// Run the simulator alone: a HIL server for the reference autopilot or PX4.
    #[command(after_long_help = include_str!("help/sim.txt"))]
    Sim(SimArgs),
    /// Run the reference autopilot alone: HIL client, links for ground stations and companions.
    #[command(after_long_help = include_str!("help/autopilot.txt"))]
    Autopilot(AutopilotArgs),
    /// Run the offboard streamer alone: arms, commands the release, streams the plan.
    #[command(after_long_help = include_str!("help/stream.txt"))]
    Stream(StreamArgs),
    /// Fly a recorded drop again from its actuators, and say whether it is the same.
    #[command(after_long_help = include_str!("help/replay.txt"))]
    Replay(ReplayArgs),
    /// Write, check and compare PX4 parameter files.
    #[command(after_long_help = include_str!("help/params.txt"))]
    Params(ParamsArgs),
    /// Hold the code against NASA's check cases and closed forms, each error against its bar.
    #[command(after_long_help = include_str!("help/verify.txt"))]
    Verify(VerifyArgs),
    /// List what can fail in a flight: by a mission, by a command.
    #[command(hide = true, after_long_help = include_str!("help/faults.txt"))]
    Faults(FaultsArgs),
    /// List every no that samara says, what mostly causes it, and the command for it.
    #[command(hide = true, after_long_help = include_str!("help/noes.txt"))]
    Noes(NoesArgs),
    /// Solve a vehicle's rotor blades in any flow and write the table that flies.
    #[command(after_long_help = include_str!("help/rotor.txt"))]
    Rotor(RotorArgs),
    /// Write the JSON schemas of mission, vehicle and gains files, and of results.
    #[command(hide = true, after_long_help = include_str!("help/schema.txt"))]
    Schema(SchemaArgs),
    /// Print what completes the command line in a shell.
    #[command(hide = true, after_long_help = include_str!("help/completions.txt"))]
    Completions(CompletionsArgs),
    /// Write the man pages.
    #[command(hide = true, after_long_help = include_str!("help/man.txt"))]
    Man(ManArgs),
    /// Write missions, vehicles, gains and schemas to a folder, to edit.
    #[command(after_long_help = include_str!("help/init.txt"))]
    Init(InitArgs),
    /// Say what is in a flight log, what was flown, and what it tells of the vehicle.
    #[command(after_long_help = include_str!("help/log.txt"))]
    Log(LogArgs),
    /// Find out from flight logs what a vehicle is, with standard errors.
    #[command(after_long_help = include_str!("help/identify.txt"))]
    Identify(IdentifyArgs),
    /// List missions, vehicles and gains that can be named, and the runs that there are.
    #[command(after_long_help = include_str!("help/list.txt"))]
    List(ListArgs),
    /// Look at what samara needs of this machine: ports, folders, Python, PX4.
    #[command(after_long_help = include_str!("help/doctor.txt"))]
    Doctor(DoctorArgs),
    /// Print what the numbers of a mission amount to, and what is odd about them.
    #[command(after_long_help = include_str!("help/check.txt"))]
    Check(CheckArgs),
    /// Draft a vehicle from its data sheet, or a mission for it with gains that fly.
    #[command(after_long_help = include_str!("help/new.txt"))]
    New(NewArgs),
}
