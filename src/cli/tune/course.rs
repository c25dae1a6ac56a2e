//! The course of a search: judged side by side, kept in a checkpoint after each iteration, gone on with from there.

use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

use super::args::TuneArgs;
use crate::cli::outcome::{BadInput, Failure};
use crate::cli::output::OutputFolder;
use samara::config::{Mission, SearchIdentity, Told, checkpoint_json, load_checkpoint};
use samara::tune::Asked;

const CHECKPOINT: &str = "checkpoint.json";

/// A search that was run.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    /// Candidates that were judged now, not read from a checkpoint.
    pub fresh: usize,
    /// Whether Ctrl-C ended it.
    pub stopped: bool,
}

/// What every search depends on.
pub fn identity_of(mission: &Mission) -> Vec<(&'static str, String)> {
    vec![
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("mission", mission.name.clone()),
        ("inputs_sha256", mission.hash_without_gains()),
        ("seed", mission.seed.to_string()),
    ]
}

/// Runs a search to its end. With `--resume` it is first told what the checkpoint holds. `judge` says what a candidate, by its place
/// among those asked about, comes to; `None` when there is nothing to judge it by. `progress` tells where the search is.
///
/// # Errors
/// [`Failure::BadInput`] when the checkpoint cannot be read or written or belongs to another search.
pub fn run<S>(
    args: &TuneArgs,
    folder: &OutputFolder,
    identity: &SearchIdentity,
    search: &mut S,
    stop: &AtomicBool,
    judge: impl Fn(&S, usize, &S::Candidate) -> Option<S::Told> + Sync,
    progress: impl Fn(&S) -> String,
) -> Result<Course, Failure>
where
    S: Asked + Sync,
    S::Candidate: Sync,
    S::Told: Told + Send,
{
    let mut told: Vec<S::Told> = if args.resume {
        load_checkpoint(&folder.path().join(CHECKPOINT), identity).bad_input()?
    } else {
        Vec::new()
    };
    let mut used = 0;
    while let Some(n) = search.ask().map(<[_]>::len).filter(|n| told.len() - used >= *n) {
        search.tell(&told[used..used + n]);
        used += n;
    }
    let keep = |told: &[S::Told]| {
        let text = checkpoint_json(identity, told);
        folder.write(CHECKPOINT, |out| out.write_all(text.as_bytes())).map(|_| ())
    };
    // What is left over was told to a search of more iterations: that checkpoint is the better one.
    if used > 0 && used == told.len() {
        keep(&told)?;
    }
    told.truncate(used);
    let bar = ProgressBar::no_length();
    let style = ProgressStyle::with_template("{spinner} {elapsed} {msg}, {rate}");
    bar.set_style(style.context("the progress bar")?.with_key("rate", rate));
    while let Some(candidates) = search.ask() {
        bar.set_message(progress(search));
        let judged = |(place, candidate): (usize, &S::Candidate)| {
            let going = !stop.load(Ordering::Relaxed);
            bar.inc(u64::from(going));
            going.then(|| judge(search, place, candidate)).flatten()
        };
        let judged: Option<Vec<S::Told>> =
            candidates.par_iter().enumerate().with_max_len(1).map(judged).collect();
        let Some(judged) = judged else { break };
        search.tell(&judged);
        told.extend(judged);
        keep(&told)?;
    }
    bar.finish_and_clear();
    Ok(Course { fresh: told.len() - used, stopped: search.ask().is_some() })
}

fn rate(state: &indicatif::ProgressState, out: &mut dyn std::fmt::Write) {
    // A bar that cannot be written is no reason to end a search.
    let _ = write!(out, "{:.0} evaluations a second", state.per_sec());
}
