//! The command line: what was typed, then what to do. The only place that prints, reads the clock and sets
//! exit codes.
//!
//! Results go to stdout, everything else to stderr. Exit codes: 0 yes, 1 the result says no, 2 bad input, 3
//! internal error, 4 a search asks others.

mod alone_flight;
mod answer;
mod args;
mod aside;
mod assess;
mod autopilot;
mod card;
mod check;
mod compare;
mod conclusion;
#[cfg(test)]
mod docs_tests;
mod doctor;
mod drop;
mod estimate;
mod faults;
mod fidelity;
mod go;
mod help;
mod identify;
mod init;
mod list;
#[cfg_attr(not(feature = "view"), path = "live_absent.rs")]
mod live;
mod log;
mod mission;
mod narrator;
mod new;
mod noes;
mod params;
mod pilot;
mod plan;
mod plan_grid;
mod planning;
mod progress;
mod recording;
mod replay;
mod reporter;
mod results;
mod rotor;
mod schema;
mod set;
mod shell_files;
mod sign_key;
mod sim;
mod stream;
mod study;
mod system;
mod terminal;
mod verbs;
mod verify;
#[cfg(feature = "view")]
mod view;

use std::ffi::OsString;

use clap::{CommandFactory, FromArgMatches};

use terminal::exit_code;
use verbs::{Cli, Verb};

/// Parses a command line, whose first word is the program's name, and runs the verb: the exit code. For one
/// command line in a process, which it ends itself where help is asked for.
pub fn run(words: impl IntoIterator<Item = OsString>) -> u8 {
    let command = || help::with_negative_values(help::flowed(Cli::command()));
    let typed = command().try_get_matches_from(words);
    let cli = match typed.and_then(|typed| Cli::from_arg_matches(&typed)) {
        Ok(cli) => cli,
        Err(e) if !e.use_stderr() => e.exit(),
        // What was typed is shown without what acts on a terminal.
        Err(e) => {
            terminal::print_err(&e.render().to_string());
            return u8::try_from(e.exit_code()).unwrap_or(2);
        }
    };
    #[cfg(unix)]
    system::let_limits_be_errors();
    exit_code(match cli.verb {
        Verb::Drop(args) => drop::run(&args),
        #[cfg(feature = "view")]
        Verb::View(args) => view::run(args),
        Verb::Plan(args) => plan::run(&args),
        Verb::Tune(args) => study::searches::run(&args.0),
        Verb::Design(args) => study::searches::run(&args.0),
        #[cfg(feature = "shards")]
        Verb::Evaluate(args) => study::evaluate::run(&args),
        Verb::Assess(args) => assess::run(*args),
        Verb::Study(args) => study::run(&args),
        #[cfg(feature = "shards")]
        Verb::Merge(args) => assess::shards::merge::run(&args),
        Verb::Fidelity(args) => fidelity::run(&args),
        Verb::Sim(args) => sim::run(&args),
        Verb::Autopilot(args) => autopilot::run(&args),
        Verb::Stream(args) => stream::run(&args),
        Verb::Replay(args) => replay::run(&args),
        Verb::Params(args) => params::run(&args),
        Verb::Verify(args) => verify::run(&args),
        Verb::Faults(args) => faults::run(&args),
        Verb::Noes(args) => noes::run(&args),
        Verb::Rotor(args) => rotor::run(&args),
        Verb::Schema(args) => schema::run(&args),
        Verb::Completions(args) => shell_files::completions(&args, command()),
        Verb::Man(args) => shell_files::man(&args, command()),
        Verb::Init(args) => init::run(&args),
        Verb::Compare(args) => compare::run(&args),
        Verb::Doctor(args) => doctor::run(&args),
        Verb::List(args) => list::run(&args),
        Verb::Identify(args) => identify::run(&args),
        Verb::Log(args) => log::run(&args),
        Verb::Card(args) => card::run(&args),
        Verb::Go(args) => go::run(&args),
        Verb::Check(args) => check::run(&args),
        Verb::New(args) => new::run(&args),
    })
}
