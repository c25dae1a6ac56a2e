//! Campaigns of the same drops, row by row: how many, and flown until Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::ThreadPool;
use rayon::prelude::*;

use crate::cli::answer::Failure;
use crate::cli::progress::ProgressLine;

/// Most trials of a row: all are kept, for what they differ by.
const MOST_TRIALS: u64 = 100_000;

/// Trials of each row, `usual` unless it is said otherwise; too many beside `option` are refused.
pub fn trials_of(asked: Option<u64>, usual: u64, option: &str) -> Result<u64, Failure> {
    let trials = asked.unwrap_or(usual);
    if trials > MOST_TRIALS {
        let message = format!("--trials: at most {MOST_TRIALS} are expected with {option}, found {trials}");
        return Err(Failure::input(message));
    }
    Ok(trials)
}

/// Flies the trials of a row in their order, `block` of them between two looks at Ctrl-C; `None` when that
/// stopped them.
pub fn fly_row<T: Send>(
    pool: &ThreadPool,
    progress: &ProgressLine,
    (trials, block): (u64, u64),
    stop: &AtomicBool,
    fly: impl Fn(u64) -> T + Sync,
) -> Option<Vec<T>> {
    let mut drops = Vec::new();
    for from in (0..trials).step_by(block as usize) {
        if stop.load(Ordering::Relaxed) {
            progress.finish();
            return None;
        }
        let some = from..trials.min(from + block);
        let flown = some.end - some.start;
        drops.extend(pool.install(|| some.into_par_iter().map(&fly).collect::<Vec<_>>()));
        progress.inc(flown);
    }
    Some(drops)
}
