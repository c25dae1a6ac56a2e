//! The command line as a whole: its verbs. What can be typed after a verb stands beside it.

use clap::{Parser, Subcommand};

use super::assess::{ASSESS_HELP, AssessArgs};
use super::autopilot::{AUTOPILOT_HELP, AutopilotArgs};
use super::drop::{DROP_HELP, DropArgs};
use super::params::{PARAMS_HELP, ParamsArgs};
use super::plan::{PLAN_HELP, PlanArgs};
use super::schema::{SCHEMA_HELP, SchemaArgs};
use super::sim::{SIM_HELP, SimArgs};
use super::stream::{STREAM_HELP, StreamArgs};
use super::tune::{TUNE_HELP, TuneArgs};
use super::verify::{VERIFY_HELP, VerifyArgs};

/// Plan and fly the drop of a multirotor from a parachute.
#[derive(Debug, Parser)]
#[command(version, about, propagate_version = true, max_term_width = 100)]
#[command(after_help = "Exit codes: 0 ok, 1 the result says no, 2 bad input or nowhere to write to,\n\
                        3 internal error.\n\
                        Start with: samara drop")]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub verb: Verb,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Plan, drop and fly a vehicle over MAVLink, and judge the flight.
    #[command(after_long_help = DROP_HELP)]
    Drop(DropArgs),
    /// Solve the optimal control problem of the drop by direct collocation.
    #[command(after_long_help = PLAN_HELP)]
    Plan(PlanArgs),
    /// Search the gains of the cascade.
    #[command(after_long_help = TUNE_HELP)]
    Tune(TuneArgs),
    /// Fly the paper's safety study: release cases, Monte Carlo campaigns, figures, one page.
    #[command(after_long_help = ASSESS_HELP)]
    Assess(AssessArgs),
    /// Run the simulator alone: a HIL server for the reference autopilot or PX4.
    #[command(after_long_help = SIM_HELP)]
    Sim(SimArgs),
    /// Run the reference autopilot alone: HIL client, links for ground stations and companions.
    #[command(after_long_help = AUTOPILOT_HELP)]
    Autopilot(AutopilotArgs),
    /// Run the offboard streamer alone: plans, arms, commands the release, streams the velocity.
    #[command(after_long_help = STREAM_HELP)]
    Stream(StreamArgs),
    /// Write, check and compare PX4 parameter files.
    #[command(after_long_help = PARAMS_HELP)]
    Params(ParamsArgs),
    /// Hold the code against NASA's check cases and closed forms, each error against its bar.
    #[command(after_long_help = VERIFY_HELP)]
    Verify(VerifyArgs),
    /// Write the JSON schemas of mission, vehicle and gains files.
    #[command(after_long_help = SCHEMA_HELP)]
    Schema(SchemaArgs),
}
