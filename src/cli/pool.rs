//! The threads that flights are spread over. Results are collected in order, so they do not depend on the number of threads.

use anyhow::Context;

/// A pool of `threads` threads; `None`: one for each core.
///
/// # Errors
/// When the system gives no threads.
pub fn pool(threads: Option<usize>) -> anyhow::Result<rayon::ThreadPool> {
    rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build().context("starting threads")
}
