//! `samara log`: what is in a flight log.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::terminal::print;
use samara::config::bounded::bytes_at_most;
use samara::report::logged_flight::LogReport;
use samara::ulog::Ulog;

/// Larger logs are refused [bytes].
const LARGEST: u64 = 1 << 30;

/// `samara log`.
#[derive(Args, Debug)]
pub struct LogArgs {
    /// A flight log of PX4's, or of samara's own autopilot (.ulg).
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// List all topics.
    #[arg(long)]
    pub topics: bool,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Looks through a log, and prints what is in it.
pub fn run(args: &LogArgs) -> Result<Answer, Failure> {
    let name = args.file.file_name().unwrap_or_default().to_string_lossy();
    let text = with_log(&args.file, |log| {
        let report = LogReport::of(&name, log);
        if args.json { report.json() } else { report.document(args.topics).text() }
    })?;
    print(&text)?;
    Ok(Answer::Yes)
}

/// What is made of a flight log.
pub fn with_log<T>(path: &Path, make: impl FnOnce(&Ulog<'_>) -> T) -> Result<T, Failure> {
    let shown = path.display();
    let bytes = bytes_at_most(path, LARGEST).with_context(|| format!("cannot read {shown}")).bad_input()?;
    Ok(make(&Ulog::read(&bytes).with_context(|| shown.to_string()).bad_input()?))
}
