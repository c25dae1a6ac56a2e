//! `samara log`: what is in a flight log or a flight's table; the one way in which other verbs read them.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::terminal::print;
use samara::config::bounded::bytes_at_most;
use samara::config::read_flight_table;
use samara::logged_flight::LoggedFlight;
use samara::report::logged_flight::LogReport;
use samara::ulog::Ulog;

/// Larger logs are refused [bytes].
const LARGEST: u64 = 1 << 30;

/// `samara log`.
#[derive(Args, Debug)]
pub struct LogArgs {
    /// A flight log of PX4's, or of samara's own autopilot (.ulg), or a flight's table (CSV, Parquet).
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
    let text = with_flight(&args.file, |flight, log| {
        let report = LogReport::of(&name, flight, log);
        if args.json { report.json() } else { report.document(args.topics).text() }
    })?;
    print(&text)?;
    Ok(Answer::Yes)
}

/// The flight of a log or of a table.
pub fn flight(path: &Path) -> Result<LoggedFlight, Failure> {
    with_flight(path, |flight, _| flight)
}

/// What is made of the flight of a log or of a table, and of the log where it is one.
fn with_flight<T>(
    path: &Path,
    make: impl FnOnce(LoggedFlight, Option<&Ulog<'_>>) -> T,
) -> Result<T, Failure> {
    let shown = path.display();
    let bytes = bytes_at_most(path, LARGEST).with_context(|| format!("cannot read {shown}")).bad_input()?;
    if bytes.starts_with(b"PAR1") {
        return Ok(make(parquet(path, bytes)?, None));
    }
    if Ulog::is_one(&bytes) || path.extension().is_none_or(|kind| !kind.eq_ignore_ascii_case("csv")) {
        let log = Ulog::read(&bytes).with_context(|| shown.to_string()).bad_input()?;
        return Ok(make(LoggedFlight::of_ulog(&log), Some(&log)));
    }
    let text = String::from_utf8(bytes).with_context(|| format!("{shown}: expected text")).bad_input()?;
    Ok(make(read_flight_table(&text, path).bad_input()?, None))
}

/// The flight of a table in Parquet.
#[cfg(feature = "shards")]
fn parquet(path: &Path, bytes: Vec<u8>) -> Result<LoggedFlight, Failure> {
    let shown = path.display().to_string();
    samara::study::flight_parquet::read_flight_parquet(bytes).with_context(|| shown).bad_input()
}

/// The flight of a table in Parquet.
#[cfg(not(feature = "shards"))]
fn parquet(path: &Path, _: Vec<u8>) -> Result<LoggedFlight, Failure> {
    let shown = path.display();
    Err(Failure::input(format!(
        "{shown}: this samara was built without the feature `shards`, which reads Parquet"
    )))
}
