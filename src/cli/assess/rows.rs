//! Campaigns of the same drops, row by row: how many, and flown until Ctrl-C.

use std::ops::Range;
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

/// Flies the trials of a row in their order, each by itself, `block` of them between two looks at Ctrl-C;
/// `None` when that stopped them.
pub fn fly_row<T: Send>(
    pool: &ThreadPool,
    progress: &ProgressLine,
    (trials, block): (u64, u64),
    stop: &AtomicBool,
    fly: impl Fn(u64) -> T + Sync,
) -> Option<Vec<T>> {
    fly_groups(pool, progress, (trials, block, 1), stop, |some| some.map(&fly).collect())
}

/// Flies the trials of a row as [`fly_row`] does, `size` of them at a time.
pub fn fly_groups<T: Send>(
    pool: &ThreadPool,
    progress: &ProgressLine,
    (trials, block, size): (u64, u64, u64),
    stop: &AtomicBool,
    fly: impl Fn(Range<u64>) -> Vec<T> + Sync,
) -> Option<Vec<T>> {
    let mut drops = Vec::new();
    for from in (0..trials).step_by(block as usize) {
        if stop.load(Ordering::Relaxed) {
            progress.finish();
            return None;
        }
        let some = from..trials.min(from + block);
        let flown = some.end - some.start;
        let group = |from: u64| fly(from..some.end.min(from + size));
        let begins: Vec<u64> = some.clone().step_by(size as usize).collect();
        let groups = || begins.into_par_iter().map(group).collect::<Vec<_>>();
        drops.extend(pool.install(groups).into_iter().flatten());
        progress.inc(flown);
    }
    Some(drops)
}
