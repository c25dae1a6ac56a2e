//! `samara faults`.

use clap::Args;

use super::answer::{Answer, Failure};
use super::terminal::print;
use samara::report::{faults_json, faults_text};

/// `samara faults`.
#[derive(Args, Debug)]
pub struct FaultsArgs {
    /// Print one JSON object on stdout instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// Lists every fault.
pub fn run(args: &FaultsArgs) -> Result<Answer, Failure> {
    print(&if args.json { faults_json() } else { faults_text() })?;
    Ok(Answer::Yes)
}
