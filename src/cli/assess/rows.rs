//! Campaigns of the same drops, row by row: how many.

use crate::cli::answer::Failure;

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
